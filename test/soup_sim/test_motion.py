"""Bots move as the paper's equations say."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from soup_sim import motion

V, A = 4.0, 20.0
EDGES = np.array([1.0, 99.0, 1.0, 99.0])
places = st.floats(1.0, 99.0)
speeds = st.floats(-5.0, 5.0)


def bot(x: float = 50.0, y: float = 50.0, vx: float = 0.0, vy: float = 0.0, heading: float = 0.0):
    """One bot's arrays: state, segments, count. A bot that moves is in the middle of a cruise."""
    state = np.array([[0.0, x, y, vx, vy, heading]])
    segments = np.zeros((1, motion.MAX_SEGMENTS, 4))
    segments[0, 0, 0] = 1.0
    return state, segments, np.array([1 if vx or vy else 0], dtype=np.int64)


def sample(arrays, times):
    """Position and velocity at many times, shape (n, 4)."""
    return np.array([motion.piece_at(arrays[0], arrays[1], arrays[2], 0, t)[:4] for t in times])


@pytest.mark.parametrize("distance", [0.001, 0.1, 0.79, 0.8, 0.81, 3.0, 47.0])
def test_a_stop_to_stop_move_takes_the_time_of_equation_6_and_its_cruise(distance: float) -> None:
    arrays = bot()
    motion.plan_leg(*arrays, 0, 0.0, 50.0 + distance, 50.0, V, A, 0.0, EDGES, 0.0)
    # equation 6 from rest is t = sqrt(g / A) up to the middle; beyond V^2 / A metres the bot cruises at V
    expected = 2.0 * math.sqrt(distance / A) if distance <= V * V / A else distance / V + V / A
    assert motion.duration_of(*arrays[1:], 0) == pytest.approx(expected, abs=1e-12)
    assert tuple(sample(arrays, [expected])[0]) == pytest.approx((50.0 + distance, 50.0, 0.0, 0.0), abs=1e-9)


def test_a_move_may_be_asked_to_take_longer() -> None:
    arrays = bot()
    motion.plan_leg(*arrays, 0, 0.0, 60.0, 50.0, V, A, 0.0, EDGES, 7.5)
    assert motion.duration_of(*arrays[1:], 0) == pytest.approx(7.5, abs=1e-9)


@given(st.floats(-9.0, 1.6), st.floats(-3.0, 12.0))
def test_a_move_that_is_given_time_of_any_size_takes_it_and_ends_on_its_goal(metres, seconds) -> None:
    distance, asked = 10.0**metres, 10.0**seconds
    arrays = bot()
    motion.plan_leg(*arrays, 0, 0.0, 50.0 + distance, 50.0, V, A, 0.0, EDGES, asked)
    distance = (50.0 + distance) - 50.0  # as far as numbers near 50 tell it
    quickest = 2.0 * math.sqrt(distance / A) if distance <= V * V / A else distance / V + V / A
    duration = motion.duration_of(*arrays[1:], 0)
    assert duration == pytest.approx(max(asked, quickest), rel=1e-9)
    track = sample(arrays, np.linspace(0.0, duration, 50))
    assert (np.hypot(track[:, 2], track[:, 3]) <= V * (1 + 1e-9)).all()
    assert (np.diff(track[:, 0]) >= -1e-9).all()
    assert np.abs(np.diff(track[:, 0])).max() <= V * duration / 49 + 1e-9
    assert track[-1][:2] == pytest.approx((50.0 + distance, 50.0), abs=1e-9)


@given(st.floats(-300.0, 308.0), st.floats(-300.0, 308.0), st.floats(0.0, 6.3))
def test_a_target_velocity_of_any_size_breaks_no_limit(x_size, y_size, direction) -> None:
    arrays = bot()
    tx, ty = 10.0**x_size * math.cos(direction), 10.0**y_size * math.sin(direction)
    motion.plan_velocity(*arrays, 0, 0.0, tx, ty, V, A, 0.0, EDGES)
    track = sample(arrays, np.linspace(0.0, 100.0, 200))
    assert np.isfinite(track).all()
    assert (np.hypot(track[:, 2], track[:, 3]) <= V * (1 + 1e-9)).all()
    assert (track[:, :2] >= 1.0 - 1e-6).all() and (track[:, :2] <= 99.0 + 1e-6).all()


def test_a_bot_that_has_turned_round_a_billion_times_still_finds_its_direction() -> None:
    arrays = bot(heading=1e10)
    motion.plan_leg(*arrays, 0, 0.0, 50.0, 60.0, V, A, 0.5, EDGES, 0.0)
    assert motion.duration_of(*arrays[1:], 0) <= math.pi / 0.5 + 10.0 / V + V / A + 1e-9


