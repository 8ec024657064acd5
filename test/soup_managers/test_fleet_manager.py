"""The fleet manager: which trips it asks for, what it promises, what it says about its tasks."""

from dataclasses import replace

import numpy as np
import pytest
from tiny_warehouse import home, let, tiny_world
from world_hands import place

from soup_managers.fleets.minimal.fleet import GATHER_S, TripFleet
from soup_managers.fleets.minimal.plans import PlanError, PlannedVisit, TripPlan
from soup_managers.fleets.minimal.policies import FleetPolicy
from soup_managers.fleets.minimal.policies import Minimal as MinimalFleet
from soup_managers.fleets.minimal.state import FleetState
from soup_managers.kernels.bitset import first, members
from soup_managers.view import WarehouseView
from soup_msgs_py.codes import Code, EventType, Phase
from soup_msgs_py.messages import (
    DELIVER,
    STORE,
    BotStatus,
    CancelTask,
    CancelTrip,
    DeliverGoal,
    Event,
    StoreGoal,
    TaskFeedback,
    TaskResult,
    TileMove,
    TripGoal,
    TripResult,
)
from soup_sim.world import World


@pytest.fixture
def world() -> World:
    """Word 0 lacks kinds 0 and 1 on station 1, bundle 0 is on station 2; kind 0 is in 3 and 5, 1 in 4."""
    world = tiny_world()
    # far from all buckets: nobody stands under one
    place(world, **{f"bot_{bot}": (2.5, 2.5 + 6.0 * bot) for bot in range(4)})
    return let(
        world,
        contents={3: {0: 2}, 5: {0: 1}, 4: {1: 1}},
        waiting={1: (0, 0)},
        opened={0: (1, (0, 1), (0, 0))},
        staged={0: (2, 2, 2)},
    )


class AllAtOnce(FleetPolicy):
    """One trip for each waiting letter, all at once: the first idle bot, the first bucket that will do."""

    def plan(self, fleet):
        for letter in fleet.letters():
            if not fleet.free_bots:
                return
            able = fleet.view.with_room if letter.key[0] == STORE else fleet.view.holders(letter.tile)
            for bucket in members(able & fleet.free_buckets):
                under = fleet.bot_under(bucket)
                bot = first(fleet.free_bots) if under < 0 else under
                if fleet.free_bots >> bot & 1:
                    visits = (PlannedVisit(letter.station, (letter,)),)
                    yield TripPlan(bot, bucket, visits, fleet.view.spot_of[bucket])
                    break
            else:
                fleet.defer(letter)


class Fleet:
    """A fleet manager that has seen the world, and some of its bots."""

    def __init__(self, world: World, bots: int = 4, policy: FleetPolicy | None = None) -> None:
        self.world = world
        view = WarehouseView(world.scenario, world.layout)
        self.mind = TripFleet(world.scenario, world.layout, policy or AllAtOnce(), view, np.random.default_rng(0))
        self.sequence = world.sequence
        # a second ago, so that it no longer waits for bots that do not come
        self.tell(world.snapshot(), *(idle(bot, time=0.0) for bot in range(bots)), now=-GATHER_S)

    def tell(self, *messages, now: float = 0.0) -> list:
        return [said for message in messages for said in self.mind.handle(message, now)]

    def trips(self, *messages, now: float = 0.0) -> list[TripGoal]:
        return [said for said in self.tell(*messages, now=now) if isinstance(said, TripGoal)]

    def event(self, kind: EventType, **about) -> Event:
        self.sequence += 1
        return Event(0.0, self.sequence, kind, **about)


WORD = DeliverGoal(0, 1, 0, (0, 1))
BUNDLE = StoreGoal(0, 2, 0, 2, 2)


def idle(bot: int, bucket: int = -1, time: float = 1.0) -> BotStatus:
    return BotStatus(time, bot, Phase.IDLE, bucket, None, 0, "")


def test_each_letter_is_a_trip_of_the_first_idle_bot_with_the_first_bucket_that_holds_it(world):
    trips = Fleet(world).trips(WORD)
    assert [(goal.bot, goal.trip.bucket) for goal in trips] == [(0, 3), (1, 4)]
    assert [goal.trip.visits[0].moves for goal in trips] == [(TileMove(0, 0),), (TileMove(1, 0),)]


