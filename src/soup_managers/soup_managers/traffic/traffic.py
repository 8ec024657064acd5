"""The timetable of all bots: who drives where and when, so that nobody ever touches anybody and everybody arrives."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from soup_managers.traffic.booking import TABLE_FULL, book, read_schedule, wait_early
from soup_managers.traffic.desk import make_desk
from soup_managers.traffic.holds import Motion
from soup_managers.traffic.lines import Line, find_lines
from soup_managers.traffic.roads import AT_END_M, Mask, make_roads
from soup_managers.traffic.routes import Routes, kind_of_spots
from soup_managers.traffic.search import rest_of_way, search
from soup_managers.traffic.timetable import add, empty_timetable, forget, forget_bot, free_from, larger
from soup_msgs_py.layout import Floats, Layout
from soup_msgs_py.messages import Point
from soup_msgs_py.scenario import Scenario

PATIENCE_S = 3.0  # a bot that is later than this on its usual way looks for another one
CAPACITY = 16  # holds of one waypoint, to begin with
_LABELS_ON_WAY = 100_000
_LABELS_FOR_BETTER = 1_500  # how long to look for a better way than waiting
_LABELS_FOR_ANY = 60_000  # how long to look for any way at all


@dataclass(frozen=True, slots=True)
class Leg:
    """A drive from one waypoint to another, at rest at both ends.

    Attributes:
        bot: Who drives.
        waypoints: Where it stops or waits: the same as `points`.
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


@dataclass(slots=True)
class _Course:
    """Where a bot stands after all that is planned for it, since when, where it faces; its legs so far."""

    place: int
    since: float
    heading: float
    legs: list[tuple[Leg, float, float]]  # with since when it stood where the leg begins, and where it faced


