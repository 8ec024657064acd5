"""The floor: every layout keeps its promises, and what does not fit is named."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree
from scipy.spatial.distance import pdist

from soup_msgs_py.errors import InputError
from soup_msgs_py.scenario import Scenario, load_scenario, scenario_from_json
from soup_msgs_py.scenario.floor_plan import MapLayout
from soup_msgs_py.warehouse.layout import Layout
from soup_sim.layouts import make_layout
from soup_sim.scenario_loader import load_warehouse

ROOT = Path(__file__).parents[2]
SCENARIOS = ROOT / "config/scenarios"
BODY_M = 2.0  # diameter of the paper's bots and buckets


def scenario_of(layout: dict, **changes) -> Scenario:
    values = {
        "name": "floor",
        "floor": {"width_m": 60.0, "height_m": 45.0},
        "bots": 1,
        "buckets": 1,
        "word_stations": 2,
        "letter_stations": 2,
        "words": "words.txt",
        "layout": layout,
    }
    return Scenario.model_validate(values | changes)


def drawn(tmp_path: Path, text: str, **layout) -> Scenario:
    """A scenario with a map of this text and as many stations as it draws."""
    file = tmp_path / "floor.txt"
    file.write_text(text)
    stations = {"word_stations": text.count("W") or 1, "letter_stations": text.count("L") or 1}
    return scenario_of({"kind": "map", "path": str(file)} | layout, **stations)


def weights(layout: Layout) -> dict[tuple[int, int], float]:
    return {(int(a), int(b)): float(w) for (a, b), w in zip(layout.edges, layout.edge_weights, strict=True)}


def waypoint_at(layout: Layout, x: float, y: float) -> int:
    return int(((layout.waypoints - (x, y)) ** 2).sum(axis=1).argmin())


def line_of(scenario: Scenario) -> str:
    """The error line of a layout that cannot be made."""
    with pytest.raises(InputError) as caught:
        make_layout(scenario, "F.yaml")
    assert "\n" not in str(caught.value)
    return str(caught.value)


@st.composite
def plans(draw) -> dict:
    """Any computed layout."""
    kind = draw(st.sampled_from(["rows", "dense", "hexagonal"]))
    plan = {
        "kind": kind,
        "pitch_m": draw(st.floats(2.01, 4.0)),
        "block_rows": draw(st.integers(1, 12)),
        "aisle_lanes": draw(st.integers(1, 2)),
        "margin_columns": draw(st.integers(1, 5)),
    }
    if kind != "hexagonal":
        plan["block_columns"] = draw(st.integers(1, 2 if kind == "rows" else 8))
    return plan


@st.composite
def floors(draw) -> tuple[Scenario, Layout]:
    """Any computed layout that fits its floor."""
    scenario = scenario_of(
        draw(plans()),
        floor={"width_m": draw(st.floats(20.0, 90.0)), "height_m": draw(st.floats(20.0, 90.0))},
        word_stations=draw(st.integers(1, 6)),
        letter_stations=draw(st.integers(1, 6)),
    )
    try:
        return scenario, make_layout(scenario)
    except InputError as error:
        assert error.key in ("floor", "word_stations", "letter_stations"), error  # too small for it, nothing else
        assume(False)
        raise


def gap(place: np.ndarray, a: np.ndarray, b: np.ndarray) -> float:
    """How far a place is from the straight way from a to b."""
    share = np.clip(np.dot(place - a, b - a) / np.dot(b - a, b - a), 0.0, 1.0)
    return float(np.linalg.norm(place - a - share * (b - a)))


def assert_spots_are_out_of_the_way(layout: Layout) -> None:
    """A bucket that is carried along an edge touches none that rests elsewhere."""
    spots = cKDTree(layout.waypoints[layout.storage_spots])
    for a, b in layout.edges:
        start, end = layout.waypoints[a], layout.waypoints[b]
        reach = float(np.linalg.norm(end - start)) / 2.0 + BODY_M
        for index in spots.query_ball_point((start + end) / 2.0, reach):
            spot = layout.storage_spots[index]
            if spot not in (a, b):
                assert gap(layout.waypoints[spot], start, end) >= BODY_M - 1e-9


def reached(layout: Layout, station: int, through_spots: bool) -> np.ndarray:
    """Waypoints that a bot with a bucket can reach from a station, by Dijkstra's algorithm."""
    tails, heads = layout.edges.T
    n = len(layout.waypoints)
    usable = np.ones(len(tails), bool) if through_spots else ~np.isin(tails, layout.storage_spots)
    graph = coo_matrix((np.ones(usable.sum()), (tails[usable], heads[usable])), shape=(n, n)).tocsr()
    return np.isfinite(dijkstra(graph, indices=station))


