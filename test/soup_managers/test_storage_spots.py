"""The fleet follows the storage spots as they change: where buckets go, and which ways are free."""

import numpy as np
import pytest
from tiny_warehouse import scenario_of

from soup_managers.fleets.minimal.state import FleetState
from soup_managers.traffic.router import Router
from soup_managers.view import WarehouseView
from soup_msgs_py.codes import EventType
from soup_msgs_py.messages import Event, SetStorageSpot
from soup_sim.layouts import make_layout


@pytest.fixture
def fleet() -> FleetState:
    """Before the first snapshot: a view that knows the storage spots, and nothing on them."""
    scenario = scenario_of()
    layout = make_layout(scenario)
    view = WarehouseView(scenario, layout)
    view.is_storage_spot[layout.storage_spots] = True
    view.ready, view.sequence = True, 0
    return FleetState(scenario, layout, view, Router(layout), np.random.default_rng(0))


def change(fleet: FleetState, kind: EventType, waypoint: int) -> None:
    fleet.view.apply(Event(0.0, fleet.view.sequence + 1, kind, waypoint=waypoint))


def test_free_spots_are_those_of_the_moment(fleet):
    spot = int(fleet.layout.storage_spots[0])
    lane = spot + 1
    assert fleet.is_free_spot(spot) and not fleet.is_free_spot(lane)
    x, y = map(float, fleet.layout.waypoints[lane])
    change(fleet, EventType.SPOT_MADE, lane)
    assert fleet.nearest_free_spot(x, y) == lane
    change(fleet, EventType.SPOT_REMOVED, lane)
    change(fleet, EventType.SPOT_REMOVED, spot)
    assert not fleet.is_free_spot(spot) and not fleet.is_free_spot(lane)
    assert fleet.nearest_free_spot(x, y) not in (-1, spot, lane)


def test_ways_lead_around_a_new_storage_spot_and_through_one_that_is_none_any_more(fleet):
    layout, router = fleet.layout, fleet.router
    start, goal = 0, layout.word_stations[0]
    before = router.cost(start, goal)
    corners = router.route(start, goal)
    on_the_way = next(
        w for w, place in enumerate(layout.waypoints.tolist()) if w not in layout.stations and tuple(place) in corners
    )
    router.set_storage_spots({*layout.storage_spots.tolist(), on_the_way})
    assert tuple(layout.waypoints[on_the_way].tolist()) not in router.route(start, goal)
    router.set_storage_spots(frozenset())
    assert router.cost(start, goal) <= before
    spot = int(layout.storage_spots[0])
    x, y = map(float, layout.waypoints[spot])
    assert router.entry(x + 0.6, y) == spot


def test_a_policy_wishes_for_what_does_not_take_a_promised_spot_away(fleet):
    spot, other = fleet.layout.storage_spots[:2].tolist()
    fleet._reserved_spots[spot] = 2
    fleet.set_storage_spot(spot, False)
    fleet.set_storage_spot(other, False)
    assert fleet.wishes == [SetStorageSpot(other, False)]
