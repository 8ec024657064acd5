"""YAML as people write it today: numbers as in YAML 1.2, merge keys, no key twice, and no text that grows or nests."""

from __future__ import annotations

import re
from typing import Any

import yaml

from soup_msgs_py.errors import InputError

MOST_VALUES = 200_000  # of one text, aliases written out
DEEPEST = 50
_MERGE = "tag:yaml.org,2002:merge"
_FLOAT = "tag:yaml.org,2002:float"
_EXPONENT = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)[eE][-+]?[0-9]+")
_LARGEST_WHOLE = 2.0**53  # up to it a float is exactly the number that was written


class _TooMuchError(ValueError):
    """A text that grows or nests too much: what was found, and what is allowed."""

    def __init__(self, found: str, allowed: str) -> None:
        super().__init__(found)
        self.found, self.allowed = found, allowed


class _Loader(yaml.CSafeLoader):
    """The safe loader, but a key that stands twice is an error instead of a silent choice."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict:
        seen = set()
        for key_node, _ in node.value:
            # `<<` is no key of its own: what it merges is put in below, behind the keys that are written
            key = "<<" if key_node.tag == _MERGE else self.construct_object(key_node, deep=True)
            if isinstance(key, (str, int)) and key in seen:
                raise yaml.constructor.ConstructorError(None, None, f"the key {key!r} twice", key_node.start_mark)
            if isinstance(key, (str, int)):
                seen.add(key)
        return super().construct_mapping(node, deep)

    def construct_number(self, node: yaml.ScalarNode) -> float | int:
        """A float; `1e6`, which YAML 1.1 takes for a text, is a whole number where one is asked for."""
        number = self.construct_yaml_float(node)
        written = _EXPONENT.fullmatch(node.value) is not None
        return int(number) if written and abs(number) < _LARGEST_WHOLE and number.is_integer() else number


_Loader.add_implicit_resolver(_FLOAT, re.compile(f"^(?:{_EXPONENT.pattern})$"), list("-+.0123456789"))
_Loader.add_constructor(_FLOAT, _Loader.construct_number)


def load_yaml(text: str, source: object, key: str, allowed: str) -> Any:
    """The value of a YAML text.

    Args:
        text: The text.
        source: For messages: the file or option.
        key: For messages: where in it; empty for all of it, then the line is told.
        allowed: For messages: what would do.

    Raises:
        InputError: It is no YAML, or too much of it.
    """
    try:
        _check_size(text)
        loader = _Loader(text)
        try:
            return loader.get_single_data()
        finally:
            loader.dispose()
    except _TooMuchError as error:
        raise InputError(source, key, error.found, error.allowed) from error
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = key or (f"line {mark.line + 1}" if mark is not None else "")
        found = (getattr(error, "problem", None) or str(error)).removeprefix("found ")
        found = found.replace("did not find expected", "no", 1)
        raise InputError(source, where, found, allowed) from error
    except (ValueError, LookupError, AttributeError, TypeError, ArithmeticError) as error:  # of a value like `!!bool x`
        raise InputError(source, key, f"a value that cannot be read ({error})", allowed) from error


def _check_size(text: str) -> None:
    """Refuse what would grow, by aliases that stand for many values, or nest, before anything is made of it."""
    sizes: dict[str, int | None] = {}  # of what each anchor stands for; None while it is not complete
    collections: list[tuple[str | None, int]] = []  # those that are not complete: anchor, values before it
    total = 0
    for event in yaml.parse(text, Loader=yaml.CSafeLoader):
        match event:
            case yaml.CollectionStartEvent():
                collections.append((event.anchor, total))
                total += 1
                if event.anchor is not None:
                    sizes[event.anchor] = None
            case yaml.CollectionEndEvent():
                name, before = collections.pop()
                if name is not None:
                    sizes[name] = total - before
            case yaml.AliasEvent():
                size = sizes.get(event.anchor or "", 0)
                if size is None:
                    raise _TooMuchError(f"*{event.anchor} within what it stands for", "aliases of what is complete")
                total += size
            case yaml.ScalarEvent():
                total += 1
                if event.anchor is not None:
                    sizes[event.anchor] = 1
            case _:
                continue
        if total > MOST_VALUES:
            raise _TooMuchError(f"more than {MOST_VALUES} values, aliases written out", "fewer values")
        if len(collections) > DEEPEST:
            raise _TooMuchError(f"more than {DEEPEST} values in one another", "values that nest less")