def left(layout: Layout, station: int, through_spots: bool) -> np.ndarray:
    """Waypoints from which a bot with a bucket can reach a station."""
    turned = Layout(**{**vars(layout), "edges": layout.edges[:, ::-1]})
    return reached(turned, station, through_spots)


# ---- laws ----------------------------------------------------------------------------------------------------


@given(floors())
def test_every_waypoint_has_room_for_a_bot_on_the_floor(floor):
    scenario, layout = floor
    assert (layout.waypoints >= BODY_M / 2.0).all()
    assert (layout.waypoints <= np.array([scenario.floor.width_m, scenario.floor.height_m]) - BODY_M / 2.0).all()


@given(floors())
def test_no_two_waypoints_are_nearer_than_a_pitch(floor):
    scenario, layout = floor
    assert pdist(layout.waypoints).min() >= scenario.layout.pitch_m * (1.0 - 1e-9)


@settings(suppress_health_check=[HealthCheck.too_slow], deadline=None)
@given(floors())
def test_a_carried_bucket_passes_no_resting_one_too_near(floor):
    assert_spots_are_out_of_the_way(floor[1])


@given(floors())
def test_every_storage_spot_is_reached_from_every_station_and_left_again(floor):
    scenario, layout = floor
    for station in layout.stations:
        deep = scenario.layout.kind == "dense"
        assert reached(layout, station, deep).all()
        assert left(layout, station, deep).all()


@given(floors())
def test_stations_are_distinct_and_no_storage_spots(floor):
    scenario, layout = floor
    assert len(layout.word_stations) == scenario.word_stations
    assert len(layout.letter_stations) == scenario.letter_stations
    assert len(np.unique(layout.stations)) == len(layout.stations)
    assert not np.isin(layout.stations, layout.storage_spots).any()


@given(floors())
def test_letter_stations_stand_on_the_left_edge_and_word_stations_on_the_right(floor):
    _, layout = floor
    x = layout.waypoints[:, 0]
    assert (x[layout.letter_stations] == x.min()).all()
    assert (x[layout.word_stations] == x.max()).all()


@given(floors())
def test_storage_spots_come_in_whole_blocks_of_columns(floor):
    scenario, layout = floor
    plan = scenario.layout
    columns = 2 if plan.kind == "hexagonal" else plan.block_columns
    spots = layout.waypoints[layout.storage_spots]
    assert len(np.unique(np.round(spots[:, 0], 6))) % columns == 0
    assert len(spots) % (columns * plan.block_rows) == 0


@given(floors())
def test_lanes_lead_both_ways_and_the_wrong_way_costs_five_times(floor):
    _, layout = floor
    cost = weights(layout)
    assert len(cost) == len(layout.edges)  # none twice
    for (a, b), weight in cost.items():
        assert (weight, cost[b, a]) in {(1.0, 1.0), (1.0, 5.0), (5.0, 1.0)}


