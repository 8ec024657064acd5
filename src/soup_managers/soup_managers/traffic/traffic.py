"""The timetable of all bots: who drives where and when, so that nobody ever touches anybody and everybody arrives."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from soup_managers.traffic.booking import TABLE_FULL, book, read_schedule, wait_early
from soup_managers.traffic.desk import make_desk
from soup_managers.traffic.holds import Motion
from soup_managers.traffic.lines import Line, find_lines
from soup_managers.traffic.nearby import Nearby
from soup_managers.traffic.roads import Mask, make_roads
from soup_managers.traffic.routes import Routes
from soup_managers.traffic.runs import heading_of, place_at, run_time, time_at, turn_time
from soup_managers.traffic.search import rest_of_way, search
from soup_managers.traffic.timetable import add, empty_timetable, forget, forget_bot, free_from, larger
from soup_msgs_py.layout import Floats, Layout
from soup_msgs_py.messages import Point
from soup_msgs_py.scenario import Scenario

PATIENCE_S = 3.0  # a bot that is later than this on its usual way looks for another one
NOWHERE = -1  # the "waypoint" of a place beside the graph
_CAPACITY = 16  # holds of one waypoint, to begin with
_LABELS_ON_WAY = 100_000
_LABELS_FOR_BETTER = 1_500  # how long to look for a better way than waiting
_LABELS_FOR_ANY = 60_000  # how long to look for any way at all
_HERE_M = 1e-9  # farther off a waypoint the first run to it takes time, and whoever is late is in the way
_PIECE_M = 3.0  # of a drive that is adopted: what is held along one is held for all of its time


@dataclass(frozen=True, slots=True)
class Leg:
    """A drive from one waypoint to another, at rest at both ends.

    Attributes:
        bot: Who drives.
        waypoints: Where it stops or waits, as in `points`; `NOWHERE` for a start beside the graph.
        points: The same in metres; the first is where it stands, twice the same point is a wait.
        stamps: When to be at each point (s); the first is the departure.
        depart: The same.
        arrive: When it stands on the last one.
    """

    bot: int
    waypoints: tuple[int, ...]
    points: tuple[Point, ...]
    stamps: tuple[float, ...]
    depart: float
    arrive: float


@dataclass(frozen=True, slots=True)
class _Stand:
    """Where a bot stands, since when, and where it faces (rad)."""

    waypoint: int
    point: Point
    since: float
    heading: float


class Traffic:
    """Collision-free and deadlock-free drives, one after the other, on the waypoint graph.

    Each bot holds the waypoints near it, as `holds` says; a new leg takes what the legs planned before have left.
    Bots stand only where nobody else has to pass, on storage spots and in the lines of stations, so every hold on a
    lane ends, and whoever waits long enough can go.

    Attributes:
        lines: Waypoints of each station's line, its dock first; bots come in from the end.
        deep: Whether bots pass through storage spots, because some can only be reached through others.
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
        self.deep = self._routes.deep
        self._points: list[Point] = [(x, y) for x, y in layout.waypoints.tolist()]
        self._table = empty_timetable(len(self._points), _CAPACITY)
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
        speed, acceleration = self._roads.max_speed, self._roads.max_acceleration
        heading = 0.0
        for k, ((ax, ay), (bx, by)) in enumerate(pairwise(points)):
            length = math.sqrt((bx - ax) * (bx - ax) + (by - ay) * (by - ay))
            if length == 0.0:
                self._hold_along(points[k], points[k], stamps[k], stamps[k + 1], bot)
                continue
            heading = heading_of(bx - ax, by - ay)
            runs_from = stamps[k + 1] - run_time(length, speed, acceleration)
            pieces = math.ceil(length / _PIECE_M)
            for piece in range(pieces):
                ends = [length * piece / pieces, length * (piece + 1) / pieces]
                start, end = ((ax + (bx - ax) * x / length, ay + (by - ay) * x / length) for x in ends)
                begin, until = (runs_from + time_at(x, length, speed, acceleration) for x in ends)
                self._hold_along(start, end, min(begin, stamps[k]) if piece == 0 else begin, until, bot)
        stand = replace(self._stands[bot], heading=heading)
        waypoints = tuple(self._nearby.waypoint(x, y) for x, y in points)
        leg = Leg(bot, waypoints, points, stamps, stamps[0], stamps[-1])
        self._legs[bot] = [(leg, _Stand(NOWHERE, points[0], stamps[0], heading))]
        self._stands[bot] = stand
        return stand.waypoint

    def _hold_along(self, start: Point, end: Point, begin: float, until: float, bot: int) -> None:
        for waypoint in self._nearby.held_along(start, end):
            self._hold(waypoint, begin, until, bot)

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
        held: set[int] = set()
        for start, end in self._ways_between(leg, now, now + notice_s):
            held.update(self._nearby.held_along(start, end))
        self._forget(bot)
        self._stands[bot] = stand
        for waypoint in sorted(held):
            self._hold(waypoint, now, math.inf, bot)

    def _ways_between(self, leg: Leg, begin: float, end: float) -> list[tuple[Point, Point]]:
        """Where a bot on a leg may be if it begins to brake between two times: straight ways."""
        speed, acceleration = self._roads.max_speed, self._roads.max_acceleration
        ways = [(leg.points[-1], leg.points[-1])] if end >= leg.arrive else []
        for k in range(len(leg.points) - 1):
            (ax, ay), (bx, by) = leg.points[k], leg.points[k + 1]
            if leg.stamps[k] > end or leg.stamps[k + 1] < begin:
                continue
            length = math.sqrt((bx - ax) * (bx - ax) + (by - ay) * (by - ay))
            if length == 0.0:
                ways.append((leg.points[k], leg.points[k]))
                continue
            # a turn comes first; the rest is the run
            runs_from = leg.stamps[k + 1] - run_time(length, speed, acceleration)
            first = place_at(begin - runs_from, length, speed, acceleration) / length
            last = place_at(end - runs_from, length, speed, acceleration) + 0.5 * speed * speed / acceleration
            last = min(last / length, 1.0)
            ways.append(
                ((ax + (bx - ax) * first, ay + (by - ay) * first), (ax + (bx - ax) * last, ay + (by - ay) * last))
            )
        return ways

    def at(self, bot: int) -> int:
        """The waypoint where a bot stands after all that is planned for it; `NOWHERE` beside the graph."""
        return self._stands[bot].waypoint

    def free_from(self, waypoint: int) -> float:
        """When nobody holds a waypoint any more: minus infinity for always, infinity while somebody stands there."""
        return float(free_from(self._table, waypoint, -1))

    def conflicts(self, bot: int, now: float) -> list[int]:
        """The bots that hold what a bot holds, at the same time, from now on: they must be stopped."""
        table = self._table
        there = np.arange(table.begin.shape[1]) < table.filled[:, None]
        rows, columns = (there & (table.bot == bot)).nonzero()
        begin = np.maximum(table.begin[rows, columns], now)[:, None]
        end = table.end[rows, columns][:, None]
        bots = table.bot[rows]
        meet = there[rows] & (bots != bot) & (np.maximum(table.begin[rows], begin) < np.minimum(table.end[rows], end))
        return sorted(set(bots[meet].tolist()))

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
        goal_free = max(float(free_from(self._table, w, bot)) for w in self._last_stretch(stand.waypoint, goal))
        if goal_free == math.inf:
            return None
        blocked = self._routes.blocked(loaded, blocked_spots)
        if stand.waypoint == NOWHERE:
            return self._rejoin(bot, goal, ready, loaded, blocked, hurried)
        edges = self._routes.find(stand.waypoint, goal, loaded, blocked, self._desk)
        label, in_time = self._on_way(edges, bot, goal, ready, goal_free, blocked)
        arrive = float(self._desk.time[label]) if label >= 0 else math.inf
        if arrive > in_time + PATIENCE_S:
            worst = math.inf if label < 0 else min(arrive - 0.5 * PATIENCE_S, in_time + 2.0 * PATIENCE_S)
            other = self._on_any_way(bot, goal, ready, blocked, worst, hurried)
            if other < 0 and label >= 0:
                self._routes.find(stand.waypoint, goal, loaded, blocked, self._desk)
                label, _ = self._on_way(edges, bot, goal, ready, goal_free, blocked)
            else:
                label = other
        if label < 0:
            return None
        leg = self._book(bot, label, ready)
        if leg is not None:
            return leg
        return self.plan(bot, goal, earliest, loaded=loaded, blocked_spots=blocked_spots, hurried=hurried)

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

    def _on_way(
        self, edges: int, bot: int, goal: int, ready: float, goal_free: float, blocked: Mask
    ) -> tuple[int, float]:
        """The label at the goal of the way on the desk, -1 for none; and when a bot could be there at best."""
        if edges == 0:
            return -1, ready
        desk = self._desk
        rest_of_way(self._roads, desk, edges)
        label = self._search(bot, goal, ready, desk.rest, True, blocked, math.inf, _LABELS_ON_WAY)
        return label, max(ready + float(desk.rest[self._stands[bot].waypoint]), goal_free)

    def _on_any_way(self, bot: int, goal: int, ready: float, blocked: Mask, worst: float, hurried: bool) -> int:
        times = self._routes.to(goal)[0]
        if times[self._stands[bot].waypoint] == math.inf:
            return -1
        most = _LABELS_FOR_ANY if worst == math.inf and not hurried else _LABELS_FOR_BETTER
        return self._search(bot, goal, ready, times, False, blocked, worst, most)

    def _search(
        self,
        bot: int,
        goal: int,
        ready: float,
        rest: Floats,
        marked_only: bool,
        blocked: Mask,
        worst: float,
        most: int,
    ) -> int:
        stand, desk = self._stands[bot], self._desk
        label = search(
            self._roads, self._table, desk, bot, stand.waypoint, goal, ready, stand.heading, rest, marked_only,
            self.deep, blocked, worst, most,
        )  # fmt: skip
        self.looked += int(desk.looked[0])
        desk.looked[0] = 0
        return label

    def _book(self, bot: int, label: int, ready: float) -> Leg | None:
        """Write what leads to a label into the timetable; None where that has only just been made large enough."""
        stand, roads, desk = self._stands[bot], self._roads, self._desk
        runs = read_schedule(desk, label, self._table.begin.shape[1] + 1)
        wait_early(roads, self._table, desk, runs, ready, stand.heading, bot)
        if book(roads, self._table, desk, runs, ready, stand.heading, self._past, bot) == TABLE_FULL:
            self._enlarge()
            return None
        stops = desk.stop[: runs + 1].tolist()
        leaves, arrives = desk.leaves[:runs].tolist(), desk.arrives[:runs].tolist()
        waypoints, stamps = [stops[0]], [leaves[0]]
        for k in range(runs):
            if leaves[k] > stamps[-1]:
                waypoints.append(stops[k])
                stamps.append(leaves[k])
            waypoints.append(stops[k + 1])
            stamps.append(arrives[k])
        points = tuple([self._points[w] for w in waypoints])
        leg = Leg(bot, tuple(waypoints), points, tuple(stamps), stamps[0], stamps[-1])
        self._add_leg(leg, float(roads.heading[desk.run_first[runs - 1]]))
        return leg

    def _add_leg(self, leg: Leg, heading: float) -> None:
        """Note a leg that is in the timetable."""
        legs = [kept for kept in self._legs[leg.bot] if kept[0].arrive > self._past]
        self._legs[leg.bot] = [*legs, (leg, self._stands[leg.bot])]
        self._stands[leg.bot] = _Stand(leg.waypoints[-1], leg.points[-1], leg.arrive, heading)

    def _rejoin(self, bot: int, goal: int, ready: float, loaded: bool, blocked: Mask, hurried: bool) -> Leg | None:
        """A leg from beside the graph: straight to a waypoint that nobody else will pass, and on from there."""
        stand, roads = self._stands[bot], self._roads
        for waypoint in self._nearby.ways_back(stand.point, loaded, blocked, goal):
            point = self._points[waypoint]
            dx, dy = point[0] - stand.point[0], point[1] - stand.point[1]
            held = self._nearby.held_to(stand.point, waypoint)
            depart = max(ready, *(float(free_from(self._table, w, bot)) for w in held))
            if depart == math.inf:
                continue
            heading = heading_of(dx, dy)
            length = float(np.sqrt(dx * dx + dy * dy))
            arrive = depart + turn_time(stand.heading, heading, roads.turn_rate)
            arrive += run_time(length, roads.max_speed, roads.max_acceleration)
            forget_bot(self._table, bot, -math.inf)
            for w in held:
                self._hold(w, stand.since, arrive, bot)
            self._stands[bot] = _Stand(waypoint, point, arrive, heading)
            self._stay(bot, self._stands[bot])
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
