"""What managers keep by events is what a newcomer would learn from the world's snapshot, at many instants of a run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from soup_lab.headless.simulation import Headless
from soup_managers.fleets.coordinated.fleet import CoordinatedFleet
from soup_managers.view import WarehouseView
from soup_msgs_py.codes import EventType
from soup_msgs_py.messages import Event
from soup_msgs_py.policies import load_policies
from soup_sim.scenario_loader import load_warehouse

CONFIG = Path(__file__).resolve().parents[2] / "config"
BUCKETS = ("bucket_bot", "bot_bucket", "bucket_at", "is_storage_spot", "stock", "wanted", "on_order")
STATIONS = ("open_words", "waiting_words", "staged_bundles", "waiting_bundles", "free_places")


def started(scenario: str, policies: str, seed: int) -> Headless:
    world = load_warehouse(CONFIG / scenario, []).world(seed)
    return Headless(world, load_policies(CONFIG / "policies" / f"{policies}.yaml"), seed)


def is_as_the_world(view: WarehouseView, run: Headless) -> None:
    world = run.world
    fresh = WarehouseView(world.scenario, world.layout)
    fresh.reset(world.snapshot())
    assert view.sequence == fresh.sequence
    for fact in BUCKETS:
        np.testing.assert_array_equal(getattr(view, fact), getattr(fresh, fact), fact)
    for fact in STATIONS:
        assert getattr(view, fact) == getattr(fresh, fact), fact
    rests = fresh.bucket_bot < 0
    for fact in ("spot_of", "bucket_x", "bucket_y"):  # of those that are carried, each knows what was last told
        np.testing.assert_array_equal(getattr(view, fact)[rests], getattr(fresh, fact)[rests], fact)
    np.testing.assert_array_equal(view.contents.tiles, fresh.contents.tiles)
    np.testing.assert_array_equal(view.contents.total, fresh.contents.total)
    assert list(view.contents) == [dict(sorted(tiles.items())) for tiles in world.snapshot().contents]


def agrees_with_itself(fleet: CoordinatedFleet) -> None:
    """What the fleet counts of bots is what they say."""
    state, view = fleet.state, fleet.view
    waypoints = [robot.waypoint for robot in state.robots if robot.waypoint >= 0]
    np.testing.assert_array_equal(state.places.taken, np.bincount(waypoints, minlength=len(state.layout.waypoints)))
    np.testing.assert_array_equal(state.robot_xy[: len(waypoints)], state.layout.waypoints[waypoints])
    carried = [robot.bucket for robot in state.robots if robot.bucket >= 0]
    assert len(carried) == len(set(carried))
    assert not state.free_buckets[carried].any()
    assert not state.free_buckets[view.bucket_bot >= 0].any()


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize(
    ("scenario", "policies", "duration"),
    [
        ("scenarios/demo.yaml", "best", 300),
        ("scenarios/demo.yaml", "minimal", 300),
        ("scenarios/dense.yaml", "best", 200),
        ("worlds/medium1.txt", "planned", 600),
    ],
)
def test_what_is_kept_by_events_is_what_a_newcomer_learns(scenario: str, policies: str, duration: int, seed: int):
    run = started(scenario, policies, seed)
    fleet = run.fleet
    moments = np.sort(np.random.default_rng(seed).uniform(0.0, duration, 60))
    for moment in moments.tolist():
        run.run(moment)
        is_as_the_world(fleet.view, run)
        if isinstance(fleet, CoordinatedFleet):
            agrees_with_itself(fleet)
    assert fleet.view.sequence > 5
    assert fleet.view.resets == 1


def test_a_bucket_that_a_person_has_lifted_and_set_down_is_free_again():
    run = started("scenarios/demo.yaml", "best", 1)
    run.run(1.0)
    fleet = run.fleet
    assert isinstance(fleet, CoordinatedFleet)
    state, view = fleet.state, fleet.view
    bucket = int(np.flatnonzero(state.free_buckets)[0])
    bot = next(robot.number for robot in state.robots if robot.bucket < 0)
    x, y = view.bucket_x[bucket], view.bucket_y[bucket]
    fleet.handle(Event(1.0, view.sequence + 1, EventType.GRABBED, bot=bot, bucket=bucket, x=x, y=y), 1.0)
    assert not state.free_buckets[bucket]
    fleet.handle(Event(1.0, view.sequence + 1, EventType.RELEASED, bot=bot, bucket=bucket, x=x, y=y), 1.0)
    assert state.free_buckets[bucket]
