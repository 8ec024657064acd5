"""Shortest ways for loaded bots along the layout's waypoints, never through a storage spot."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Set

import numpy as np
from scipy.spatial import KDTree

from soup_managers.kernels.trees import count_turns, descend, grow
from soup_msgs_py.messages import Point
from soup_msgs_py.warehouse.layout import Floats, Ints, Layout

STATION_DETOUR_M = 30.0  # how much further to drive rather than through a station, where a bot may be served
KEPT_TREES = 64
_AT_WAYPOINT_M = 0.5


class Router:
    """Ways on a waypoint graph: the cheapest, and of equally cheap ones one with the fewest turns.

    An edge costs its length times its weight. Storage spots are only beginnings and ends of ways, because a
    bucket may rest on them; a way through a station costs `STATION_DETOUR_M` extra.

    Ways are kept as trees: one towards and one away from each station that was asked for, and a bounded
    number towards other waypoints.

    Attributes:
        station_waypoints: The waypoint of each station.
    """

    def __init__(self, layout: Layout) -> None:
        self._points: list[Point] = [(float(x), float(y)) for x, y in layout.waypoints]
        self._forward = _Graph(layout, layout.edges[:, 0], layout.edges[:, 1])
        self._backward = _Graph(layout, layout.edges[:, 1], layout.edges[:, 0])
        self._waypoints = layout.waypoints
        self.station_waypoints: list[int] = layout.stations.tolist()
        self._stations = frozenset(self.station_waypoints)
        self._to: dict[int, _Tree] = {}
        self._from: dict[int, _Tree] = {}
        self._others: OrderedDict[int, _Tree] = OrderedDict()
        self._found = np.empty(len(layout.waypoints), np.int32)
        self._near = KDTree(layout.waypoints)
        self._spots: frozenset[int] = frozenset()
        self._close(frozenset(layout.storage_spots.tolist()))

    def set_storage_spots(self, spots: Set[int]) -> None:
        """Take over which waypoints are storage spots now; after a change all ways are looked for anew."""
        if spots != self._spots:
            self._close(frozenset(spots))

    def _close(self, spots: frozenset[int]) -> None:
        self._spots = spots
        self._through = np.zeros(len(self._waypoints))
        self._through[self.station_waypoints] = STATION_DETOUR_M
        self._through[sorted(spots)] = math.inf
        self._lanes = np.flatnonzero(np.isfinite(self._through))
        self._near_lane = KDTree(self._waypoints[self._lanes]) if len(self._lanes) else None
        for kept in (self._to, self._from, self._others):
            kept.clear()

    def route(self, start: int, goal: int) -> tuple[Point, ...] | None:
        """The way from one waypoint to another.

        Returns:
            Its corners in metres without the start, the goal last; None where there is no way.
        """
        if start == goal:
            return (self._points[goal],)
        if goal not in self._stations and start in self._stations:
            # a tree for every storage spot would cost too much: walk the station's tree from its other end
            nodes = self._walk(goal, start, self._tree_from(start))[::-1]
        else:
            nodes = self._walk(start, goal, self._tree_to(goal))
        if not nodes:
            return None
        return tuple([self._points[node] for node in nodes[1:]])

    def cost(self, start: int, goal: int) -> float:
        """What the way from one waypoint to another costs (m times weights); infinite where there is none."""
        if goal not in self._stations and start in self._stations:
            return float(self._tree_from(start).distance[goal])
        return float(self._tree_to(goal).distance[start])

    def costs_to(self, goal: int) -> Floats:
        """`cost` from every waypoint to a station or another waypoint, shape (waypoints,); read only."""
        return self._tree_to(goal).distance

    def costs_from(self, station: int) -> Floats:
        """`cost` from the waypoint of a station to every waypoint, shape (waypoints,); read only."""
        return self._tree_from(station).distance

    def nearest_waypoint(self, x: float, y: float) -> int:
        """The waypoint nearest to a place in metres."""
        return int(self._near.query((x, y))[1])

    def entry(self, x: float, y: float) -> int:
        """Where a loaded bot that stands anywhere joins the graph: the waypoint it is on, or a free one."""
        waypoint = self.nearest_waypoint(x, y)
        px, py = self._points[waypoint]
        here = (px - x) * (px - x) + (py - y) * (py - y) <= _AT_WAYPOINT_M * _AT_WAYPOINT_M
        if here or self._near_lane is None:
            return waypoint
        return int(self._lanes[self._near_lane.query((x, y))[1]])

    def route_from_place(self, x: float, y: float, goal: int) -> tuple[Point, ...] | None:
        """The way from any place: straight to its `entry`, then along the graph; None where there is none."""
        entry = self.entry(x, y)
        way = self.route(entry, goal)
        return way if way is None or entry == goal else (self._points[entry], *way)

    def _tree_from(self, station: int) -> _Tree:
        tree = self._from.get(station)
        if tree is None:
            # its ways are walked from their ends, against the edges
            tree = self._from[station] = _Tree(station, self._forward, self._backward, self._through)
        return tree

    def _tree_to(self, goal: int) -> _Tree:
        kept = self._to if goal in self._stations else self._others
        tree = kept.get(goal)
        if tree is None:
            tree = kept[goal] = _Tree(goal, self._backward, self._forward, self._through)
        if kept is self._others:
            self._others.move_to_end(goal)
            if len(self._others) > KEPT_TREES:
                self._others.popitem(last=False)
        return tree

    def _walk(self, start: int, goal: int, tree: _Tree) -> list[int]:
        ways = tree.ways
        count = descend(start, goal, ways.starts, ways.ends, ways.dx, ways.dy, tree.turns, self._found)
        return self._found[:count].tolist()


class _Graph:
    """Edges sorted by the waypoint they leave; those of waypoint w are `starts[w]` to `starts[w + 1]`."""

    def __init__(self, layout: Layout, tails: Ints, heads: Ints) -> None:
        order = np.lexsort((heads, tails))
        tails, heads = tails[order], heads[order]
        counts = np.bincount(tails, minlength=len(layout.waypoints))
        self.starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
        self.ends = heads.astype(np.int32)
        step = layout.waypoints[heads] - layout.waypoints[tails]
        length = np.sqrt(step[:, 0] * step[:, 0] + step[:, 1] * step[:, 1])
        self.costs = length * layout.edge_weights[order]
        safe = np.where(length > 0, length, 1.0)
        self.dx, self.dy = step[:, 0] / safe, step[:, 1] / safe
        # what growing a tree needs beside its result
        nodes, room = len(layout.waypoints), len(heads) + 1
        self.desk = np.empty(nodes, np.int32), np.empty(room), np.empty(room, np.int32)


class _Tree:
    """The cheapest ways between a waypoint and all others: costs, and the turns left after each edge."""

    def __init__(self, root: int, growing: _Graph, ways: _Graph, through: Floats) -> None:
        self.ways = ways
        self.distance = np.empty(len(through))
        self.turns = np.empty(len(ways.ends), np.uint8)
        order, keys, nodes = growing.desk
        reached = grow(root, growing.starts, growing.ends, growing.costs, through, self.distance, order, keys, nodes)
        count_turns(
            root, ways.starts, ways.ends, ways.costs, ways.dx, ways.dy, through,
            self.distance, order, reached, self.turns,
        )  # fmt: skip
        self.distance.flags.writeable = False
