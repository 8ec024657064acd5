"""Bots that meet: they pass each other, wait for each other, and get where they want to be."""

import numpy as np
import pytest
from bare_floor import BareFloor
from hypothesis import given, settings
from hypothesis import strategies as st
from world_hands import changed

from soup_msgs_py.messages import DriveGoal, DriveResult, TileMove, Transfer


def drive(floor, bot, *points):
    floor.tell(floor.crew, DriveGoal(bot, 100 + bot, tuple(points)))


def arrived(floor, count):
    return lambda: sum(isinstance(m, DriveResult) and m.code == "done" for m in floor.told) >= count


def test_two_bots_head_on_pass_each_other_without_touching():
    floor = BareFloor([(10, 30), (50, 30)])
    drive(floor, 0, (50, 30))
    drive(floor, 1, (10, 30))
    assert floor.go_on(15, arrived(floor, 2))
    assert floor.contacts == 0


def test_bots_whose_ways_cross_do_not_touch():
    floor = BareFloor([(10, 30), (30, 10)])
    drive(floor, 0, (50, 30))
    drive(floor, 1, (30, 50))
    assert floor.go_on(15, arrived(floor, 2))
    assert floor.contacts == 0


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    st.floats(-1, 1),
    st.floats(-20, 20),
    st.sampled_from([(1, 0), (0, 1), (0.6, 0.8), (-0.8, 0.6), (-1, 0)]),
    st.booleans(),
)
def test_whatever_the_angle_two_bots_pass(offset, lead, direction, loaded):
    dx, dy = direction
    start = (30 - dx * (20 + lead * 0.1) + offset, 30 - dy * (20 + lead * 0.1) + offset)
    end = (30 + dx * 20, 30 + dy * 20)
    if np.hypot(start[0] - 10, start[1] - 30) < 3 or np.hypot(end[0] - 50, end[1] - 30) < 3:
        return
    buckets = [(0, 0), (0, 0)] if loaded else []
    floor = BareFloor([(10, 30), start], buckets=buckets, carrying={0: 0, 1: 1} if loaded else None)
    drive(floor, 0, (50, 30))
    drive(floor, 1, end)
    assert floor.go_on(40, arrived(floor, 2))
    assert floor.contacts == 0


def test_a_loaded_bot_drives_between_rows_of_buckets_on_its_path():
    buckets = [(0, 0)] + [(x, y) for x in range(12, 48, 3) for y in (27, 33)]
    floor = BareFloor([(5, 30)], buckets=buckets, carrying={0: 0})
    drive(floor, 0, (55, 30))
    assert floor.go_on(13.2, arrived(floor, 1))
    assert floor.contacts == 0


def test_two_loaded_bots_pass_each_other_in_an_aisle_of_two_lanes():
    buckets = [(0, 0), (0, 0)] + [(x, y) for x in range(12, 48, 3) for y in (27, 36)]
    floor = BareFloor([(5, 30), (55, 30)], buckets=buckets, carrying={0: 0, 1: 1})
    drive(floor, 0, (55, 30))
    drive(floor, 1, (5, 30))
    assert floor.go_on(40, arrived(floor, 2))
    assert floor.contacts == 0


def test_an_unloaded_bot_drives_under_resting_buckets():
    floor = BareFloor([(5, 30)], buckets=[(x, 30) for x in range(12, 48, 3)])
    drive(floor, 0, (55, 30))
    assert floor.go_on(13.2, arrived(floor, 1))


def test_a_loaded_bot_drives_around_a_bucket_on_its_way():
    floor = BareFloor([(5, 30)], buckets=[(0, 0), (30, 30.2)], carrying={0: 0})
    drive(floor, 0, (55, 30))
    assert floor.go_on(20, arrived(floor, 1))
    assert floor.contacts == 0


def test_a_bot_drives_around_one_that_stands_on_its_way():
    floor = BareFloor([(5, 30), (30, 30)])
    drive(floor, 0, (55, 30))
    assert floor.go_on(20, arrived(floor, 1))
    assert floor.contacts == 0


def served(floor, bot, tiles):
    """Have a bot on the station give tiles to a word; each takes five seconds."""
    with changed(floor.world) as state:
        state["serving"]["contents"][0] = [(3, tiles)]
        state["serving"]["stations"][0]["open_words"] = [(0, "D" * tiles, (3,) * tiles, [False] * tiles)]
    floor.tell(floor.crew, Transfer(bot, 0, 0, (TileMove(3, 0),) * tiles))


