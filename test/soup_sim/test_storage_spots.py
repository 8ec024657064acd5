"""Managers and persons may change where buckets rest, as long as every bucket can."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from world_hands import bucket_at_hand, clear, do, place

from soup_lab.headless.simulation import Headless
from soup_managers.fleets.make import FLEET
from soup_managers.fleets.minimal.policies import Minimal
from soup_msgs_py import messages as m
from soup_msgs_py.codes import Code, EventType
from soup_msgs_py.policies import Policies, PolicyChoice
from soup_sim.checkpoint import restore_checkpoint, write_checkpoint
from soup_sim.scenario_loader import Warehouse, load_warehouse
from soup_sim.validate import Judge
from soup_sim.world import World

ROOT = Path(__file__).parents[2]
DEMO = ROOT / "config/scenarios/demo.yaml"


@pytest.fixture(scope="module")
def warehouse() -> Warehouse:
    return load_warehouse(DEMO)


@pytest.fixture
def world(warehouse: Warehouse) -> World:
    return warehouse.world(1)


def ask(world: World, waypoint: int, storage: bool) -> tuple[m.Reply, list[m.Event]]:
    """What the world says to a change."""
    said = world.handle(m.SetStorageSpot(waypoint, storage))
    (reply,) = (s for s in said if isinstance(s, m.Reply))
    return reply, [s for s in said if isinstance(s, m.Event)]


def lane(world: World) -> int:
    """A waypoint that is nothing in particular and far from bots at the lower edge."""
    plain = set(range(len(world.layout.waypoints))) - set(world.layout.storage_spots) - set(world.layout.stations)
    return max(plain, key=lambda w: world.layout.waypoints[w][1])


def free_spot(world: World) -> int:
    x, y = world.buckets().x, world.buckets().y
    taken = set(zip(x.tolist(), y.tolist(), strict=True))
    return next(s for s in world.snapshot().storage_spots if tuple(world.layout.waypoints[s].tolist()) not in taken)


def spot_under(world: World, bucket: int) -> int:
    x, y = float(world.buckets().x[bucket]), float(world.buckets().y[bucket])
    return next(s for s in world.snapshot().storage_spots if tuple(world.layout.waypoints[s].tolist()) == (x, y))


def test_a_bucket_rests_where_a_waypoint_has_become_a_storage_spot(world: World) -> None:
    spot = lane(world)
    x, y = map(float, world.layout.waypoints[spot])
    bucket_at_hand(world, 0, 3)
    assert do(world, m.Grab(0, 1)).success
    place(world, bot_0=(x, y))
    assert do(world, m.Release(0, 2)).code is Code.OUT_OF_TOLERANCE
    reply, events = ask(world, spot, True)
    assert reply == m.Reply(Code.DONE, f"waypoint {spot} at ({x:.3f}, {y:.3f}) is a storage spot now")
    assert [(e.type, e.waypoint, e.x, e.y) for e in events] == [(EventType.SPOT_MADE, spot, x, y)]
    assert spot in world.snapshot().storage_spots
    assert do(world, m.Release(0, 3)).success


def test_no_bucket_rests_where_a_storage_spot_was(world: World) -> None:
    spot = free_spot(world)
    x, y = map(float, world.layout.waypoints[spot])
    reply, events = ask(world, spot, False)
    assert reply.success and [e.type for e in events] == [EventType.SPOT_REMOVED]
    assert spot not in world.snapshot().storage_spots
    bucket_at_hand(world, 0, 3)
    assert do(world, m.Grab(0, 1)).success
    place(world, bot_0=(x, y))
    assert do(world, m.Release(0, 2)).code is Code.OUT_OF_TOLERANCE


def test_a_spot_with_a_bucket_or_with_one_coming_down_stays(world: World) -> None:
    home = spot_under(world, 3)
    reply, events = ask(world, home, False)
    assert (reply.code, events) == (Code.SPOT_TAKEN, [])
    assert f"bucket 3 rests on storage spot {home}" in reply.message
    bucket_at_hand(world, 0, 3)
    assert do(world, m.Grab(0, 1)).success
    world.handle(m.Release(0, 2))
    reply, _ = ask(world, home, False)
    assert reply.code is Code.SPOT_TAKEN and "is being set down" in reply.message
    world.advance(world.now + 1.0)
    bucket_at_hand(world, 0, 3)
    assert do(world, m.Grab(0, 3)).success
    assert ask(world, home, False)[0].success


def test_a_station_becomes_no_storage_spot(world: World) -> None:
    station = int(world.layout.word_stations[0])
    reply, _ = ask(world, station, True)
    assert (reply.code, reply.message) == (Code.BLOCKED, f"waypoint {station} is word station 0")


@pytest.mark.parametrize("near", ["word station 0", "storage spot"])
def test_bodies_on_a_new_storage_spot_touch_nothing(warehouse: Warehouse, near: str) -> None:
    layout = warehouse.layout
    plain = lane(warehouse.world(1))
    other = int(layout.word_stations[0] if near == "word station 0" else layout.storage_spots[0])
    waypoints = layout.waypoints.copy()
    waypoints[plain] = waypoints[other] + (-0.9, 0.0)
    world = World(warehouse.scenario, replace(layout, waypoints=waypoints), warehouse.words, 1)
    reply, _ = ask(world, plain, True)
    assert reply.code is Code.BLOCKED
    assert reply.message.startswith(near) and "0.900 m away, too near" in reply.message


def test_a_bucket_on_a_new_storage_spot_does_not_stand_out_over_the_edge_of_the_floor(warehouse: Warehouse) -> None:
    layout = warehouse.layout
    plain = lane(warehouse.world(1))
    waypoints = layout.waypoints.copy()
    waypoints[plain] = (20.0, 0.4)
    world = World(warehouse.scenario, replace(layout, waypoints=waypoints), warehouse.words, 1)
    assert ask(world, plain, True)[0].code is Code.OFF_FLOOR


def test_a_change_that_changes_nothing_and_a_waypoint_that_is_none_are_refused(world: World) -> None:
    spot, plain = free_spot(world), lane(world)
    assert ask(world, spot, True)[0].code is Code.NOT_NEEDED
    assert ask(world, plain, False)[0].code is Code.NOT_NEEDED
    for waypoint in (-1, len(world.layout.waypoints)):
        assert ask(world, waypoint, True)[0].code is Code.UNKNOWN


def test_every_bucket_keeps_a_place(warehouse: Warehouse) -> None:
    world = load_warehouse(DEMO, ["buckets=96"]).world(1)
    bucket_at_hand(world, 0, 3)
    home = spot_under(world, 3)
    assert do(world, m.Grab(0, 1)).success
    reply, _ = ask(world, home, False)
    assert (reply.code, reply.message) == (Code.BLOCKED, "all 96 storage spots are needed for 96 buckets")


def test_a_checkpoint_holds_the_storage_spots(warehouse: Warehouse, world: World, tmp_path: Path) -> None:
    made, gone = lane(world), free_spot(world)
    assert ask(world, made, True)[0].success and ask(world, gone, False)[0].success
    write_checkpoint(tmp_path / "now", world)
    restored = warehouse.world(2)
    restore_checkpoint(tmp_path / "now", restored)
    assert restored.snapshot().storage_spots == world.snapshot().storage_spots
    assert ask(restored, gone, True)[0].success
    assert ask(restored, made, False)[0].success


class Gathering(Minimal):
    """A fleet policy that makes storage spots of lanes and gives up free ones, one after another."""

    asked = 0

    def plan(self, fleet):
        self.asked += 1
        if self.asked % 4 == 0:
            spots = sorted(fleet.view.storage_spots)
            spot = spots[self.asked * 7 % len(spots)]
            if fleet.is_free_spot(spot):
                fleet.set_storage_spot(spot, False)
            fleet.set_storage_spot(self.asked * 13 % len(fleet.layout.waypoints), True)
        return super().plan(fleet)


def test_a_fleet_policy_may_change_them_while_bots_are_at_work(warehouse: Warehouse, monkeypatch) -> None:
    monkeypatch.setitem(FLEET, "gathering", Gathering)
    world = warehouse.world(1)
    events: list[m.Event] = []
    judge = Judge(warehouse.scenario, warehouse.layout, world.snapshot())

    def on_event(event: m.Event) -> None:
        events.append(event)
        judge.event(event)

    run = Headless(world, Policies(fleet=PolicyChoice(name="gathering")), 1, on_event)
    for until in range(20, 420, 20):
        run.run(float(until))
        judge.poses(world.bots(), world.buckets())
    judge.finish(world.snapshot())
    assert judge.violations == []
    happened = [event.type for event in events]
    assert happened.count(EventType.SPOT_MADE) > 5 and happened.count(EventType.SPOT_REMOVED) > 5
    assert happened.count(EventType.RELEASED) > 50
    known = set(world.snapshot().storage_spots)
    assert known != set(warehouse.layout.storage_spots.tolist())
    assert run.fleet.view.storage_spots == known


def test_a_trip_to_a_spot_that_a_person_has_taken_away_ends_on_another_one(warehouse: Warehouse) -> None:
    world = warehouse.world(1)
    clear(world)
    run = Headless(world, Policies(), 1)
    now = 0.0
    taken = 0
    while taken < 3:
        now += 1.0
        run.run(now)
        assert now < 200.0
        for bucket in range(world.scenario.buckets):
            if world.buckets().bot[bucket] >= 0 and taken < 3:
                for waypoint in set(world.snapshot().storage_spots):
                    if run.fleet.view.spot_of[bucket] == waypoint and not run.fleet.view.occupied[waypoint]:
                        run.tell(world, m.SetStorageSpot(waypoint, False))
                        taken += 1
    run.run(now + 300.0)
    assert world.statistics()["releases"] > 30
    places = {tuple(p) for p in world.layout.waypoints[list(world.snapshot().storage_spots)].round(3).tolist()}
    resting = world.buckets().bot < 0
    tolerance = world.scenario.bot.tolerance_m
    for x, y in zip(world.buckets().x[resting], world.buckets().y[resting], strict=True):
        assert min((x - px) ** 2 + (y - py) ** 2 for px, py in places) <= tolerance**2
