"""Compiles the two functions that turn a dataclass into its ROS message and back, from the fields of both.

A field travels under its own name, or under that without its unit (`distance_m` as `distance`), in the way that its
type hint says:

| hint | travels as | refused |
|---|---|---|
| int, str, bool, bytes | itself | |
| float | itself | what is no finite number |
| float `time` | the stamp of the header, or `stamp` | |
| float `time` without a stamp, floats `stamps` | itself | what no stamp can hold |
| StrEnum | its value | what is no member |
| a dataclass with a row above | its message | what that refuses |
| tuple, frozenset | a list | absurd lengths; as its elements |
| array | a list | another length than the first array's; what is not finite |

A property of the dataclass fills the field of its name. What no hint can say stands in the message's row (`rows`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields
from enum import StrEnum
from typing import Any, NamedTuple, get_args, get_origin, get_type_hints

import numpy as np

from soup_msgs_py.messages import Point
from soup_msgs_py.wire import basics

# hint -> expressions for what the message holds, and for what the dataclass holds; functions are those of `basics`
_WAYS: dict[Any, tuple[str, str]] = {
    int: ("{}", "{}"),
    str: ("{}", "{}"),
    bool: ("bool({})", "{}"),
    float: ("float({})", "finite({})"),
    bytes: ("array('B', {})", "bytes({})"),
    tuple[int, ...]: ("{}", "to_ints({})"),
    tuple[Point, ...]: ("to_points({})", "from_points({})"),
    frozenset[int]: ("sorted({})", "frozenset(to_ints({}))"),
}
# the same, by the message's field; the first of these that there is holds `time`
_WAYS_OF_TIMES = {
    "header": ("header_at({})", "from_stamp({}.stamp)"),
    "stamp": ("to_stamp({})", "from_stamp({})"),
    "time": ("float({})", "bounded({})"),
    "stamps": ("{}", "to_times({})"),
}
_SOURCE = """
def to_ros(value):
{steps}    return Message({to_message})

