"""The coordinated fleet, the default (`best.yaml`): it works leg by leg on the reservation table of the traffic.

Nothing is promised before it has to be: a bot is bound to a bucket and a station, but which letters are moved is
settled when the bucket is docked, and where the bucket goes next when it is done there. Each leg is one drive on
reserved ways, each operation at its end one trip without a way::

    fetch -> (dock queue of the station) -> dock: tiles until it serves no more -> another station | storage spot

The rooms: `moves` sends bots and keeps those that wait, `docking` moves the dock queues up, `dispatch` decides what is
next, `recovery` knows where bots stand when something went wrong, `liveness` who does not answer, and `startup_barrier`
and `take_over` how a fleet begins that others were before.
"""

from __future__ import annotations

import numpy as np

from soup_managers.explain import Explain
from soup_managers.fleets.base import Fleet
from soup_managers.fleets.coordinated.digging import Digging
from soup_managers.fleets.coordinated.dispatch import Dispatch
from soup_managers.fleets.coordinated.dock_queues import DockQueues
from soup_managers.fleets.coordinated.docking import Docking
from soup_managers.fleets.coordinated.liveness import Liveness
from soup_managers.fleets.coordinated.moves import Moves
from soup_managers.fleets.coordinated.orders import Orders
from soup_managers.fleets.coordinated.policies import Coordinated
from soup_managers.fleets.coordinated.recovery import Recovery
from soup_managers.fleets.coordinated.startup_barrier import StartupBarrier
from soup_managers.fleets.coordinated.take_over import drives_on, stays
from soup_managers.state.planning_state import PlanningState
from soup_managers.state.robots import Activity, Purpose, Robot
from soup_managers.state.tasks import Key, Task
from soup_managers.traffic import Traffic
from soup_managers.view import WarehouseView
from soup_msgs_py.codes import Code, EventType, Phase
from soup_msgs_py.messages import (
    DELIVER,
    STORE,
    BotGone,
    Bots,
    BotStatus,
    Bound,
    DriveResult,
    Event,
    TripResult,
)
from soup_msgs_py.mind import NEVER, Message
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Layout
from soup_msgs_py.warehouse.tiles import tile_name

