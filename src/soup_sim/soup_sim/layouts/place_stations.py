"""Stations: evenly along the edges of the floor, or where the scenario says."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from soup_msgs_py.errors import InputError
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Floats
from soup_sim.layouts.draft import Draft, Indices, body_m, distances_to_segments

_SAME_PLACE_M = 1e-6
_TRIED_LANES = 32  # waypoints nearest to a station that may become its access


@dataclass(frozen=True)
class _Wanted:
    """A station of the scenario: where it is asked for, and the waypoint that is there already, or -1."""

    key: str
    xy: tuple[float, float]
    waypoint: int


def place_stations(draft: Draft, scenario: Scenario, left: Indices, right: Indices, source: object) -> None:
    """Put the stations of a scenario into a draft.

    A station on a lane keeps its edges, but none to another station: bots may come from all sides and queue along
    the column, and ways through a station are for routers to avoid. One that is not on a waypoint gets its own,
    joined to the nearest lane, and what passes too near to it is closed::

        . . . .        . .   .
                           W
        . . . W        . .   .       around a station that is not on a waypoint
                         |
        . . . .        . . . .

    Args:
        draft: Waypoints and edges without stations; changed.
        scenario: Says how many stations, or where.
        left: Waypoints along the left edge, from the bottom, for letter stations.
        right: The same along the right edge, for word stations.
        source: The file that error messages name.

    Raises:
        InputError: They do not fit.
    """
    words = _wanted(draft, "word_stations", scenario.word_stations, right, source)
    letters = _wanted(draft, "letter_stations", scenario.letter_stations, left, source)
    body = body_m(scenario)
    _check(draft, words + letters, body, scenario, source)

    on_grid = np.array([s.waypoint for s in words + letters if s.waypoint >= 0], dtype=np.int64)
    draft.keep_edges(np.logical_not(np.isin(draft.edges, on_grid).all(axis=1)))

    new = [s for s in words + letters if s.waypoint < 0]
    for station in new:
        starts, ends = draft.waypoints[draft.edges[:, 0]], draft.waypoints[draft.edges[:, 1]]
        draft.keep_edges(distances_to_segments(np.array(station.xy), starts, ends) >= body)
    waypoint = {id(s): s.waypoint for s in words + letters}
    first = len(draft.waypoints)
    waypoint.update((id(station), first + index) for index, station in enumerate(new))
    if new:
        draft.waypoints = np.concatenate([draft.waypoints, [station.xy for station in new]])
        draft.is_spot = np.concatenate([draft.is_spot, np.zeros(len(new), dtype=bool)])
    draft.words = [waypoint[id(station)] for station in words]
    draft.letters = [waypoint[id(station)] for station in letters]
    if new:
        _give_access(draft, new, first, body, source)


def _wanted(
    draft: Draft, key: str, wanted: int | list[tuple[float, float]], edge: Indices, source: object
) -> list[_Wanted]:
    """All stations of one kind; `edge` is where evenly spaced ones stand."""
    if isinstance(wanted, int):
        if wanted > len(edge):
            allowed = f"at most {len(edge)} along an edge of this floor"
            raise InputError(source, key, f"{wanted} stations", allowed)
        chosen = edge[[int((2 * k + 1) * len(edge) / (2 * wanted)) for k in range(wanted)]]
        return [_Wanted(key, _pair(draft.waypoints[w]), int(w)) for w in chosen]
    lanes = np.flatnonzero(~draft.is_spot)
    distances, nearest = cKDTree(draft.waypoints[lanes]).query(wanted)
    return [
        _Wanted(f"{key}.{index}", position, int(lanes[n]) if distance <= _SAME_PLACE_M else -1)
        for index, (position, distance, n) in enumerate(zip(wanted, distances, nearest, strict=True))
    ]


def _check(draft: Draft, stations: list[_Wanted], body: float, scenario: Scenario, source: object) -> None:
    """Every station has room for a bot with a bucket: on the floor, clear of stations and resting buckets."""
    margin, width, height = body / 2.0, scenario.floor.width_m, scenario.floor.height_m
    places = np.array([station.xy for station in stations])
    near = sorted(cKDTree(places).query_pairs(body * (1.0 - 1e-9)))
    too_near = {second: first for first, second in reversed(near)}
    spots = draft.waypoints[draft.is_spot]
    to_spot, nearest_spot = cKDTree(spots).query(places)
    for index, station in enumerate(stations):
        x, y = station.xy
        found = f"a station at ({x:g}, {y:g})"
        if not (margin <= x <= width - margin and margin <= y <= height - margin):
            allowed = (
                f"a place where a bot fits on the floor, {margin:g} to {width - margin:g} "
                f"by {margin:g} to {height - margin:g} m"
            )
            raise InputError(source, station.key, found, allowed)
        if index in too_near:
            other_x, other_y = stations[too_near[index]].xy
            allowed = f"a place {body:g} m or more from the station at ({other_x:g}, {other_y:g})"
            raise InputError(source, station.key, found, allowed)
        if to_spot[index] < body:
            spot_x, spot_y = spots[nearest_spot[index]]
            allowed = f"a place {body:g} m or more from the storage spot at ({spot_x:g}, {spot_y:g})"
            raise InputError(source, station.key, found, allowed)


def _give_access(draft: Draft, new: list[_Wanted], first: int, body: float, source: object) -> None:
    """Join new stations, numbered from `first`, to the lanes; leave out lanes that they have cut off."""
    open_lanes = draft.main_part(~draft.is_spot)
    open_lanes[draft.stations] = False
    lanes = np.flatnonzero(open_lanes)
    others = np.concatenate([np.flatnonzero(draft.is_spot), draft.stations])
    for index, station in enumerate(new):
        here = first + index
        xy = draft.waypoints[here]
        in_the_way = draft.waypoints[others[others != here]]
        nearest = np.argsort(((draft.waypoints[lanes] - xy) ** 2).sum(axis=1), kind="stable")[:_TRIED_LANES]
        for lane in lanes[nearest].tolist():
            if distances_to_segments(in_the_way, xy, draft.waypoints[lane]).min(initial=np.inf) >= body:
                draft.add_edges(np.array([here, lane]), np.array([lane, here]), np.ones(2))
                break
        else:
            found = f"a station at ({xy[0]:g}, {xy[1]:g})"
            allowed = f"a place with a way to a lane, {body:g} m or more from spots and other stations"
            raise InputError(source, station.key, found, allowed)
    kept = draft.main_part(~draft.is_spot) | draft.is_spot
    kept[draft.stations] = True
    draft.keep_waypoints(kept)


def _pair(xy: Floats) -> tuple[float, float]:
    return float(xy[0]), float(xy[1])
