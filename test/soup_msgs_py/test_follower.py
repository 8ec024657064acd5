"""A part that has said something for a later time holds the world there until it has got to where it must."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from rclpy.serialization import serialize_message

from soup_msgs_py import topics
from soup_msgs_py.allegiance import SILENT_S
from soup_msgs_py.codes import EventType
from soup_msgs_py.live.follower import Follower
from soup_msgs_py.messages import AssignBundle, Beat, Event, Heard
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

    def belongs(self, said: int, run: int) -> bool:
        return run in (0, said)

    def waits(self, _why: str) -> None:
        pass

    def works(self) -> None:
        pass


class Mind:
    """Wants nothing."""

    next_wake = NEVER
    reacts_to = EVERYTHING
    lost = False

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
        self.world = load_warehouse(CONFIG / "scenarios/demo.yaml", []).world(1, run=1)
        self.announce(1)
        self.snapshot(1)
        assert self.follower.in_step

    def announce(self, run: int) -> None:
        """A world of this run begins, or a bag of it is played."""
        world = self.world
        profile = tuple(map(float, world.tile_profile))
        self.wires.takes[topics.SCENARIO](Announcement(world.now, world.scenario, world.layout, profile, run))

    def snapshot(self, run: int) -> None:
        """It sends a snapshot."""
        snapshot = replace(self.world.snapshot(), run=run)
        self.wires.takes[topics.SNAPSHOT](serialize_message(to_ros(snapshot)))

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


def test_a_part_stays_with_its_world_while_the_bag_of_another_run_is_played(
    part: Part, monkeypatch: pytest.MonkeyPatch
):
    mind, wall = part.follower.mind, time.monotonic()
    part.announce(2)
    for second in range(20):
        monkeypatch.setattr(time, "monotonic", lambda second=second: wall + second)
        part.snapshot(2)
        part.snapshot(1)
        part.wires.looks[0]()
    assert (part.follower.run, part.follower.in_step) == (1, True)
    assert part.follower.mind is mind


def test_a_part_changes_over_to_a_world_that_is_started_again(part: Part, monkeypatch: pytest.MonkeyPatch):
    mind, wall = part.follower.mind, time.monotonic()
    part.announce(2)
    monkeypatch.setattr(time, "monotonic", lambda: wall + SILENT_S)
    part.wires.looks[0]()
    part.snapshot(2)
    assert (part.follower.run, part.follower.in_step) == (2, True)
    assert part.follower.mind is not mind


def test_a_mind_that_is_lost_joins_anew_at_the_next_snapshot(part: Part):
    mind: Any = part.follower.mind
    mind.lost = True
    part.wires.takes[topics.EVENTS](Event(0.0, part.world.sequence + 1, EventType.GRABBED, bot=99, bucket=9999))
    assert not part.follower.in_step
    mind.lost = False
    part.world.handle(AssignBundle(part.world.scenario.word_station_count, tile=0))
    part.snapshot(1)
    assert part.follower.in_step
