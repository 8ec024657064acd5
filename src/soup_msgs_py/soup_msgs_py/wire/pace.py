"""What keeps the world and the parts that think in step."""

from __future__ import annotations

import math

from soup_msgs import msg

from soup_msgs_py.messages import Beat, Heard
from soup_msgs_py.wire.basics import MalformedMessage, check_finite, from_ros, to_ros


@to_ros.register
def _(beat: Beat) -> msg.Beat:
    return msg.Beat(time=float(beat.time), number=beat.number)


@from_ros.register
def _(beat: msg.Beat) -> Beat:
    check_finite(beat.time)
    return Beat(beat.time, beat.number)


@to_ros.register
def _(heard: Heard) -> msg.Heard:
    return msg.Heard(part=heard.part, beat=heard.beat, next_time=heard.next_time, leaves=heard.leaves)


@from_ros.register
def _(heard: msg.Heard) -> Heard:
    if math.isnan(heard.next_time):
        raise MalformedMessage("a time that is no number")
    return Heard(heard.part, heard.beat, heard.next_time, heard.leaves)
