"""Ways of loaded bots: over edges, never through storage spots, as cheap as can be, with few corners."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra
from tiny_warehouse import scenario_of

from soup_managers.traffic.router import STATION_DETOUR_M, Router
from soup_msgs_py.warehouse.layout import Layout
from soup_sim.layouts import make_layout

PITCH = 3.0
TINY = make_layout(scenario_of())
seeds = st.integers(0, 2**32 - 1)


def random_layout(rng: np.random.Generator) -> Layout:
    """A grid of waypoints with random one-way streets, weights, storage spots and stations."""
    columns, rows = (int(n) for n in rng.integers(3, 9, 2))
    waypoints = np.array([(PITCH * c, PITCH * r) for c in range(columns) for r in range(rows)])
    edges = []
    for here in range(len(waypoints)):
        for there in (here + 1 if (here + 1) % rows else -1, here + rows):
            if 0 <= there < len(waypoints):
                edges += [e for e in ((here, there), (there, here)) if rng.random() < 0.9]
    kinds = rng.permutation(len(waypoints))
    stations = int(rng.integers(1, 3))
    return Layout(
        width_m=PITCH * columns,
        height_m=PITCH * rows,
        waypoints=waypoints,
        edges=np.array(edges, np.int32),
        edge_weights=rng.choice([1.0, 1.0, 5.0], len(edges)),
        storage_spots=kinds[2 * stations : 2 * stations + len(waypoints) // 4].astype(np.int32),
        word_stations=kinds[:stations].astype(np.int32),
        letter_stations=kinds[stations : 2 * stations].astype(np.int32),
    )


def waypoints_of(layout: Layout, start: int, corners: tuple) -> list[int]:
    """All waypoints on a way that is given by its corners; fails where a leg follows no edges."""
    edges = {(int(a), int(b)) for a, b in layout.edges}
    number = {(float(x), float(y)): n for n, (x, y) in enumerate(layout.waypoints)}
    way = [start]
    for x, y in corners:
        goal = number[x, y]
        while way[-1] != goal:
            hx, hy = layout.waypoints[way[-1]]
            step = (hx + PITCH * np.sign(x - hx), hy + PITCH * np.sign(y - hy))
            assert (way[-1], number[step]) in edges
            way.append(number[step])
    return way


def cost_of(layout: Layout, way: list[int]) -> float:
    weights = {(int(a), int(b)): w for (a, b), w in zip(layout.edges, layout.edge_weights, strict=True)}
    stations = set(layout.stations.tolist())
    return sum(PITCH * weights[edge] for edge in pairwise(way)) + sum(
        STATION_DETOUR_M for waypoint in way[1:-1] if waypoint in stations
    )


def detour(layout: Layout, waypoint: int, goal: int) -> float:
    """What driving on from a waypoint costs."""
    if waypoint == goal:
        return 0.0
    if waypoint in layout.storage_spots:
        return np.inf
    return STATION_DETOUR_M if waypoint in layout.stations else 0.0


def dijkstra_says(layout: Layout, start: int, goal: int) -> float:
    """The cheapest way by another program: what may not be driven through has no edges that leave it."""
    n = len(layout.waypoints)
    spots, stations = set(layout.storage_spots.tolist()), set(layout.stations.tolist())
    graph = np.zeros((n, n))
    for (a, b), weight in zip(layout.edges.tolist(), layout.edge_weights, strict=True):
        if a == start or a not in spots:
            graph[a, b] = PITCH * weight + (STATION_DETOUR_M if a in stations and a != start else 0.0)
    return float(dijkstra(csr_matrix(graph), indices=start)[goal])


@given(seeds)
def test_ways_follow_edges_avoid_storage_spots_and_cost_what_dijkstra_says(seed):
    rng = np.random.default_rng(seed)
    layout = random_layout(rng)
    router = Router(layout)
    spots = set(layout.storage_spots.tolist())
    places = [*layout.stations.tolist(), *rng.integers(0, len(layout.waypoints), 4).tolist()]
    for start in places:
        for goal in places:
            if start == goal:
                continue
            corners = router.route(start, goal)
            expected = dijkstra_says(layout, start, goal)
            assert router.cost(start, goal) == pytest.approx(expected)
            if corners is None:
                assert expected == np.inf
                continue
            way = waypoints_of(layout, start, corners)
            assert not spots.intersection(way[1:-1])
            assert cost_of(layout, way) == pytest.approx(expected)


@given(seeds)
def test_a_way_has_a_corner_only_where_its_direction_changes(seed):
    rng = np.random.default_rng(seed)
    layout = random_layout(rng)
    start, goal = rng.choice(len(layout.waypoints), 2, replace=False).tolist()
    corners = Router(layout).route(start, goal)
    for before, corner, after in zip(
        [layout.waypoints[start], *(corners or ())], corners or (), (corners or ())[1:], strict=False
    ):
        one, other = np.sign(np.subtract(corner, before)), np.sign(np.subtract(after, corner))
        assert tuple(one) != tuple(other)


def test_of_equally_long_ways_the_one_with_the_fewest_turns_is_taken():
    router = Router(TINY)
    far = router.nearest_waypoint(0.0, TINY.height_m)
    # down the left edge first, it would have to leave the row of storage spots in front of the station again
    right, top = TINY.waypoints.max(axis=0)
    station = max(TINY.word_stations.tolist(), key=lambda w: TINY.waypoints[w, 1])
    assert router.route(far, station) == ((right, top), tuple(TINY.waypoints[station]))


@given(seeds)
def test_no_way_of_the_same_cost_has_fewer_turns(seed):
    rng = np.random.default_rng(seed)
    layout = random_layout(rng)
    router = Router(layout)
    edges = layout.edges.tolist()
    start, goal = rng.choice(len(layout.waypoints), 2, replace=False).tolist()
    corners = router.route(start, goal)
    # all cheapest ways, waypoint by waypoint in the order of their costs: fewest turns by last step
    left = {w: router.cost(w, goal) for w in range(len(layout.waypoints))}
    fewest: dict[int, dict[tuple, int]] = {start: {}}
    for here in sorted(left, key=lambda waypoint: -left[waypoint]):
        for a, b in edges:
            if a != here or here not in fewest or left[a] == np.inf:
                continue
            if cost_of(layout, [a, b]) + left[b] + detour(layout, b, goal) > left[a] + 1e-6:
                continue
            step = tuple(np.sign(layout.waypoints[b] - layout.waypoints[a]))
            turns = min((n + (last != step) for last, n in fewest[here].items()), default=0)
            known = fewest.setdefault(b, {})
            known[step] = min(known.get(step, turns), turns)
    if corners is None:
        assert goal not in fewest
    else:
        assert len(corners) - 1 == min(fewest[goal].values())


def test_the_way_to_where_one_is_is_that_place():
    assert Router(TINY).route(5, 5) == (tuple(TINY.waypoints[5]),)


def test_a_loaded_bot_off_the_waypoints_joins_them_where_no_bucket_may_rest():
    router = Router(TINY)
    spot = int(TINY.storage_spots[0])
    x, y = TINY.waypoints[spot]
    assert router.entry(x, y) == spot
    entry = router.entry(x + 0.8, y + 0.6)
    assert entry not in TINY.storage_spots
    goal = int(TINY.word_stations[0])
    way = router.route_from_place(x + 0.8, y + 0.6, goal)
    assert way is not None
    assert way[0] == tuple(TINY.waypoints[entry])
    assert way[1:] == router.route(entry, goal)
