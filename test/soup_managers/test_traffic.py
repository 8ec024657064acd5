"""Traffic: bots hold what they need, wait where they may, always arrive, and never touch."""

from __future__ import annotations

import heapq
import math
from itertools import combinations, pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from soup_managers.traffic import Leg, Traffic
from soup_managers.traffic.footprint import Motion, left_after, swap_lag
from soup_managers.traffic.queue_lanes import find_lines
from soup_msgs_py.scenario import Scenario, load_scenario
from soup_msgs_py.warehouse.layout import Layout
from soup_sim.contact import first_touch
from soup_sim.layouts import make_layout

ROOT = Path(__file__).parents[2]
SCENARIOS = ("paper", "large", "demo", "dense", "hexagonal", "map")
V, A = 4.0, 20.0
FOREVER = 1e6


def scenario_of(name: str) -> Scenario:
    return load_scenario(ROOT / f"config/scenarios/{name}.yaml")


@pytest.fixture(scope="module")
def demo() -> tuple:
    scenario = scenario_of("demo")
    return scenario, make_layout(scenario)


@pytest.fixture
def traffic(demo) -> Traffic:
    return Traffic(*demo)


# ---- lines ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SCENARIOS)
def test_lines_are_ways_of_their_own_to_their_docks(name):
    layout = make_layout(scenario_of(name))
    lines = find_lines(layout)
    edges = {(int(a), int(b)) for a, b in layout.edges}
    assert [line[0] for line in lines] == layout.stations.tolist()
    private = [w for line in lines for w in line]
    assert len(private) == len(set(private))
    assert not set(private) & set(layout.storage_spots.tolist())
    for line in lines:
        assert all((behind, place) in edges for place, behind in pairwise(line))
        assert any((line[0], w) in edges and w not in private for w in range(len(layout.waypoints)))
        assert any((w, line[-1]) in edges and w not in private for w in range(len(layout.waypoints)))


@pytest.mark.parametrize("name", SCENARIOS)
def test_all_other_lanes_stay_joined(name):
    layout = make_layout(scenario_of(name))
    public = np.ones(len(layout.waypoints), dtype=bool)
    public[layout.storage_spots] = False
    public[[w for line in find_lines(layout) for w in line]] = False
    used = layout.edges[public[layout.edges].all(axis=1)]
    shape = (len(public), len(public))
    graph = coo_matrix((np.ones(len(used)), (used[:, 0], used[:, 1])), shape=shape)
    part = connected_components(graph, directed=True, connection="strong")[1]
    assert len(np.unique(part[public])) == 1


@pytest.mark.parametrize(("name", "places"), [("paper", 3), ("large", 4), ("demo", 3), ("dense", 3), ("hexagonal", 3)])
def test_stations_at_the_edge_have_room_for_a_line(name, places):
    assert min(len(line) for line in find_lines(make_layout(scenario_of(name)))) >= places


