"""Settings that a person wrote: a YAML file, single overrides, their check against a model; errors as one line."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from soup_msgs_py.errors import InputError
from soup_msgs_py.reading.files import read_text
from soup_msgs_py.reading.yaml_text import load_yaml

Overrides = Iterable[str]
Model = TypeVar("Model", bound=BaseModel)
LARGEST_FILE_BYTES = 10_000_000
DEEPEST_KEY = 20  # parts of a dotted key


def read_mapping(path: Path) -> dict[str, Any]:
    """The mapping at the top of a YAML file.

    Raises:
        InputError: The file is missing, unreadable, not YAML, or not a mapping.
    """
    allowed = "a YAML file of `key: value` lines"
    data = load_yaml(read_text(path, LARGEST_FILE_BYTES, allowed), path, "", allowed)
    if not isinstance(data, dict):
        raise InputError(path, "", "nothing" if data is None else f"a {type(data).__name__}", allowed)
    return data


def apply_overrides(data: dict[str, Any], overrides: Overrides) -> set[str]:
    """Put `KEY=VALUE` texts (dotted keys, YAML values) into a mapping.

    Returns:
        The dotted keys that were overridden.

    Raises:
        InputError: An override is not `KEY=VALUE`, or runs through a key that is no mapping.
    """
    keys = set()
    for override in overrides:
        key, equals, text = override.partition("=")
        if not equals or not key:
            raise InputError("--set", "", repr(override), "KEY=VALUE, for instance bots=120")
        value = load_yaml(text, "--set", key, "a YAML value, for instance 120 or [0.8, 0.2]")
        *parents, last = key.split(".")
        if len(parents) >= DEEPEST_KEY:
            raise InputError("--set", key, f"{len(parents) + 1} dotted parts", f"at most {DEEPEST_KEY}")
        place: Any = data
        for parent in parents:
            place = place.setdefault(parent, {})
            if not isinstance(place, dict):
                raise InputError("--set", key, f"a value at {parent!r}", "a dotted key through mappings")
        place[last] = value
        keys.add(key)
    return keys


def validate(model: type[Model], data: dict[str, Any], source: object, overridden: Iterable[str] = ()) -> Model:
    """Check a mapping against a model.

    Raises:
        InputError: The first thing that is wrong, as one line.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise first_problem(model, error, data, source, set(overridden)) from error


def first_problem(
    model: type[BaseModel],
    error: ValidationError,
    data: Any,
    source: object,
    overridden: Iterable[str] = (),
    prefix: str = "",
) -> InputError:
    """What a model says of a mapping, as one line.

    Args:
        model: The model.
        error: What it says.
        data: The mapping.
        source: The file or option that the mapping comes from.
        overridden: Dotted keys that the command line has put into it.
        prefix: The key that the mapping stands under.
    """
    problem = _most_telling(error)
    kind = problem["type"]
    key = ".".join(_keys_only(problem["loc"], data, kind == "missing"))
    found, allowed = _shorten(problem["input"]), problem["msg"]
    if kind == "extra_forbidden":
        name, known = str(problem["loc"][-1]), _known_keys(model, problem["loc"])
        close = difflib.get_close_matches(name[:80], known, n=1)
        found = "an unknown key"
        allowed = (
            f"{close[0]} (did you mean it?), or one of {', '.join(known)}" if close else ", ".join(known) or "none"
        )
    elif kind in ("missing", "union_tag_not_found"):
        if kind == "union_tag_not_found":
            key += ".kind"
        found, allowed = "nothing", "a value; this key is required"
    elif kind == "union_tag_invalid":
        key += ".kind"
        found, allowed = repr(problem["ctx"]["tag"]), problem["ctx"]["expected_tags"]
    elif kind == "value_error":
        parts = str(problem["ctx"]["error"]).split("|")
        if len(parts) == 3:
            key = ".".join(filter(None, [key, parts[0]]))
        if len(parts) >= 2:
            found, allowed = parts[-2], parts[-1]
        else:
            allowed = parts[0]
    else:
        for opening in ("Input should be", "String should have", "Value error,"):
            allowed = allowed.replace(opening, "").strip() or allowed
    if any(key == k or key.startswith(k + ".") or k.startswith(key + ".") for k in overridden):
        source = f"{source} with --set"
    return InputError(source, ".".join(filter(None, [prefix, key])), found, allowed)


def _most_telling(error: ValidationError) -> Any:
    """Of the problems of one part the one that lies deepest, an unknown key before all else: likely a slip."""
    problems = error.errors(include_url=False)
    first = problems[0]
    rivals = [p for p in problems if p["loc"][:1] == first["loc"][:1]]
    return max(rivals, key=lambda p: (len(p["loc"]), p["type"] == "extra_forbidden", not p["type"].endswith("_type")))


def _keys_only(location: tuple[int | str, ...], data: Any, missing: bool) -> list[str]:
    """The steps of a pydantic location that are keys of the data; the others name branches of unions."""
    keys: list[str] = []
    part: Any
    for index, part in enumerate(location):
        has_key = isinstance(data, dict) and part in data
        has_place = isinstance(data, (list, tuple)) and isinstance(part, int) and part < len(data)
        if has_key or has_place:
            data = data[part]
        elif not (missing and index == len(location) - 1):
            continue
        keys.append(str(part))
    return keys


def _known_keys(model: type[BaseModel], location: tuple[int | str, ...]) -> list[str]:
    """The keys that are allowed where an unknown one was found."""
    here: Any = model
    for part in location[:-1]:
        fields = getattr(here, "model_fields", {})
        if part in fields:
            here = fields[part].annotation
        else:
            members = getattr(here, "__args__", ())
            named = [m for m in members if getattr(m, "__name__", "") == part or _tag(m) == part]
            here = named[0] if named else here
    if not hasattr(here, "model_fields"):
        candidates = [m for m in getattr(here, "__args__", ()) if hasattr(m, "model_fields")]
        here = candidates[0] if candidates else model
    return sorted(field.alias or name for name, field in here.model_fields.items())


def _tag(model: Any) -> object:
    """The value of a model's `kind` field, by which unions of models are told apart."""
    field = getattr(model, "model_fields", {}).get("kind")
    return field.default if field is not None else None


def _shorten(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 80 else text[:77] + "..."
