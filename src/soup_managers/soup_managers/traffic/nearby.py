"""What is near a place: waypoints, and what a bot holds that stands or drives beside the graph."""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from soup_managers.traffic.holds import gaps_between
from soup_managers.traffic.roads import AT_END_M, Mask, Roads
from soup_msgs_py.messages import Point

_ON_EDGE_M = 1e-3
_WAYS_BACK = 6  # waypoints that a bot beside the graph tries to get back to


class Nearby:
    """Places and the graph around them."""

    def __init__(self, roads: Roads) -> None:
        self._roads = roads
        self._tree = KDTree(roads.points)
        self._starts, self._ends = roads.points[roads.tail], roads.points[roads.head]

    def waypoint(self, x: float, y: float) -> int:
        """The nearest waypoint."""
        return int(self._tree.query((x, y))[1])

    def held_on(self, waypoint: int) -> list[int]:
        """What a bot holds that stands on a waypoint."""
        roads = self._roads
        held = [waypoint]
        if roads.crowded[waypoint]:
            for edge in roads.into_edge[roads.into[waypoint] : roads.into[waypoint + 1]].tolist():
                holds = slice(roads.hold[edge], roads.hold[edge + 1])
                at_end = roads.hold_to[holds] >= roads.length[edge] - AT_END_M
                held += [w for w in roads.hold_at[holds][at_end].tolist() if w not in held]
        return held

    def held_along(self, start: Point, end: Point) -> list[int]:
        """What a bot holds beside the graph, on a straight way or, with one place, at rest.

        The waypoints that nobody else can pass, and both ends of every edge that it is on or that is too close
        between its ends: whoever is on an edge holds its head.
        """
        roads = self._roads
        a, b = np.array([start]), np.array([end])
        gaps = gaps_between(self._starts, self._ends, a, b)
        passed = gaps_between(roads.points, roads.points, a, b) < roads.apart
        closed = (gaps < _ON_EDGE_M) | ((gaps < roads.apart) & ~passed[roads.tail] & ~passed[roads.head])
        passed[roads.tail[closed]] = passed[roads.head[closed]] = True
        return np.flatnonzero(passed).tolist()

    def ways_back(self, place: Point, loaded: bool, blocked: Mask, goal: int) -> list[int]:
        """Waypoints to which a bot can drive straight from a place beside the graph, the nearest first.

        Args:
            place: Where it is.
            loaded: Whether it carries a bucket, which must not touch any that rests.
            blocked: Spots where buckets may rest, shape (waypoints,).
            goal: Where it goes; of other spots and stations it keeps away.
        """
        roads = self._roads
        _, near = self._tree.query(place, k=min(_WAYS_BACK, len(roads.points)))
        found = []
        for waypoint in np.atleast_1d(near).tolist():
            if waypoint != goal and (roads.line[waypoint] >= 0 or (loaded and blocked[waypoint])):
                continue
            if loaded:
                here, there = np.array([place]), roads.points[[waypoint]]
                spots = roads.points[blocked]
                # where it is now, no bucket rests
                close = gaps_between(spots, spots, here, there) < roads.apart
                if (close & (gaps_between(spots, spots, here, here) >= roads.apart)).any():
                    continue
            found.append(waypoint)
        return found
