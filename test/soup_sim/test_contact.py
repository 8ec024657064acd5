"""Discs touch at the computed instant, and never pass through each other."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from soup_sim.contact import after, first_touch

R = 2.0


@pytest.mark.parametrize(
    ("start", "velocity", "expected"),
    [
        ((10.0, 0.0), (-4.0, 0.0), 2.0),  # head on
        ((8.0, 8.0), (-4.0, -4.0), (math.hypot(8.0, 8.0) - 2.0) / math.hypot(4.0, 4.0)),  # crossing at a right angle
        ((10.0, 1.999), (-4.0, 0.0), (10.0 - math.sqrt(4.0 - 1.999**2)) / 4.0),  # glancing
        ((10.0, 2.001), (-4.0, 0.0), math.inf),  # a miss
        ((10.0, 0.0), (4.0, 0.0), math.inf),  # parting
    ],
)
def test_contact_at_constant_velocity_is_at_the_computed_instant(start, velocity, expected) -> None:
    assert first_touch(start[0], start[1], velocity[0], velocity[1], 0.0, 0.0, R, 100.0) == pytest.approx(
        expected, abs=1e-9
    )


def test_contact_while_accelerating_is_at_the_computed_instant() -> None:
    # head on from rest at 5 m/s2 over 8 m
    assert first_touch(10.0, 0.0, 0.0, 0.0, -5.0, 0.0, R, 100.0) == pytest.approx(math.sqrt(16.0 / 5.0), abs=1e-9)
    # braking just enough not to touch
    assert first_touch(10.0, 0.0, -4.0, 0.0, 1.001, 0.0, R, 100.0) == math.inf
    assert first_touch(10.0, 0.0, -4.0, 0.0, 0.999, 0.0, R, 100.0) < math.inf


def test_discs_that_touch_may_part_but_not_close_in() -> None:
    assert first_touch(2.0, 0.0, 1.0, 0.0, 0.0, 0.0, R, 1.0) == math.inf
    assert first_touch(2.0, 0.0, 0.0, 1.0, 0.0, 0.0, R, 1.0) == math.inf
    assert first_touch(2.0, 0.0, -1e-3, 0.0, 0.0, 0.0, R, 1.0) == 0.0
    assert first_touch(2.0, 0.0, 0.0, 0.0, -1.0, 0.0, R, 1.0) == 0.0
    assert first_touch(2.0, 0.0, 1.0, 0.0, -2.0, 0.0, R, 5.0) == pytest.approx(1.0, abs=1e-6)


numbers = st.floats(-20.0, 20.0)


@given(numbers, numbers, st.floats(-1e4, 1e4), st.floats(-1e4, 1e4), numbers, numbers)
def test_nothing_tunnels_at_any_speed(px, py, vx, vy, ax, ay) -> None:
    if math.hypot(px, py) < R + 1e-3:
        return
    when = first_touch(px, py, vx, vy, ax, ay, R, 2.0)
    times = np.linspace(0.0, min(when, 2.0), 20_001)
    distances = np.hypot(px + vx * times + 0.5 * ax * times**2, py + vy * times + 0.5 * ay * times**2)
    assert distances.min() >= R - 1e-6
    if when < math.inf:
        at = np.hypot(px + vx * when + 0.5 * ax * when**2, py + vy * when + 0.5 * ay * when**2)
        assert at == pytest.approx(R, abs=1e-6)


@given(st.floats(0.0, 1e9), st.floats(0.0, 1e9))
def test_a_search_goes_on_in_time_however_late_it_is(t: float, end: float) -> None:
    assert after(t, end) > t
    assert after(t, end) == end or end <= t + max(1e-12, 1e-15 * t)
