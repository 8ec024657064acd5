"""Simulated time follows wall time at the real-time factor, and never jumps."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from soup_sim.pacing import FASTEST_WITHOUT, LONGEST_STRIDE_S, LONGEST_STRIDE_SIMULATED_S, Pacer


def test_time_begins_with_the_first_look():
    assert Pacer(5.0, math.inf).until(1000.0, 0.0) == 0.0


def test_simulated_time_runs_the_factor_faster_than_wall_time():
    pacer, now = Pacer(5.0, math.inf), 0.0
    for tick in range(101):
        now = pacer.until(7.0 + 0.01 * tick, now)
    assert now == pytest.approx(5.0)
    assert pacer.wall_seconds == pytest.approx(1.0)


def test_a_machine_that_is_late_runs_slower_instead_of_jumping():
    pacer = Pacer(5.0, math.inf)
    pacer.until(0.0, 0.0)
    assert pacer.until(60.0, 0.0) == pytest.approx(5.0 * LONGEST_STRIDE_S)


def test_a_world_that_had_to_wait_for_a_moment_catches_up():
    pacer = Pacer(5.0, math.inf)
    pacer.until(0.0, 0.0)
    assert pacer.until(0.02, 0.0) == pytest.approx(0.1)
    assert pacer.until(0.04, 0.0) == pytest.approx(0.2)


def test_a_paused_world_stands_and_its_wall_time_does_not_count():
    pacer = Pacer(1.0, math.inf, paused=True)
    assert [pacer.until(wall, 3.0) for wall in (0.0, 1.0, 2.0)] == [3.0, 3.0, 3.0]
    assert pacer.wall_seconds == 0.0
    pacer.pause(False)
    assert pacer.until(2.05, 3.0) == pytest.approx(3.05)


def test_a_step_goes_on_for_its_time_and_pauses_again():
    pacer, now = Pacer(1.0, math.inf, paused=True), 2.0
    pacer.until(0.0, now)
    pacer.step(now, 0.25)
    for tick in range(1, 50):
        now = pacer.until(0.05 * tick, now)
    assert now == pytest.approx(2.25)
    assert pacer.paused


@given(st.floats(0.01, 100), st.floats(0, 50), st.lists(st.floats(0, 3), max_size=30))
def test_time_never_goes_back_nor_beyond_the_end(speed: float, end: float, waits: list[float]):
    pacer, wall, now = Pacer(speed, end), 0.0, 0.0
    for wait in waits:
        wall += wait
        later = pacer.until(wall, now)
        assert now <= later <= max(end, now)
        now = later


def test_a_world_without_a_limit_goes_on_by_whole_strides_whatever_the_wall_clock_says():
    pacer = Pacer(math.inf, 100.0)
    assert pacer.until(0.0, 0.0) == LONGEST_STRIDE_SIMULATED_S
    assert pacer.until(0.0, LONGEST_STRIDE_SIMULATED_S) == 2.0 * LONGEST_STRIDE_SIMULATED_S
    assert pacer.until(0.5, 99.0) == 100.0


@pytest.mark.parametrize(("speed", "most"), [(math.inf, FASTEST_WITHOUT), (50.0, FASTEST_WITHOUT), (5.0, 5.0)])
def test_a_world_that_goes_on_without_somebody_does_not_race(speed: float, most: float):
    pacer, now = Pacer(speed, math.inf), 0.0
    for tick in range(101):
        now = pacer.until(7.0 + 0.01 * tick, now, without=True)
    assert now == pytest.approx(most)
