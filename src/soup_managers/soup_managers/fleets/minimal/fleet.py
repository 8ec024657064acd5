"""The fleet manager (the paper's bucketbot manager): has the bots do what the other managers ask for."""

from __future__ import annotations

import numpy as np

from soup_managers.bitset import members
from soup_managers.explain import Explain
from soup_managers.fleets.minimal.letters import Task, common_tiles, goal_tiles
from soup_managers.fleets.minimal.plan_check import check_plan
from soup_managers.fleets.minimal.state import FleetState
from soup_managers.manager import Manager
from soup_managers.plans import Key, PlanError, TripPlan
from soup_managers.policies.fleet import FleetPolicy
from soup_managers.router import Router
from soup_managers.view import WarehouseView
from soup_msgs_py.codes import Code, EventType, Phase
from soup_msgs_py.layout import Layout
from soup_msgs_py.messages import (
    DELIVER,
    STORE,
    Bots,
    BotStatus,
    CancelTask,
    CancelTrip,
    DeliverGoal,
    Event,
    StoreGoal,
    TaskFeedback,
    TaskResult,
    TaskState,
    TripGoal,
    TripResult,
)
from soup_msgs_py.mind import NEVER, Message
from soup_msgs_py.scenario import Scenario

REST_S = 1.0  # a bot whose trip failed is not asked again sooner
GATHER_S = 1.0  # how long a new fleet manager waits for all bots to say which trips they are on
RESULT_LATE_S = 2.0  # a bot that is idle for so long has forgotten its trip