def from_ros({parameters}):
    value = Kind({to_value})
{check}    return value
"""


class Way:
    """How one field travels where its hint does not say it.

    Args:
        names: Fields of the message, if not the one of its own name.
        out: From the field's value to that of the message's; with several, to a tuple.
        back: From what they hold, one argument each, to the field's value.
    """

    def __init__(self, *names: str, out: Callable[[Any], Any] | None = None, back: Callable[..., Any] | None = None):
        self.names, self.out, self.back = names, out, back


class Codec(NamedTuple):
    """The two functions; `from_ros` takes after the message what that does not hold."""

    ros: Any
    to_ros: Callable[[Any], Any]
    from_ros: Callable[..., Any]


codecs: dict[type, Codec] = {}  # by the dataclass
readers: dict[type, Callable[[Any], Any]] = {}  # by the message
_verbs: dict[tuple[type, str], Callable[[Any], Any]] = {}  # by a message that several dataclasses share, and its verb


def to_ros(message: Any) -> Any:
    """The ROS message for a dataclass."""
    codec = codecs.get(type(message))
    if codec is None:
        raise TypeError(f"no ROS message for {type(message).__name__}")
    return codec.to_ros(message)


def to_ros_of(run: int, message: Any) -> Any:
    """The same, for messages that say which run of the world they belong to."""
    return basics.of_run(run, to_ros(message))


def from_ros(message: Any) -> Any:
    """The dataclass for a ROS message.

    Raises:
        MalformedMessage: The message makes no sense.
    """
    read = readers.get(type(message))
    if read is None:
        raise TypeError(f"no dataclass for {type(message).__name__}")
    return read(message)


def from_cdr(cdr: bytes, kind: type) -> Any:
    """The dataclass for a serialized ROS message of a class; as `from_ros`."""
    return from_ros(basics.read_cdr(cdr, kind))


def _read_verb(message: Any) -> Any:
    read = _verbs.get((type(message), message.verb))
    if read is None:
        raise basics.MalformedMessage(f"{message.verb[:40]!r} is no verb of {type(message).__name__}")
    return read(message)


def row(
    kind: type,
    ros: Any,
    *,
    ways: Mapping[str, Way] | None = None,
    apart: tuple[str, ...] = (),
    check: Callable[[Any], None] | None = None,
    verb: str = "",
    **constants: int,
) -> Codec:
    """Compile the codec of a message. `to_ros` takes the first one of a dataclass.

    Args:
        kind: The dataclass.
        ros: Its message.
        ways: How fields travel whose hints do not say it.
        apart: Fields of one that the other lacks, for the caller to fill; those of the dataclass that have no default
            are arguments of the codec's `from_ros`, in their order.
        check: Refuses what is read though each field makes sense, by a `MalformedMessage`.
        verb: Says which of the dataclasses that share the message it holds.
        constants: What other fields of a shared message hold then.

    Raises:
        TypeError: A field without a counterpart, or a hint that no rule is for.
    """
    found = _Expressions(kind, ros)
    parameters, steps, to_value = ["message"], "", []
    to_message = {name: repr(value) for name, value in ({"verb": verb} | constants if verb else constants).items()}
    for field in fields(kind):
        name, targets = field.name, (field.name,)
        if name not in apart:
            targets, out, back = found.of_field(name, (ways or {}).get(name, Way()))
            if len(targets) > 1:
                steps, out = f"{steps}    {', '.join(targets)} = {out}\n", ""
            to_message |= {target: out or target for target in targets}
            to_value.append(f"{name}={back}")
        elif field.default is MISSING:
            parameters.append(name)
            to_value.append(f"{name}={name}")
    to_message |= {name: f"value.{name}" for name in found.types if isinstance(getattr(kind, name, None), property)}
    left = found.types.keys() - to_message.keys() - {*apart, "header", "stamp", "run"}
    if left and not verb:
        raise TypeError(f"{ros.__name__} has more than {kind.__name__}: {', '.join(sorted(left))}")
    source = _SOURCE.format(
        steps=steps,
        to_message=", ".join(f"{name}={out}" for name, out in to_message.items()),
        parameters=", ".join(parameters),
        to_value=", ".join(to_value),
        check="    check(value)\n" if check else "",
    )
    names = {**found.names, "Kind": kind, "Message": ros, "check": check}
    exec(compile(source, f"<codec of {kind.__name__}>", "exec"), names)
    codec = Codec(ros, names["to_ros"], names["from_ros"])
    codecs.setdefault(kind, codec)
    if verb:
        _verbs[ros, verb], readers[ros] = codec.from_ros, _read_verb
    elif len(parameters) == 1:
        readers[ros] = codec.from_ros
    return codec


class _Expressions:
    """The expressions for the fields of a dataclass, and the names in them."""

    def __init__(self, kind: type, ros: Any) -> None:
        self.types, self.names = ros.get_fields_and_field_types(), dict(vars(basics))
        self._kind, self._ros, self._hints, self._first_array = kind, ros, get_type_hints(kind), ""

    def of_field(self, name: str, way: Way) -> tuple[tuple[str, ...], str, str]:
        """The fields of the message that hold it, its expression for them, and theirs for it."""
        stamps = [target for target in _WAYS_OF_TIMES if target in self.types] if name == "time" else []
        own = name if name in self.types else name.rpartition("_")[0]
        targets = way.names or (*stamps[:1], own)[:1]
        if not self.types.keys() >= {*targets}:
            raise TypeError(f"{self._kind.__name__}.{name}: its message has no {' or '.join(targets)}")
        out, back = ("", "") if way.out and way.back else self._of_target(self._hints[name], targets[0])
        if way.out:
            self.names[f"{name}_out"], out = way.out, f"{name}_out({{}})"
        if way.back:
            self.names[f"{name}_back"], back = way.back, f"{name}_back({{}})"
        arguments = ", ".join(f"message.{target}" for target in targets)
        return targets, out.format(f"value.{name}"), back.format(arguments)

    def _of_target(self, hint: Any, target: str) -> tuple[str, str]:
        if get_origin(hint) is not np.ndarray:
            return _WAYS_OF_TIMES.get(target) or self._of_hint(hint)
        self._first_array = self._first_array or target
        dtype = get_args(get_args(hint)[1])[0]
        self.names[dtype.__name__] = dtype
        typecode = getattr(self._ros(), target).typecode
        return f"pack({typecode!r}, {{}})", f"unpack({{}}, {dtype.__name__}, len(message.{self._first_array}))"

    def _of_hint(self, hint: Any) -> tuple[str, str]:
        name = getattr(hint, "__name__", "")
        if hint in _WAYS:
            return _WAYS[hint]
        if get_origin(hint) in (tuple, frozenset):
            out, back = (way.format("each") for way in self._of_hint(get_args(hint)[0]))
            return f"[{out} for each in {{}}]", f"{name}([{back} for each in not_absurd({{}})])"
        if hint in codecs:
            ros, self.names[f"{name}_out"], self.names[f"{name}_back"] = codecs[hint]
            has_run = "run" in self._hints and "run" in ros.get_fields_and_field_types()
            return f"of_run(value.run, {name}_out({{}}))" if has_run else f"{name}_out({{}})", f"{name}_back({{}})"
        if isinstance(hint, type) and issubclass(hint, StrEnum):
            self.names[name] = hint
            return "{}.value", f"member({name}, {{}})"
        raise TypeError(f"no rule for {hint} in {self._kind.__name__}")