def test_minimal_has_one_letter_of_a_task_under_way_at_a_time(world):
    fleet = Fleet(world, policy=MinimalFleet())
    trips = fleet.trips(WORD, BUNDLE)
    assert [(goal.bot, goal.trip.visits[0].station) for goal in trips] == [(0, 1), (1, 2)]
    bucket = trips[0].trip.bucket
    fleet.tell(fleet.event(EventType.GRABBED, bot=0, bucket=bucket))
    fleet.tell(fleet.event(EventType.TRANSFERRED, bot=0, bucket=bucket, station=1, tile=0, job=0))
    x, y = home(world, bucket)
    fleet.tell(fleet.event(EventType.RELEASED, bot=0, bucket=bucket, x=x, y=y))
    next_trips = fleet.trips(TripResult(0, trips[0].trip.trip, Code.DONE, ""), idle(0))
    assert [goal.trip.visits[0].moves for goal in next_trips] == [(TileMove(1, 0),)]


def test_a_trip_goes_straight_to_the_bucket_then_along_the_waypoints_and_back_to_its_spot(world):
    trip = Fleet(world).trips(WORD)[0].trip
    spot = home(world, 3)
    assert trip.fetch_route == (spot,)
    assert trip.visits[0].route[-1] == world.layout.station_xy(1)
    assert trip.store_route[-1] == spot
    for (ax, ay), (bx, by) in zip((spot, *trip.visits[0].route), trip.visits[0].route, strict=False):
        assert ax == bx or ay == by


def test_tasks_are_served_first_in_first_out_deliver_and_store_alike(world):
    fleet = Fleet(world, bots=0)
    fleet.tell(BUNDLE, WORD)
    goals = fleet.trips(idle(0), idle(1), idle(2))
    assert [goal.trip.visits[0].station for goal in goals] == [2, 2, 1]
    assert [goal.trip.bucket for goal in goals] == [0, 1, 3]


def test_a_bot_that_stands_under_the_bucket_takes_it(world):
    place(world, bot_2=home(world, 3))
    assert [(goal.bot, goal.trip.bucket) for goal in Fleet(world).trips(WORD)] == [(2, 3), (0, 4)]


def test_a_bucket_whose_bot_rests_after_a_failure_is_passed_over(world):
    fleet = Fleet(world, bots=3)
    (first, *_) = fleet.trips(WORD)
    x, y = home(world, 3)
    fleet.tell(fleet.event(EventType.RESUMED, bot=0, x=x, y=y))
    again = fleet.trips(TripResult(0, first.trip.trip, Code.COLLIDED, ""), idle(0))
    assert [(goal.bot, goal.trip.bucket) for goal in again] == [(2, 5)]


def test_bots_that_never_said_that_they_are_there_are_not_asked(world):
    fleet = Fleet(world, bots=0)
    assert fleet.tell(WORD) == [TaskFeedback(DELIVER, 0, (0, 1), "only 0 of 4 bots have said that they are there")]
    assert [goal.bot for goal in fleet.trips(idle(3))] == [3]


def test_a_task_says_what_it_waits_for_once(world):
    let(world, contents={3: {0: 2}, 5: {0: 1}})
    fleet = Fleet(world)
    said = fleet.tell(WORD)
    assert said[-1] == TaskFeedback(DELIVER, 0, (0, 1), "no bucket holds B0")
    assert not [m for m in fleet.tell(BUNDLE, idle(3)) if isinstance(m, TaskFeedback) and m.kind == DELIVER]


def test_a_task_says_that_all_bots_are_busy(world):
    fleet = Fleet(world, bots=1)
    assert fleet.tell(WORD)[-1] == TaskFeedback(DELIVER, 0, (0, 1), "all bots are busy")
    assert fleet.mind.tasks()[0].bots == (0,)


def test_a_letter_waits_for_a_bucket_in_use_and_is_served_when_that_is_back(world):
    opened = {0: (1, (0, 1), (0, 0)), 1: (0, (0, 0), (0, 0))}
    let(world, contents={3: {0: 2}, 4: {1: 1}}, opened=opened)
    fleet = Fleet(world)
    first = fleet.trips(WORD)[0]
    said = fleet.tell(DeliverGoal(1, 0, 1, (0, 0)))
    assert said == [TaskFeedback(DELIVER, 1, (0, 0), "every bucket that holds A0 is in use")]
    x, y = home(world, 3)
    fleet.tell(
        fleet.event(EventType.GRABBED, bot=0, bucket=3, x=x, y=y),
        fleet.event(EventType.TRANSFERRED, bot=0, bucket=3, station=1, tile=0, job=0, x=5.0, y=5.0),
        fleet.event(EventType.RELEASED, bot=0, bucket=3, x=x, y=y),
    )
    again = fleet.trips(idle(0), TripResult(0, first.trip.trip, Code.DONE, ""))
    assert [(goal.bot, goal.trip.bucket) for goal in again] == [(0, 3)]


