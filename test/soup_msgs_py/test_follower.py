"""A part that has said something for a later time holds the world there until it has got to where it must."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from rclpy.serialization import serialize_message

from soup_msgs_py import topics
from soup_msgs_py.codes import EventType
from soup_msgs_py.live.follower import Follower
from soup_msgs_py.messages import Beat, Heard
from soup_msgs_py.mind import EVERYTHING, NEVER
from soup_msgs_py.wire import Announcement, from_ros, to_ros
from soup_sim.setup import load_warehouse

CONFIG = Path(__file__).resolve().parents[2] / "config"


class Wires:
    """Stands in for the process, its node and its report: keeps who listens, and what was said."""

    name = "fleet manager"

    def __init__(self) -> None:
        self.values: dict[str, str] = {}
        self.takes: dict[str, Any] = {}
        self.said: list[Heard] = []
        self.looks: list[Any] = []

    def follow(self, _node: Any, _kind: type, topic: str, take: Any, _profile: Any, **_: Any) -> None:
        self.takes[topic] = take

    subscribe = follow

    def create_publisher(self, *_: Any) -> Wires:
        return self

    def publish(self, message: Any) -> None:
        self.said.append(from_ros(message))

    def every(self, _period_s: float, look: Any) -> None:
        self.looks.append(look)

    def at_end(self, _function: Any) -> None:
        pass

    def waits(self, _why: str) -> None:
        pass

    def works(self) -> None:
        pass


class Mind:
    """Wants nothing."""

    next_wake = NEVER
    reacts_to = EVERYTHING

    def handle(self, message: Any, now: float) -> list[Any]:
        return []

    def wake(self, now: float) -> list[Any]:
        return []


class Part:
    """A follower in step with a world, whose hold the test sets."""

    def __init__(self) -> None:
        self.hold = NEVER
        self.wires = wires = Wires()
        live: Any = wires
        self.follower = Follower(
            live, live, live, lambda _: Mind(), lambda _: None, lambda: "", holds=lambda _: self.hold
        )
        world = load_warehouse(CONFIG / "scenarios/demo.yaml", []).world(1, run=1)
        profile = tuple(map(float, world.tile_profile))
        wires.takes[topics.SCENARIO](Announcement(world.now, world.scenario, world.layout, profile, world.run))
        wires.takes[topics.SNAPSHOT](serialize_message(to_ros(world.snapshot())))
        assert self.follower.in_step

    def beat(self, number: int, time: float) -> None:
        """The world says a beat."""
        self.wires.takes[topics.BEAT](Beat(time, number, ("fleet manager",)))

    @property
    def heard(self) -> tuple[int, float]:
        """The newest beat that the world was told was heard, and the time of the next one wanted."""
        return self.wires.said[-1].beat, self.wires.said[-1].next_time


@pytest.fixture
def part() -> Part:
    """A part in step."""
    return Part()


def test_a_beat_before_the_hold_is_heard_at_once_and_the_next_is_wanted_at_the_hold(part: Part):
    part.hold = 3.0
    part.beat(1, 2.0)
    assert part.heard == (1, 3.0)


@pytest.mark.parametrize("by", ["a message", "time"])
def test_a_beat_at_the_hold_is_heard_when_the_hold_is_gone(part: Part, by: str):
    part.hold = 3.0
    part.beat(1, 2.0)
    part.beat(2, 3.0)
    part.follower.tell(Beat(3.0, 0))
    assert part.heard == (1, 3.0)
    part.hold = 4.5
    if by == "a message":
        part.follower.tell(Beat(3.0, 0))
    else:
        part.wires.looks[0]()
    assert part.heard == (2, 4.5)


def test_a_hold_that_comes_between_two_beats_is_told(part: Part):
    part.beat(1, 2.0)
    assert part.heard == (1, NEVER)
    part.hold = 2.5
    part.follower.tell(Beat(2.0, 0))
    assert part.heard == (1, 2.5)


def test_a_beat_that_concerns_only_others_is_not_answered(part: Part):
    answered = len(part.wires.said)
    part.wires.takes[topics.BEAT](Beat(2.0, 1, ("another part",)))
    assert len(part.wires.said) == answered
    assert part.follower.now == 2.0


def test_the_world_is_told_when_the_mind_reacts_to_other_events_than_before(part: Part):
    mind: Any = part.follower.mind
    mind.reacts_to = frozenset({EventType.GRABBED})
    part.follower.tell(Beat(2.0, 0))
    assert part.wires.said[-1].reacts == {EventType.GRABBED}
