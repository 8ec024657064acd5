"""All bots by one reservation table: who drives where and when, so that nobody touches anybody and all arrive."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from soup_managers.traffic.booking import book, wait_early
from soup_managers.traffic.footprint import Motion
from soup_managers.traffic.legs import NOWHERE, Leg, braking_places, heading_after, pieces_of
from soup_managers.traffic.nav_graph import Mask, make_roads
from soup_managers.traffic.nearby import Nearby
from soup_managers.traffic.queue_lanes import Line, find_lines
from soup_managers.traffic.reservations import add, conflicts, forget, forget_bot, free_from, larger, no_reservations
from soup_managers.traffic.routes import Routes
from soup_managers.traffic.search_buffers import make_desk
from soup_managers.traffic.sipp import Found, Query, find, rest_of_way
from soup_msgs_py.kinematics import heading_of, run_time, turn_time
from soup_msgs_py.messages import Point
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Floats, Layout

PATIENCE_S = 3.0  # a bot that is later than this on its usual way looks for another one
_CAPACITY = 16  # holds of one waypoint, to begin with
_LABELS_ON_WAY = 100_000
_LABELS_FOR_BETTER = 1_500  # how long to look for a better way than waiting
_LABELS_FOR_ANY = 60_000  # how long to look for any way at all
_HERE_M = 1e-9  # farther off a waypoint the first run to it takes time, and whoever is late is in the way


@dataclass(frozen=True, slots=True)
class _Stand:
    """Where a bot stands, since when, and where it faces (rad)."""

    waypoint: int
    point: Point
    since: float
    heading: float


class Traffic:
    """Collision-free and deadlock-free drives, one after the other, on the waypoint graph.

    Each bot holds the waypoints near it, as `footprint` says; a new leg takes what the legs planned before have left.
    Bots stand only where nobody else has to pass, on storage spots and in the lines of stations, so every hold on a
    lane ends, and whoever waits long enough can go.

    Attributes:
        lines: Waypoints of each station's line, its dock first; bots come in from the end.
        looked: Labels that searches have looked at so far: what plans have cost.
    """

    def __init__(self, scenario: Scenario, layout: Layout) -> None:
        bot = scenario.bot
        body = 2.0 * max(bot.radius_m, scenario.bucket.radius_m)
        motion = Motion(body, bot.max_speed_mps, bot.max_acceleration_mps2)
        self.lines: list[Line] = find_lines(layout)
        self._roads = make_roads(layout, self.lines, motion, bot.turn_rate_radps or 0.0)
        self._nearby = Nearby(self._roads)
        self._routes = Routes(self._roads)
        self._points: list[Point] = [(x, y) for x, y in layout.waypoints.tolist()]
        self._table = no_reservations(len(self._points), _CAPACITY)
        self._desk = make_desk(self._roads, _CAPACITY)
        self._stands: dict[int, _Stand] = {}  # where each bot stands after all that is planned for it
        self._legs: dict[int, list[tuple[Leg, _Stand]]] = {}  # what is planned for it, and where it stood before
        self._past = -math.inf
        self.looked = 0

    # ---- who stands where ------------------------------------------------------------------------------------

    def stand(self, bot: int, waypoint: int, since: float, heading: float = 0.0) -> None:
        """A bot stands on a waypoint for good; whatever was planned for it is forgotten."""
        self._forget(bot)
        self._stay(bot, _Stand(waypoint, self._points[waypoint], since, heading))

    def stand_at(self, bot: int, x: float, y: float, since: float, heading: float = 0.0) -> None:
        """A bot has stopped anywhere, for good; whatever was planned for it is forgotten.

        Others that have planned to pass there are its `conflicts`.
        """
        waypoint = self._nearby.waypoint(x, y)
        px, py = self._points[waypoint]
        if (px - x) * (px - x) + (py - y) * (py - y) <= _HERE_M * _HERE_M:
            self.stand(bot, waypoint, since, heading)
            return
        self._forget(bot)
        self._stay(bot, _Stand(NOWHERE, (x, y), since, heading))

    def adopt(self, bot: int, points: tuple[Point, ...], stamps: tuple[float, ...]) -> int:
        """A bot drives already, as an earlier fleet had planned it; whatever was planned for it here is forgotten.

        It holds a little more than if the drive had been planned here, and for a little longer.

        Args:
            bot: Who drives.
            points: Where it stops or waits (m).
            stamps: When it is there (s).

        Returns:
            The waypoint where it will stand; `NOWHERE` for a place beside the graph.
        """
        self.stand_at(bot, *points[-1], stamps[-1])
        roads = self._roads
        for start, end, begin, until in pieces_of(points, stamps, roads.max_speed, roads.max_acceleration):
            for waypoint in self._nearby.held_along(start, end):
                self._hold(waypoint, begin, until, bot)
        heading = heading_after(points)
        stand = replace(self._stands[bot], heading=heading)
        waypoints = tuple(self._nearby.waypoint(x, y) for x, y in points)
        leg = Leg(bot, waypoints, points, stamps, stamps[0], stamps[-1])
        self._legs[bot] = [(leg, _Stand(NOWHERE, points[0], stamps[0], heading))]
        self._stands[bot] = stand
        return stand.waypoint

    def undo(self, bot: int, now: float) -> None:
        """A bot has not departed on its last leg: it still stands where that begins.

        Others that have meanwhile planned to pass there are its `conflicts`.
        """
        if not self._legs[bot]:
            return
        _, stand = self._legs[bot].pop()
        forget_bot(self._table, bot, now)
        self._stay(bot, _Stand(stand.waypoint, stand.point, now, stand.heading))

    def halt(self, bot: int, now: float, notice_s: float = 0.0) -> None:
        """A bot that drives is told to stop, and does so after `notice_s` at the latest; `stand_at` will tell where.

        Until then it holds all places where it can get to. Others that have planned to pass there are its `conflicts`.
        """
        if not self._legs[bot]:
            return
        leg, stand = self._legs[bot][-1]
        if now + notice_s <= leg.depart:
            self.undo(bot, now)
            return
        roads = self._roads
        ways = braking_places(leg, now, now + notice_s, roads.max_speed, roads.max_acceleration)
        held = {waypoint for start, end in ways for waypoint in self._nearby.held_along(start, end)}
        self._forget(bot)
        self._stands[bot] = stand
        for waypoint in sorted(held):
            self._hold(waypoint, now, math.inf, bot)

    def at(self, bot: int) -> int:
        """The waypoint where a bot stands after all that is planned for it; `NOWHERE` beside the graph."""
        return self._stands[bot].waypoint

    def free_from(self, waypoint: int) -> float:
        """When nobody holds a waypoint any more: minus infinity for always, infinity while somebody stands there."""
        return float(free_from(self._table, waypoint, -1))

    def conflicts(self, bot: int, now: float) -> list[int]:
        """The bots that hold what a bot holds, at the same time, from now on: they must be stopped."""
        return conflicts(self._table, bot, now)

    def nearest(self, x: float, y: float) -> int:
        """The waypoint nearest to a place (m)."""
        return self._nearby.waypoint(x, y)

    # ---- drives ----------------------------------------------------------------------------------------------

    def plan(
        self,
        bot: int,
        goal: int,
        earliest: float,
        *,
        loaded: bool,
        blocked_spots: Mask | None = None,
        hurried: bool = False,
    ) -> Leg | None:
        """Plan and reserve a bot's next leg, from where its last one ends.

        Args:
            bot: Who drives.
            goal: The waypoint where it goes and stands until its next leg.
            earliest: When it may depart (s).
            loaded: Whether it carries a bucket.
            blocked_spots: Waypoints on which buckets rest, shape (waypoints,): a loaded bot in a deep layout passes
                through the other spots. Without it, through none.
            hurried: Whether not to look long for a way where the usual one is closed.

        Returns:
            The leg that arrives first; None, and nothing has changed, if there is none now: somebody stands at the
            goal or in the only way with no plan to leave.
        """
        stand = self._stands[bot]
        ready = max(earliest, stand.since)
        if stand.waypoint == goal:
            return Leg(bot, (goal,), (stand.point,), (ready,), ready, ready)

        # nobody gets to a goal where somebody stands for good
        goal_free = max(float(free_from(self._table, w, bot)) for w in self._last_stretch(stand.waypoint, goal))
        if goal_free == math.inf:
            return None

        blocked = self._routes.blocked(loaded, blocked_spots)
        if stand.waypoint == NOWHERE:
            return self._rejoin(bot, goal, ready, loaded, blocked, hurried)
        errand = self._routes.errand(stand.waypoint, goal, blocked)
        rest = _read_only(self._desk.rest)
        query = Query(bot, stand.waypoint, errand, ready, stand.heading, rest, True, math.inf, _LABELS_ON_WAY)
        found = self._quickest(query, goal_free, hurried)
        return None if found is None else self._book(query, found)

    def forget_before(self, now: float) -> None:
        """What is over by now need not be remembered; call it from time to time."""
        self._past = max(self._past, now)

    # ---- estimates -------------------------------------------------------------------------------------------

    def travel_time(self, start: int, goal: int) -> float:
        """About how long a drive takes without traffic (s); exact to and from station lines."""
        return self._routes.estimate(start, goal)

    def times_to(self, goal: int) -> Floats:
        """How long drives to a goal take from every waypoint (s), shape (waypoints,); read only, kept for lines."""
        return self._routes.to(goal)[0]

    def estimates(self, start: int, goals: NDArray[np.int64]) -> Floats:
        """As `travel_time` for many goals, shape (n,); quick, infinite where no way leads from a station line."""
        if self._roads.line[start] >= 0:
            return self._routes.away(start)[0][goals]
        steps = np.abs(self._roads.points[goals] - self._roads.points[start])
        return (steps[:, 0] + steps[:, 1]) / self._roads.max_speed

    def times_from(self, start: int) -> Floats:
        """How long drives from a place take to every lane and spot (s); read only, kept for station lines."""
        return self._routes.away(start)[0]

    # ---- within ----------------------------------------------------------------------------------------------

    def _last_stretch(self, start: int, goal: int) -> Line:
        """The goal, and the places of its line that one must pass on the way there."""
        line = self.lines[self._roads.line[goal]] if self._roads.line[goal] >= 0 else (goal,)
        first = line.index(goal)
        behind = line.index(start) if start in line[first:] else len(line)
        return line[first:behind]

    def _quickest(self, query: Query, goal_free: float, hurried: bool) -> Found | None:
        """The drive on the usual way; where it is late or none is left, on any other way that is better."""
        found, in_time = self._on_way(query, goal_free)
        arrive = math.inf if found is None else float(found.arrives[-1])
        if arrive <= in_time + PATIENCE_S:
            return found
        worst = math.inf if found is None else min(arrive - 0.5 * PATIENCE_S, in_time + 2.0 * PATIENCE_S)
        better = self._on_any_way(query, worst, hurried)
        return found if better is None else better

    def _on_way(self, query: Query, goal_free: float) -> tuple[Found | None, float]:
        """The drive on the quickest way without traffic; and when a bot could arrive at best."""
        edges = self._routes.find(query.start, query.errand, self._desk)
        if edges == 0:
            return None, query.ready
        rest_of_way(self._roads, self._desk, edges)
        return self._find(query), max(query.ready + float(query.rest[query.start]), goal_free)

    def _on_any_way(self, query: Query, worst: float, hurried: bool) -> Found | None:
        times = self._routes.to(query.errand.goal)[0]
        if times[query.start] == math.inf:
            return None
        most = _LABELS_FOR_ANY if worst == math.inf and not hurried else _LABELS_FOR_BETTER
        return self._find(query._replace(rest=times, on_way=False, worst=worst, most=most))

    def _find(self, query: Query) -> Found | None:
        found = find(self._roads, self._table, self._desk, query)
        self.looked += int(self._desk.looked[0])
        self._desk.looked[0] = 0
        return found

    def _book(self, query: Query, found: Found) -> Leg:
        """Write a drive into the reservation table."""
        wait_early(self._roads, self._table, self._desk, query, found)
        while not book(self._roads, self._table, self._desk, query, found, self._past):
            self._enlarge()
        stops, leaves, arrives = found.stops.tolist(), found.leaves.tolist(), found.arrives.tolist()
        waypoints, stamps = [stops[0]], [leaves[0]]
        for k, stop in enumerate(stops[1:]):
            if leaves[k] > stamps[-1]:
                waypoints.append(stops[k])
                stamps.append(leaves[k])
            waypoints.append(stop)
            stamps.append(arrives[k])
        points = tuple([self._points[w] for w in waypoints])
        leg = Leg(query.bot, tuple(waypoints), points, tuple(stamps), stamps[0], stamps[-1])
        self._add_leg(leg, float(self._roads.heading[found.edges[-1]]))
        return leg

    def _add_leg(self, leg: Leg, heading: float) -> None:
        """Note a leg that is in the reservation table."""
        legs = [kept for kept in self._legs[leg.bot] if kept[0].arrive > self._past]
        self._legs[leg.bot] = [*legs, (leg, self._stands[leg.bot])]
        self._stands[leg.bot] = _Stand(leg.waypoints[-1], leg.points[-1], leg.arrive, heading)

    def _rejoin(self, bot: int, goal: int, ready: float, loaded: bool, blocked: Mask, hurried: bool) -> Leg | None:
        """A leg from beside the graph: straight to a waypoint that nobody else will pass, and on from there."""
        stand, roads = self._stands[bot], self._roads
        for waypoint in self._nearby.ways_back(stand.point, loaded, blocked, goal):
            # when is the way to there free for good?
            point = self._points[waypoint]
            dx, dy = point[0] - stand.point[0], point[1] - stand.point[1]
            held = self._nearby.held_to(stand.point, waypoint)
            depart = max(ready, *(float(free_from(self._table, w, bot)) for w in held))
            if depart == math.inf:
                continue

            # let it drive there and stand
            heading = heading_of(dx, dy)
            length = float(np.sqrt(dx * dx + dy * dy))
            arrive = depart + turn_time(stand.heading, heading, roads.turn_rate)
            arrive += run_time(length, roads.max_speed, roads.max_acceleration)
            forget_bot(self._table, bot, -math.inf)
            for w in held:
                self._hold(w, stand.since, arrive, bot)
            self._stands[bot] = _Stand(waypoint, point, arrive, heading)
            self._stay(bot, self._stands[bot])

            # and on from there; or as if nothing had been
            ahead = self.plan(bot, goal, arrive, loaded=loaded, blocked_spots=blocked, hurried=hurried)
            if ahead is not None:
                first = () if goal == waypoint else ahead.waypoints[int(ahead.depart <= arrive) :]
                stamps = () if goal == waypoint else ahead.stamps[int(ahead.depart <= arrive) :]
                waypoints = (NOWHERE, waypoint, *first)
                points = (stand.point, *(self._points[w] for w in waypoints[1:]))
                leg = Leg(bot, waypoints, points, (depart, arrive, *stamps), depart, max(arrive, ahead.arrive))
                self._legs[bot] = [(leg, stand)]
                return leg
            forget_bot(self._table, bot, -math.inf)
            self._stay(bot, stand)
        return None

    def _forget(self, bot: int) -> None:
        """Whatever was planned for a bot is forgotten; it is nowhere."""
        if self._stands.pop(bot, None) is not None:
            forget_bot(self._table, bot, -math.inf)
        self._legs[bot] = []

    def _stay(self, bot: int, stand: _Stand) -> None:
        """Let a bot stand for good."""
        self._stands[bot] = stand
        beside = stand.waypoint == NOWHERE
        held = self._nearby.held_along(stand.point, stand.point) if beside else self._nearby.held_on(stand.waypoint)
        for w in held:
            self._hold(w, stand.since, math.inf, bot)

    def _hold(self, waypoint: int, begin: float, end: float, bot: int) -> None:
        forget(self._table, waypoint, self._past)
        if self._table.filled[waypoint] >= self._table.begin.shape[1]:
            self._enlarge()
        add(self._table, waypoint, begin, end, bot)

    def _enlarge(self) -> None:
        self._table = larger(self._table)
        self._desk = make_desk(self._roads, self._table.begin.shape[1])


def _read_only(array: Floats) -> Floats:
    """A view like those that `Routes` hands out, so that the search need be compiled only once."""
    view = array.view()
    view.flags.writeable = False
    return view
