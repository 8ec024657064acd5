"""A part tells the world that it has heard a beat once nothing is missing any more that belongs before it."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from rclpy.serialization import serialize_message

from soup_live.allegiance import SILENT_S
from soup_live.world_client import WorldClient
from soup_msgs_py import topics
from soup_msgs_py.codes import Code, EventType
from soup_msgs_py.messages import AssignBundle, Beat, BotReply, Event, Heard
from soup_msgs_py.mind import EVERYTHING, NEVER
from soup_msgs_py.wire import Announcement, from_ros, to_ros
from soup_sim.scenario_loader import load_warehouse

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

    def guard(self, function: Any) -> Any:
        return function

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


class Service:
    """Stands in for a service of the world and what it will answer."""

    def call_async(self, _request: Any) -> Service:
        return self

    def add_done_callback(self, take: Any) -> None:
        self._take = take

    def result(self) -> Any:
        return self._answer

    def answer(self, answer: Any) -> None:
        """The world answers."""
        self._answer = answer
        self._take(self)


class Part:
    """A client in step with a world."""

    def __init__(self) -> None:
        self.wires = wires = Wires()
        live: Any = wires
        self.client = WorldClient(live, live, live, lambda _: Mind(), lambda _: None, lambda: "")
        self.world = load_warehouse(CONFIG / "scenarios/demo.yaml", []).world(1, run=1)
        self.sequence = self.world.sequence
        self.announce(1)
        self.snapshot(1)
        assert self.client.in_step

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


def test_what_was_said_to_others_is_told_when_the_mind_has_heard_the_message_that_it_was_said_upon(part: Part):
    part.client.mail.got("goals deliver")
    part.client.tell(Beat(2.0, 0))
    assert part.wires.said[-1].got == (("goals deliver", 1),)
    told = len(part.wires.said)
    part.client.tell(Beat(2.0, 0))
    assert len(part.wires.said) == told


def test_who_will_be_asked_by_a_beat_waits_with_its_news_for_it(part: Part):
    part.client.mail.sent("bound")
    told = len(part.wires.said)
    part.client.tell(Beat(2.0, 0), is_asked=True)
    part.client.tell(Beat(2.0, 0))
    assert len(part.wires.said) == told
    part.beat(1, 2.0)
    assert len(part.wires.said) == told + 1
    assert part.wires.said[-1].sent == (("bound", 1),)


def test_where_that_beat_does_not_come_the_news_is_told_all_the_same(part: Part):
    part.client.mail.sent("bound")
    part.client.tell(Beat(2.0, 0), is_asked=True)
    part.wires.looks[0]()
    assert part.wires.said[-1].sent == (("bound", 1),)


def test_a_beat_that_was_faster_than_the_event_before_it_is_heard_after_that(part: Part):
    told = len(part.wires.said)
    sequence = part.sequence
    part.wires.takes[topics.BEAT](Beat(2.0, 1, ("fleet manager",), sequence + 1))
    assert len(part.wires.said) == told
    part.wires.takes[topics.EVENTS](Event(2.0, sequence + 1, EventType.WORD_CLEARED))
    assert part.heard[0] == 1


def test_what_the_world_has_answered_comes_with_the_beat_and_all_of_it_is_taken_in_before_that_is_heard():
    part = Part()
    heard_after: list[int] = []

    def take(reply: BotReply) -> None:
        part.client.tell(reply, is_asked=True)
        heard_after.append(part.heard[0])

    part.client._take_reply = take
    replies = tuple(BotReply(bot, 1, Code.DONE, "there", 2.0, 0.0, 0.0) for bot in (3, 4))
    part.wires.takes[topics.BEAT](Beat(2.0, 1, ("fleet manager",), -1, replies))
    assert heard_after == [0, 0]
    assert part.heard[0] == 1


def test_a_beat_that_was_faster_than_an_event_is_heard_after_what_it_brought(part: Part):
    heard_after: list[int] = []
    part.client._take_reply = lambda _reply: heard_after.append(part.heard[0])
    reply, sequence = BotReply(3, 1, Code.DONE, "there", 2.0, 0.0, 0.0), part.sequence + 1
    part.wires.takes[topics.BEAT](Beat(2.0, 1, ("fleet manager",), sequence, (reply,)))
    assert heard_after == []
    part.wires.takes[topics.EVENTS](Event(2.0, sequence, EventType.WORD_CLEARED))
    assert heard_after == [0]
    assert part.heard[0] == 1


def test_a_beat_is_not_heard_before_the_world_has_answered_what_it_was_asked(part: Part):
    world = Service()
    answers: list[str] = []
    part.client.call(world, "assign a word", answers.append)
    part.beat(1, 2.0)
    assert part.heard[0] == 0
    world.answer("done")
    assert answers == ["done"]
    assert part.heard[0] == 1


def test_a_beat_that_concerns_only_others_is_not_answered(part: Part):
    answered = len(part.wires.said)
    part.wires.takes[topics.BEAT](Beat(2.0, 1, ("another part",)))
    assert len(part.wires.said) == answered
    assert part.client.now == 2.0


def test_the_world_is_told_when_the_mind_reacts_to_other_events_than_before(part: Part):
    mind: Any = part.client.mind
    mind.reacts_to = frozenset({EventType.GRABBED})
    part.client.tell(Beat(2.0, 0))
    assert part.wires.said[-1].reacts == {EventType.GRABBED}


def test_a_part_stays_with_its_world_while_the_bag_of_another_run_is_played(
    part: Part, monkeypatch: pytest.MonkeyPatch
):
    mind, wall = part.client.mind, time.monotonic()
    part.announce(2)
    for second in range(20):
        monkeypatch.setattr(time, "monotonic", lambda second=second: wall + second)
        part.snapshot(2)
        part.snapshot(1)
        part.wires.looks[0]()
    assert (part.client.run, part.client.in_step) == (1, True)
    assert part.client.mind is mind


def test_a_part_changes_over_to_a_world_that_is_started_again(part: Part, monkeypatch: pytest.MonkeyPatch):
    mind, wall = part.client.mind, time.monotonic()
    part.announce(2)
    monkeypatch.setattr(time, "monotonic", lambda: wall + SILENT_S)
    part.wires.looks[0]()
    part.snapshot(2)
    assert (part.client.run, part.client.in_step) == (2, True)
    assert part.client.mind is not mind


def test_a_part_that_has_followed_a_bag_returns_to_the_world_that_still_speaks(
    part: Part, monkeypatch: pytest.MonkeyPatch
):
    wall = time.monotonic()
    part.announce(2)
    monkeypatch.setattr(time, "monotonic", lambda: wall + SILENT_S)  # its world was slow
    part.wires.looks[0]()
    assert part.client.run == 2
    part.snapshot(1)
    assert part.client.run == 2
    monkeypatch.setattr(time, "monotonic", lambda: wall + 2.0 * SILENT_S)  # the bag has ended
    part.snapshot(1)
    part.wires.looks[0]()
    part.snapshot(1)
    assert (part.client.run, part.client.in_step) == (1, True)


def test_a_mind_that_is_lost_joins_anew_at_the_next_snapshot(part: Part):
    mind: Any = part.client.mind
    mind.lost = True
    part.wires.takes[topics.EVENTS](Event(0.0, part.world.sequence + 1, EventType.GRABBED, bot=99, bucket=9999))
    assert not part.client.in_step
    mind.lost = False
    part.world.handle(AssignBundle(part.world.scenario.word_station_count, tile=0))
    part.snapshot(1)
    assert part.client.in_step


def test_time_comes_from_the_world_followed_and_not_from_a_clock_on_which_anybody_may_speak(part: Part):
    assert topics.CLOCK not in part.wires.takes
    part.beat(3, 12.5)
    assert part.client.now == 12.5