@given(floors())
def test_a_station_is_joined_to_all_its_neighbours_but_other_stations(floor):
    scenario, layout = floor
    beside = cKDTree(layout.waypoints)
    for station in layout.stations:
        joined = set(layout.edges[layout.edges[:, 0] == station, 1].tolist())
        assert joined == set(layout.edges[layout.edges[:, 1] == station, 0].tolist())
        assert not joined & set(layout.stations.tolist())
        near = beside.query_ball_point(layout.waypoints[station], scenario.layout.pitch_m * 1.5)
        same_line = [w for w in near if np.isclose(layout.waypoints[w] - layout.waypoints[station], 0.0).any()]
        assert set(same_line) - {station} - set(layout.stations.tolist()) <= joined


@given(floors())
def test_the_same_scenario_makes_the_same_layout(floor):
    scenario, layout = floor
    assert make_layout(scenario_from_json(scenario.model_dump_json())) == layout


@settings(suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much], deadline=None)
@given(plans(), st.lists(st.tuples(st.floats(1.0, 59.0), st.floats(1.0, 44.0)), min_size=1, max_size=4))
def test_stations_anywhere_are_clear_of_all_traffic_or_refused(plan, places):
    scenario = scenario_of(plan, word_stations=places)
    try:
        layout = make_layout(scenario)
    except InputError as error:
        assert error.key.split(".")[0] in ("layout", "floor", "word_stations", "letter_stations")
        return
    assert_spots_are_out_of_the_way(layout)
    assert reached(layout, layout.stations[0], plan["kind"] == "dense").all()
    for station, place in zip(layout.word_stations, places, strict=True):
        here = layout.waypoints[station]
        assert here == pytest.approx(place, abs=1e-5)
        for a, b in layout.edges:
            if station not in (a, b):
                assert gap(here, layout.waypoints[a], layout.waypoints[b]) >= BODY_M - 1e-9


# ---- each kind -----------------------------------------------------------------------------------------------


def test_rows_join_storage_spots_to_aisles_beside_them_only():
    layout = make_layout(scenario_of({"kind": "rows"}))
    spots = set(layout.storage_spots.tolist())
    for a, b in layout.edges:
        if a in spots or b in spots:
            assert layout.waypoints[a, 1] == layout.waypoints[b, 1]


def test_traffic_keeps_right_in_aisles():
    layout = make_layout(scenario_of({"kind": "rows", "margin_columns": 2}))
    cost = weights(layout)
    x, y = np.unique(layout.waypoints[:, 0]), np.unique(layout.waypoints[:, 1])
    left_lane, right_lane = x[2], x[3]
    down = waypoint_at(layout, left_lane, y[5]), waypoint_at(layout, left_lane, y[4])
    up = waypoint_at(layout, right_lane, y[4]), waypoint_at(layout, right_lane, y[5])
    assert cost[down] == cost[up] == 1.0
    assert cost[down[1], down[0]] == cost[up[1], up[0]] == 5.0


def test_in_a_dense_block_every_neighbour_is_joined():
    layout = make_layout(scenario_of({"kind": "dense", "block_columns": 4, "block_rows": 5, "margin_columns": 2}))
    cost = weights(layout)
    for spot in layout.storage_spots:
        near = cKDTree(layout.waypoints).query_ball_point(layout.waypoints[spot], 3.0 + 1e-6)
        assert len(near) == 5  # itself and four neighbours
        assert all((spot, other) in cost and (other, spot) in cost for other in near if other != spot)


def test_inner_buckets_of_a_dense_block_must_be_dug_out():
    layout = load_warehouse(SCENARIOS / "dense.yaml").layout
    open_places = reached(layout, layout.stations[0], through_spots=False)
    assert int((~open_places[layout.storage_spots]).sum()) == 9 * 4 * 6  # 9 blocks of 6 x 8 without their rims


