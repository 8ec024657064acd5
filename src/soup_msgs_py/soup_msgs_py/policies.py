"""Which policy each part follows: the policies file, and classes that a person names as `file.py:Class`."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import re
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, field_validator

from soup_msgs_py.blame import told
from soup_msgs_py.errors import InputError
from soup_msgs_py.reading.files import check_regular, folder_of, whole_path
from soup_msgs_py.reading.options import check_options
from soup_msgs_py.reading.yaml_input import read_mapping, validate
from soup_msgs_py.warehouse.cell_world import SUFFIX

MANAGERS = ("word", "letter", "fleet")
ROLES = (*MANAGERS, "bot")
# the policies that come with the warehouse, by role; said here, too, since to load them takes seconds
NAMES = {
    "word": ("in_stock", "minimal", "served"),
    "letter": ("ahead", "drawn", "minimal"),
    "fleet": ("coordinated", "minimal", "planned"),
    "bot": ("evade", "straight"),
}
NONE = "none"  # the policy of a part that nobody has heard of
_PART = re.compile(r"(?:(word|letter|fleet) manager|bots [0-9,-]+)")
_LONGEST_NAME = 4096  # it may hold a path


class PolicyChoice(BaseModel):
    """A policy by name (or `file.py:Class`, or `module:Class`) and its options."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    name: Annotated[str, Field(min_length=1)]
    options: dict[str, Any] = {}