def test_a_task_is_done_when_all_its_tiles_are_moved(world):
    fleet = Fleet(world)
    fleet.tell(WORD)
    x, y = home(world, 3)
    moved = [
        fleet.event(EventType.TRANSFERRED, bot=bot, bucket=3 + bot, station=1, tile=bot, job=0, x=x, y=y)
        for bot in (0, 1)
    ]
    assert fleet.tell(moved[0]) == [TaskFeedback(DELIVER, 0, (1,), "")]
    (result,) = fleet.tell(moved[1])
    assert (result.task, result.code) == (0, Code.DONE)
    assert fleet.mind.tasks() == ()


def test_a_result_may_come_before_the_event_that_tells_of_the_transfer(world):
    fleet = Fleet(world)
    first, _ = fleet.trips(WORD)
    assert not fleet.trips(TripResult(0, first.trip.trip, Code.DONE, ""), idle(0), idle(2), idle(3))
    event = fleet.event(EventType.TRANSFERRED, bot=0, bucket=3, station=1, tile=0, job=0, x=5.0, y=5.0)
    assert fleet.tell(event) == [TaskFeedback(DELIVER, 0, (1,), "")]
    assert not [m for m in fleet.mind.wake(10.0) if isinstance(m, TripGoal)]


def test_a_letter_that_a_finished_trip_did_not_move_is_brought_after_all(world):
    fleet = Fleet(world)
    first, _ = fleet.trips(WORD)
    fleet.tell(TripResult(0, first.trip.trip, Code.DONE, ""), idle(0))
    assert [m.trip.visits[0].moves for m in fleet.mind.wake(fleet.mind.next_wake)] == [(TileMove(0, 0),)]


def test_a_failed_letter_goes_first_and_its_bot_rests_a_second(world):
    fleet = Fleet(world, bots=2)
    first, _ = fleet.trips(WORD, BUNDLE)
    assert not fleet.trips(TripResult(0, first.trip.trip, Code.COLLIDED, ""), idle(0))
    assert fleet.mind.next_wake == 1.0
    (again,) = [m for m in fleet.mind.wake(1.0) if isinstance(m, TripGoal)]
    assert (again.bot, again.trip.visits) == (0, first.trip.visits)


def test_a_bot_left_with_a_bucket_stores_it_where_it_came_from(world):
    fleet = Fleet(world, bots=1)
    (first,) = fleet.trips(WORD)
    x, y = world.layout.station_xy(1)
    fleet.tell(fleet.event(EventType.GRABBED, bot=0, bucket=3, x=x, y=y))
    fleet.tell(TripResult(0, first.trip.trip, Code.NOT_NEEDED, ""), idle(0, bucket=3))
    (store,) = fleet.mind.wake(1.0)
    assert (store.bot, store.trip.bucket, store.trip.visits, store.trip.fetch_route) == (0, 3, (), ())
    assert store.trip.store_route[-1] == home(world, 3)


def test_a_bot_that_forgot_its_trip_is_noticed(world):
    fleet = Fleet(world, bots=1)
    (first,) = fleet.trips(WORD)
    fleet.tell(idle(0, time=5.0), now=5.0)
    assert not [m for m in fleet.mind.wake(7.0) if isinstance(m, TripGoal)]
    (again,) = [m for m in fleet.mind.wake(8.0) if isinstance(m, TripGoal)]
    assert again.trip.visits == first.trip.visits


def test_a_known_task_that_is_asked_for_again_is_not_delivered_twice(world):
    fleet = Fleet(world)
    assert len(fleet.trips(WORD)) == 2
    assert fleet.trips(WORD) == []
    assert len(fleet.mind.tasks()) == 1


def test_a_new_fleet_manager_keeps_the_promises_of_trips_under_way(world):
    fleet = Fleet(world, bots=2)
    first, second = fleet.trips(WORD)
    under_way = [BotStatus(0.0, g.bot, Phase.FETCHING, -1, g.trip, 0, "") for g in (first, second)]
    new = Fleet(world, bots=0)
    new.tell(*under_way, idle(2), idle(3))
    assert new.trips(WORD) == []
    assert new.mind.tasks()[0].bots == (0, 1)
    goals = new.trips(BUNDLE)
    assert [(goal.bot, goal.trip.bucket) for goal in goals] == [(2, 0), (3, 1)]
    assert min(goal.trip.trip for goal in goals) > second.trip.trip


def test_a_trip_that_a_bot_was_on_in_a_world_that_has_ended_is_not_waited_for(world):
    (trip,) = Fleet(world, bots=1).trips(WORD)
    new = Fleet(world, bots=0)
    new.tell(BotStatus(60.0, 0, Phase.FETCHING, -1, trip.trip, 0, ""), idle(1), idle(2), idle(3), now=7.0)
    new.trips(WORD, now=7.0)
    assert 0 in new.mind.tasks()[0].bots
    new.tell(idle(0, time=0.2), now=7.0)
    new.mind.wake(10.0)
    assert 0 not in new.mind.tasks()[0].bots


