"""What all conversions share: stamps, numbers, lists, outcomes, and what is refused of them."""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterable, Sequence
from enum import StrEnum
from typing import Any, TypeVar

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point as RosPoint
from rclpy.serialization import deserialize_message
from soup_msgs import msg
from std_msgs.msg import Header

from soup_msgs_py import topics
from soup_msgs_py.codes import Code
from soup_msgs_py.messages import Point

MOST = 100_000  # elements in any one list
MOST_BYTES = 1 << 20  # of a message, unless it may hold the whole floor
MOST_BYTES_OF_A_FLOOR = 1 << 26
OF_A_FLOOR = (msg.Scenario, msg.Snapshot, msg.WorldState, msg.Bots, msg.Buckets, msg.Stations)
MOST_S = 2.0**31 - 1.0  # no stamp holds a later time
MOST_M = 1e9  # no floor is that wide
Member = TypeVar("Member", bound=StrEnum)
Result = TypeVar("Result")


class MalformedMessage(ValueError):
    """A message from the wire that makes no sense; shells count it and drop it."""


def to_stamp(seconds: float) -> Time:
    """A simulated time as a stamp."""
    whole, nanoseconds = divmod(round(seconds * 1e9), 1_000_000_000)
    return Time(sec=whole, nanosec=nanoseconds)


def from_stamp(stamp: Time) -> float:
    """A stamp as simulated time (s)."""
    return stamp.sec + stamp.nanosec * 1e-9


def header_at(seconds: float) -> Header:
    """The header of what is true at a simulated time, in frame `map`."""
    return Header(stamp=to_stamp(seconds), frame_id=topics.FRAME)


def pack(typecode: str, values: Any) -> array:
    """Numbers as the array that a ROS message holds, without a Python object a number."""
    packed = array(typecode)
    packed.frombytes(np.ascontiguousarray(values, dtype=typecode).tobytes())
    return packed


def unpack(values: Any, dtype: type, size: int | None = None) -> Any:
    """The array of a ROS message as a numpy array, checked: its length (`size`), finite numbers."""
    unpacked = np.asarray(values).astype(dtype)
    not_absurd(unpacked)
    if size is not None and len(unpacked) != size:
        raise MalformedMessage(f"lists of {size} and {len(unpacked)} elements that should be equally long")
    if unpacked.dtype.kind == "f" and not np.isfinite(unpacked).all():
        raise MalformedMessage("a number that is not finite")
    return unpacked


def finite(number: float) -> float:
    """The number, if it is one."""
    if not math.isfinite(number):
        raise MalformedMessage("a number that is not finite")
    return number


def bounded(seconds: float) -> float:
    """The time, if a stamp can hold it."""
    if not abs(seconds) <= MOST_S:
        raise MalformedMessage(f"a time of {seconds:g} s; allowed: at most {MOST_S:.0f} s")
    return seconds


def to_times(seconds: Sequence[float]) -> tuple[float, ...]:
    """Times of a ROS message, if stamps can hold them."""
    for time in not_absurd(seconds):
        if not abs(time) <= MOST_S:
            bounded(time)
    return tuple(seconds)


def check_frame(frame: str) -> None:
    """Refuse places in a frame that nobody here can turn into the floor's; an empty one is the floor's."""
    if frame not in ("", topics.FRAME):
        raise MalformedMessage(f"places in frame {frame[:40]!r}; allowed: {topics.FRAME!r}")


def not_absurd(values: Any) -> Any:
    """The list, unless it is longer than any that makes sense."""
    if len(values) > MOST:
        raise MalformedMessage(f"a list of {len(values)} elements")
    return values


def to_ints(values: Iterable[int]) -> tuple[int, ...]:
    """The integers of a ROS message."""
    return tuple(not_absurd(values).tolist() if isinstance(values, array) else map(int, values))


def member(kind: type[Member], text: str) -> Member:
    """The member of an enumeration that a text names."""
    try:
        return kind(text)
    except ValueError as error:
        raise MalformedMessage(f"{text[:40]!r} is no {kind.__name__}") from error


def to_points(points: Iterable[Point]) -> list[RosPoint]:
    """Points of the floor (m) for a ROS message."""
    return [RosPoint(x=float(x), y=float(y)) for x, y in points]


def from_points(points: Sequence[RosPoint]) -> tuple[Point, ...]:
    """Points of the floor (m) from a ROS message; their height is of no interest."""
    for point in not_absurd(points):
        if not (abs(point.x) <= MOST_M and abs(point.y) <= MOST_M):
            raise MalformedMessage(f"a place at ({point.x:g}, {point.y:g}); allowed: at most {MOST_M:g} m from 0")
    return tuple((point.x, point.y) for point in points)


def of_run(run: int, message: Any, part: str | None = None) -> Any:
    """The ROS message, told which run of the world it belongs to, and which process."""
    message.run = run
    if part is not None:
        message.part = part
    return message


def read_cdr(cdr: bytes, kind: type) -> Any:
    """The ROS message, of a class, in serialized form.

    Its size is looked at first: what is refused is not unpacked, which takes far longer than to receive it.

    Raises:
        MalformedMessage: It is none of that class, or too long.
    """
    most = MOST_BYTES_OF_A_FLOOR if issubclass(kind, OF_A_FLOOR) else MOST_BYTES
    if len(cdr) > most:
        raise MalformedMessage(f"a message of {len(cdr)} bytes; allowed: at most {most}")
    try:
        return deserialize_message(cdr, kind)
    except (RuntimeError, UnicodeDecodeError) as error:  # the RMW's own error is a RuntimeError
        raise MalformedMessage(f"{len(cdr)} bytes that are no {kind.__name__}") from error


def fill_result(result: Result, code: Code, message: str) -> Result:
    """Write an outcome into the response of a service or the result of an action."""
    outcome: Any = result
    outcome.success = code is Code.DONE
    outcome.code, outcome.message = code.value, message
    return result


def read_result(result: Any) -> tuple[Code, str]:
    """The outcome in the response of a service or the result of an action."""
    return member(Code, result.code), result.message
