"""What is near a place: waypoints, and the footprint of a bot that stands or drives beside the graph."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from soup_managers.traffic.footprint import gaps_between
from soup_managers.traffic.nav_graph import AT_END_M, Mask, Roads
from soup_msgs_py.messages import Floats, Point

_ON_EDGE_M = 1e-3
_REMEMBERED = 10_000  # answers
_OWN = 0.25  # a bot that is nearer than this to a waypoint, in distances of two that touch, belongs there
_WAYS_BACK = 6  # waypoints that a bot beside the graph tries to get back to


class Nearby:
    """Places and the graph around them."""

    def __init__(self, roads: Roads) -> None:
        self._roads = roads
        self._tree = KDTree(roads.points)
        self._held: dict[tuple[Point, Point], list[int]] = {}
        self._swept_on: dict[tuple[Point, int], list[int]] = {}
        self._starts, self._ends = roads.points[roads.tail], roads.points[roads.head]
        self._middles = KDTree(0.5 * (self._starts + self._ends))
        self._half_edge = 0.5 * float(roads.length.max(initial=0.0))

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
        """What a bot holds beside the graph, on a straight way or, with one place, at rest; to be read only.

        The waypoints that nobody else can pass, and both ends of every edge that it is on or that is too close
        between its ends: whoever is on an edge holds its head. Of an edge that it stands on, near one end, that end
        will do: nobody gets past it, and whoever stands at the other end may stay there.
        """
        held = self._held.get((start, end))
        if held is None:
            roads = self._roads
            a, b = np.array([start]), np.array([end])
            passed = np.zeros(len(roads.points), bool)
            passed[self._points_near(a, b)] = True
            edges = self._edges_near(a, b)
            gaps = gaps_between(self._starts[edges], self._ends[edges], a, b)
            tails, heads = roads.tail[edges], roads.head[edges]
            near_end = passed[tails] | passed[heads]
            closed = (gaps < roads.apart) & ~near_end
            if start != end:
                closed |= gaps < _ON_EDGE_M
            passed[tails[closed]] = passed[heads[closed]] = True
            held = self._remember(self._held, (start, end), np.flatnonzero(passed).tolist())
        return held

    def held_to(self, place: Point, waypoint: int) -> set[int]:
        """What a bot beside the graph holds while it drives straight back to a waypoint."""
        point = self._roads.points[waypoint].tolist()
        own = np.hypot(point[0] - place[0], point[1] - place[1]) < _OWN * self._roads.apart
        # where it is all but there, nobody can be in between
        end = place if own else (point[0], point[1])
        return {*self.held_along(place, end), *self.held_on(waypoint)}

    def _swept(self, place: Point, waypoint: int) -> list[int]:
        """Waypoints where no bucket may rest while a bucket is driven straight from a place to a waypoint."""
        swept = self._swept_on.get((place, waypoint))
        if swept is None:
            roads = self._roads
            here, there = np.array([place]), roads.points[[waypoint]]
            # where it is now, no bucket rests
            close = np.setdiff1d(self._points_near(here, there), self._points_near(here, here))
            swept = self._remember(self._swept_on, (place, waypoint), close.tolist())
        return swept

    def _points_near(self, a: Floats, b: Floats) -> NDArray[np.intp]:
        """Waypoints too close to a straight line from a to b, ascending."""
        near = self._around(self._tree, a, b, 0.0)
        points = self._roads.points[near]
        return near[gaps_between(points, points, a, b) < self._roads.apart]

    def _edges_near(self, a: Floats, b: Floats) -> NDArray[np.intp]:
        """Edges that may be too close to a straight line from a to b."""
        return self._around(self._middles, a, b, self._half_edge)

    def _around(self, tree: KDTree, a: Floats, b: Floats, more: float) -> NDArray[np.intp]:
        reach = 0.5 * float(np.hypot(*(b - a)[0])) + self._roads.apart + more + _ON_EDGE_M
        return np.array(sorted(tree.query_ball_point(0.5 * (a + b)[0], reach)), np.intp)

    def _remember(self, answers: dict[Any, list[int]], question: Any, answer: list[int]) -> list[int]:
        if len(answers) >= _REMEMBERED:
            answers.clear()
        answers[question] = answer
        return answer

    def ways_back(self, place: Point, loaded: bool, blocked: Mask, goal: int) -> list[int]:
        """Waypoints to which a bot can drive straight from a place beside the graph, the nearest first.

        Args:
            place: Where it is.
            loaded: Whether it carries a bucket, which must not touch any that rests.
            blocked: Spots where buckets may rest, shape (waypoints,).
            goal: Where it goes; of other spots and station lines it keeps away, unless it is there.
        """
        roads = self._roads
        away, near = self._tree.query(place, k=min(_WAYS_BACK, len(roads.points)))
        found = []
        for distance, waypoint in zip(np.atleast_1d(away).tolist(), np.atleast_1d(near).tolist(), strict=True):
            own = distance < _OWN * roads.apart
            if waypoint != goal and ((roads.line[waypoint] >= 0 and not own) or (loaded and blocked[waypoint])):
                continue
            if not loaded or not blocked[self._swept(place, waypoint)].any():
                found.append(waypoint)
        return found
