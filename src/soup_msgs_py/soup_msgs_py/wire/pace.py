"""What keeps the world and the parts that think in step, and says who is in charge of what."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from soup_msgs import msg

from soup_msgs_py.codes import EventType
from soup_msgs_py.mail import Counts
from soup_msgs_py.messages import Beat, Charge, Heard
from soup_msgs_py.wire.basics import MalformedMessage, check_times, from_ros, member, not_absurd, pack, to_ints, to_ros

_PART = re.compile(r"(word|letter|fleet) manager|bots [0-9,-]+")
_CHANNEL = re.compile(r"bound|(goals|results) (deliver|store)|(orders|outcomes) bots [0-9,-]+|drives [0-9]+")


@to_ros.register
def _(beat: Beat) -> msg.Beat:
    return msg.Beat(
        time=float(beat.time),
        number=beat.number,
        parts=list(beat.parts),
        sequence=beat.sequence,
        replies=[to_ros(reply) for reply in beat.replies],
    )


@from_ros.register
def _(beat: msg.Beat) -> Beat:
    check_times(beat.time)
    replies = tuple(from_ros(reply) for reply in not_absurd(beat.replies))
    return Beat(beat.time, beat.number, tuple(beat.parts), beat.sequence, replies)


@to_ros.register
def _(heard: Heard) -> msg.Heard:
    return msg.Heard(
        part=heard.part,
        beat=heard.beat,
        next_time=heard.next_time,
        reacts=[kind.value for kind in heard.reacts],
        bots=pack("i", sorted(heard.bots)),
        leaves=heard.leaves,
        sent_on=[name for name, _ in heard.sent],
        sent=[count for _, count in heard.sent],
        got_on=[name for name, _ in heard.got],
        got=[count for _, count in heard.got],
    )


@from_ros.register
def _(heard: msg.Heard) -> Heard:
    if math.isnan(heard.next_time):
        raise MalformedMessage("a time that is no number")
    if not _PART.fullmatch(heard.part):
        raise MalformedMessage(f"{heard.part[:40]!r} is no part that the world would wait for")
    reacts = frozenset(member(EventType, kind) for kind in heard.reacts)
    return Heard(
        heard.part,
        heard.beat,
        heard.next_time,
        reacts,
        frozenset(to_ints(heard.bots)),
        heard.leaves,
        _counts(heard.sent_on, heard.sent),
        _counts(heard.got_on, heard.got),
    )


def _counts(names: Sequence[str], counts: Sequence[int]) -> Counts:
    if len(names) != len(counts):
        raise MalformedMessage(f"{len(counts)} counts for {len(names)} channels")
    if not all(_CHANNEL.fullmatch(name) for name in names):
        raise MalformedMessage("counts of a channel that there is not")
    return tuple(zip(names, map(int, counts), strict=True))


@to_ros.register
def _(charge: Charge) -> msg.Charge:
    bots = pack("i", charge.bots)
    return msg.Charge(part=charge.part, term=charge.term, rank=charge.rank, policy=charge.policy, bots=bots)


@from_ros.register
def _(charge: msg.Charge) -> Charge:
    return Charge(charge.part, charge.term, charge.rank, charge.policy, to_ints(charge.bots))
