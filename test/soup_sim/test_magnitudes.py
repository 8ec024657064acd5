"""Numbers of any size that bots ask with break no law: what cannot be resolved is refused with a sentence."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from world_hands import do

from soup_msgs_py import messages as m
from soup_msgs_py.codes import Code
from soup_sim.driving import latest_time
from soup_sim.scenario_loader import Warehouse, load_warehouse
from soup_sim.validate import Judge
from soup_sim.world import World

from .test_laws import ROOT, SMALL

WALL_CLOCK_S = 1.7e9
sizes = st.one_of(st.floats(-3.0, 3.0), st.floats(-300.0, 308.0)).map(lambda size: 10.0**size)
signed = st.one_of(sizes, sizes.map(lambda size: -size), st.just(0.0))


@pytest.fixture(scope="module")
def small() -> Warehouse:
    """A little warehouse whose bots are four."""
    return load_warehouse(ROOT / "config/scenarios/demo.yaml", SMALL)


def judged(world: World, warehouse: Warehouse, requests: list) -> list:
    """Ask a world, let it run on for a while, and have the judge look all the time; its violations."""
    judge = Judge(warehouse.scenario, warehouse.layout, world.snapshot())
    for request in requests:
        said = world.handle(request)
        for instant in np.linspace(0.0, 3.0, 31) + world.now:
            said += world.advance(float(instant))
            for event in said:
                if isinstance(event, m.Event):
                    judge.event(event)
            said = []
            judge.poses(world.bots(), world.buckets())
    return judge.violations


@given(st.lists(st.tuples(st.integers(0, 3), signed, signed, signed), min_size=1, max_size=4))
@settings(max_examples=40)
def test_velocities_of_any_size_break_no_law(small: Warehouse, asked) -> None:
    world = small.world(1)
    requests = [m.SetVelocity(bot, vx, vy, turn) for bot, vx, vy, turn in asked]
    assert judged(world, small, requests) == []
    assert np.isfinite(world.bots().heading).all()


@given(
    st.lists(st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)), min_size=1, max_size=4),
    st.lists(signed, min_size=4, max_size=4),
    st.integers(0, 3),
)
@settings(max_examples=40)
def test_stamps_of_any_size_break_no_law(small: Warehouse, places, stamps, bot) -> None:
    world = small.world(1)
    floor = small.scenario.floor
    points = tuple((1.0 + x * (floor.width_m - 2.0), 1.0 + y * (floor.height_m - 2.0)) for x, y in places)
    times = tuple(sorted(stamps[: len(points)]))
    assert judged(world, small, [m.FollowPath(bot, 1, points, times)]) == []


@given(signed, signed)
@settings(max_examples=40)
def test_a_place_of_any_size_is_driven_to_or_refused(small: Warehouse, x, y) -> None:
    world = small.world(1)
    reply = do(world, m.FollowPath(0, 1, ((x, y),)))
    assert reply.code in (Code.DONE, Code.OFF_FLOOR, Code.COLLIDED)


@pytest.mark.parametrize("stamp", [WALL_CLOCK_S, 1e300, math.inf, -math.inf, math.nan])
def test_a_path_with_stamps_of_a_wall_clock_is_refused_with_a_sentence(world: World, stamp: float) -> None:
    x, y = (float(value) for value in world.layout.waypoints[0])
    reply = do(world, m.FollowPath(3, 1, ((x, y),), (stamp,)))
    assert reply.code is Code.INVALID
    assert "use_sim_time" in reply.message and "at most 134217728 s" in reply.message


def test_all_bots_of_a_crowd_arrive_at_stamps_that_are_far_away(small: Warehouse) -> None:
    world = small.world(1)
    last = latest_time(small.scenario.bot.max_speed_mps)
    places = [(float(x), float(y)) for x, y in zip(world.bots().x, world.bots().y, strict=True)]
    for bot, (x, y) in enumerate(places):
        goal = (x, y + 0.3 if y < 9.0 else y - 0.3)
        world.handle(m.FollowPath(bot, 1, (goal,), (last / 2.0,)))
    track = []
    for _ in range(20):
        world.advance(world.now + 0.05)
        track.append((world.bots().x, world.bots().y))
    for (ax, ay), (bx, by) in pairwise(track):
        assert np.hypot(bx - ax, by - ay).max() <= small.scenario.bot.max_speed_mps * 0.05 + 1e-9