def test_in_a_hexagonal_block_neighbours_are_one_pitch_apart():
    layout = make_layout(scenario_of({"kind": "hexagonal", "block_rows": 8, "margin_columns": 2}))
    spots = layout.waypoints[layout.storage_spots]
    touching = cKDTree(spots).query_pairs(3.0 * (1.0 + 1e-9))
    neighbours = np.bincount(np.array(list(touching)).ravel(), minlength=len(spots))
    assert set(neighbours.tolist()) == {2, 3, 4}  # at a tip, at a corner, along a column
    columns = np.unique(np.round(spots[:, 0], 6))
    assert columns[1] - columns[0] == pytest.approx(3.0 * 3.0**0.5 / 2.0)


def test_every_hexagonal_spot_is_next_to_an_aisle():
    layout = make_layout(scenario_of({"kind": "hexagonal", "block_rows": 8, "margin_columns": 2}))
    lanes = np.setdiff1d(np.arange(len(layout.waypoints)), layout.storage_spots)
    for spot in layout.storage_spots:
        assert np.isin(layout.edges[layout.edges[:, 0] == spot, 1], lanes).all()


# ---- maps ----------------------------------------------------------------------------------------------------

SMALL = """\
L.<<<<.W
#.vSS^.#
L.vSS^.W
#.>>>>.#
"""


def test_a_map_becomes_what_it_draws(tmp_path):
    layout = make_layout(drawn(tmp_path, SMALL))
    assert len(layout.waypoints) == 28
    assert len(layout.storage_spots) == 4
    assert len(layout.edges) == 2 * (4 * 7 - 4 + 3 * 6)
    x, y = layout.waypoints.T
    assert np.ptp(x) == 7 * 3.0 and np.ptp(y) == 3 * 3.0
    assert (x.min() + x.max(), y.min() + y.max()) == (60.0, 45.0)  # in the middle of the floor


def test_stations_of_a_map_are_numbered_as_one_reads(tmp_path):
    layout = make_layout(drawn(tmp_path, SMALL))
    assert layout.waypoints[layout.word_stations].tolist() == [[40.5, 27.0], [40.5, 21.0]]
    assert layout.waypoints[layout.letter_stations].tolist() == [[19.5, 27.0], [19.5, 21.0]]


def test_the_wrong_way_of_a_drawn_lane_costs_more(tmp_path):
    layout = make_layout(drawn(tmp_path, SMALL, wrong_way=7.0))
    cost = weights(layout)
    left_end, right_end = waypoint_at(layout, 25.5, 27.0), waypoint_at(layout, 28.5, 27.0)
    assert (cost[right_end, left_end], cost[left_end, right_end]) == (1.0, 7.0)
    top, below = waypoint_at(layout, 25.5, 24.0), waypoint_at(layout, 25.5, 21.0)
    assert (cost[top, below], cost[below, top]) == (1.0, 7.0)


def test_the_wrong_way_of_a_drawn_lane_can_be_forbidden(tmp_path):
    layout = make_layout(drawn(tmp_path, SMALL, wrong_way=None))
    cost = weights(layout)
    left_end, right_end = waypoint_at(layout, 25.5, 27.0), waypoint_at(layout, 28.5, 27.0)
    assert (right_end, left_end) in cost
    assert (left_end, right_end) not in cost


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("L.S.W\n..x..\n", "floor.txt: line 2, column 3: found 'x'; allowed: lanes . > <"),
        ("L.S.W\n....\n", "floor.txt: line 2: found 4 characters; allowed: 5, as in line 1"),
        ("", "floor.txt: found no line"),
        ("L.S..\n.....\n", "floor.txt: found no word station (W)"),
        ("..S.W\n.....\n", "floor.txt: found no letter station (L)"),
        ("L...W\n.....\n", "floor.txt: found no storage spot (S)"),
        ("L..#W\n..S##\n", "floor.txt: found a letter station at line 1, column 1 without a way"),
        ("L...W\n.SSS.\nSSSS#\n.....\n", "floor.txt: found a lane at line 4, column 1 without"),
        ("L...W\nSSSSS\nSSSSS\nSSSSS\n", "floor.txt: found a storage spot at line 3, column 1 without"),
        ("L..W#\n.S.#.\n..###\n", "floor.txt: found a lane at line 2, column 5 without"),
        ("L" + "." * 30 + "SW\n", "floor.txt: found 33 by 1 waypoints, which need 98 by 2 m; allowed: at most"),
        (".SLW\n" * 20, "floor.txt: found 4 by 20 waypoints, which need 11 by 59 m"),
    ],
)
def test_a_bad_map_is_named_with_its_place(tmp_path, text, expected):
    assert expected in line_of(drawn(tmp_path, text))