class Policies(BaseModel):
    """The policies of a run, one a role. In the file each is a name, or a mapping with `name` and `options`."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    word: PolicyChoice = PolicyChoice(name="minimal")
    letter: PolicyChoice = PolicyChoice(name="minimal")
    fleet: PolicyChoice = PolicyChoice(name="minimal")
    bot: PolicyChoice = PolicyChoice(name="evade")

    @field_validator("*", mode="before")
    @classmethod
    def _name_alone(cls, value: object) -> object:
        return name_alone(value)


def policies_of(parts: Mapping[str, Mapping[str, str]]) -> Policies:
    """What parts say that they follow; `NONE` where nobody has said it.

    Args:
        parts: By the name of a process, such as `bots 0-5`, the values that it reports.
    """
    chosen: dict[str, str] = dict.fromkeys(ROLES, NONE)
    for part, values in parts.items():
        role, policy = _PART.fullmatch(part), values.get("policy", "")
        if role is not None and 0 < len(policy) <= _LONGEST_NAME:  # anybody may say anything on the network
            chosen[role[1] or "bot"] = policy
    return Policies(**{role: PolicyChoice(name=name) for role, name in chosen.items()})


def name_alone(value: object) -> object:
    """A choice as a mapping, where a person wrote only the name of a policy."""
    return {"name": value} if isinstance(value, str) else value


def load_policies(path: str | Path | None, overrides: Mapping[str, str | None] | None = None) -> Policies:
    """Read a policies file and put single choices of the command line over it.

    Args:
        path: The YAML file, or None for the defaults.
        overrides: Role to policy name, as given on the command line; None leaves the file's choice.

    Raises:
        InputError: The file or a choice is wrong. Whether the names exist is checked by `load_policy`.
    """
    data: dict[str, Any] = {} if path is None else read_mapping(Path(path))
    base = folder_of(path) if path is not None else Path.cwd()
    policies = validate(Policies, data, path or "policies")
    chosen = {role: anchor(getattr(policies, role), base) for role in ROLES}
    for role, name in (overrides or {}).items():
        if name is not None:
            chosen[role] = anchor(validate(PolicyChoice, {"name": name}, f"--{role}-policy"), Path.cwd())
    return Policies(**chosen)


def usual_policies(usual: Path, scenario: Path) -> Path:
    """The policies file of a run that names none: for a world of cells the one beside the usual one that has a plan."""
    return usual.with_name("planned.yaml") if scenario.suffix == SUFFIX else usual


def anchor(choice: PolicyChoice, base: Path) -> PolicyChoice:
    """Make each `file.py:Class`, relative to the folder `base`, absolute, so that every process finds it.

    Options that name policies themselves, alone or as a mapping with `name`, are treated alike.
    """
    options = {key: _anchor_option(value, base) for key, value in choice.options.items()}
    return choice.model_copy(update={"name": _anchor_name(choice.name, base), "options": options})


def _anchor_name(text: str, base: Path) -> str:
    place, colon, name = text.rpartition(":")
    return f"{whole_path(place, base)}:{name}" if colon and place.endswith(".py") else text


def _anchor_option(value: Any, base: Path) -> Any:
    if isinstance(value, str):
        return _anchor_name(value, base)
    if isinstance(value, dict) and isinstance(value.get("name"), str):
        return {**value, "name": _anchor_name(value["name"], base)}
    return value


def load_policy(choice: PolicyChoice, role: str, known: Mapping[str, type], base_class: type) -> Any:
    """Make the policy of a choice; see `policy_maker`.

    Args:
        choice: What was chosen.
        role: For messages: word, letter, fleet or bot.
        known: The policies that come with the warehouse, by name.
        base_class: The class that a policy of this role extends.

    Raises:
        InputError: There is no such policy, it is of the wrong kind, or its options do not fit.
    """
    return policy_maker(choice, f"{role} policy", known, base_class)()


def policy_maker(choice: PolicyChoice, source: str, known: Mapping[str, type], base_class: type) -> Callable[[], Any]:
    """What makes policies of a choice, each with the options as keyword arguments.

    Code is loaded only from the file or module that the choice names.

    Args:
        choice: What was chosen.
        source: For messages: where it was chosen.
        known: The policies that come with the warehouse, by name.
        base_class: The class that such a policy extends.

    Raises:
        InputError: There is no such policy, or it is of the wrong kind; from what makes it: its options do not fit.
    """
    names = f"{', '.join(sorted(known))}, FILE.py:Class or module:Class"
    place, colon, class_name = choice.name.rpartition(":")
    if not colon:
        if choice.name not in known:
            raise InputError(source, "", repr(choice.name), names)
        policy_class: Any = known[choice.name]
    else:
        policy_class = getattr(_load_module(place, source), class_name, None)
        if policy_class is None:
            raise InputError(source, place, f"no {class_name!r}", "the name of a class in it")
    if not (isinstance(policy_class, type) and issubclass(policy_class, base_class)):
        raise InputError(source, choice.name, "another thing", f"a class that extends {base_class.__name__}")
    if inspect.isabstract(policy_class) or policy_class is base_class:
        lacks = ", ".join(sorted(getattr(policy_class, "__abstractmethods__", ())))
        allowed = f"a class that implements {lacks}" if lacks else f"a class that extends {base_class.__name__}"
        raise InputError(source, choice.name, "a class that decides nothing by itself", allowed)

    def make() -> Any:
        options = check_options(policy_class, choice.options, source, f"{choice.name}.options")
        try:
            return policy_class(**options)
        except InputError:  # of a policy that an option names
            raise
        except (Exception, SystemExit) as error:  # a person's own class may fail in any way
            allowed = "a constructor that takes its options"
            raise InputError(source, choice.name, told(error), allowed) from error

    return make


def _load_module(place: str, source: str) -> Any:
    allowed = "a Python file or module that can be imported"
    if not place.endswith(".py"):
        try:
            return importlib.import_module(place)
        except (Exception, SystemExit) as error:  # a person's own module may fail in any way
            raise InputError(source, place, told(error), allowed) from error
    try:
        check_regular(place)
    except FileNotFoundError as error:
        raise InputError(source, "", f"no file {place}", allowed) from error
    except OSError as error:
        raise InputError(source, "", f"{place}: {error.strerror}", allowed) from error
    spec = importlib.util.spec_from_file_location(f"soup_policy_{Path(place).stem}", place)
    if spec is None or spec.loader is None:
        raise InputError(source, "", place, allowed)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        del sys.modules[spec.name]
        raise InputError(source, place, told(error), allowed) from error
    return module
