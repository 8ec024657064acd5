"""A fleet manager that carries out one plan for all bots, each at its own pace, and never out of order."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from soup_managers.fleets.base import Fleet
from soup_managers.fleets.planned.policies import Planned
from soup_managers.planners.precedence import Action, actions_of
from soup_managers.state.tasks import Key, Task, TaskBook
from soup_managers.view import WarehouseView
from soup_msgs_py.codes import Code, EventType, Phase
from soup_msgs_py.kinematics import run_time
from soup_msgs_py.messages import (
    Bots,
    BotStatus,
    DriveGoal,
    DriveResult,
    Event,
    Point,
    Trip,
    TripGoal,
    TripResult,
)
from soup_msgs_py.mind import NEVER, Message
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.scenario.floor_plan import CellsLayout
from soup_msgs_py.warehouse.layout import Layout

RETRY_S = 1.0  # before a bot that could not do something is asked again
RESULT_LATE_S = 2.0  # an idle bot has forgotten what it was asked for, if no result comes within that time
NEAR_M = 0.2  # of a cell: a bot is there


@dataclass
class _Order:
    """What a bot was asked for, and when (s): its actions up to, not including, `end`."""

    number: int
    end: int
    since: float


class PlannedFleet(Fleet[Task]):
    """Carries out the plan of a `Planned` policy in a world of cells.

    A new one makes the same plan, waits until all bots stand, and finds out by where they are, and where the buckets
    are, how far each has come.
    """

    def __init__(self, scenario: Scenario, layout: Layout, policy: Planned, view: WarehouseView) -> None:
        """Make the plan.

        Raises:
            InputError: There is no plan.
            RunError: No plan was found.
        """
        super().__init__(view, TaskBook(Task))
        assert isinstance(scenario.layout, CellsLayout), "looked at by `check_fleet`"
        self._stalled: dict[int, str] = {}
        self._layout = layout
        self._world = scenario.layout.world
        self._actions = actions_of(self._world, policy.plan(self._world))
        self._waypoint = {cell: waypoint for waypoint, cell in enumerate(self._world.open_cells)}
        body = scenario.bot
        self._move_s = run_time(scenario.layout.pitch_m, body.max_speed_mps, body.max_acceleration_mps2)
        self._done = [0] * len(self._actions)
        self._orders: dict[int, _Order] = {}
        self._number = 0
        self._status: dict[int, BotStatus] = {}
        self._rests: dict[int, float] = {}  # bots that are not to be asked before a time
        self._doubted: dict[int, float] = {}  # bots that stand though they were asked, and until when to believe it
        self._lost: dict[int, int] = {}  # bots that did not do all they were asked for, and the end of that
        self._at_work = False  # whether it is known how far the bots have come
        self._handlers |= {
            DriveResult: self._handle_result,
            TripResult: self._handle_result,
            Bots: self._handle_bots,
        }

    @property
    def stalled(self) -> dict[int, str]:
        """Bots that could not do what the plan says, and why."""
        return self._stalled

    @property
    def reacts_to(self) -> frozenset[EventType]:
        """Nothing: bots tell what they have done."""
        return frozenset()

    @property
    def wants_places(self) -> bool:
        """Whether it has to see where bots stand."""
        if not self.view.ready:
            return False
        return any(map(self._stands, self._lost)) if self._at_work else self._all_stand()

    @property
    def is_done(self) -> bool:
        """Whether all bots have done all that the plan says."""
        return self._at_work and all(
            done == len(actions) for done, actions in zip(self._done, self._actions, strict=True)
        )

    def reason(self, task: Task) -> str:
        """Nobody works for it."""
        return "this fleet carries out a plan, and serves no stations"

    def bots_of(self) -> dict[Key, tuple[int, ...]]:
        """None."""
        return {}

    def wake(self, now: float) -> list[Message]:
        """Ask bots again."""
        for bot in [bot for bot, until in self._rests.items() if until <= now]:
            del self._rests[bot]
        for bot in [bot for bot, until in self._doubted.items() if until <= now]:
            del self._doubted[bot]
            self._lose(bot, "forgot what it was asked for", now)
        return self.step(now)

    def take_over(self, now: float) -> None:
        """Find out anew how far the bots have come."""
        self._at_work = False
        for books in (self._orders, self._rests, self._doubted, self._lost):
            books.clear()

    def on_event(self, event: Event, now: float) -> list[Message]:
        """Nothing; see `reacts_to`."""
        return []

    # ---- messages ------------------------------------------------------------------------------------------

    def on_status(self, status: BotStatus, now: float) -> list[Message]:
        """A bot stands, or is at work."""
        bot = status.bot
        self._status[bot] = status
        order = self._orders.get(bot)
        if order is not None and self._stands(bot) and status.time > order.since:
            self._doubted.setdefault(bot, now + RESULT_LATE_S)
        else:
            self._doubted.pop(bot, None)
        return self.step(now)

    def _handle_result(self, result: DriveResult | TripResult, now: float) -> list[Message]:
        number = result.drive if isinstance(result, DriveResult) else result.trip
        bot, order = result.bot, self._orders.get(result.bot)
        if order is None or order.number != number:
            return []
        if result.code is Code.DONE:
            del self._orders[bot]
            self._doubted.pop(bot, None)
            self._done[bot] = order.end
            self._stalled.pop(bot, None)
        else:
            self._lose(bot, result.message, now)
        return self.step(now)

    def _lose(self, bot: int, why: str, now: float) -> None:
        """A bot has not done what it was asked for, or not all of it."""
        self._lost[bot] = self._orders.pop(bot).end
        self._rests[bot] = now + RETRY_S
        self._stalled[bot] = why

    def _handle_bots(self, bots: Bots, now: float) -> list[Message]:
        if not self.wants_places:
            return []
        self.view.observe(bots)
        if not self._at_work:
            if bots.time < max(status.time for status in self._status.values()):
                return []
            self._done = [self._how_far(bot) for bot in range(len(self._actions))]
            self._at_work = True
        for bot in [bot for bot in self._lost if self._stands(bot) and bots.time >= self._status[bot].time]:
            self._done[bot] = self._along(bot, self._done[bot], self._lost.pop(bot))
        return self.step(now)

    # ---- what follows --------------------------------------------------------------------------------------

    def _stands(self, bot: int) -> bool:
        status = self._status.get(bot)
        return status is not None and status.phase is Phase.IDLE and status.trip is None

    def _all_stand(self) -> bool:
        return all(map(self._stands, range(len(self._actions))))

    def _how_far(self, bot: int) -> int:
        """How many of its actions a bot has done, by where it is and which buckets it has moved.

        Where it was in the same cell twice meanwhile, it counts as there for the first time: it goes round again,
        which costs time and nobody the right of way.
        """
        actions, view = self._actions[bot], self.view
        done = 0
        for place, action in enumerate(actions):
            if action.box < 0:
                continue
            spot = view.spot_of[action.box] if view.bot_bucket[bot] != action.box else -1
            starts = self._waypoint[self._world.boxes[action.box]]
            if (spot == starts) if action.picks else (spot != self._waypoint[action.there]):
                break
            done = place + 1
        ends = next((k for k in range(done, len(actions)) if not actions[k].moves), len(actions))
        return self._along(bot, done, ends)

    def _along(self, bot: int, done: int, end: int) -> int:
        """How many of its actions a bot has done that stands where some of those from `done` to `end` lead.

        Between two cells it has not come to the second one.
        """
        actions = self._actions[bot][done:end]
        if not actions or not actions[0].moves:
            return done
        x, y = float(self.view.bot_x[bot]), float(self.view.bot_y[bot])
        cells = [self._place(cell) for cell in (actions[0].here, *(action.there for action in actions))]
        for index, (cx, cy) in enumerate(cells):
            if abs(x - cx) <= NEAR_M and abs(y - cy) <= NEAR_M:
                return done + index
        # ways between cells are straight along one axis: how much longer they are over the bot
        detours = [abs(x - ax) + abs(y - ay) + abs(x - bx) + abs(y - by) for (ax, ay), (bx, by) in pairwise(cells)]
        return done + detours.index(min(detours))

    def _place(self, cell: int) -> Point:
        x, y = self._layout.waypoints[self._waypoint[cell]]
        return float(x), float(y)

    def _may_begin(self, action: Action) -> bool:
        return action.after is None or self._done[action.after[0]] > action.after[1]

    def step(self, now: float) -> list[Message]:
        """Ask all bots that stand for what they can do next."""
        said = self.tell_tasks(list(self.book.tasks.values()))
        if self._at_work and not self.view.lost:
            for bot, actions in enumerate(self._actions):
                if not self._is_free(bot):
                    continue
                place = self._done[bot] = self._past_what_is_done(bot)
                if place == len(actions) or not self._may_begin(actions[place]):
                    continue
                if actions[place].ring:
                    said += self._turn(actions[place], now)
                elif actions[place].moves:
                    said.append(self._drive(bot, place, now))
                else:
                    said.append(self._handle_box(bot, place, now))
        self.next_wake = min([*self._rests.values(), *self._doubted.values()], default=NEVER)
        return said

    def _is_free(self, bot: int) -> bool:
        busy = bot in self._orders or bot in self._rests or bot in self._lost
        return not busy and self._stands(bot)

    def _past_what_is_done(self, bot: int) -> int:
        """The bot's next action: a box that it has already picked up or dropped, unnoticed, is done."""
        actions, place = self._actions[bot], self._done[bot]
        if place < len(actions) and not actions[place].moves:
            has_it = self._status[bot].bucket == actions[place].box
            place += has_it == actions[place].picks
        return place

    def _drive(self, bot: int, place: int, now: float) -> DriveGoal:
        """On through all cells that are free already, but not past one that somebody waits for."""
        actions, end = self._actions[bot], place + 1
        while end < len(actions) and not actions[end - 1].awaited:
            action = actions[end]
            if not action.moves or action.ring or not self._may_begin(action):
                break
            end += 1
        points = tuple(self._place(action.there) for action in actions[place:end])
        return DriveGoal(bot, self._ask(bot, end, now), points)

    def _handle_box(self, bot: int, place: int, now: float) -> TripGoal:
        """Pick up or drop a box, where the bot stands."""
        action = self._actions[bot][place]
        number = self._ask(bot, place + 1, now)
        store = () if action.picks else (self._place(action.here),)
        return TripGoal(bot, Trip(number, action.box, (), (), store))

    def _turn(self, action: Action, now: float) -> list[Message]:
        """Bots move into each other's cells, all at once, as soon as all of them can."""
        ring = {bot: self._done[bot] for bot in action.ring}
        for bot, place in ring.items():
            actions = self._actions[bot]
            if place == len(actions) or actions[place].step != action.step or not self._is_free(bot):
                return []
        said: list[Message] = []
        for bot, place in ring.items():
            points = tuple(
                self._place(cell) for cell in (self._actions[bot][place].here, self._actions[bot][place].there)
            )
            number = self._ask(bot, place + 1, now)
            said.append(DriveGoal(bot, number, points, (now, now + self._move_s)))
        return said

    def _ask(self, bot: int, end: int, now: float) -> int:
        """The number of a new order; numbers grow even over a restart of the manager."""
        self._number = max(self._number + 1, int(now * 1000))
        self._orders[bot] = _Order(self._number, end, now)
        return self._number