class Traffic:
    """Collision-free and deadlock-free drives, one after the other, on the waypoint graph.

    Each bot holds the waypoints near it, as `holds` says; a new leg takes what the legs planned before have left.
    Bots stand only where nobody else has to pass, on storage spots and in the lines of stations, so every hold on a
    lane ends, and whoever waits long enough can go.

    Attributes:
        lines: Waypoints of each station's line, its dock first; bots come in from the end.
        deep: Whether bots pass through storage spots, because some can only be reached through others.
    """

    def __init__(self, scenario: Scenario, layout: Layout) -> None:
        bot = scenario.bot
        motion = Motion(2.0 * max(bot.radius_m, scenario.bucket.radius_m), bot.max_speed_mps, bot.max_acceleration_mps2)
        self.lines: list[Line] = find_lines(layout)
        self._roads = make_roads(layout, self.lines, motion, bot.turn_rate_radps or 0.0)
        self._routes = Routes(self._roads)
        self.deep = self._routes.deep
        self._points: list[Point] = [(x, y) for x, y in layout.waypoints.tolist()]
        self._table = empty_timetable(len(self._points), CAPACITY)
        self._desk = make_desk(self._roads, CAPACITY)
        self._courses: dict[int, _Course] = {}
        self._past = -math.inf

    # ---- who stands where ------------------------------------------------------------------------------------

    def stand(self, bot: int, waypoint: int, since: float, heading: float = 0.0) -> None:
        """A bot stands on a waypoint for good; whatever was planned for it is forgotten."""
        self.remove(bot)
        self._courses[bot] = _Course(waypoint, since, heading, [])
        self._hold_for_good(bot, waypoint, since)

    def remove(self, bot: int) -> None:
        """Forget a bot altogether."""
        if self._courses.pop(bot, None) is not None:
            forget_bot(self._table, bot, -math.inf)

    def at(self, bot: int) -> int:
        """The waypoint where a bot stands after all that is planned for it."""
        return self._courses[bot].place

    def free_from(self, waypoint: int) -> float:
        """When nobody holds a waypoint any more: minus infinity for always, infinity while somebody stands there."""
        return float(free_from(self._table, waypoint, -1))

    def conflicts(self, bot: int) -> list[int]:
        """The bots whose planned drives pass where a bot stands now; they must be stopped and planned anew."""
        table = self._table
        mine, theirs = [], []
        for w in np.flatnonzero(table.filled).tolist():
            for k in range(table.filled[w]):
                hold = w, float(table.begin[w, k]), float(table.end[w, k]), int(table.bot[w, k])
                (mine if hold[3] == bot else theirs).append(hold)
        held = {w: begin for w, begin, end, _ in mine if end == math.inf}
        return sorted({other for w, _, end, other in theirs if w in held and end > held[w]})

    # ---- drives ----------------------------------------------------------------------------------------------

    def plan(
        self,
        bot: int,
        goal: int,
        earliest: float,
        *,
        loaded: bool,
        depart_by: float = math.inf,
        blocked_spots: Mask | None = None,
    ) -> Leg | None:
        """Plan and reserve a bot's next leg, from where its last one ends.

        Args:
            bot: Who drives.
            goal: The waypoint where it goes and stands until its next leg.
            earliest: When it may depart (s).
            loaded: Whether it carries a bucket.
            depart_by: When it must have departed.
            blocked_spots: Waypoints on which buckets rest, shape (waypoints,): a loaded bot in a deep layout passes
                through the other spots. Without it, through none.

        Returns:
            The leg that arrives first; None, and nothing has changed, if there is none now: somebody stands at the
            goal or in the only way with no plan to leave.
        """
        course = self._courses[bot]
        start, ready = course.place, max(earliest, course.since)
        if start == goal:
            point = self._points[goal]
            return Leg(bot, (goal,), (point,), (ready,), ready, ready)
        goal_free = max(float(free_from(self._table, w, bot)) for w in self._last_stretch(start, goal))
        if goal_free == math.inf:
            return None
        blocked = self._routes.blocked(loaded, blocked_spots)
        edges = self._routes.find(start, goal, loaded, blocked, self._desk)
        label, in_time = self._on_way(edges, bot, goal, ready, goal_free, blocked, depart_by)
        arrive = float(self._desk.time[label]) if label >= 0 else math.inf
        if arrive > in_time + PATIENCE_S:
            worst = min(arrive - 0.5 * PATIENCE_S, in_time + 2.0 * PATIENCE_S) if label >= 0 else math.inf
            other = self._on_any_way(bot, goal, ready, blocked, depart_by, worst)
            if other < 0 and label >= 0:
                self._routes.find(start, goal, loaded, blocked, self._desk)
                label, _ = self._on_way(edges, bot, goal, ready, goal_free, blocked, depart_by)
            else:
                label = other
        if label < 0:
            return None
        return self._book(bot, label, ready, depart_by) or self.plan(
            bot, goal, earliest, loaded=loaded, depart_by=depart_by, blocked_spots=blocked_spots
        )

    def revoke(self, bot: int, now: float) -> None:
        """Take back all legs of a bot that have not departed: it stands where the first of them begins.

        A bot that is under way keeps its leg. Who has meanwhile planned to pass there is among its `conflicts`.
        """
        course = self._courses[bot]
        while course.legs and course.legs[-1][0].depart > now:
            leg, since, heading = course.legs.pop()
            forget_bot(self._table, bot, leg.depart)
            course.place, course.since, course.heading = leg.waypoints[0], since, heading
            self._hold_for_good(bot, course.place, since)

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

    def times_from(self, start: int) -> Floats:
        """How long drives from a place take to every lane and spot (s); read only, kept for station lines."""
        return self._routes.away(start)[0]

    # ---- at the start ----------------------------------------------------------------------------------------

    def is_lane(self, waypoint: int) -> bool:
        """Whether everybody passes there, so that nobody should stay."""
        return not self._roads.spot[waypoint] and self._roads.line[waypoint] < 0

    def parking(self, bot: int, taken: Iterable[int] = ()) -> list[int]:
        """The free storage spots where a bot could wait, the nearest first."""
        times = self._routes.away(self.at(bot))[0].copy()
        times[~self._roads.spot] = np.inf
        times[list(taken)] = np.inf
        near = np.argsort(times, kind="stable")
        return [int(w) for w in near[np.isfinite(times[near])] if self.free_from(int(w)) < math.inf]

    def clear_lanes(self, earliest: float, taken: Iterable[int] = ()) -> list[Leg]:
        """Send all unloaded bots that stay on lanes or in lines to storage spots; those that can go."""
        spots = set(taken)
        waiting = [bot for bot, course in sorted(self._courses.items()) if not self._roads.spot[course.place]]
        legs: list[Leg] = []
        while True:
            gone = []
            for bot in waiting:
                for spot in self.parking(bot, spots)[:4]:
                    leg = self.plan(bot, spot, earliest, loaded=False)
                    if leg is not None:
                        spots.add(spot)
                        gone.append(bot)
                        legs.append(leg)
                        break
            waiting = [bot for bot in waiting if bot not in gone]
            if not gone:
                return legs

    def set_storage_spot(self, waypoint: int, is_spot: bool) -> None:
        """A waypoint becomes a storage spot, or a lane again."""
        self._roads.spot[waypoint] = is_spot
        kind_of_spots(self._roads)
        self._routes = Routes(self._roads)
        self.deep = self._routes.deep

    # ---- within ----------------------------------------------------------------------------------------------

    def _last_stretch(self, start: int, goal: int) -> Line:
        """The goal, and the places of its line that one must pass on the way there."""
        line = self.lines[self._roads.line[goal]] if self._roads.line[goal] >= 0 else (goal,)
        first = line.index(goal)
        behind = line.index(start) if start in line[first:] else len(line)
        return line[first:behind]

    def _on_way(
        self, edges: int, bot: int, goal: int, ready: float, goal_free: float, blocked: Mask, depart_by: float
    ) -> tuple[int, float]:
        """The label at the goal of the way on the desk, -1 for none; and when a bot could be there at best."""
        if edges == 0:
            return -1, ready
        course, desk = self._courses[bot], self._desk
        rest_of_way(self._roads, desk, edges)
        label = search(
            self._roads, self._table, desk, bot, course.place, goal, ready, course.heading, desk.rest, True,
            self.deep, blocked, depart_by, math.inf, _LABELS_ON_WAY,
        )  # fmt: skip
        return label, max(ready + float(desk.rest[course.place]), goal_free)

    def _on_any_way(self, bot: int, goal: int, ready: float, blocked: Mask, depart_by: float, worst: float) -> int:
        course = self._courses[bot]
        times = self._routes.to(goal)[0]
        if times[course.place] == math.inf:
            return -1
        most = _LABELS_FOR_ANY if worst == math.inf else _LABELS_FOR_BETTER
        return search(
            self._roads, self._table, self._desk, bot, course.place, goal, ready, course.heading, times, False,
            self.deep, blocked, depart_by, worst, most,
        )  # fmt: skip

    def _book(self, bot: int, label: int, ready: float, depart_by: float) -> Leg | None:
        """Write what leads to a label into the timetable; None where that has only just been made large enough."""
        course, roads, desk = self._courses[bot], self._roads, self._desk
        runs = read_schedule(desk, label, self._table.begin.shape[1] + 1)
        wait_early(roads, self._table, desk, runs, ready, course.heading, depart_by, bot)
        if book(roads, self._table, desk, runs, ready, course.heading, self._past, bot) == TABLE_FULL:
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
        points = self._points
        leg = Leg(bot, tuple(waypoints), tuple([points[w] for w in waypoints]), tuple(stamps), stamps[0], stamps[-1])
        course.legs = [kept for kept in course.legs if kept[0].arrive > self._past]
        course.legs.append((leg, course.since, course.heading))
        course.place, course.since = stops[-1], stamps[-1]
        course.heading = float(roads.heading[desk.run_first[runs - 1]])
        return leg

    def _hold_for_good(self, bot: int, waypoint: int, since: float) -> None:
        for w in self._held_on(waypoint):
            forget(self._table, w, self._past)
            while self._table.filled[w] >= self._table.begin.shape[1]:
                self._enlarge()
            add(self._table, w, since, math.inf, bot)

    def _held_on(self, waypoint: int) -> list[int]:
        """What a bot holds that stands on a waypoint."""
        roads = self._roads
        held = [waypoint]
        if roads.crowded[waypoint]:
            for edge in roads.into_edge[roads.into[waypoint] : roads.into[waypoint + 1]].tolist():
                holds = slice(roads.hold[edge], roads.hold[edge + 1])
                at_end = roads.hold_to[holds] >= roads.length[edge] - AT_END_M
                held += [w for w in roads.hold_at[holds][at_end].tolist() if w not in held]
        return held

    def _enlarge(self) -> None:
        self._table = larger(self._table)
        self._desk = make_desk(self._roads, self._table.begin.shape[1])
