"""The fleet manager that works leg by leg, on the timetable of reserved traffic.

Nothing is promised before it has to be: a bot is bound to a bucket and a station, but which letters are moved is
settled when the bucket is docked, and where the bucket goes next when it is done there. Each leg is one drive on
reserved ways, each operation at its end one trip without a way::

    fetch -> (line of the station) -> dock: tiles until it serves no more -> another station | storage spot
"""

from __future__ import annotations

import numpy as np

from soup_managers.explain import Explain
from soup_managers.fleets.base import Fleet
from soup_managers.fleets.coordinated.adopting import drives_on, stays
from soup_managers.fleets.coordinated.digging import Digging
from soup_managers.fleets.coordinated.fetching import Fetch, Fetching
from soup_managers.fleets.coordinated.lines import FAR_S, Lines, spots_near
from soup_managers.fleets.coordinated.lowest import lowest
from soup_managers.fleets.coordinated.places import Places
from soup_managers.fleets.coordinated.robots import Activity, Purpose, Robot
from soup_managers.fleets.coordinated.scores import Scores
from soup_managers.fleets.coordinated.settling import Settling
from soup_managers.fleets.coordinated.situation import Situation
from soup_managers.fleets.coordinated.watch import Watch
from soup_managers.fleets.coordinated.whereabouts import RETRY_S, Whereabouts
from soup_managers.fleets.tasks import Key, Task
from soup_managers.policies.coordinated import Coordinated
from soup_managers.traffic import Traffic
from soup_managers.view import WarehouseView
from soup_msgs_py.codes import Code, EventType, Phase
from soup_msgs_py.layout import Floats, Layout
from soup_msgs_py.messages import (
    DELIVER,
    STORE,
    BotGone,
    Bots,
    BotStatus,
    Bound,
    DriveGoal,
    DriveResult,
    Event,
    TileMove,
    Trip,
    TripGoal,
    TripResult,
    Visit,
)
from soup_msgs_py.mind import NEVER, Message
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.tiles import tile_name

TICK_S = 1.0  # between two looks at all stations
AT_ONCE = 10  # bots that may try again in that time
LOOKS = 40_000  # at one instant; then ways are looked for in a hurry, and after twice as many no more
BURIED_S = 20.0  # what it costs that a stored bucket closes the way to another one
TRIES = 8  # alternatives that are tried at once
GIVE_UP_S = 20.0  # a bucket that could not get to its station for so long does something else
WAITS_S = 15.0  # a bucket waits no longer for a bundle
_REACTS_TO = frozenset({EventType.WORD_COMPLETED, EventType.BUNDLE_EMPTIED})
_WITH_GOALS_AHEAD = _REACTS_TO | {EventType.WORD_ASSIGNED}
NEARLY_ALL = 0.9  # tasks: some words may only just have been opened
KEEP_ROOM = 0.25  # share of the capacity: a bucket with less room is done at a letter station