@given(places, places, speeds, speeds, places, places)
def test_a_leg_ends_on_its_goal_at_rest_from_any_state(x, y, vx, vy, gx, gy) -> None:
    size = math.hypot(vx, vy)
    if size > V:
        vx, vy = vx * V / size * 0.999, vy * V / size * 0.999
    arrays = bot(x, y, vx, vy)
    motion.plan_leg(*arrays, 0, 0.0, gx, gy, V, A, 0.0, EDGES, 0.0)
    end = motion.duration_of(*arrays[1:], 0)
    assert sample(arrays, [end + 1e-9])[0] == pytest.approx((gx, gy, 0.0, 0.0), abs=1e-7)


@given(
    st.lists(st.tuples(st.floats(0.0, 3.0), speeds, speeds, st.booleans(), places, places), max_size=8),
    st.sampled_from([0.0, 1.5]),
)
def test_no_command_stream_breaks_the_limits_of_speed_and_acceleration_or_leaves_the_floor(commands, turn_rate) -> None:
    arrays = bot()
    now = 0.0
    before = (0.0, 0.0)
    for pause, tx, ty, by_goal, gx, gy in commands:
        assert tuple(sample(arrays, [now])[0][2:]) == pytest.approx(
            before, abs=1e-9
        )  # commands never make the velocity jump
        if by_goal:
            motion.plan_leg(*arrays, 0, now, gx, gy, V, A, turn_rate, EDGES, 0.0)
        else:
            motion.plan_velocity(*arrays, 0, now, tx, ty, V, A, turn_rate, EDGES)
        segments = arrays[1][0, : arrays[2][0]]
        assert (np.hypot(segments[:, 1], segments[:, 2]) <= A * (1 + 1e-9)).all()
        track = sample(arrays, now + np.linspace(0.0, 3.0, 200))
        assert (np.hypot(track[:, 2], track[:, 3]) <= V * (1 + 1e-9)).all()
        assert (track[:, :2] >= 1.0 - 1e-6).all() and (track[:, :2] <= 99.0 + 1e-6).all()
        now += pause
        before = tuple(sample(arrays, [now])[0][2:])


def test_a_target_velocity_is_reached_at_full_acceleration_and_kept() -> None:
    arrays = bot()
    motion.plan_velocity(*arrays, 0, 0.0, 3.0, 0.0, V, A, 0.0, EDGES)
    track = sample(arrays, [0.075, 0.15, 5.0])
    assert track[:, 2] == pytest.approx([1.5, 3.0, 3.0])


def test_too_fast_a_target_velocity_is_cut_to_the_maximum_speed() -> None:
    arrays = bot()
    motion.plan_velocity(*arrays, 0, 0.0, 30.0, 40.0, V, A, 0.0, EDGES)
    assert sample(arrays, [2.0])[0][2:] == pytest.approx((2.4, 3.2))


def test_a_target_velocity_that_nobody_changes_ends_at_the_edge_of_the_floor() -> None:
    arrays = bot()
    motion.plan_velocity(*arrays, 0, 0.0, 4.0, 1.0, V, A, 0.0, EDGES)
    assert sample(arrays, [1000.0])[0][0] == pytest.approx(99.0)
    assert sample(arrays, [1000.0])[0][2:] == pytest.approx((0.0, 0.0))


def test_turning_takes_time_where_the_scenario_says_so() -> None:
    arrays = bot()
    motion.plan_leg(*arrays, 0, 0.0, 50.0, 60.0, V, A, 0.5, EDGES, 0.0)
    turning = math.pi / 2 / 0.5
    assert motion.duration_of(*arrays[1:], 0) == pytest.approx(turning + 10.0 / V + V / A)
    assert sample(arrays, [turning])[0][:2] == pytest.approx((50.0, 50.0))


@given(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3))
def test_headings_are_what_atan2_says(dx: float, dy: float) -> None:
    if math.hypot(dx, dy) > 1e-6:
        difference = motion.heading_of(dx, dy) - math.atan2(dy, dx)
        assert math.remainder(difference, 2 * math.pi) == pytest.approx(0.0, abs=1e-12)


def test_the_odometer_counts_bends_and_reversals() -> None:
    arrays = bot(vx=2.0)
    motion.plan_velocity(*arrays, 0, 0.0, -2.0, 0.0, V, A, 0.0, EDGES)
    driven = motion.length_of(*arrays, 0, 0.2)
    assert driven == pytest.approx(2.0 * 2.0**2 / (2 * A), rel=1e-6)