def test_a_one_way_street_without_an_end_is_named(tmp_path):
    trap = drawn(tmp_path, "L...W\n.S#v#\n..#v#\n", wrong_way=None)
    assert "found a lane at line 2, column 4 without a way from and to every station" in line_of(trap)


def test_stations_must_be_those_of_the_map(tmp_path):
    scenario = drawn(tmp_path, SMALL)
    more = scenario.model_copy(update={"word_stations": 3})
    assert "F.yaml: word_stations: found 3; allowed: 2, as many as" in line_of(more)
    placed = scenario.model_copy(update={"letter_stations": [(5.0, 5.0)]})
    assert "F.yaml: letter_stations: found positions; allowed: 2, as many as" in line_of(placed)


def test_a_missing_map_is_named(tmp_path):
    scenario = scenario_of({"kind": "map", "path": str(tmp_path / "none.txt")})
    assert "F.yaml: layout.path: found" in line_of(scenario)
    assert "No such file" in line_of(scenario)


def test_a_map_that_is_no_text_is_named(tmp_path):
    scenario = drawn(tmp_path, SMALL)
    (tmp_path / "floor.txt").write_bytes(b"\xff\xfe")
    assert "found bytes that are not UTF-8 text" in line_of(scenario)
    (tmp_path / "floor.txt").write_bytes(b"#" * 1_000_001)
    assert "more than 1000000 bytes; allowed: a map file, at most 1000000 bytes" in line_of(scenario)


def test_a_map_is_found_relative_to_its_scenario():
    scenario = load_scenario(SCENARIOS / "map.yaml")
    assert isinstance(scenario.layout, MapLayout)
    assert scenario.layout.path == str(ROOT / "config/maps/small.txt")


# ---- edges and highways --------------------------------------------------------------------------------------


def test_a_highway_changes_the_cost_along_its_line_in_its_direction():
    plain = make_layout(scenario_of({"kind": "rows"}))
    low, high = waypoint_at(plain, 3.0, 3.0), waypoint_at(plain, 3.0, 30.0)
    x = plain.waypoints[low, 0] + 3.0
    y_low, y_high = plain.waypoints[low, 1], plain.waypoints[high, 1]
    road = {"start": [x, y_low], "end": [x, y_high], "weight": 0.5}
    before, after = weights(plain), weights(make_layout(scenario_of({"kind": "rows", "highways": [road]})))
    assert before.keys() == after.keys()
    changed = [edge for edge in before if before[edge] != after[edge]]
    assert len(changed) == round((y_high - y_low) / 3.0)
    for a, b in changed:
        assert plain.waypoints[a, 0] == plain.waypoints[b, 0] == x
        assert plain.waypoints[a, 1] < plain.waypoints[b, 1]
        assert after[a, b] == before[a, b] * 0.5


def test_a_one_way_highway_has_no_edge_against_it():
    road = {"start": [4.5, 1.5], "end": [4.5, 31.5], "one_way": True}
    layout = make_layout(scenario_of({"kind": "rows", "highways": [road]}))
    cost = weights(layout)
    low, high = waypoint_at(layout, 4.5, 4.5), waypoint_at(layout, 4.5, 7.5)
    assert (low, high) in cost and (high, low) not in cost


