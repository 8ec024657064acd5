"""The fleet that plans whole trips by its policy, each with the letters that it promises to move."""

from __future__ import annotations

import numpy as np

from soup_managers.explain import Explain
from soup_managers.fleets.base import Fleet
from soup_managers.fleets.minimal.letters import LetterTask
from soup_managers.fleets.minimal.plan_check import check_plan
from soup_managers.fleets.minimal.plans import Key, PlanError, TripPlan
from soup_managers.fleets.minimal.policies import FleetPolicy
from soup_managers.fleets.minimal.state import FleetState
from soup_managers.kernels.bitset import members
from soup_managers.traffic.router import Router
from soup_managers.view import WarehouseView
from soup_msgs_py.codes import Code, EventType, Phase
from soup_msgs_py.messages import (
    Bots,
    BotStatus,
    CancelTrip,
    Event,
    TripGoal,
    TripResult,
)
from soup_msgs_py.mind import NEVER, Message
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Layout

REST_S = 1.0  # a bot whose trip failed is not asked again sooner
GATHER_S = 1.0  # how long a new fleet manager waits for all bots to say which trips they are on
RESULT_LATE_S = 2.0  # a bot that is idle for so long has forgotten its trip


class TripFleet(Fleet[LetterTask]):
    """Keeps the promises of the fleet's trips, and has its policy plan them."""

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
        self._layout = layout
        self._policy = policy
        self._explain = explain or Explain()
        self._fleet = FleetState(scenario, layout, view, router or Router(layout), rng)
        self._letters = self._fleet.book
        super().__init__(view, self._letters)
        self._trips_asked = 0
        self._status: dict[int, BotStatus] = {}
        self._ended: dict[int, int] = {}  # the last trip of each bot that ended
        self._resting: dict[int, float] = {}  # bots that are not to be asked before a time
        self._doubted: dict[int, float] = {}  # bots idle on a trip, and when the trip counts as forgotten
        self._started = False
        self._gather_until = NEVER
        self._handlers |= {TripResult: self._handle_trip_result, Bots: self._handle_bots}

    @property
    def stalled(self) -> dict[int, str]:
        """Bots that say that they are idle though they are on a trip."""
        return dict.fromkeys(sorted(self._doubted), "does not answer")

    def bots_of(self) -> dict[Key, tuple[int, ...]]:
        """The bots on trips for each task."""
        bots: dict[Key, set[int]] = {}
        for bot, active in self._fleet.trips.items():
            for letter in active.letters:
                bots.setdefault(letter.key, set()).add(bot)
        return {key: tuple(sorted(on)) for key, on in bots.items()}

    def wake(self, now: float) -> list[Message]:
        """Look again at bots that rested, results that never came and events that are late."""
        for bot in [bot for bot, until in self._doubted.items() if until <= now]:
            del self._doubted[bot]
            self._end_trip(bot, False, now)
        for bot in [bot for bot, until in self._resting.items() if until <= now]:
            del self._resting[bot]
            self._settle(bot)
        return self.step(now)

    def take_over(self, now: float) -> None:
        """Learn anew which storage spots there are, and where bots stand."""
        self._fleet.router.set_storage_spots(self.view.storage_spots)
        if not self._started:
            self._started = True
            self._gather_until = now + GATHER_S
        for bot in sorted(self._status):
            self._settle(bot)

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
            task = self.completed(event)
            if task is None:
                return []
            self._letters.set_missing(task, (), event.sequence)
        elif kind is EventType.WORD_ASSIGNED:
            return self.opened(event, now)
        elif kind is EventType.SPOT_MADE or kind is EventType.SPOT_REMOVED:
            self._fleet.router.set_storage_spots(self.view.storage_spots)
        else:
            return []
        return self.step(now)

    # ---- messages ------------------------------------------------------------------------------------------

    def on_cancel(self, task: LetterTask) -> list[Message]:
        """Trips that are for this task alone are not needed."""
        return [
            CancelTrip(bot, active.trip.trip)
            for bot, active in self._fleet.trips.items()
            if active.letters and all(letter.key == task.key for letter in active.letters)
        ]

    def on_status(self, status: BotStatus, now: float) -> list[Message]:
        """A bot is on a trip, or stands."""
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
        return self.step(now)

    def _handle_trip_result(self, result: TripResult, now: float) -> list[Message]:
        active = self._fleet.trips.get(result.bot)
        if active is None or active.trip.trip != result.trip:
            return []
        self._end_trip(result.bot, result.code is Code.DONE, now)
        return self.step(now)

    def _handle_bots(self, bots: Bots, now: float) -> list[Message]:
        if self.view.ready:
            self.view.observe(bots)
            for bot in members(self._fleet.free_bots):
                self._settle(bot)
        return []

    # ---- what follows --------------------------------------------------------------------------------------

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

    def step(self, now: float) -> list[Message]:
        """Start trips, tell managers what changed about their tasks, and set the alarm."""
        said: list[Message] = []
        fleet = self._fleet
        late = fleet.expire(now)
        knows_all = now >= self._gather_until or len(self._status) >= len(self.view.bot_bucket)
        if self.view.ready and not self.view.lost and knows_all:
            if (fleet.free_bots or fleet.loaded_bots) and self._letters.queue:
                for plan in self._policy.plan(fleet):
                    self._check(plan)
                    if not self._start(plan, now, said):
                        for letter in (letter for visit in plan.visits for letter in visit.letters):
                            fleet.defer(letter, f"no way leads to {self._layout.station_name(letter.station)}")
            for bot in members(fleet.loaded_bots):
                self._store(bot, now, said)
            said += fleet.wishes
            fleet.wishes.clear()
        if self._letters.changed:
            changed = list(self._letters.changed.values())
            self._letters.changed.clear()
            said += self.tell_tasks(changed)
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
        spot = int(view.spot_of[bucket])
        if spot < 0 or not fleet.is_free_spot(spot):
            spot = fleet.nearest_free_spot(float(view.bot_x[bot]), float(view.bot_y[bot]))
        if spot < 0 or not self._start(TripPlan(bot, bucket, (), spot), now, said):
            self._resting[bot] = now + REST_S
            self._settle(bot)

    def reason(self, task: LetterTask) -> str:
        """Why a task waits; empty where all its letters are on their way."""
        reason = self._letters.reason(task)
        if reason and len(self._status) < len(self.view.bot_bucket) and not self._fleet.trips:
            return f"only {len(self._status)} of {len(self.view.bot_bucket)} bots have said that they are there"
        return reason
