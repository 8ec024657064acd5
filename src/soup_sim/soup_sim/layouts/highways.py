"""Edges and highways that a scenario adds to any layout (paper, "Extendable Interfaces": waypoints)."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from soup_msgs_py.errors import InputError
from soup_msgs_py.scenario.floor_plan import Edge, Highway, Layout_
from soup_sim.layouts.draft import Draft, distances_to_segments

_TOLERANCE = 0.1  # how far from a waypoint a place in a scenario may be, in pitches
_STRAIGHT = 0.99  # cosine of the angle between an edge and the highway that it is part of


def change_edges(draft: Draft, plan: Layout_, body: float, source: object) -> None:
    """Add the edges that a scenario gives, then apply its highways.

    A highway from `start` to `end` makes the edges along it cheaper or dearer in its direction; with `one_way`,
    those against it are removed::

        . . . . . .           start                end
        . > > > > .             > --- > --- > --- >     weight of each x highway's weight
        . . . . . .

    Args:
        draft: Changed.
        plan: The layout's part of the scenario.
        body: Diameter of the largest bodies (m).
        source: The file that error messages name.

    Raises:
        InputError: No waypoint or edge is where one is needed, or a new edge passes a resting bucket.
    """
    tree = cKDTree(draft.waypoints) if plan.edges else None
    for index, edge in enumerate(plan.edges):
        _add_edge(draft, edge, plan.pitch_m, body, tree, f"layout.edges.{index}", source)
    for index, highway in enumerate(plan.highways):
        _apply_highway(draft, highway, plan.pitch_m, f"layout.highways.{index}", source)


def _add_edge(draft: Draft, edge: Edge, pitch: float, body: float, tree: Any, key: str, source: object) -> None:
    a = _waypoint_at(draft, tree, edge.start, pitch, f"{key}.start", source)
    b = _waypoint_at(draft, tree, edge.end, pitch, f"{key}.end", source)
    if a == b:
        raise InputError(source, f"{key}.end", "the waypoint of start", "another waypoint")
    closed = draft.is_spot.copy()
    closed[draft.stations] = True
    closed[[a, b]] = False
    blocking = np.flatnonzero(closed)
    gaps = distances_to_segments(draft.waypoints[blocking], draft.waypoints[a], draft.waypoints[b])
    if len(gaps) and gaps.min() < body:
        place = int(blocking[gaps.argmin()])
        kind = "storage spot" if draft.is_spot[place] else "station"
        allowed = f"a way {body:g} m or more from storage spots and stations"
        raise InputError(source, key, f"an edge that passes the {kind} at {draft.name(place)}", allowed)
    there = (draft.edges[:, 0] == a) & (draft.edges[:, 1] == b)
    draft.keep_edges(~there)
    draft.add_edges(np.array([a]), np.array([b]), np.array([edge.weight]))


def _apply_highway(draft: Draft, highway: Highway, pitch: float, key: str, source: object) -> None:
    start, end = np.array(highway.start), np.array(highway.end)
    length = float(np.sqrt(((end - start) ** 2).sum()))
    if length < pitch / 2.0:
        raise InputError(source, f"{key}.end", "the place of start", "another place")
    near = distances_to_segments(draft.waypoints, start, end) <= _TOLERANCE * pitch
    steps = draft.waypoints[draft.edges[:, 1]] - draft.waypoints[draft.edges[:, 0]]
    ahead = steps @ (end - start) / (length * np.maximum(np.sqrt((steps * steps).sum(axis=1)), 1e-12))
    on_it = near[draft.edges].all(axis=1)
    with_it, against_it = on_it & (ahead > _STRAIGHT), on_it & (ahead < -_STRAIGHT)
    if not with_it.any():
        found = f"no edge from ({start[0]:g}, {start[1]:g}) towards ({end[0]:g}, {end[1]:g})"
        raise InputError(source, key, found, "a straight line along edges of this layout")
    draft.weights = np.where(with_it, draft.weights * highway.weight, draft.weights)
    if highway.one_way:
        draft.keep_edges(~against_it)


def _waypoint_at(draft: Draft, tree: Any, place: tuple[float, float], pitch: float, key: str, source: object) -> int:
    distance, waypoint = tree.query(place)
    if distance > _TOLERANCE * pitch:
        x, y = draft.waypoints[waypoint]
        found = f"no waypoint at ({place[0]:g}, {place[1]:g})"
        raise InputError(source, key, found, f"a waypoint; the nearest is at ({x:.12g}, {y:.12g})")
    return int(waypoint)