def test_an_extra_edge_joins_two_waypoints():
    plan = {"kind": "rows", "edges": [{"start": [4.5, 4.5], "end": [7.5, 7.5], "weight": 2.0}]}
    layout = make_layout(scenario_of(plan))
    cost = weights(layout)
    a, b = waypoint_at(layout, 4.5, 4.5), waypoint_at(layout, 7.5, 7.5)
    assert cost[a, b] == 2.0 and (b, a) not in cost


def test_an_extra_edge_gives_one_that_is_there_another_weight():
    plan = {"kind": "rows", "edges": [{"start": [4.5, 4.5], "end": [4.5, 7.5], "weight": 3.0}]}
    layout = make_layout(scenario_of(plan))
    assert len(layout.edges) == len(make_layout(scenario_of({"kind": "rows"})).edges)
    assert weights(layout)[waypoint_at(layout, 4.5, 4.5), waypoint_at(layout, 4.5, 7.5)] == 3.0


@pytest.mark.parametrize(
    ("plan", "expected"),
    [
        (
            {"edges": [{"start": [4.0, 4.5], "end": [7.5, 4.5]}]},
            "layout.edges.0.start: found no waypoint at (4, 4.5); allowed: a waypoint; the nearest is at (4.5, 4.5)",
        ),
        (
            {"edges": [{"start": [4.5, 4.5], "end": [4.5, 4.6]}]},
            "layout.edges.0.end: found the waypoint of start; allowed: another waypoint",
        ),
        (
            {"edges": [{"start": [4.5, 7.5], "end": [55.5, 7.5]}]},
            "layout.edges.0: found an edge that passes the storage spot at (19.5, 7.5); allowed: a way 2 m or more",
        ),
        (
            {"highways": [{"start": [4.0, 3.0], "end": [9.0, 31.0]}]},
            "layout.highways.0: found no edge from (4, 3) towards (9, 31); allowed: a straight line along edges",
        ),
        (
            {"highways": [{"start": [4.5, 4.5], "end": [4.5, 4.5]}]},
            "layout.highways.0.end: found the place of start; allowed: another place",
        ),
        (
            # all ways out of the lowest letter station
            {
                "highways": [
                    {"start": start, "end": [1.5, 10.5], "one_way": True}
                    for start in ([4.5, 10.5], [1.5, 13.5], [1.5, 7.5])
                ]
            },
            "layout: found a letter station at (1.5, 10.5) without a way from and to every station",
        ),
    ],
)
def test_edges_that_make_no_sense_are_named(plan, expected):
    assert expected in line_of(scenario_of({"kind": "rows"} | plan))


# ---- what does not fit ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("layout", "changes", "expected"),
    [
        (
            {"kind": "rows", "pitch_m": 2.0},
            {},
            "layout.pitch_m: found 2.0; allowed: more than the diameter of bodies, 2 m",
        ),
        ({"kind": "dense", "pitch_m": 1.0}, {}, "layout.pitch_m: found 1.0"),
        ({"kind": "hexagonal", "pitch_m": 1.9}, {}, "layout.pitch_m: found 1.9"),
        ({"kind": "rows", "block_columns": 3}, {}, "layout.block_columns: found 3; allowed: at most 2, so that"),
        ({"kind": "rows"}, {"buckets": 5000}, "buckets: found 5000 buckets; allowed: at most the 40 storage spots"),
        ({"kind": "rows"}, {"bots": 5000}, "bots: found 5000 bots; allowed: at most 296 here"),
        (
            {"kind": "rows"},
            {"word_stations": 16},
            "word_stations: found 16 stations; allowed: at most 15 along an edge",
        ),
        ({"kind": "dense", "margin_columns": 9}, {}, "floor: found 60 by 45 m; allowed: room for the margins"),
        ({"kind": "rows", "block_rows": 40}, {}, "floor: found 60 by 45 m; allowed: room for"),
        ({"kind": "hexagonal", "block_rows": 40}, {}, "floor: found 60 by 45 m; allowed: room for"),
        ({"kind": "hexagonal", "margin_columns": 12}, {}, "floor: found 60 by 45 m; allowed: room for"),
        (
            {"kind": "rows"},
            {"word_stations": [(58.0, 10.0), (58.0, 11.5)]},
            "word_stations.1: found a station at (58, 11.5); allowed: a place 2 m or more from the station at (58, 10)",
        ),
        (
            {"kind": "rows"},
            {"word_stations": [(1.5, 10.5)]},
            "letter_stations: found a station at (1.5, 10.5); allowed: a place 2 m or more from the station",
        ),
        (
            {"kind": "rows"},
            {"letter_stations": [(0.5, 10.0)]},
            "letter_stations.0: found a station at (0.5, 10); allowed: a place where a bot fits on the floor, 1 to 59",
        ),
        (
            {"kind": "rows"},
            {"letter_stations": [(20.0, 7.5)]},
            "letter_stations.0: found a station at (20, 7.5); allowed: a place 2 m or more from the storage spot",
        ),
    ],
)
def test_what_does_not_fit_is_one_line(layout, changes, expected):
    assert "F.yaml: " + expected in line_of(scenario_of(layout, **changes))