class FleetManager(Manager):
    """Keeps the tasks of the fleet and the promises of its trips, and has its policy plan trips.

    It owns nothing durable: a new one finds the world in the snapshot, the trips under way in the statuses of
    the bots, and its tasks in the goals that their managers send again.

    Attributes:
        wants_places: It does not: where bots stand is in their statuses.
    """

    wants_places = False

    def __init__(
        self,
        scenario: Scenario,
        layout: Layout,
        policy: FleetPolicy,
        view: WarehouseView,
        rng: np.random.Generator,
        router: Router | None = None,
        explain: Explain | None = None,
    ) -> None:
        super().__init__(view)
        self._layout = layout
        self._policy = policy
        self._explain = explain or Explain()
        self._fleet = FleetState(scenario, layout, view, router or Router(layout), rng)
        self._book = self._fleet.book
        self._trips_asked = 0
        self._status: dict[int, BotStatus] = {}
        self._ended: dict[int, int] = {}  # the last trip of each bot that ended
        self._resting: dict[int, float] = {}  # bots that are not to be asked before a time
        self._doubted: dict[int, float] = {}  # bots idle on a trip, and when the trip counts as forgotten
        self._early: list[Message] = []  # what came before the first snapshot
        self._started = False
        self._gather_until = NEVER
        self._handlers |= {
            DeliverGoal: self._handle_goal,
            StoreGoal: self._handle_goal,
            CancelTask: self._handle_cancel,
            BotStatus: self._handle_status,
            TripResult: self._handle_trip_result,
            Bots: self._handle_bots,
        }

    @property
    def stalled(self) -> dict[int, str]:
        """Bots that say that they are idle though they are on a trip."""
        return dict.fromkeys(sorted(self._doubted), "does not answer")

    def tasks(self) -> tuple[TaskState, ...]:
        """The fleet's list of tasks, in the order of their arrival."""
        bots: dict[Key, list[int]] = {}
        for bot, active in self._fleet.trips.items():
            for key in dict.fromkeys(letter.key for letter in active.letters):
                bots.setdefault(key, []).append(bot)
        return tuple(
            [
                TaskState(
                    task.number,
                    task.kind,
                    task.station,
                    task.job,
                    tuple(task.missing),
                    tuple(sorted(bots.get(task.key, ()))),
                    self._reason(task),
                )
                for task in self._book.tasks.values()
            ]
        )

    def wake(self, now: float) -> list[Message]:
        """Look again at bots that rested, results that never came and events that are late."""
        for bot in [bot for bot, until in self._doubted.items() if until <= now]:
            del self._doubted[bot]
            self._end_trip(bot, False, now)
        for bot in [bot for bot, until in self._resting.items() if until <= now]:
            del self._resting[bot]
            self._settle(bot)
        return self._act(now)

    def on_world(self, now: float) -> list[Message]:
        """Take over what came before the snapshot; after a gap, correct all tasks by what is there."""
        self._fleet.router.set_storage_spots(self.view.storage_spots)
        if not self._started:
            self._started = True
            self._gather_until = now + GATHER_S
        # what bots do comes first: it may be what the goals ask for
        early = sorted(self._early, key=lambda message: not isinstance(message, BotStatus))
        self._early = []
        said = [answer for message in early for answer in self.handle(message, now)]
        for task in list(self._book.tasks.values()):
            left = self._lacking(task.kind, task.job, task.station)
            if left is not None:
                self._book.set_missing(task, common_tiles(task.missing, left), self.view.sequence)
            elif task.kind == STORE or task.job not in self.view.waiting_words:
                self._book.set_missing(task, (), self.view.sequence)
        for bot in sorted(self._status):
            self._settle(bot)
        return said + self._act(now)

    def on_event(self, event: Event, now: float) -> list[Message]:
        """Transfers bring tasks forward, and buckets that are set down can be used again."""
        kind = event.type
        if kind is EventType.TRANSFERRED:
            self._fleet.moved(event)
        elif kind is EventType.RELEASED:
            if self._fleet.free_bots >> event.bot & 1:
                self._settle(event.bot)  # its status came before the event that says where it stands
            self._fleet.bucket_freed(event.bucket)
        elif kind is EventType.WORD_COMPLETED or kind is EventType.BUNDLE_EMPTIED:
            task = self._book.tasks.get((DELIVER if kind is EventType.WORD_COMPLETED else STORE, event.job))
            if task is None:
                return []
            self._book.set_missing(task, (), event.sequence)
        elif kind is EventType.SPOT_MADE or kind is EventType.SPOT_REMOVED:
            self._fleet.router.set_storage_spots(self.view.storage_spots)
        else:
            return []
        return self._act(now)

    # ---- messages ------------------------------------------------------------------------------------------

    def _handle_goal(self, goal: DeliverGoal | StoreGoal, now: float) -> list[Message]:
        if not self.view.ready:
            self._early.append(goal)
            kind = DELIVER if isinstance(goal, DeliverGoal) else STORE
            return [TaskFeedback(kind, goal.task, goal_tiles(goal), "the fleet waits for a snapshot of the world")]
        kind, job = (DELIVER, goal.word) if isinstance(goal, DeliverGoal) else (STORE, goal.bundle)
        left = self._lacking(kind, job, goal.station)
        if left is None and not (kind == DELIVER and job in self.view.waiting_words):
            what = f"word {job} is not open" if kind == DELIVER else f"bundle {job} is not staged"
            return [
                TaskResult(kind, goal.task, Code.UNKNOWN, f"{what} on station {goal.station}"),
                *self._act(now),
            ]
        said: list[Message] = []
        known = self._book.numbered(kind, goal.task)
        other = self._book.tasks.get((kind, job))
        if other is not None and other is not known:
            said.append(TaskResult(kind, other.number, Code.REPLACED, f"task {goal.task} asks for the same"))
            self._book.remove(other.key)
        if known is not None:
            self._book.remove(known.key)
        missing = list(goal_tiles(goal)) if left is None else common_tiles(goal_tiles(goal), left)
        self._book.accept(Task(kind, goal.task, goal.station, job, missing, self.view.sequence))
        return said + self._act(now)

    def _handle_cancel(self, cancel: CancelTask, now: float) -> list[Message]:
        task = self._book.numbered(cancel.kind, cancel.task)
        if task is None:
            text = f"the fleet has no {cancel.kind} task {cancel.task}"
            return [TaskResult(cancel.kind, cancel.task, Code.UNKNOWN, text)]
        self._book.remove(task.key)
        said: list[Message] = [TaskResult(task.kind, task.number, Code.CANCELLED, "taken back")]
        for bot, active in self._fleet.trips.items():
            if active.letters and all(letter.key == task.key for letter in active.letters):
                said.append(CancelTrip(bot, active.trip.trip))
        return said + self._act(now)

    def _handle_status(self, status: BotStatus, now: float) -> list[Message]:
        if not self.view.ready:
            self._early.append(status)
            return []
        bot = status.bot
        self._status[bot] = status
        active = self._fleet.trips.get(bot)
        self._doubted.pop(bot, None)
        if status.trip is not None:
            self._trips_asked = max(self._trips_asked, status.trip.trip + 1)
            if active is not None:
                return []
            if status.trip.trip != self._ended.get(bot):
                self._fleet.adopt(status)
        elif active is not None and status.phase is Phase.IDLE and status.time > active.since:
            self._doubted[bot] = now + RESULT_LATE_S
        self._settle(bot)
        return self._act(now)

    def _handle_trip_result(self, result: TripResult, now: float) -> list[Message]:
        active = self._fleet.trips.get(result.bot)
        if active is None or active.trip.trip != result.trip:
            return []
        self._end_trip(result.bot, result.code is Code.DONE, now)
        return self._act(now)

    def _handle_bots(self, bots: Bots, now: float) -> list[Message]:
        if self.view.ready:
            self.view.observe(bots)
            for bot in members(self._fleet.free_bots):
                self._settle(bot)
        return []

    # ---- what follows --------------------------------------------------------------------------------------

    def _lacking(self, kind: str, job: int, station: int) -> tuple[int, ...] | None:
        """The tiles that a word or bundle on a station still needs moved; None where there is no such one."""
        if kind == DELIVER:
            word = self.view.open_words.get(job)
            return word.missing if word is not None and word.station == station else None
        bundle = self.view.staged_bundles.get(job)
        return (bundle.tile,) * bundle.count if bundle is not None and bundle.station == station else None

    def _end_trip(self, bot: int, done: bool, now: float) -> None:
        self._ended[bot] = self._fleet.trips[bot].trip.trip
        self._doubted.pop(bot, None)
        self._fleet.end(bot, done, now)
        if not done:
            self._resting[bot] = now + REST_S
        self._settle(bot)

    def _settle(self, bot: int) -> None:
        """Make a bot available if it is known to be idle, and not otherwise."""
        status = self._status.get(bot)
        if status is None or status.phase is not Phase.IDLE or status.trip is not None or bot in self._fleet.trips:
            self._fleet.leave(bot)
        else:
            self._fleet.stand(bot, status.bucket, available=bot not in self._resting)

    def _act(self, now: float) -> list[Message]:
        """Start trips, tell managers what changed about their tasks, and set the alarm."""
        said: list[Message] = []
        fleet = self._fleet
        late = fleet.expire(now)
        knows_all = now >= self._gather_until or len(self._status) >= len(self.view.bot_bucket)
        if self.view.ready and not self.view.lost and knows_all:
            if (fleet.free_bots or fleet.loaded_bots) and self._book.queue:
                for plan in self._policy.plan(fleet):
                    self._check(plan)
                    if not self._start(plan, now, said):
                        for letter in (letter for visit in plan.visits for letter in visit.letters):
                            fleet.defer(letter, f"no way leads to {self._layout.station_name(letter.station)}")
            for bot in members(fleet.loaded_bots):
                self._store(bot, now, said)
            said += fleet.wishes
            fleet.wishes.clear()
        if self._book.changed:
            self._tell(said)
        self.next_wake = late if knows_all else min(late, self._gather_until)
        if self._resting or self._doubted:
            self.next_wake = min([self.next_wake, *self._resting.values(), *self._doubted.values()])
        return said

    def _check(self, plan: TripPlan) -> None:
        try:
            check_plan(plan, self._fleet)
        except PlanError as error:
            raise PlanError(
                f"fleet policy {type(self._policy).__name__} planned a trip that cannot be: {error}"
            ) from error

    def _start(self, plan: TripPlan, now: float, said: list[Message]) -> bool:
        trip = self._fleet.start(plan, self._trips_asked, now)
        if trip is None:
            return False
        self._trips_asked += 1
        said.append(TripGoal(plan.bot, trip))
        self._explain.now = now
        station = plan.visits[0].station if plan.visits else -1
        self._explain.choice("trips", plan.bucket, np.zeros(0), bot=plan.bot, station=station, spot=plan.spot)
        return True

    def _store(self, bot: int, now: float, said: list[Message]) -> None:
        """Have an idle bot put its bucket where it came from, or on the nearest free spot."""
        view, fleet = self.view, self._fleet
        bucket = self._status[bot].bucket
        spot = view.spot_of[bucket]
        if spot < 0 or not fleet.is_free_spot(spot):
            spot = fleet.nearest_free_spot(float(view.bot_x[bot]), float(view.bot_y[bot]))
        if spot < 0 or not self._start(TripPlan(bot, bucket, (), spot), now, said):
            self._resting[bot] = now + REST_S
            self._settle(bot)

    def _tell(self, said: list[Message]) -> None:
        changed = list(self._book.changed.values())
        self._book.changed.clear()
        for task in changed:
            if not task.missing:
                self._book.remove(task.key)
                said.append(TaskResult(task.kind, task.number, Code.DONE, "all letters are in place"))
                continue
            told = len(task.missing), self._reason(task)
            if told != task.told:
                task.told = told
                said.append(TaskFeedback(task.kind, task.number, tuple(task.missing), told[1]))

    def _reason(self, task: Task) -> str:
        reason = self._book.reason(task)
        if reason and len(self._status) < len(self.view.bot_bucket) and not self._fleet.trips:
            return f"only {len(self._status)} of {len(self.view.bot_bucket)} bots have said that they are there"
        return reason