@pytest.mark.parametrize("name", ["paper", "demo", "dense", "hexagonal", "map"])
def test_every_spot_is_reached_from_every_line_and_every_line_from_every_spot(name):
    scenario = scenario_of(name)
    layout = make_layout(scenario)
    traffic = Traffic(scenario, layout)
    for line in traffic.lines[:: max(1, len(traffic.lines) // 6)]:
        for place in line:
            assert np.isfinite(traffic.times_from(place)[layout.storage_spots]).all()
            assert np.isfinite(traffic.times_to(place)[layout.storage_spots]).all()
            assert np.isfinite(traffic.times_to(place)[layout.stations]).all()


# ---- swaps ---------------------------------------------------------------------------------------------------


def closest(lag: float, length_in: float, length_out: float, cosine: float, from_rest: bool) -> float:
    """The least distance of two bots: one leaves a place, the other comes `lag` seconds later."""
    least = math.inf
    for t in np.arange(0.0, length_in / V + V / A + 0.01, 0.0005).tolist():
        to_go = length_in - (driven(t, length_in) if from_rest else min(V * t, length_in))
        gone = driven(t + lag, length_out)
        least = min(least, math.sqrt(to_go**2 + gone**2 - 2.0 * cosine * to_go * gone))
    return least


def driven(t: float, length: float) -> float:
    total, ramp = length / V + V / A, V / A
    if t <= ramp:
        return A * t * t / 2.0
    if t >= total - ramp:
        return length - A * max(total - t, 0.0) ** 2 / 2.0
    return V * (t - ramp / 2.0)


@pytest.mark.parametrize(
    ("pitch", "radius", "most"),
    [(3.0, 1.0, 0.0), (2.5, 1.0, 0.09), (1.5, 0.5, 0.0)],
)
def test_the_next_bot_at_a_station_starts_with_the_one_that_leaves(pitch, radius, most):
    motion = Motion(2.0 * radius, V, A)
    apart = 2.0 * radius + 0.01
    lag = swap_lag(pitch, pitch, 0.0, True, apart, motion)
    assert lag <= most
    assert closest(lag, pitch, pitch, 0.0, True) >= apart - 1e-3
    if lag > 0.0:
        assert closest(lag - 0.01, pitch, pitch, 0.0, True) < apart


@given(st.floats(2.1, 6.0), st.floats(2.1, 6.0), st.floats(-1.0, 0.0), st.booleans())
def test_whoever_comes_after_the_lag_touches_nobody(length_in, length_out, cosine, from_rest):
    motion = Motion(2.0, V, A)
    lag = swap_lag(length_in, length_out, cosine, from_rest, 2.01, motion)
    assert closest(lag, length_in, length_out, cosine, from_rest) >= 2.01 - 2e-3
    left = left_after(length_in, length_out, cosine, from_rest, 2.01, motion)
    assert left == pytest.approx(driven(lag, length_out), abs=1e-9)


# ---- drives --------------------------------------------------------------------------------------------------


def pieces(leg: Leg, until: float) -> list[tuple]:
    """A leg as pieces of constant acceleration: start, end, place, velocity, acceleration; then it stands."""
    found = []
    for (a, b), (start, end) in zip(pairwise(leg.points), pairwise(leg.stamps), strict=True):
        length = math.dist(a, b)
        if length == 0.0:
            found.append((start, end, a, (0.0, 0.0), (0.0, 0.0)))
            continue
        assert end - start == pytest.approx(
            length / V + V / A if length * A >= V * V else 2.0 * math.sqrt(length / A), abs=1e-9
        )
        ux, uy = (b[0] - a[0]) / length, (b[1] - a[1]) / length
        ramp = min(V / A, math.sqrt(length / A))
        speed = A * ramp
        for begin, stop, along, v, acceleration in (
            (start, start + ramp, 0.0, 0.0, A),
            (start + ramp, end - ramp, A * ramp * ramp / 2.0, speed, 0.0),
            (end - ramp, end, length - A * ramp * ramp / 2.0, speed, -A),
        ):
            if stop > begin:
                place = (a[0] + ux * along, a[1] + uy * along)
                found.append((begin, stop, place, (v * ux, v * uy), (acceleration * ux, acceleration * uy)))
    found.append((leg.arrive, until, leg.points[-1], (0.0, 0.0), (0.0, 0.0)))
    return found


def moved(piece: tuple, time: float) -> tuple:
    start, _, (x, y), (vx, vy), (ax, ay) = piece
    s = time - start
    return x + s * (vx + ax * s / 2.0), y + s * (vy + ay * s / 2.0), vx + ax * s, vy + ay * s


def touch(some: list[tuple], others: list[tuple], body: float) -> float:
    """When two bots touch first; their pieces in order of time, each as exact as the world's own."""
    i = j = 0
    while i < len(some) and j < len(others):
        a, b = some[i], others[j]
        start, end = max(a[0], b[0]), min(a[1], b[1])
        if end > start:
            ax, ay, avx, avy = moved(a, start)
            bx, by, bvx, bvy = moved(b, start)
            when = first_touch(
                bx - ax, by - ay, bvx - avx, bvy - avy, b[4][0] - a[4][0], b[4][1] - a[4][1], body, end - start
            )
            if when < math.inf:
                return start + when
        if a[1] <= b[1]:
            i += 1
        else:
            j += 1
    return math.inf


def assert_nobody_touches(legs_of: dict[int, list[Leg]], body: float) -> None:
    tracks = {}
    for bot, legs in legs_of.items():
        track = []
        untils = [following.depart for following in legs[1:]] + [FOREVER]
        for leg, until in zip(legs, untils, strict=True):
            track += pieces(leg, until)
        x = [p[2][0] for p in track]
        y = [p[2][1] for p in track]
        tracks[bot] = track, (min(x), max(x), min(y), max(y))
    for a, b in combinations(tracks, 2):
        (some, box), (others, other_box) = tracks[a], tracks[b]
        if box[0] > other_box[1] + 9 or other_box[0] > box[1] + 9 or box[2] > other_box[3] + 9:
            continue
        when = touch(some, others, body)
        assert when == math.inf, f"bots {a} and {b} touch at {when}"


def drive_about(
    traffic: Traffic,
    layout: Layout,
    bots: int,
    legs: int,
    seed: int,
    *,
    dwell_s: float = 3.0,
    before: dict[int, list[Leg]] | None = None,
) -> dict[int, list[Leg]]:
    """Bots on storage spots drive between spots and station lines at random; every leg must be planned.

    With `before` they do not begin on spots: they are still on the last legs of an earlier timetable.
    """
    rng = np.random.default_rng(seed)
    spots = layout.storage_spots.tolist()
    driven: dict[int, list[Leg]] = {}
    agenda = []
    for bot, drives in (before or {}).items():
        traffic.adopt(bot, drives[-1].points, drives[-1].stamps)
        driven[bot] = drives[-1:]
        agenda.append((drives[-1].arrive, bot))
    for bot, spot in enumerate(rng.permutation(spots)[: 0 if before else bots].tolist()):
        traffic.stand(bot, spot, 0.0)
        point = (float(layout.waypoints[spot, 0]), float(layout.waypoints[spot, 1]))
        driven[bot] = [Leg(bot, (spot,), (point,), (0.0,), 0.0, 0.0)]
        agenda.append((0.0, bot))
    under_way_until = max(time for time, _ in agenda) if before else -math.inf
    heapq.heapify(agenda)
    for _ in range(legs):
        now, bot = heapq.heappop(agenda)
        traffic.forget_before(now)
        goals = spots
        if rng.random() < 0.5 and traffic.at(bot) in spots:
            line = traffic.lines[int(rng.integers(len(traffic.lines)))]
            goals = [line[0]] if all(traffic.free_from(w) < math.inf for w in line) else spots
        free = [w for w in goals if traffic.free_from(w) < math.inf]
        goal = free[int(rng.integers(len(free)))]
        leg = traffic.plan(bot, goal, now, loaded=bool(rng.random() < 0.5))
        if leg is None and now < under_way_until:  # who is on an earlier leg holds a little too much
            heapq.heappush(agenda, (now + 1.0, bot))
            continue
        assert leg is not None, (bot, traffic.at(bot), goal)
        assert now <= leg.depart <= leg.arrive < now + 1000.0
        driven[bot].append(leg)
        heapq.heappush(agenda, (leg.arrive + float(rng.uniform(0.0, dwell_s)), bot))
    return driven


@pytest.mark.parametrize(("name", "bots", "legs"), [("demo", 40, 1500), ("hexagonal", 60, 1000), ("map", 30, 800)])
def test_bots_that_drive_at_random_arrive_and_never_touch(name, bots, legs):
    scenario = scenario_of(name)
    layout = make_layout(scenario)
    traffic = Traffic(scenario, layout)
    driven = drive_about(traffic, layout, bots, legs, seed=1)
    assert_nobody_touches(driven, 2.0 * scenario.bot.radius_m)


@settings(max_examples=15)
@given(
    st.integers(0, 1000),
    st.sampled_from(["rows", "hexagonal"]),
    st.floats(2.05, 4.0),
    st.integers(1, 2),
    st.integers(1, 4),
    st.integers(2, 6),
)
def test_on_any_floor_nobody_is_stuck_and_nobody_touches(seed, kind, pitch, lanes, margin, stations):
    scenario = scenario_of("paper").model_copy(
        update={
            "floor": scenario_of("dense").floor,
            "word_stations": stations,
            "letter_stations": stations,
            "layout": scenario_of("hexagonal" if kind == "hexagonal" else "paper").layout.model_copy(
                update={"pitch_m": pitch, "aisle_lanes": lanes, "margin_columns": margin, "block_rows": 5}
            ),
            "buckets": 10,
            "bots": 10,
        }
    )
    layout = make_layout(scenario)
    driven = drive_about(Traffic(scenario, layout), layout, 15, 100, seed)
    assert_nobody_touches(driven, 2.0)


def test_a_leg_says_when_it_departs_stops_and_arrives(traffic, demo):
    layout = demo[1]
    spot, dock = int(layout.storage_spots[0]), traffic.lines[0][0]
    traffic.stand(0, spot, 0.0)
    leg = traffic.plan(0, dock, 5.0, loaded=True)
    assert leg is not None
    assert leg.waypoints[0] == spot and leg.waypoints[-1] == dock
    assert leg.points == tuple(tuple(layout.waypoints[w].tolist()) for w in leg.waypoints)
    assert leg.stamps[0] == leg.depart == 5.0 and leg.stamps[-1] == leg.arrive
    assert leg.arrive == pytest.approx(5.0 + traffic.travel_time(spot, dock), abs=1e-6)
    assert traffic.at(0) == dock
    assert traffic.free_from(dock) == math.inf
    assert leg.depart <= traffic.free_from(spot) <= leg.depart + 0.5


def test_nobody_goes_where_somebody_stands_for_good(traffic, demo):
    a, b = (int(w) for w in demo[1].storage_spots[:2])
    traffic.stand(0, a, 0.0)
    traffic.stand(1, b, 0.0)
    assert traffic.plan(0, b, 0.0, loaded=False) is None
    assert traffic.free_from(a) == math.inf
    assert traffic.plan(1, int(demo[1].storage_spots[2]), 0.0, loaded=False) is not None
    assert traffic.plan(0, b, 0.0, loaded=False) is not None


def test_a_bot_waits_until_the_dock_is_free_and_then_follows_at_once(traffic):
    dock, second = traffic.lines[0][:2]
    traffic.stand(0, dock, 0.0)
    traffic.stand(1, second, 0.0)
    assert traffic.plan(1, dock, 0.0, loaded=True) is None
    away = traffic.plan(0, int(np.flatnonzero(traffic._roads.spot)[0]), 10.0, loaded=True)
    assert away is not None and away.depart == 10.0
    follows = traffic.plan(1, dock, 0.0, loaded=True)
    assert follows is not None
    assert 10.0 <= follows.depart <= 10.01
    assert follows.arrive <= 10.0 + 1.5 / V + V / A + 0.01


def test_a_bot_in_line_may_leave_without_docking(traffic):
    line = traffic.lines[0]
    traffic.stand(0, line[0], 0.0)
    traffic.stand(1, line[-1], 0.0)
    spot = int(np.flatnonzero(traffic._roads.spot)[0])
    leg = traffic.plan(1, spot, 0.0, loaded=False)
    assert leg is not None and line[0] not in leg.waypoints


def test_a_leg_that_is_undone_has_never_been(traffic, demo):
    a, b, c = (int(w) for w in demo[1].storage_spots[[0, 40, 80]])
    traffic.stand(0, a, 0.0)
    before = traffic._table.filled.copy()
    first = traffic.plan(0, b, 1.0, loaded=False)
    held = traffic._table.filled.copy()
    second = traffic.plan(0, c, 100.0, loaded=False)
    assert first is not None and second is not None
    traffic.undo(0, 50.0)
    assert traffic.at(0) == b and (traffic._table.filled == held).all()
    traffic.undo(0, 0.5)
    assert traffic.at(0) == a and (traffic._table.filled == before).all()
    assert traffic.free_from(a) == math.inf
    assert traffic.plan(0, b, 1.0, loaded=False) == first


def test_what_a_search_has_found_is_a_copy_that_later_searches_leave_alone(traffic, demo, monkeypatch):
    found, search = [], traffic._find
    monkeypatch.setattr(traffic, "_find", lambda query: found.append(search(query)) or found[-1])
    spots = demo[1].storage_spots[[0, 40, 80]].tolist()
    traffic.stand(0, spots[0], 0.0)
    assert traffic.plan(0, spots[1], 1.0, loaded=False) is not None
    first = found[0]
    then = [values.copy() for values in first]
    assert traffic.plan(0, spots[2], 100.0, loaded=False) is not None
    assert traffic.plan(0, spots[0], 200.0, loaded=True) is not None
    for values, before in zip(first, then, strict=True):
        np.testing.assert_array_equal(values, before)
        assert not any(np.shares_memory(values, scratch) for scratch in traffic._desk)


def test_ways_lead_around_a_bot_that_stands_in_an_aisle(traffic, demo):
    spot, dock = int(demo[1].storage_spots[0]), traffic.lines[0][0]
    traffic.stand(0, spot, 0.0)
    free = traffic.plan(0, dock, 0.0, loaded=True)
    assert free is not None
    traffic.stand(0, spot, 0.0)
    lanes = set(range(len(demo[1].waypoints))).difference(demo[1].storage_spots.tolist(), *traffic.lines)
    corner = next(w for w in free.waypoints[1:] if w in lanes)
    beyond = free.waypoints[free.waypoints.index(corner) + 1]
    step = demo[1].waypoints[beyond] - demo[1].waypoints[corner]
    middle = demo[1].waypoints[corner] + step / 2.0
    blocked = int(((demo[1].waypoints - middle) ** 2).sum(axis=1).argmin())
    traffic.stand(1, blocked, 0.0)
    around = traffic.plan(0, dock, 0.0, loaded=True)
    assert around is not None and blocked not in around.waypoints
    assert around.arrive > free.arrive


def to_a_spot(traffic: Traffic, layout: Layout, bot: int) -> Leg | None:
    """A leg of a bot to one of the nearest storage spots that nobody stands on or goes to."""
    spots = [w for w in layout.storage_spots.tolist() if traffic.free_from(w) < math.inf]
    spots.sort(key=traffic.times_from(traffic.at(bot)).tolist().__getitem__)
    legs = (traffic.plan(bot, spot, 0.0, loaded=False) for spot in spots[:4])
    return next((leg for leg in legs if leg is not None), None)


def test_bots_on_lanes_find_storage_spots_to_wait_on(demo):
    scenario, layout = demo
    traffic = Traffic(scenario, layout)
    rng = np.random.default_rng(3)
    free = np.setdiff1d(np.arange(len(layout.waypoints)), layout.stations)
    places = rng.permutation(free)[:40].tolist()
    driven = {}
    for bot, place in enumerate(places):
        traffic.stand(bot, place, 0.0)
        point = (float(layout.waypoints[place, 0]), float(layout.waypoints[place, 1]))
        driven[bot] = [Leg(bot, (place,), (point,), (0.0,), 0.0, 0.0)]
    spots = set(layout.storage_spots.tolist())
    for bot in [*driven, *driven, *driven]:  # who cannot go yet may when others have gone
        leg = to_a_spot(traffic, layout, bot) if traffic.at(bot) not in spots else None
        if leg is not None:
            driven[bot].append(leg)
    assert all(traffic.at(bot) in spots for bot in driven)
    assert len({traffic.at(bot) for bot in driven}) == len(driven)
    assert_nobody_touches(driven, 2.0 * scenario.bot.radius_m)


def test_who_drives_another_way_than_was_planned_is_in_the_way_of_others_as_long_as_it_drives(traffic, demo):
    spot, dock = int(demo[1].storage_spots[0]), traffic.lines[0][0]
    traffic.stand(0, spot, 0.0)
    leg = traffic.plan(0, dock, 0.0, loaded=True)
    assert leg is not None
    traffic.stand(1, int(demo[1].storage_spots[-1]), 0.0)
    assert traffic.conflicts(1, 0.0) == []
    traffic.adopt(1, tuple(reversed(leg.points)), leg.stamps)
    assert traffic.conflicts(1, 0.0) == [0]
    assert traffic.conflicts(0, 0.0) == [1]
    assert traffic.conflicts(1, leg.arrive + 60.0) == []


def test_a_bot_stopped_between_waypoints_is_in_the_way_of_those_who_planned_to_pass(traffic, demo):
    spot, dock = int(demo[1].storage_spots[0]), traffic.lines[0][0]
    traffic.stand(0, spot, 0.0)
    leg = traffic.plan(0, dock, 0.0, loaded=True)
    assert leg is not None
    (ax, ay), (bx, by) = leg.points[1:3]
    traffic.stand_at(1, ax * 0.7 + bx * 0.3, ay * 0.7 + by * 0.3, 0.0)
    assert traffic.conflicts(1, 0.0) == [0]
    traffic.undo(0, 0.0)
    assert traffic.conflicts(1, 0.0) == []
    around = traffic.plan(0, dock, 0.0, loaded=True)
    assert around is not None
    assert_nobody_touches(
        {0: [around], 1: [Leg(1, (-1,), ((ax * 0.7 + bx * 0.3, ay * 0.7 + by * 0.3),), (0.0,), 0.0, 0.0)]},
        2.0 * demo[0].bot.radius_m,
    )


def test_a_bot_stopped_between_waypoints_gets_back_on_its_way(traffic, demo):
    scenario, layout = demo
    spot, dock = int(layout.storage_spots[0]), traffic.lines[0][0]
    x, y = layout.waypoints[spot] + np.array([0.6, 0.0])
    traffic.stand_at(0, float(x), float(y), 0.0)
    traffic.stand(1, int(layout.storage_spots[30]), 0.0)
    other = traffic.plan(1, traffic.lines[3][0], 0.0, loaded=True)
    leg = traffic.plan(0, dock, 0.0, loaded=True)
    assert leg is not None and other is not None
    assert leg.points[0] == (float(x), float(y)) and leg.waypoints[-1] == dock
    assert_nobody_touches({0: [leg], 1: [other]}, 2.0 * scenario.bot.radius_m)


@pytest.mark.parametrize(("name", "bots"), [("demo", 40), ("hexagonal", 60), ("map", 30)])
def test_who_plans_on_from_drives_under_way_touches_nobody(name, bots):
    scenario = scenario_of(name)
    layout = make_layout(scenario)
    before = drive_about(Traffic(scenario, layout), layout, bots, 500, seed=2)
    after = drive_about(Traffic(scenario, layout), layout, bots, 500, seed=3, before=before)
    assert_nobody_touches(after, 2.0 * scenario.bot.radius_m)


def test_the_same_requests_make_the_same_plans(demo):
    scenario, layout = demo
    once, again = (drive_about(Traffic(scenario, layout), layout, 12, 200, seed=5) for _ in range(2))
    assert once == again