@pytest.mark.parametrize(
    ("setting", "expected"),
    [
        ("layout.kind=spiral", "layout.kind: found 'spiral'; allowed: 'rows', 'dense', 'hexagonal', 'map'"),
        ("layout={}", "layout.kind: found nothing; allowed: a value; this key is required"),
        (
            "layout.block_colums=3",
            "layout.block_colums: found an unknown key; allowed: block_columns (did you mean it?)",
        ),
        ("layout.pitch_m=-1", "layout.pitch_m: found -1; allowed: greater than or equal to 0.1"),
        ("layout.aisle_lanes=3", "layout.aisle_lanes: found 3; allowed: less than or equal to 2"),
        ("layout={kind: map}", "layout.path: found nothing; allowed: a value"),
        ("layout={kind: map, path: a, wrong_way: 0.5}", "layout.wrong_way: found 0.5; allowed: greater than or equal"),
        ("layout={kind: hexagonal, block_columns: 3}", "layout.block_columns: found an unknown key"),
        (
            "layout.highways=[{start: [1, 2], end: [3, 4], weight: 0}]",
            "weight: found 0; allowed: greater than or equal to 0.001",
        ),
        ("layout.edges=[{start: [1, 2]}]", "layout.edges.0.end: found nothing"),
        ("layout.edges=[{start: [1, 2, 3], end: [1, 2]}]", "layout.edges.0.start: found (1, 2, 3)"),
    ],
)
def test_a_wrong_key_of_a_layout_is_one_line(setting, expected):
    with pytest.raises(InputError) as caught:
        load_scenario(SCENARIOS / "demo.yaml", [setting])
    assert expected in str(caught.value)


# ---- scenario files ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", sorted(path.stem for path in SCENARIOS.glob("*.yaml")))
def test_every_scenario_file_makes_a_warehouse_with_room_to_spare(name):
    warehouse = load_warehouse(SCENARIOS / f"{name}.yaml")
    scenario, layout = warehouse.scenario, warehouse.layout
    assert scenario.name == name
    assert len(layout.storage_spots) >= 1.2 * scenario.buckets
    tails, heads = layout.edges.T
    n = len(layout.waypoints)
    graph = coo_matrix((np.ones(len(tails)), (tails, heads)), shape=(n, n))
    assert connected_components(graph, connection="strong")[0] == 1


def test_the_paper_and_its_variations_have_the_stations_that_they_name():
    pareto = load_scenario(SCENARIOS / "pareto.yaml")
    assert pareto.tile_kinds == 13_000
    large = load_scenario(SCENARIOS / "large.yaml")
    assert (large.bots, large.buckets, large.word_stations, large.letter_stations) == (1000, 10_000, 100, 100)


def test_a_large_layout_fills_its_floor():
    layout = make_layout(load_scenario(SCENARIOS / "large.yaml"))
    assert len(layout.waypoints) > 38_000
