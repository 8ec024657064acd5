"""What a manager knows of the world: true as long as no event is missing, and it knows when one is."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tiny_warehouse import let, scenario_of, tiny_world

from soup_managers.kernels.bitset import first, members
from soup_managers.view import WarehouseView
from soup_msgs_py.codes import EventType
from soup_msgs_py.messages import Event, SetStorageSpot, Word
from soup_sim.layouts import make_layout
from soup_sim.world import World


@pytest.fixture
def world() -> World:
    """Buckets 0 and 1 hold kind 0, 1 also kind 1; word 0 is open, word 1 waits, a bundle of 3 is staged."""
    return let(
        tiny_world(),
        contents={0: {0: 2}, 1: {0: 1, 1: 1}},
        waiting={1: (2,)},
        opened={0: (1, (0, 0, 1), (0, 0, 0))},
        staged={0: (3, 5, 3)},
        sequence=10,
    )


@pytest.fixture
def view(world) -> WarehouseView:
    view = WarehouseView(world.scenario, world.layout)
    view.reset(world.snapshot())
    return view


def transfer(sequence: int, **about) -> Event:
    return Event(0.0, sequence, EventType.TRANSFERRED, bot=0, x=1.0, y=2.0, **about)


def test_buckets_are_found_by_what_they_hold(view):
    assert list(members(view.holders(0))) == [0, 1]
    assert list(members(view.holders(1))) == [1]
    assert view.holders(7) == 0
    assert first(view.holders(7)) == -1
    assert view.with_room == (1 << 9) - 1


def test_a_tile_taken_out_fills_the_first_unfilled_letter_of_its_kind(view):
    view.apply(transfer(11, bucket=0, station=1, tile=0, job=0))
    assert view.open_words[0].filled == [True, False, False]
    view.apply(transfer(12, bucket=0, station=1, tile=0, job=0))
    assert view.open_words[0].missing == (1,)
    assert view.contents[0] == {}
    assert list(members(view.holders(0))) == [1]
    assert view.wanted[0] == 0
    assert view.stock[0] == 1


def test_a_tile_from_a_bundle_goes_into_the_bucket(view):
    view.apply(transfer(11, bucket=2, station=3, tile=5, job=0))
    assert view.contents[2] == {5: 1}
    assert view.staged_bundles[0].count == 2
    assert view.stock[5] == 3


def test_a_full_bucket_has_no_room(view):
    for sequence in range(11, 19):
        view.apply(transfer(sequence, bucket=2, station=3, tile=5, job=0))
    assert view.room_in(2) == 0
    assert not view.with_room >> 2 & 1


def test_a_finished_word_holds_its_place_until_it_is_cleared(view):
    assert view.free_places[1] == 1
    view.apply(Event(0.0, 11, EventType.WORD_COMPLETED, job=0, station=1, count=3))
    assert view.free_places[1] == 1
    view.apply(Event(0.0, 12, EventType.WORD_CLEARED, job=0, station=1))
    assert view.free_places[1] == 2
    assert 0 not in view.open_words


def test_a_word_arrives_waits_and_is_opened(view):
    view.apply(Event(0.0, 11, EventType.WORD_ARRIVED, job=2, tiles=(1, 2), text="BC"))
    assert view.waiting_words[2] == Word(2, "BC", (1, 2))
    view.apply(Event(0.0, 12, EventType.WORD_ASSIGNED, job=2, station=0))
    assert list(view.waiting_words) == [1]
    assert view.open_words[2].missing == (1, 2)
    assert view.free_places[0] == 1


def test_a_bundle_that_arrived_waits_until_it_is_staged(view):
    view.apply(Event(0.0, 11, EventType.BUNDLE_ARRIVED, job=7, tile=4, count=3))
    assert list(view.waiting_bundles) == [7]
    assert view.stock[4] == 0
    view.apply(Event(0.0, 12, EventType.BUNDLE_STAGED, job=7, tile=4, count=3, station=2))
    assert not view.waiting_bundles
    assert view.stock[4] == 3
    view.apply(Event(0.0, 13, EventType.BUNDLE_EMPTIED, job=7, station=2))
    assert view.free_places[2] == view.scenario.letter_station.staged_bundles


def test_a_bucket_leaves_its_spot_with_a_bot_and_rests_where_it_is_released(view, world):
    home = view.spot_of[4]
    other = next(spot for spot in world.snapshot().storage_spots if view.bucket_at[spot] < 0)
    x, y = world.layout.waypoints[other]
    view.apply(Event(0.0, 11, EventType.GRABBED, bot=2, bucket=4, x=3.0, y=3.0))
    assert view.bucket_at[home] == -1
    assert not view.resting >> 4 & 1
    assert view.bot_bucket[2] == 4
    view.apply(Event(0.0, 12, EventType.RELEASED, bot=2, bucket=4, x=x + 0.05, y=y))
    assert view.bucket_at[other] == 4
    assert view.spot_of[4] == other
    assert view.bot_x[2] == x + 0.05


def test_a_waypoint_becomes_a_storage_spot_and_a_storage_spot_a_waypoint(view, world):
    lane = next(w for w in range(len(world.layout.waypoints)) if w not in world.snapshot().storage_spots)
    gone = next(spot for spot in world.snapshot().storage_spots if view.bucket_at[spot] < 0)
    assert view.storage_spots == set(world.snapshot().storage_spots)
    x, y = map(float, world.layout.waypoints[lane])
    assert view.spot_at(x, y) == -1
    view.apply(Event(0.0, 11, EventType.SPOT_MADE, waypoint=lane, x=x, y=y))
    assert view.spot_at(x, y) == lane
    assert lane in view.spots_within(x, y, 1.0)
    x, y = map(float, world.layout.waypoints[gone])
    view.apply(Event(0.0, 12, EventType.SPOT_REMOVED, waypoint=gone, x=x, y=y))
    assert view.spot_at(x, y) == -1
    assert view.storage_spots == {*world.snapshot().storage_spots, lane} - {gone}


@given(st.lists(st.tuples(st.integers(0, 99), st.integers(0, 99)), min_size=1, max_size=40), st.integers(0, 2**32 - 1))
def test_the_storage_spots_near_a_place_are_found_nearest_first(points, seed):
    rng = np.random.default_rng(seed)
    scenario = scenario_of()
    layout = replace(make_layout(scenario), waypoints=np.array(points, float))
    view = WarehouseView(scenario, layout)
    view.is_storage_spot[:] = rng.random(len(points)) < 0.7
    for x, y in rng.uniform(-30, 130, (10, 2)):
        distances = ((layout.waypoints - (x, y)) ** 2).sum(axis=1)
        near = view.spots_within(x, y, 20.0)
        assert sorted(near) == np.flatnonzero((distances < 400) & view.is_storage_spot).tolist()
        assert distances[near].tolist() == sorted(distances[near])


def test_a_newcomer_learns_the_storage_spots_of_the_moment(world):
    view = WarehouseView(world.scenario, world.layout)
    view.reset(world.snapshot())
    gone = next(spot for spot in view.storage_spots if view.bucket_at[spot] < 0)
    world.handle(SetStorageSpot(gone, False))
    view = WarehouseView(world.scenario, world.layout)
    view.reset(world.snapshot())
    assert view.storage_spots == set(world.layout.storage_spots.tolist()) - {gone}


def test_a_world_that_is_started_again_is_taken_over_though_it_counts_its_events_anew(view, world):
    view.apply(transfer(11, bucket=0, station=1, tile=0, job=0))
    let(world, sequence=0)
    assert not view.reset(world.snapshot())
    assert view.reset(replace(world.snapshot(), run=7))
    assert (view.run, view.sequence, view.lost) == (7, 0, False)
    assert view.contents[0] == {0: 2}
    assert view.apply(transfer(1, bucket=0, station=1, tile=0, job=0))


def test_a_view_that_has_lost_an_old_world_joins_the_new_one(view, world):
    view.apply(transfer(13, bucket=0, station=1, tile=0, job=0))
    assert view.lost
    let(world, sequence=2)
    assert view.reset(replace(world.snapshot(), run=7))
    assert not view.lost


def test_an_event_counts_once(view):
    event = transfer(11, bucket=0, station=1, tile=0, job=0)
    assert view.apply(event)
    assert not view.apply(event)
    assert view.contents[0] == {0: 1}


def test_a_gap_in_the_events_asks_for_a_snapshot_that_is_new_enough(view, world):
    old = world.snapshot()
    view.apply(transfer(13, bucket=0, station=1, tile=0, job=0))
    assert view.lost
    assert view.contents[0] == {0: 2}
    view.reset(old)
    assert view.lost
    view.reset(let(world, contents={0: {0: 1}}, sequence=13).snapshot())
    assert not view.lost
    assert view.contents[0] == {0: 1}
    assert view.apply(transfer(14, bucket=0, station=1, tile=0, job=0))


def test_a_snapshot_that_holds_nothing_new_changes_nothing(view, world):
    assert not view.reset(world.snapshot())
    assert view.sequence == 10


def test_a_snapshot_that_holds_more_is_taken_over(view, world):
    let(world, sequence=12)
    assert view.reset(world.snapshot())
    assert view.sequence == 12


def test_an_event_far_ahead_that_was_nobodys_does_not_keep_a_view_lost(view, world):
    view.apply(transfer(5_000, bucket=0, station=1, tile=0, job=0))
    let(world, sequence=11)
    assert not view.reset(world.snapshot())
    assert view.reset(world.snapshot())
    assert not view.lost
    assert view.apply(transfer(12, bucket=0, station=1, tile=0, job=0))


@pytest.mark.parametrize(
    "foreign",
    [
        transfer(11, bucket=9_999, station=1, tile=0, job=0),
        transfer(11, bucket=0, station=1, tile=77, job=0),
        Event(0.0, 11, EventType.GRABBED, bot=9_999, bucket=0, x=1.0, y=1.0),
        Event(0.0, 11, EventType.BUNDLE_STAGED, job=9, station=9_999, tile=0, count=1),
    ],
)
def test_an_event_of_what_is_not_there_makes_the_view_lost_until_the_next_snapshot(view, world, foreign):
    assert not view.apply(foreign)
    assert view.lost
    assert view.reset(world.snapshot()) or view.reset(world.snapshot())
    assert not view.lost
    assert view.contents[0] == {0: 2}