def test_a_bot_waits_away_from_an_occupied_station_and_goes_when_it_is_free():
    floor = BareFloor([(2, 30), (30, 30)], carrying={0: 0})
    served(floor, 0, 4)
    drive(floor, 1, (2, 30))
    floor.go_on(12)
    assert 2.9 < np.hypot(floor.bots.x[1] - 2, floor.bots.y[1] - 30) < 5
    assert floor.bots.vx[1] == floor.bots.vy[1] == 0
    said = [m.message for m in floor.told if getattr(m, "bot", -1) == 1 and hasattr(m, "visits_done")]
    assert any("waits for bot 0" in text for text in said)
    floor.go_on(10)
    drive(floor, 0, (50, 30))
    assert floor.go_on(10, arrived(floor, 1))
    assert floor.go_on(20, arrived(floor, 2))
    assert floor.contacts == 0


@pytest.mark.parametrize("waiting", [2, 3, 5])
def test_the_bot_that_leaves_a_station_gets_out_between_those_that_wait(waiting):
    starts = [(2, 30)] + [(20 + 4 * (k % 2), 30 + 4 * (k - waiting // 2)) for k in range(waiting)]
    floor = BareFloor(starts, carrying={0: 0})
    served(floor, 0, 3)
    for bot in range(1, waiting + 1):
        drive(floor, bot, (2, 30))
    floor.go_on(16)
    drive(floor, 0, (50, 30))
    done = 1
    # each that arrives is sent away again
    while done < 2 * waiting + 1:
        assert floor.go_on(30, arrived(floor, done))
        for bot in range(1, waiting + 1):
            if np.hypot(floor.bots.x[bot] - 2, floor.bots.y[bot] - 30) < 0.01 and not floor.crew.minds[bot].driving:
                drive(floor, bot, (50, 10 + 5 * bot))
        done += 1
    assert floor.contacts == 0


def test_an_idle_bot_makes_way_for_one_that_wants_its_place():
    floor = BareFloor([(30, 30), (5, 30)])
    drive(floor, 1, (30, 30))
    assert floor.go_on(25, arrived(floor, 1))
    assert floor.contacts == 0


@pytest.mark.parametrize("seed", range(4))
def test_thirty_bots_that_cross_at_random_reach_their_goals(seed):
    rng = np.random.default_rng(seed)
    places = rng.permutation([(x, y) for x in range(4, 58, 6) for y in range(4, 58, 6)])
    floor = BareFloor([tuple(p) for p in places[:30]])
    for bot in range(30):
        drive(floor, bot, tuple(map(float, places[30 + bot])))
    assert floor.go_on(90, arrived(floor, 30))
    assert floor.contacts <= 2


def test_an_idle_bot_makes_way_for_one_that_cannot_pass_it():
    row = [(x, y) for x in (27.5, 30) for y in (27.5, 32.5)]
    floor = BareFloor([(5, 30), (27.5, 30)], buckets=[(0, 0), *row, (32.5, 30)], carrying={0: 0})
    drive(floor, 0, (30, 30))
    assert floor.go_on(40, arrived(floor, 1))
    assert floor.contacts == 0


def test_a_bot_does_not_set_off_into_one_that_is_about_to_pass():
    floor = BareFloor([(30, 30), (33.2, 45)])
    drive(floor, 1, (33.2, 10))
    floor.go_on(3.3)
    drive(floor, 0, (50, 30))
    assert floor.go_on(15, arrived(floor, 2))
    assert floor.contacts == 0


def test_nobody_waits_for_ever_at_a_station_that_others_come_to_again_and_again():
    floor = BareFloor([(2, 30), *((20 + 5 * k, 30) for k in range(4))])
    visits = [0] * 5
    places = [(2.0, 30.0)] + [(30.0, 10.0 + 10 * bot) for bot in range(1, 5)]
    outwards = [True, False, False, False, False]
    drive(floor, 0, (45, 5))
    for bot in range(1, 5):
        drive(floor, bot, (2, 30))
    for _ in range(4 * 150):
        floor.go_on(0.25)
        for bot in range(1, 5):
            if not floor.crew.minds[bot].driving and floor.bots.state[bot] == 0:
                visits[bot] += not outwards[bot]
                outwards[bot] = not outwards[bot]
                drive(floor, bot, places[bot] if outwards[bot] else (2, 30))
    assert min(visits[1:]) >= 5
    assert floor.contacts <= 1