class CoordinatedFleet(Fleet[Task]):
    """Serves the other managers' tasks with reserved traffic and the decisions of a `Coordinated` policy.

    Bots, buckets and stations are as the world tells, and what is bound for where is decided anew by a new one.
    """

    def __init__(
        self,
        scenario: Scenario,
        layout: Layout,
        policy: Coordinated,
        view: WarehouseView,
        rng: np.random.Generator,
        explain: Explain | None = None,
    ) -> None:
        self._layout, self._policy = layout, policy
        self._explain = explain or Explain()
        self._traffic = Traffic(scenario, layout)
        self.situation = Situation(view, layout, self._traffic, policy.horizons, rng)
        super().__init__(view, self.situation.tasks)
        self._places = Places(layout, scenario.bots)
        self._digging = Digging(layout, self._places)
        self._fetching = Fetching(self.situation, policy, self._places, self._digging, self._explain, self.mistakes)
        self._onward_scores = Scores(self.mistakes, "onward", policy.onward, 0.0)
        self._storage_costs = Scores(self.mistakes, "storage", policy.storage, np.inf)
        self._waiting_spots = spots_near(self.situation.docks, self._places.spots, self._traffic)
        self._kept_free = np.zeros(len(layout.waypoints), bool)
        self._kept_free[[spot for spots in self._waiting_spots for spot in spots]] = True
        self._lines = Lines(self.situation, self._traffic.lines)
        self._told: dict[int, BotStatus] = {}  # bots that say that they stand or work, and are still to be seen there
        self._orders = 0
        self._watch = Watch(self.situation.robots)
        self._said: list[Message] = []
        self._whereabouts = Whereabouts(
            scenario,
            layout,
            view,
            self.situation,
            self._traffic,
            self._places,
            self._lines,
            self._watch,
            self._said,
        )
        self._settling = Settling()
        self._tick = NEVER
        self._undecided: list[Robot] = []
        self._has_idle = True  # whether bots had no work when all stations were looked at last
        self._looks_at, self._looks_before = -1.0, 0  # when ways were looked for last, and how many looks before then
        self._waiting: dict[int, Robot] = {}  # those whose next step was not possible: tried again
        self._handlers |= {
            BotGone: self._handle_gone,
            TripResult: self._handle_result,
            DriveResult: self._handle_result,
            Bots: self._handle_bots,
        }

    def bots_of(self) -> dict[Key, tuple[int, ...]]:
        """The bots that are bound for the station of each task."""
        bound = [tuple(robot.number for robot in robots) for robots in self.situation.bound]
        return {key: bound[task.station] for key, task in self.book.tasks.items()}

    @property
    def stalled(self) -> dict[int, str]:
        """Bots that are left alone until they answer and are seen where they stand, and what went wrong."""
        return {bot: robot.note for bot, robot in sorted(self._watch.lost.items())}

    @property
    def reacts_to(self) -> frozenset[EventType]:
        """The ends of its tasks; all else it learns from who does it."""
        return _WITH_GOALS_AHEAD if self._ahead else _REACTS_TO

    @property
    def wants_places(self) -> bool:
        """Whether it has to see where bots stand."""
        return bool(self._told) or self._watch.wants_places

    def wake(self, now: float) -> list[Message]:
        """Look after all stations, and try again what was not possible."""
        if not self.view.ready or self.view.lost:
            self._tick = self.next_wake = now + TICK_S
            return []
        for robot in self._watch.deaf(now):
            self._whereabouts.does_not_stop(robot, now)
        for robot in self._watch.overdue(now):
            self._whereabouts.overdue(robot, now)
        if now < self._tick:
            return self.step(now)
        self._tick = now + TICK_S
        self._settle(now)
        self._find_again(now)
        self._whereabouts.ask_silent(now)
        for robot in [robot for robot in self._waiting.values() if robot.retry_at <= now]:
            self._waiting.pop(robot.number, None)  # one before it may have had it sent away
            self._resume(robot, now)
            if robot.activity is Activity.STANDS and robot.bucket >= 0 and self._digging.needed:
                self._free_the_way(robot, now)
        self._traffic.forget_before(now)
        self._explain.now = now
        self._fetch(now)
        said = self.step(now)
        self._has_idle = bool(self.situation.idle_bots())
        return said + self.tell_tasks(list(self.book.tasks.values()))

    def take_over(self, now: float) -> None:
        """Make the books about buckets anew from the view."""
        self._settling.begin(now)
        self.situation.take_over()
        self._places.take_over(self.view.bucket_on, self.view.storage_spots)
        for robot in self.situation.robots:
            if robot.load >= 0:
                self.situation.free_buckets[robot.load] = False
        self._tick = now + TICK_S

    def on_event(self, event: Event, now: float) -> list[Message]:
        """Tiles were moved, buckets lifted and set down."""
        kind, situation = event.type, self.situation
        if kind is EventType.TRANSFERRED:
            delivered = event.station < situation.word_stations
            situation.stock.put(event.bucket, event.tile, -1 if delivered else 1)
            situation.tasks.moved((DELIVER if delivered else STORE, event.job), event.tile)
            situation.changed(event.station)
        elif kind is EventType.WORD_ASSIGNED:
            return self.opened(event, now)
        elif kind is EventType.WORD_COMPLETED or kind is EventType.BUNDLE_EMPTIED:
            task = self.completed(event)
            return [self.end(task)] if task is not None else []
        elif kind is EventType.GRABBED:
            situation.free_buckets[event.bucket] = False
            self._places.lifted(int(situation.spot_of[event.bucket]))
        elif kind is EventType.RELEASED:
            spot = self.view.spot_of[event.bucket]
            situation.spot_of[event.bucket] = spot
            self._places.set_down(spot)
        elif kind is EventType.BOT_COLLISION or kind is EventType.BUCKET_COLLISION:
            self._watch.collided(event.bots, now)
        elif kind is EventType.SPOT_MADE or kind is EventType.SPOT_REMOVED:
            self._places.allow(event.waypoint, kind is EventType.SPOT_MADE)
        return []

    # ---- messages ------------------------------------------------------------------------------------------

    def on_goal(self, task: Task) -> None:
        """The bucket at the dock may serve it."""
        docked = self._lines.at(task.station, 0)
        if docked is not None and docked.activity is Activity.STANDS:
            self._undecided.append(docked)

    def on_status(self, status: BotStatus, now: float) -> list[Message]:
        """A bot may be seen for the first time, or drive for somebody else."""
        robot = self.situation.robots[status.bot]
        self._watch.heard(status, now)
        if status.trip is not None:
            self._orders = max(self._orders, status.trip.trip)
        self._set_alarm()
        stands, is_new = status.phase is Phase.IDLE, robot.activity is Activity.UNKNOWN
        self._told.pop(status.bot, None)
        if stands and robot.activity is Activity.AWAY:
            robot.failed_at = max(robot.failed_at, status.time)  # where it was seen before, it may not be any more
        if drives_on(status) and (is_new or self._whereabouts.drives_for_another(robot, status, now)):
            self._whereabouts.adopt_drive(robot, status)
            return self.step(now)
        if (is_new and (stands or stays(status))) or (stands and robot.adopted):
            self._told[robot.number] = status
            return self._enter(now)
        return []

    def _handle_gone(self, gone: BotGone, now: float) -> list[Message]:
        """A bot that stands has nobody who could say so; one that was asked for something fails that anyway."""
        robot = self.situation.robots[gone.bot]
        self._watch.gone(gone.bot)
        if robot.activity is not Activity.STANDS:
            return []
        self._whereabouts.failed(robot, Code.STOPPED, f"nobody answers for bot {gone.bot}", True, now)
        return self.step(now)

    def _enter(self, now: float) -> list[Message]:
        """Enter the bots that have told that they stand, and were seen since: where they were before, they drove."""
        seen = [bot for bot, status in self._told.items() if status.time <= self.view.seen_at]
        for bot in seen:
            status, robot = self._told.pop(bot), self.situation.robots[bot]
            if robot.adopted:
                if self._whereabouts.end_adopted(robot, status, now):
                    self._arrived(robot, now)
            elif robot.activity is Activity.UNKNOWN:
                del self._watch.unplaced[bot]
                if status.trip is not None:
                    self._whereabouts.adopt_trip(robot, status.trip, status.bucket, now)
                elif status.phase is Phase.IDLE:
                    self._stands(robot, status.bucket, now)
                    self._lines.keep(robot)
                else:
                    self._whereabouts.stands_in_the_way(robot, now)
        if not seen:
            return []
        if not self._watch.unplaced:
            self._fetch(now)
        return self.step(now)

    def _handle_bots(self, bots: Bots, now: float) -> list[Message]:
        if self.view.ready:
            self.view.observe(bots)
            for bot, robot in self._watch.lost.items():
                if bots.vx[bot] != 0.0 or bots.vy[bot] != 0.0:
                    robot.failed_at = max(robot.failed_at, np.nextafter(bots.time, np.inf))  # to be seen again, at rest
            for robot in self._watch.struck(bots.time):
                self._whereabouts.struck(robot, now)
            if self._watch.unplaced:
                for robot in self._watch.dead(list(zip(bots.x.tolist(), bots.y.tolist(), strict=True)), bots.time):
                    self._whereabouts.stands_in_the_way(robot, now)
            if self._told:
                return self._enter(now)
        return []

    def _handle_result(self, result: DriveResult | TripResult, now: float) -> list[Message]:
        robot = self.situation.robots[result.bot]
        drive = isinstance(result, DriveResult)
        number = result.drive if isinstance(result, DriveResult) else result.trip
        if robot.activity is not (Activity.DRIVES if drive else Activity.WORKS) or robot.order != number:
            return []
        began = self._watch.ended(robot)
        if result.code is not Code.DONE or robot.number in self._whereabouts.halted:
            self._whereabouts.failed(robot, result.code, result.message, began, now)
        elif drive:
            self._arrived(robot, now)
        else:
            self._worked(robot)
        return self.step(now)

    # ---- where bots stand ----------------------------------------------------------------------------------

    def _stands(self, robot: Robot, bucket: int, now: float) -> None:
        """A bot has told that it stands idle: it can be used from where it is."""
        self._whereabouts.stands(robot, bucket, now)
        robot.activity = Activity.STANDS
        if bucket >= 0:
            self._undecided.append(robot)
        elif not self._places.is_spot[robot.waypoint] or (
            self._digging.needed and not self._places.occupied[robot.waypoint]
        ):
            robot.purpose = Purpose.PARK
            self._later(robot, now, "")

    def _find_again(self, now: float) -> None:
        """Bots that went wrong can be used again from where they are seen to stand."""
        found = self._watch.found(now, self.view.seen_at)
        for robot in found:
            self._stands(robot, int(self.view.bot_bucket[robot.number]), now)
        if found:
            self._whereabouts.note_closed()

    # ---- legs and operations -------------------------------------------------------------------------------

    def _go(self, robot: Robot, goal: int, now: float, *, hurried: bool = False) -> bool:
        """Send a bot that stands to a waypoint; False where no way can be planned now."""
        if self._traffic.at(robot.number) == goal:
            self._arrived(robot, now)
            return True
        if not self._settling.over:
            return False
        loaded = robot.bucket >= 0
        looks = self._looks(now)
        if looks > 2 * LOOKS:
            return False
        leg = self._traffic.plan(
            robot.number,
            goal,
            now,
            loaded=loaded,
            blocked_spots=self._places.occupied,
            hurried=hurried or looks > LOOKS,
        )
        if leg is None:
            return False
        self._waiting.pop(robot.number, None)
        self._whereabouts.departs(robot, goal, leg)
        self._orders += 1
        robot.order = self._orders
        robot.blocked_since = NEVER
        self._watch.asked(robot, now, leg.depart)
        self._said.append(DriveGoal(robot.number, robot.order, leg.points, leg.stamps, robot.bucket))
        return True

    def _looks(self, now: float) -> int:
        """How much has been looked for ways at this instant.

        Where many stand in each other's way, after a stop of all for instance, each way takes long to find. The world
        waits for the fleet meanwhile, and would give it up.
        """
        if self._looks_at != now:
            self._looks_at, self._looks_before = now, self._traffic.looked
        return self._traffic.looked - self._looks_before

    def _arrived(self, robot: Robot, now: float) -> None:
        robot.activity = Activity.STANDS
        match robot.purpose:
            case Purpose.FETCH:
                self._work(robot, robot.target, (), (), now)
            case Purpose.STORE:
                x, y = self._layout.waypoints[robot.waypoint]
                self._work(robot, robot.bucket, (), ((float(x), float(y)),), now)
            case Purpose.SERVE if robot.slot == 0:
                self._undecided.append(robot)
            case Purpose.SERVE:
                self._lines.moved.add(robot.station)
            case _:
                robot.purpose = Purpose.NONE

    def _work(
        self,
        robot: Robot,
        bucket: int,
        visits: tuple[Visit, ...],
        store: tuple[tuple[float, float], ...],
        now: float,
    ) -> None:
        robot.activity, robot.asked_at = Activity.WORKS, now
        self._orders += 1
        robot.order = self._orders
        self._said.append(TripGoal(robot.number, Trip(robot.order, bucket, (), visits, store)))

    def _worked(self, robot: Robot) -> None:
        """A bot has lifted, set down or served."""
        robot.activity = Activity.STANDS
        if robot.purpose is Purpose.FETCH:
            robot.bucket, robot.target = robot.target, -1
            robot.purpose = Purpose.SERVE if robot.station >= 0 else Purpose.NONE
        elif robot.purpose is Purpose.STORE:
            self.situation.free_buckets[robot.bucket] = True
            robot.bucket = -1
            robot.purpose = Purpose.NONE
            return
        if robot.purpose is Purpose.SERVE and robot.slot != 0:
            self._lines.moved.add(robot.station)
        else:
            self._undecided.append(robot)

    def _later(self, robot: Robot, now: float, why: str) -> None:
        robot.note = why
        # where many wait, after a restart for instance, nearly all would try in vain again and again
        many = len(self._waiting) / AT_ONCE if self._settling.over else 1.0
        robot.retry_at = now + RETRY_S * max(1.0, many)
        self._waiting[robot.number] = robot

    def _resume(self, robot: Robot, now: float) -> None:
        """Try again what was not possible."""
        if robot.activity is not Activity.STANDS:
            return
        match robot.purpose:
            case Purpose.PARK:
                self._park(robot, now)
            case Purpose.SERVE if robot.slot != 0:
                self._lines.moved.add(robot.station)
            case _ if robot.bucket >= 0:
                self._undecided.append(robot)

    def _set_alarm(self) -> None:
        self.next_wake = min(self._tick, self._watch.next_time)

    def _settle(self, now: float) -> None:
        """Look whether bots may be sent about by now; then all do what they have waited with."""
        if self._settling.look(bool(self._watch.unplaced), self._has_all_tasks, now):
            for robot in self._waiting.values():
                robot.retry_at = min(robot.retry_at, now)

    def _has_all_tasks(self) -> bool:
        """Whether nearly all words and bundles that are on stations are in tasks, and some are."""
        tasks, view = self.book.tasks, self.view
        words = [word for word, state in view.open_words.items() if state.missing]
        keys = [*((DELIVER, word) for word in words), *((STORE, bundle) for bundle in view.staged_bundles)]
        return bool(keys) and sum(key in tasks for key in keys) >= NEARLY_ALL * len(keys)

    def step(self, now: float) -> list[Message]:
        """Decide what is to be decided, and say it."""
        self._explain.now = now
        self._settle(now)
        while self._undecided or self._lines.moved:
            if self._undecided:
                self._onward(self._undecided.pop(0), now)
            else:
                station = min(self._lines.moved)
                self._lines.moved.discard(station)
                self._move_up(station, now)
        self._set_alarm()
        said = self._said.copy()
        self._said.clear()
        if self._lines.bound_changed:
            self._lines.bound_changed = False
            bound = [(r.load, station) for station, robots in enumerate(self.situation.bound) for r in robots]
            said.append(Bound(now, tuple([b for b, _ in bound]), tuple([s for _, s in bound])))
        return said

    # ---- lines of stations ---------------------------------------------------------------------------------

    def _move_up(self, station: int, now: float) -> None:
        """Move a station's line up, and let those who wait for a place in it come."""
        lines, closed = self._lines, bool(self.situation.closed[station])
        places = lines.places[station]
        while (gap := lines.gap(station)) is not None:
            slot, robot = gap
            if robot.activity is not Activity.STANDS:
                break
            before = robot.slot
            lines.put(robot, slot)
            if not self._go(robot, places[slot], now):
                lines.put(robot, before)
                self._later(robot, now, "waits to move up")
                break
        waiting = [
            (self.situation.travel_s(robot.waypoint, station), robot.number, robot)
            for robot in self.situation.bound[station]
            if robot.slot < 0 and robot.activity is Activity.STANDS and robot.bucket >= 0
        ]
        waiting.sort()
        for _, _, robot in waiting:
            if closed or now - robot.blocked_since > GIVE_UP_S:
                self._lines.unbind(robot)
                robot.purpose, robot.blocked_since = Purpose.NONE, NEVER
                self._undecided.append(robot)
        if closed:
            return
        waiting = [entry for entry in waiting if entry[2].station == station]
        crowded = len(self.situation.bound[station]) > len(places)
        for travel, _, robot in waiting:
            if crowded and travel > FAR_S and self._come_near(robot, station, now):
                continue
            slot = lines.slot_for(robot, station, now)
            if slot < 0:
                continue
            lines.put(robot, slot)
            if not self._go(robot, places[slot], now):
                lines.put(robot, -1)
                robot.blocked_since = min(robot.blocked_since, now)
                self._later(robot, now, f"no way leads to {self._layout.station_name(station)} now")

    def _come_near(self, robot: Robot, station: int, now: float) -> bool:
        """Send a bucket that comes from far to a free storage spot near its station, where it waits for a place.

        So nobody keeps a place in the line while it crosses the floor.
        """
        open_ = self._digging.open_spots()
        for spot in self._waiting_spots[station]:
            if self._places.is_free(spot) and open_[spot] and self._go(robot, spot, now):
                return True
        return False

    # ---- decisions -----------------------------------------------------------------------------------------

    def _onward(self, robot: Robot, now: float) -> None:
        """What a bot with a bucket that stands does next."""
        if robot.activity is not Activity.STANDS or robot.bucket < 0:
            return
        situation = self.situation
        if not self._settling.over and not self._stays_at_dock(robot):
            self._later(robot, now, "waits until all bots have told what they do")
            return
        if robot.purpose is Purpose.SERVE:
            if robot.slot != 0:
                return
            station = robot.station
            moves = self._moves(robot, station)
            if moves:
                robot.blocked_since = NEVER
                self._work(robot, robot.bucket, (Visit(station, moves, ()),), (), now)
                return
            if not situation.is_word_station(station) and self._worth_waiting(robot, now):
                self._later(robot, now, "waits for a bundle")
                return
        if not self._serve_on(robot, now):
            self._store(robot, now)

    def _moves(self, robot: Robot, station: int) -> tuple[TileMove, ...]:
        """The tiles that can be moved between a bot's bucket and a station."""
        situation = self.situation
        if situation.is_word_station(station):
            return situation.tasks.deliveries(station, situation.stock.of(robot.bucket))
        return situation.tasks.fillings(station, situation.room(robot.bucket))

    def _stays_at_dock(self, robot: Robot) -> bool:
        """Whether a bot stands at a dock that nobody else has and where its bucket is of use; it serves there then."""
        if robot.purpose is Purpose.SERVE:
            return robot.slot == 0 and bool(self._moves(robot, robot.station))
        station = self._lines.station_at(robot.waypoint)
        if station < 0 or self._lines.places[station][0] != self._traffic.at(robot.number):
            return False
        if self._lines.at(station, 0) is not None or not self._moves(robot, station):
            return False
        self._lines.enter(robot, station, 0)
        return True

    def _worth_waiting(self, robot: Robot, now: float) -> bool:
        """Whether a bucket stays for a while at a letter station that has nothing for it just now."""
        robot.blocked_since = min(robot.blocked_since, now)
        if now - robot.blocked_since > WAITS_S:
            return False
        return self.situation.room(robot.bucket) > KEEP_ROOM * self.situation.stock.capacity

    def _serve_on(self, robot: Robot, now: float) -> bool:
        scores = self._onward_scores.of(self._policy.onward.score(self.situation, robot), len(self.situation.docks))
        station = self._go_on(robot, scores, now)
        self._explain.choice("onward", station, scores, bot=robot.number, bucket=robot.bucket)
        return station >= 0

    def _go_on(self, robot: Robot, scores: Floats, now: float) -> int:
        """Send a bucket to the best station that has a place and a way to it; which, or -1."""
        for station in lowest(-scores, TRIES):
            if scores[station] <= 0.0:
                return -1
            slot = self._lines.slot_for(robot, station, now) if station != robot.station else -1
            if slot < 0:
                continue
            before, place = robot.purpose, self._lines.places[station][slot]
            robot.purpose = Purpose.SERVE
            is_there = self._traffic.at(robot.number) == place
            if is_there or self._go(robot, place, now):
                self._lines.unbind(robot)
                self._lines.bind(robot, station)
                self._lines.put(robot, slot)
                if is_there:
                    self._arrived(robot, now)
                return station
            robot.purpose = before
        return -1

    def _store(self, robot: Robot, now: float) -> None:
        """Put the bucket away."""
        situation = self.situation
        spots = self._places.free_spots()
        open_ = self._digging.open_spots()[spots]
        kept = self._kept_free[spots]
        spots = spots[open_ & ~kept] if (open_ & ~kept).any() else spots[open_]
        if not len(spots):
            self._later(robot, now, "no storage spot is free")
            return
        travel = self._traffic.times_from(robot.waypoint)[spots]
        costs = self._policy.storage.cost(situation, robot.bucket, spots, travel)
        costs = self._storage_costs.of(costs, len(spots)) + BURIED_S * self._digging.buried(spots)
        costs = np.where(np.isfinite(travel), costs, np.inf)
        before = robot.purpose
        robot.purpose = Purpose.STORE
        for choice in lowest(costs, TRIES):
            spot = int(spots[choice])
            if np.isfinite(costs[choice]) and self._go(robot, spot, now):
                self._lines.unbind(robot)
                self._explain.choice("storage", spot, -costs, spots, bot=robot.number, bucket=robot.bucket)
                return
        robot.purpose = before
        self._explain.choice("storage", -1, -costs, spots, bot=robot.number, bucket=robot.bucket)
        self._later(robot, now, "no way leads to a free storage spot now")

    def _park(self, robot: Robot, now: float) -> None:
        """A bot without work that stands on a lane goes under a bucket, out of the way."""
        spots = self._places.spots[self._places.taken[self._places.spots] == 0]
        under = self._places.occupied[spots]
        if self._digging.needed and under.any():
            spots = spots[under]  # beside one it would close the way to those behind
        costs = self._traffic.estimates(robot.waypoint, spots)
        for choice in lowest(costs, TRIES):
            if self._go(robot, int(spots[choice]), now, hurried=True):
                return
        self._later(robot, now, "no way leads off the lane now")

    def _fetch(self, now: float) -> None:
        """Have buckets fetched for the stations that run out of work."""
        if self._settling.over and not self._watch.unplaced:
            for fetch in self._fetching.choose(now):
                self._send_for(fetch, now)

    def _send_for(self, fetch: Fetch, now: float) -> None:
        """Have a bot fetch a bucket; where it cannot get there now, the bucket is left alone for a while."""
        robot, bucket = fetch.robot, fetch.wanted.bucket
        robot.purpose, robot.target = Purpose.FETCH, bucket
        self.situation.free_buckets[bucket] = False
        if not fetch.wanted.digs:
            self._lines.bind(robot, fetch.wanted.station)
        if not self._go(robot, int(self.situation.spot_of[bucket]), now):
            self._fetching.unreachable(bucket, now)
            self.situation.free_buckets[bucket] = True
            self._lines.unbind(robot)
            robot.purpose, robot.target = Purpose.NONE, -1

    def _free_the_way(self, robot: Robot, now: float) -> None:
        """Have a bucket moved that keeps a bot with a bucket from getting out of a block."""
        fetch = self._fetching.dig_out(robot.waypoint, now)
        if fetch is not None:
            self._send_for(fetch, now)

    def reason(self, task: Task) -> str:
        """Why a task waits; empty where something is on its way to its station."""
        if self._watch.unplaced:
            return f"{len(self._watch.unplaced)} bots have not said that they are there"
        if self.situation.closed[task.station]:
            return "a bot that does not answer stands in the line of its station"
        if not self.situation.bound[task.station]:
            if not self._has_idle:
                return "all bots are busy"
            if task.kind == STORE:
                return "no free bucket has room"
            nowhere = [tile for tile in dict.fromkeys(task.missing) if not self.situation.stock.tiles[tile].any()]
            return (
                f"no bucket holds {', '.join(map(tile_name, nowhere[:3]))}" if nowhere else "no free bucket serves it"
            )
        return ""
