"""Ways without regard to traffic, from trees that are kept for station lines and searched for all others."""

from __future__ import annotations

from collections import OrderedDict

import numpy as np

from soup_managers.traffic.nav_graph import FORWARD, Mask, Roads
from soup_managers.traffic.search_buffers import Desk
from soup_managers.traffic.ways import Errand, find_way, follow, follow_back, tree_from, tree_to
from soup_msgs_py.kinematics import turn_time
from soup_msgs_py.warehouse.layout import Floats, Ints

KEPT_TREES = 64

_Tree = tuple[Floats, Ints]


class Routes:
    """Quickest ways, wrong ways counted several times.

    Attributes:
        deep: Whether some storage spots can only be reached through others, so that bots must pass through spots.
    """

    def __init__(self, roads: Roads) -> None:
        self._roads = roads
        beside_lane = np.zeros(len(roads.line), dtype=bool)
        from_lane = ~roads.spot[roads.tail]
        beside_lane[roads.head[from_lane]] = True
        self.deep = bool((roads.spot & ~beside_lane).any())
        along = roads.points[roads.head] - roads.points[roads.tail]
        self._square = bool((np.abs(along).min(axis=1, initial=np.inf) < 1e-6).all()) if len(along) else True
        self._nothing = np.zeros(len(roads.line), dtype=bool)
        self._to: dict[int, _Tree] = {}
        self._from: dict[int, _Tree] = {}
        self._others: OrderedDict[int, _Tree] = OrderedDict()

    def blocked(self, loaded: bool, resting: Mask | None) -> Mask:
        """The spots through which a bot may not pass; without better knowledge, all for a loaded one."""
        if not loaded:
            return self._nothing
        return self._roads.spot if resting is None else resting

    def errand(self, start: int, goal: int, blocked: Mask) -> Errand:
        """The errand of a bot that may not pass through some spots."""
        return Errand(goal, int(self._roads.line[start]), self.deep, blocked)

    def find(self, start: int, errand: Errand, desk: Desk) -> int:
        """Write the edges of the way on the desk; how many there are, 0 for no way."""
        roads, goal = self._roads, errand.goal
        if not errand.deep or errand.blocked is self._nothing:
            if roads.line[goal] >= 0:
                return follow(roads, start, goal, self.to(goal)[1], desk.way)
            if roads.line[start] >= 0:
                return follow_back(roads, start, goal, self.away(start)[1], desk.way)
        return find_way(roads, start, errand, self._square, desk)

    def to(self, goal: int) -> _Tree:
        """Seconds from everywhere to a goal, and the first edge of each way."""
        kept = self._to if self._roads.line[goal] >= 0 else self._others
        tree = kept.get(goal)
        if tree is None:
            tree = kept[goal] = self._tree_to(goal)
            tree[0].flags.writeable = False
        if kept is self._others:
            self._others.move_to_end(goal)
            if len(self._others) > KEPT_TREES:
                self._others.popitem(last=False)
        return tree

    def _tree_to(self, goal: int) -> _Tree:
        """Ways to a place in a line lead to the line's end, and on from there; so only ends need a search."""
        roads = self._roads
        ahead = np.flatnonzero((roads.kind == FORWARD) & (roads.head == goal))
        if roads.line[goal] < 0 or not len(ahead):
            return tree_to(roads, goal, self.deep, self._nothing)
        edge = int(ahead[0])
        behind = int(roads.tail[edge])
        times, first = self.to(behind)
        times, first = times.copy(), first.copy()
        stops_s = roads.max_speed / roads.max_acceleration
        times += float(roads.pace[edge]) + stops_s
        if roads.turn_rate > 0.0:
            into = roads.into_edge[roads.into[behind] : roads.into[behind + 1]]
            turns = [turn_time(roads.heading[e], roads.heading[edge], roads.turn_rate) for e in into.tolist()]
            times += min(turns)
        times[behind], first[behind] = float(roads.pace[edge]) + stops_s, edge
        times[goal], first[goal] = 0.0, -1
        return times, first

    def away(self, start: int) -> _Tree:
        """Seconds from a place to all lanes and spots, and the last edge of each way; kept for station lines."""
        tree = self._from.get(start)
        if tree is None:
            tree = tree_from(self._roads, start, self.deep, self._nothing)
            tree[0].flags.writeable = False
            if self._roads.line[start] >= 0:
                self._from[start] = tree
        return tree

    def estimate(self, start: int, goal: int) -> float:
        """About how long the way between two places takes (s); exact to and from station lines."""
        roads = self._roads
        if start == goal:
            return 0.0
        if roads.line[goal] >= 0:
            return float(self.to(goal)[0][start])
        if roads.line[start] >= 0:
            return float(self.away(start)[0][goal])
        dx, dy = np.abs(roads.points[start] - roads.points[goal])
        V, A = roads.max_speed, roads.max_acceleration
        return float((dx + dy) / V + 3.0 * V / A)
