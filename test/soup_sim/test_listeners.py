"""The world stays where it has said something until everybody who thinks has heard it."""

from __future__ import annotations

import math

import pytest

from soup_msgs_py.messages import Heard
from soup_sim.listeners import PATIENCE_S, Listeners


@pytest.fixture
def listeners() -> Listeners:
    """The fleet manager and some bots follow the world."""
    listeners = Listeners()
    for part in ("fleet manager", "bots 0-3"):
        listeners.hear(Heard(part, 0, math.inf), 0.0)
    return listeners


def test_a_world_that_nobody_follows_waits_for_nobody():
    listeners = Listeners()
    listeners.beat(1.0, 0.0)
    assert not listeners.wait(0.0)
    assert listeners.next_time == math.inf


def test_the_world_waits_until_everybody_has_heard_it(listeners: Listeners):
    assert not listeners.wait(0.0)
    beat = listeners.beat(1.0, 0.0)
    listeners.hear(Heard("bots 0-3", beat.number, math.inf), 0.1)
    assert listeners.wait(0.1)
    listeners.hear(Heard("fleet manager", beat.number, math.inf), 0.2)
    assert not listeners.wait(0.2)


def test_what_was_heard_before_does_not_count_for_a_second_beat_at_the_same_instant(listeners: Listeners):
    first, second = listeners.beat(1.0, 0.0), listeners.beat(1.0, 0.0)
    for part in ("bots 0-3", "fleet manager"):
        listeners.hear(Heard(part, first.number, math.inf), 0.1)
    assert listeners.wait(0.1)
    assert second.number > first.number


def test_time_stops_when_the_first_one_wants_to_look_around(listeners: Listeners):
    listeners.hear(Heard("bots 0-3", 0, 2.5), 0.0)
    listeners.hear(Heard("fleet manager", 0, 4.0), 0.0)
    assert listeners.next_time == 2.5
    listeners.beat(2.5, 0.0)
    assert listeners.next_time == 4.0


def test_a_part_that_leaves_is_not_waited_for(listeners: Listeners):
    listeners.beat(1.0, 0.0)
    for part in ("bots 0-3", "fleet manager"):
        listeners.hear(Heard(part, 0, 3.0, leaves=True), 0.0)
    assert not listeners.wait(0.0)
    assert listeners.next_time == math.inf
    assert listeners.lost == ()


def test_the_world_loses_its_patience_with_a_part_that_is_silent_until_it_speaks_again(listeners: Listeners):
    beat = listeners.beat(1.0, 0.0)
    listeners.hear(Heard("bots 0-3", beat.number, math.inf), 0.1)
    assert listeners.wait(PATIENCE_S)
    assert not listeners.wait(PATIENCE_S + 0.1)
    assert listeners.lost == ("fleet manager",)
    listeners.hear(Heard("fleet manager", beat.number, math.inf), PATIENCE_S + 1.0)
    assert listeners.lost == ()
    listeners.beat(2.0, PATIENCE_S + 1.0)
    assert listeners.wait(PATIENCE_S + 1.0)


def test_nobody_is_lost_while_the_world_is_paused(listeners: Listeners):
    listeners.beat(1.0, 0.0)
    assert listeners.wait(10.0 * PATIENCE_S, paused=True)
    assert listeners.wait(10.5 * PATIENCE_S)
    assert listeners.lost == ()


def test_it_can_be_asked_for_whom_the_world_waits_most(listeners: Listeners):
    assert listeners.waited(0.0).startswith("0 %")
    beat = listeners.beat(1.0, 0.0)
    listeners.hear(Heard("bots 0-3", beat.number, math.inf), 0.1)
    listeners.hear(Heard("fleet manager", beat.number, math.inf), 0.5)
    assert listeners.waited(1.0) == "50 % of the time, most for fleet manager"
    assert listeners.waited(2.0).startswith("0 %")