def test_a_new_fleet_manager_waits_a_moment_for_all_bots_to_say_what_they_do(world):
    view = WarehouseView(world.scenario, world.layout)
    mind = TripFleet(world.scenario, world.layout, AllAtOnce(), view, np.random.default_rng(0))
    for message in (world.snapshot(), WORD, idle(0), idle(1), idle(2)):
        assert not [said for said in mind.handle(message, 5.0) if isinstance(said, TripGoal)]
    assert mind.next_wake == 5.0 + GATHER_S
    assert [goal.bot for goal in mind.wake(mind.next_wake) if isinstance(goal, TripGoal)] == [0, 1]


def test_goals_that_come_before_the_snapshot_are_kept(world):
    view = WarehouseView(world.scenario, world.layout)
    mind = TripFleet(world.scenario, world.layout, AllAtOnce(), view, np.random.default_rng(0))
    (feedback,) = mind.handle(WORD, 0.0)
    assert "snapshot" in feedback.message
    mind.handle(idle(0), 0.0)
    mind.handle(world.snapshot(), 0.0)
    assert [goal.bot for goal in mind.wake(GATHER_S) if isinstance(goal, TripGoal)] == [0]


def test_a_task_for_what_is_not_there_ends_at_once(world):
    (result,) = Fleet(world).tell(DeliverGoal(77, 1, 77, (0,)))
    assert (result.code, result.message) == (Code.UNKNOWN, "word 77 is not open on station 1")
    (result,) = Fleet(world).tell(DeliverGoal(0, 0, 0, (0,)))
    assert (result.code, result.message) == (Code.UNKNOWN, "word 0 is not open on station 0")
    (result,) = Fleet(world).tell(StoreGoal(9, 2, 9, 0, 1))
    assert (result.code, result.message) == (Code.UNKNOWN, "bundle 9 is not staged on station 2")


def test_a_task_taken_back_takes_its_trips_back(world):
    fleet = Fleet(world, bots=1)
    (first,) = fleet.trips(WORD)
    result, cancel = fleet.tell(CancelTask(DELIVER, 0))
    assert result.code is Code.CANCELLED
    assert cancel == CancelTrip(0, first.trip.trip)
    assert fleet.mind.tasks() == ()
    (unknown,) = fleet.tell(CancelTask(STORE, 5))
    assert unknown.code is Code.UNKNOWN


def test_after_lost_events_tasks_are_what_the_world_says(world):
    fleet = Fleet(world, bots=0)
    fleet.tell(WORD, BUNDLE)
    fleet.sequence += 3
    fleet.tell(fleet.event(EventType.RESUMED, bot=1, x=1.0, y=1.0))
    assert fleet.mind.view.lost
    assert not fleet.tell(idle(0))
    let(world, opened={0: (1, (0, 1), (1, 0))}, staged={}, sequence=fleet.sequence)
    said = fleet.tell(world.snapshot())
    assert TaskResult(STORE, 0, Code.DONE, "all letters are in place") in said
    assert [m.trip.visits[0].moves for m in said if isinstance(m, TripGoal)] == [(TileMove(1, 0),)]


class Careless(FleetPolicy):
    """Plans what a test tells it."""

    def __init__(self, **wrong) -> None:
        self.wrong = wrong

    def plan(self, fleet: FleetState):
        letter = next(iter(fleet.letters()))
        spot = int(fleet.view.spot_of[self.wrong.get("bucket", 3) % 9])
        if self.wrong.get("spot", 0) is None:
            del self.wrong["spot"]
        visit = PlannedVisit(self.wrong.pop("station", letter.station), (letter,) * self.wrong.pop("times", 1))
        yield replace(TripPlan(0, 3, (visit,), spot), **self.wrong)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"bot": 3}, "bot 3 is not idle"),
        ({"bucket": 99}, "there is no bucket 99"),
        ({"bucket": 4, "spot": None}, "bucket 4 holds too few A0"),
        ({"spot": 0}, "storage spot 0 is not free for bucket 3"),
        ({"station": 0}, "letter A0 belongs to station 1, not 0"),
        ({"times": 2}, "letter A0 of deliver 0 is planned twice"),
    ],
)
def test_a_plan_that_cannot_be_is_refused_with_a_sentence(world, wrong, message):
    with pytest.raises(PlanError, match=message):
        Fleet(world, bots=1, policy=Careless(**wrong)).tell(WORD)