TICK_S = 1.0  # between two looks at all stations
NEARLY_ALL = 0.9  # tasks: some words may only just have been opened
_REACTS_TO = frozenset({EventType.WORD_COMPLETED, EventType.BUNDLE_EMPTIED})
_WITH_GOALS_AHEAD = _REACTS_TO | {EventType.WORD_ASSIGNED}


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
        """Begin with a world that is not heard of yet.

        Args:
            scenario: The warehouse.
            layout: Its floor.
            policy: The decisions.
            view: The warehouse as the world tells it.
            rng: For all random draws of the policy.
            explain: Is told its decisions.
        """
        self._explain = explain or Explain()
        self._traffic = traffic = Traffic(scenario, layout)
        self.state = state = PlanningState(view, traffic, policy.horizons, rng)
        super().__init__(view, state.tasks)
        self._orders = orders = Orders()
        self._barrier = barrier = StartupBarrier()
        self._queues = queues = DockQueues(state, traffic.lines)
        self._liveness = liveness = Liveness(state.robots)
        digging = Digging(layout, state.places)
        self._recovery = Recovery(state, queues, liveness, orders)
        self._moves = moves = Moves(state, queues, liveness, self._recovery, barrier, orders)
        self._docking = Docking(state, digging, queues, moves)
        self._dispatch = Dispatch(
            state, policy, queues, barrier, moves, self._docking, digging, self._explain, self.mistakes
        )
        self._told: dict[int, BotStatus] = {}  # bots that say that they stand or work, and are still to be seen there
        self._tick = NEVER
        self._has_idle = True  # whether bots had no work when all stations were looked at last
        self._handlers |= {
            BotGone: self._handle_gone,
            TripResult: self._handle_result,
            DriveResult: self._handle_result,
            Bots: self._handle_bots,
        }

    # ---- what it says of itself ------------------------------------------------------------------------------

    @property
    def stalled(self) -> dict[int, str]:
        """Bots that are left alone until they answer and are seen where they stand, and what went wrong."""
        return {bot: robot.note for bot, robot in sorted(self._liveness.lost.items())}

    @property
    def reacts_to(self) -> frozenset[EventType]:
        """The ends of its tasks; all else it learns from who does it."""
        return _WITH_GOALS_AHEAD if self._ahead else _REACTS_TO

    @property
    def wants_places(self) -> bool:
        """Whether it has to see where bots stand."""
        return bool(self._told) or self._liveness.wants_places

    def bots_of(self) -> dict[Key, tuple[int, ...]]:
        """The bots that are bound for the station of each task."""
        bound = [tuple(robot.number for robot in robots) for robots in self.state.bound]
        return {key: bound[task.station] for key, task in self.book.tasks.items()}

    def reason(self, task: Task) -> str:
        """Why a task waits; empty where something is on its way to its station."""
        if self._liveness.unplaced:
            return f"{len(self._liveness.unplaced)} bots have not said that they are there"
        if self.state.closed[task.station]:
            return "a bot that does not answer stands in the line of its station"
        if self.state.bound[task.station]:
            return ""
        if not self._has_idle:
            return "all bots are busy"
        if task.kind == STORE:
            return "no free bucket has room"
        nowhere = [tile for tile in dict.fromkeys(task.missing) if not self.state.stock.tiles[tile].any()]
        return f"no bucket holds {', '.join(map(tile_name, nowhere[:3]))}" if nowhere else "no free bucket serves it"

    # ---- time ------------------------------------------------------------------------------------------------

    def wake(self, now: float) -> list[Message]:
        """Look after all stations, and try again what was not possible."""
        if not self.view.ready or self.view.lost:
            self._tick = self.next_wake = now + TICK_S
            return []
        for robot in self._liveness.deaf(now):
            self._recovery.does_not_stop(robot, now)
        for robot in self._liveness.overdue(now):
            self._recovery.overdue(robot, now)
        if now < self._tick:
            return self.step(now)
        self._tick = now + TICK_S
        self._begin_when_possible(now)
        self._find_again(now)
        self._recovery.ask_silent(now)
        for robot in self._moves.due(now):
            self._moves.stop_waiting(robot)  # one before it may have had it sent away
            if robot.purpose is Purpose.PARK and robot.activity is Activity.STANDS:
                self._dispatch.park(robot, now)
            else:
                self._moves.resume(robot)
            self._dispatch.free_the_way(robot, now)
        self._traffic.forget_before(now)
        self._explain.now = now
        self._fetch(now)
        said = self.step(now)
        self._has_idle = bool(self.state.idle_bots())
        return said + self.tell_tasks(list(self.book.tasks.values()))

    def step(self, now: float) -> list[Message]:
        """Decide what is to be decided, and say it."""
        self._explain.now = now
        self._begin_when_possible(now)
        undecided, moved = self._moves.undecided, self._queues.moved
        while undecided or moved:
            if undecided:
                self._dispatch.onward(undecided.pop(0), now)
            else:
                station = min(moved)
                moved.discard(station)
                self._docking.move_up(station, now)
        self._set_alarm()
        said = self._orders.take()
        if self._queues.bound_changed:
            self._queues.bound_changed = False
            bound = [(r.load, station) for station, robots in enumerate(self.state.bound) for r in robots]
            said.append(Bound(now, tuple([b for b, _ in bound]), tuple([s for _, s in bound])))
        return said

    def _set_alarm(self) -> None:
        self.next_wake = min(self._tick, self._liveness.next_time)

    def _fetch(self, now: float) -> None:
        if self._barrier.over and not self._liveness.unplaced:
            self._dispatch.fetch(now)

    def _begin_when_possible(self, now: float) -> None:
        """Look whether bots may be sent about by now; then all do what they have waited with."""
        if self._barrier.look(bool(self._liveness.unplaced), self._has_all_tasks, now):
            self._moves.all_may_retry(now)

    def _has_all_tasks(self) -> bool:
        """Whether nearly all words and bundles that are on stations are in tasks, and some are."""
        tasks, view = self.book.tasks, self.view
        words = [word for word, opened in view.open_words.items() if opened.missing]
        keys = [*((DELIVER, word) for word in words), *((STORE, bundle) for bundle in view.staged_bundles)]
        return bool(keys) and sum(key in tasks for key in keys) >= NEARLY_ALL * len(keys)

    # ---- the world -------------------------------------------------------------------------------------------

    def take_over(self, now: float) -> None:
        """Begin with what the view knows now."""
        self._barrier.begin(now)
        self.state.take_over()
        self._tick = now + TICK_S

    def on_event(self, event: Event, now: float) -> list[Message]:
        """Tiles were moved, words opened and completed, bundles emptied; bots collided."""
        kind, state = event.type, self.state
        if kind is EventType.TRANSFERRED:
            delivered = event.station < state.word_stations
            state.tasks.moved((DELIVER if delivered else STORE, event.job), event.tile)
            state.changed(event.station)
        elif kind is EventType.WORD_ASSIGNED:
            return self.opened(event, now)
        elif kind is EventType.WORD_COMPLETED or kind is EventType.BUNDLE_EMPTIED:
            task = self.completed(event)
            return [self.end(task)] if task is not None else []
        elif kind is EventType.BOT_COLLISION or kind is EventType.BUCKET_COLLISION:
            self._liveness.collided(event.bots, now)
        return []

    def on_goal(self, task: Task) -> None:
        """The bucket at the dock may serve it."""
        docked = self._queues.at(task.station, 0)
        if docked is not None and docked.activity is Activity.STANDS:
            self._moves.undecided.append(docked)

    # ---- the bots --------------------------------------------------------------------------------------------

    def on_status(self, status: BotStatus, now: float) -> list[Message]:
        """A bot may be seen for the first time, or drive for somebody else."""
        robot = self.state.robots[status.bot]
        self._liveness.heard(status, now)
        if status.trip is not None:
            self._orders.heard(status.trip.trip)
        self._set_alarm()
        stands, is_new = status.phase is Phase.IDLE, robot.activity is Activity.UNKNOWN
        self._told.pop(status.bot, None)
        if stands and robot.activity is Activity.AWAY:
            robot.not_seen_before(status.time)
        if drives_on(status) and (is_new or self._recovery.drives_for_another(robot, status, now)):
            self._recovery.adopt_drive(robot, status)
            return self.step(now)
        if (is_new and (stands or stays(status))) or (stands and robot.adopted):
            self._told[robot.number] = status
            return self._enter(now)
        return []

    def _handle_gone(self, gone: BotGone, now: float) -> list[Message]:
        """A bot that stands has nobody who could say so; one that was asked for something fails that anyway."""
        robot = self.state.robots[gone.bot]
        self._liveness.gone(gone.bot)
        if robot.activity is not Activity.STANDS:
            return []
        self._recovery.failed(robot, Code.STOPPED, f"nobody answers for bot {gone.bot}", True, now)
        return self.step(now)

    def _handle_bots(self, bots: Bots, now: float) -> list[Message]:
        if not self.view.ready:
            return []
        self.view.observe(bots)
        for bot, robot in self._liveness.lost.items():
            if bots.vx[bot] != 0.0 or bots.vy[bot] != 0.0:
                robot.not_seen_before(float(np.nextafter(bots.time, np.inf)))  # to be seen again, at rest
        in_the_way = self._liveness.struck(bots.time)
        for robot in in_the_way:
            self._recovery.struck(robot, now)
        if self._liveness.unplaced:
            places = list(zip(bots.x.tolist(), bots.y.tolist(), strict=True))
            dead = self._liveness.dead(places, bots.time)
            for robot in dead:
                self._recovery.stands_in_the_way(robot, now)
            in_the_way += dead
        said = self.step(now) if in_the_way else []  # those who are to stop have to hear it now
        return said + self._enter(now) if self._told else said

    def _handle_result(self, result: DriveResult | TripResult, now: float) -> list[Message]:
        robot = self.state.robots[result.bot]
        drive = isinstance(result, DriveResult)
        number = result.drive if isinstance(result, DriveResult) else result.trip
        if robot.activity is not (Activity.DRIVES if drive else Activity.WORKS) or robot.order != number:
            return []
        began = self._liveness.ended(robot)
        if result.code is not Code.DONE or robot.number in self._recovery.halted:
            self._recovery.failed(robot, result.code, result.message, began, now)
        elif drive:
            self._moves.arrived(robot, now)
        else:
            self._moves.worked(robot)
        return self.step(now)

    def _enter(self, now: float) -> list[Message]:
        """Enter the bots that have told that they stand, and were seen since: where they were before, they drove."""
        seen = [bot for bot, status in self._told.items() if status.time <= self.view.seen_at]
        for bot in seen:
            status, robot = self._told.pop(bot), self.state.robots[bot]
            if robot.adopted:
                if self._recovery.end_adopted(robot, status, now):
                    self._moves.arrived(robot, now)
            elif robot.activity is Activity.UNKNOWN:
                self._liveness.placed(bot)
                if status.trip is not None:
                    self._recovery.adopt_trip(robot, status.trip, status.bucket, now)
                elif status.phase is Phase.IDLE:
                    self._can_be_used(robot, status.bucket, now)
                    self._queues.keep(robot)
                else:
                    self._recovery.stands_in_the_way(robot, now)
        if not seen:
            return []
        if not self._liveness.unplaced:
            self._fetch(now)
        return self.step(now)

    def _find_again(self, now: float) -> None:
        """Bots that went wrong can be used again from where they are seen to stand."""
        found = self._liveness.found(now, self.view.seen_at)
        for robot in found:
            self._can_be_used(robot, int(self.view.bot_bucket[robot.number]), now)
        if found:
            self._recovery.note_closed()

    def _can_be_used(self, robot: Robot, bucket: int, now: float) -> None:
        """A bot has told that it stands idle: it can be used from where it is."""
        self._recovery.stands(robot, bucket, now)
        robot.arrived()
        if bucket >= 0:
            self._moves.undecided.append(robot)
        elif self._dispatch.needs_parking(robot):
            robot.is_for(Purpose.PARK)
            self._moves.later(robot, now, "")
