"""The world stays where it has said something until everybody who thinks has heard it."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from soup_msgs_py.codes import Code, EventType
from soup_msgs_py.messages import Beat, BotReply, Event, Heard
from soup_sim.lockstep import BOTS_PATIENCE_S, FIRST_ANSWERS, FIRST_PATIENCE_S, PATIENCE_S, Lockstep

REACTS = frozenset({EventType.BOT_COLLISION, EventType.WORD_COMPLETED})
FLEET = Heard("fleet manager", 0, math.inf, REACTS)
BOTS = Heard("bots 0-3", 0, math.inf, REACTS, frozenset(range(4)))
STRUCK = Event(1.0, 1, EventType.BOT_COLLISION, bots=(3, 7))


def answer(part: Heard, beat: Beat) -> Heard:
    """What a part says when it has heard a beat."""
    return replace(part, beat=beat.number)


@pytest.fixture
def listeners() -> Lockstep:
    """The fleet manager and some bots follow the world, which has said something that concerns both."""
    listeners = Lockstep()
    listeners.hear(FLEET, 0.0)
    listeners.hear(BOTS, 0.0)
    for _ in range(FIRST_ANSWERS):
        listeners.tell(STRUCK)
        beat = listeners.beat(0.5, 0.0)
        for part in (FLEET, BOTS):
            listeners.hear(answer(part, beat), 0.0)
    listeners.tell(STRUCK)
    return listeners


def test_a_world_that_nobody_follows_waits_for_nobody():
    listeners = Lockstep()
    listeners.beat(1.0, 0.0)
    assert not listeners.wait(0.0)
    assert listeners.next_time == math.inf


def test_the_world_waits_until_everybody_has_heard_it(listeners: Lockstep):
    assert not listeners.wait(0.0)
    beat = listeners.beat(1.0, 0.0)
    listeners.hear(answer(BOTS, beat), 0.1)
    assert listeners.wait(0.1)
    listeners.hear(answer(FLEET, beat), 0.2)
    assert not listeners.wait(0.2)


def test_what_was_heard_before_does_not_count_for_a_second_beat_at_the_same_instant(listeners: Lockstep):
    first = listeners.beat(1.0, 0.0)
    listeners.tell(STRUCK)
    second = listeners.beat(1.0, 0.0)
    for part in (BOTS, FLEET):
        listeners.hear(answer(part, first), 0.1)
    assert listeners.wait(0.1)
    assert second.number > first.number


def test_time_stops_when_the_first_one_wants_to_look_around(listeners: Lockstep):
    listeners.hear(replace(BOTS, next_time=2.5), 0.0)
    listeners.hear(replace(FLEET, next_time=4.0), 0.0)
    assert listeners.next_time == 2.5
    listeners.beat(2.5, 0.0)
    assert listeners.next_time == 4.0


def test_a_part_that_leaves_is_not_waited_for(listeners: Lockstep):
    listeners.beat(1.0, 0.0)
    for part in (BOTS, FLEET):
        listeners.hear(replace(part, leaves=True), 0.0)
    assert not listeners.wait(0.0)
    assert listeners.next_time == math.inf
    assert listeners.lost == ()


def test_the_world_loses_its_patience_with_a_part_that_is_silent_until_it_speaks_again(listeners: Lockstep):
    beat = listeners.beat(1.0, 0.0)
    listeners.hear(answer(BOTS, beat), 0.1)
    assert listeners.wait(PATIENCE_S)
    assert not listeners.wait(PATIENCE_S + 0.1)
    assert listeners.lost == ("fleet manager",)
    assert "fleet manager" in listeners.beat(1.5, PATIENCE_S + 0.5).parts  # it may only have stood still
    assert not listeners.wait(PATIENCE_S + 0.5)
    listeners.hear(answer(FLEET, beat), PATIENCE_S + 1.0)
    assert listeners.lost == ()
    listeners.tell(STRUCK)
    listeners.beat(2.0, PATIENCE_S + 1.0)
    assert listeners.wait(PATIENCE_S + 1.0)


def test_a_manager_that_has_just_begun_is_waited_for_while_it_compiles_what_it_computes_with():
    listeners = Lockstep()
    listeners.hear(FLEET, 0.0)
    listeners.tell(STRUCK)
    listeners.beat(1.0, 0.0)
    assert listeners.wait(FIRST_PATIENCE_S)
    assert not listeners.wait(FIRST_PATIENCE_S + 0.1)


def test_bots_are_waited_for_less_long_than_who_may_have_to_think(listeners: Lockstep):
    beat = listeners.beat(1.0, 0.0)
    assert listeners.wait(BOTS_PATIENCE_S + 0.1)
    assert listeners.lost == ("bots 0-3",)
    listeners.hear(answer(FLEET, beat), BOTS_PATIENCE_S + 0.2)
    assert not listeners.wait(BOTS_PATIENCE_S + 0.2)


def test_nobody_is_lost_while_the_world_is_paused(listeners: Lockstep):
    listeners.beat(1.0, 0.0)
    assert listeners.wait(10.0 * PATIENCE_S, paused=True)
    assert listeners.wait(10.5 * PATIENCE_S)
    assert listeners.lost == ()


def test_a_world_that_goes_on_waits_until_those_are_back_who_followed_it():
    listeners = Lockstep(7)
    listeners.expect(["fleet manager", "bots 0-3"], 0.0)
    assert listeners.names == ["fleet manager", "bots 0-3"]
    assert listeners.wait(0.1)
    listeners.hear(FLEET, 0.2)
    assert listeners.wait(0.2)
    listeners.hear(BOTS, 0.3)
    assert not listeners.wait(0.3)
    listeners.tell(STRUCK)
    assert listeners.beat(1.0, 0.3).number > 7
    assert listeners.wait(0.3)


def test_a_world_that_goes_on_does_not_wait_for_ever():
    listeners = Lockstep()
    listeners.expect(["fleet manager", "bots 0-3"], 0.0)
    listeners.hear(FLEET, 0.2)
    assert not listeners.wait(PATIENCE_S + 0.1)
    assert listeners.lost == ("bots 0-3",)
    listeners.hear(BOTS, PATIENCE_S + 0.2)
    assert listeners.lost == ()


def test_it_can_be_asked_for_whom_the_world_waits_most(listeners: Lockstep):
    assert listeners.waited(0.0).startswith("0 %")
    beat = listeners.beat(1.0, 0.0)
    listeners.hear(answer(BOTS, beat), 0.1)
    listeners.hear(answer(FLEET, beat), 0.5)
    assert listeners.waited(1.0) == "50 % of the time, most for fleet manager"
    assert listeners.waited(2.0).startswith("0 %")


@pytest.mark.parametrize(
    ("said", "who"),
    [
        (STRUCK, ("fleet manager", "bots 0-3")),
        (Event(1.0, 1, EventType.BOT_COLLISION, bots=(7, 8)), ("fleet manager",)),
        (Event(1.0, 1, EventType.WORD_COMPLETED, job=3), ("fleet manager",)),
        (Event(1.0, 1, EventType.TRANSFERRED, bot=3), ()),
        (BotReply(3, 1, Code.DONE, "", 1.0, 0.0, 0.0), ("bots 0-3",)),
        (BotReply(7, 1, Code.DONE, "", 1.0, 0.0, 0.0), ()),
    ],
)
def test_only_those_whom_it_concerns_have_to_hear_it(said: Event | BotReply, who: tuple[str, ...]):
    listeners = Lockstep()
    listeners.hear(FLEET, 0.0)
    listeners.hear(BOTS, 0.0)
    listeners.tell(said)
    assert listeners.asked == bool(who)
    assert listeners.beat(1.0, 0.0).parts == who
    assert not listeners.asked
    assert listeners.wait(0.0) == bool(who)
