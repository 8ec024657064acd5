"""When recorded moments are due in a replay."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from soup_lab.bags.pace import SLIP_S, ReplayPace

SECOND = 1_000_000_000
BEGIN = 1_790_000_000 * SECOND
speeds = st.floats(0.1, 100.0)
seconds = st.floats(0.0, 1000.0)


@given(speeds, seconds)
def test_spacing_is_the_recorded_one_divided_by_the_speed(speed: float, after: float):
    pace = ReplayPace(speed, 50.0, BEGIN)
    at = BEGIN + round(after * SECOND)
    assert pace.due(at) == pytest.approx(50.0 + after / speed)
    now = pace.now(pace.due(at))
    assert now is not None
    assert abs(now - at) < 1e-5 * SECOND * speed


@given(st.lists(st.tuples(seconds, st.sampled_from(["pause", "go on", "slower", "faster"])), max_size=20))
def test_whatever_is_asked_time_never_jumps_and_never_goes_back(asked: list[tuple[float, str]]):
    pace, wall, before = ReplayPace(1.0, 0.0, BEGIN), 0.0, BEGIN
    for waited, what in asked:
        wall += waited
        now = pace.now(wall)
        assert now is not None
        assert before - 2 <= now <= before + waited * pace.speed * SECOND + 1000
        match what:
            case "pause":
                pace.pause(wall, True)
            case "go on":
                pace.pause(wall, False)
            case _:
                pace.set_speed(wall, pace.speed * (0.5 if what == "slower" else 2.0))
        before = pace.now(wall)
        assert before is not None
        assert abs(before - now) < 1000


def test_paused_nothing_is_due():
    pace = ReplayPace(1.0, 0.0, BEGIN, paused=True)
    assert pace.due(BEGIN + 1) == math.inf
    assert pace.now(100.0) == BEGIN
    pace.pause(100.0, False)
    assert pace.now(101.0) == BEGIN + SECOND


def test_a_step_ends_where_it_was_asked_to_and_stands():
    pace = ReplayPace(1.0, 0.0, BEGIN, paused=True)
    pace.step(10.0, BEGIN + 3 * SECOND)
    assert pace.now(11.0) == BEGIN + SECOND
    assert pace.now(99.0) == BEGIN + 3 * SECOND
    assert not pace.reached(BEGIN + 3 * SECOND)
    assert pace.reached(BEGIN + 4 * SECOND)
    assert pace.paused
    assert pace.now(200.0) == BEGIN + 3 * SECOND


def test_what_cannot_be_made_up_for_is_given_up():
    pace = ReplayPace(10.0, 0.0, BEGIN)
    at = BEGIN + 10 * SECOND
    pace.late(1.0 + SLIP_S / 2, at)
    assert pace.given_up_s == 0.0
    pace.late(1.0 + 2 * SLIP_S, at)
    assert pace.given_up_s == pytest.approx(2 * SLIP_S)
    assert pace.due(at) == pytest.approx(1.0 + 2 * SLIP_S)


def test_without_a_limit_all_is_due():
    pace = ReplayPace(math.inf, 0.0, BEGIN)
    assert pace.now(0.0) is None
    pace.step(0.0, BEGIN + SECOND)
    assert pace.now(0.0) == BEGIN + SECOND
