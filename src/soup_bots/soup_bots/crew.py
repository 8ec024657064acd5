"""Any number of bots in one process: their minds, and the steering that looks around for all of them at once.

Live a crew may be a single bot; in one process it is all of them. The minds decide what to do next; the crew keeps,
in arrays, where each driving bot is on its route, asks the steering once a sensing period, and tells the world only
what changes.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from copy import deepcopy

import numpy as np
from numpy.typing import NDArray

from soup_bots.commands import ASK, BACK, SAY, SILENT, TELL, WHEEL, what_changes
from soup_bots.senses import KnownContents, Senses
from soup_bots.steering.base import (
    BOT_ON_GOAL,
    BUCKET_IN_WAY,
    BUCKET_ON_GOAL,
    EVADES,
    FOLLOW,
    VELOCITY,
    Limits,
    Steer,
    Steering,
    SteerView,
    follow_all,
)
from soup_bots.trip.bot_mind import BotMind
from soup_bots.trip.waypoint_progress import corners_passed, room_to_start
from soup_bots.trip.yielding import free_place
from soup_msgs_py.codes import BotState, EventType
from soup_msgs_py.messages import Bots, Buckets, DriveGoal, Event, FollowPath, SetVelocities, Snapshot
from soup_msgs_py.mind import NEVER, Message
from soup_msgs_py.mistakes import Mistakes
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Layout

GOLDEN = 0.6180339887498949  # multiples of it, without their integer part, are never close
STANDING = 0.1  # share of the maximum speed below which a bot counts as standing
SAME_VELOCITY = 0.02  # share of the maximum speed by which a velocity must change to be told again
TOLD_AFTER_S = 2.0  # a bot that stands this long on its way says why
ASKS_AFTER_S = 3.0  # a bot that waits this long for an idle one asks it to make way
_MOVING, _PENALISED = int(BotState.MOVING), int(BotState.PENALISED)  # members of an enumeration compare slowly
_AT_WORK = frozenset({int(BotState.GRABBING), int(BotState.RELEASING), int(BotState.TRANSFERRING)})
IDS_OF_ALL = (EventType.BOT_COLLISION, EventType.BUCKET_COLLISION)
# the events that a crew has to hear; whatever carries its messages leaves out the others
FOR_BOTS = frozenset(
    {
        EventType.RESUMED,
        EventType.BOT_COLLISION,
        EventType.BUCKET_COLLISION,
        EventType.GRABBED,
        EventType.RELEASED,
        EventType.TRANSFERRED,
    }
)

_REACTS_TO = frozenset({EventType.RESUMED, *IDS_OF_ALL})


class Crew:
    """The minds of some bots, and their steering.

    Attributes:
        minds: The minds, by number of the bot.
        next_wake: Simulated time (s) when `wake` is due.
        sense_period_s: Simulated seconds between two calls of `sense`: a bot drives its own radius in it.
        mistakes: What its steering chose that cannot be.
        sense_offset_s: When the first call is due. Crews in different processes do not know each other's intentions;
            looking at different moments keeps them from evading to the same side for ever.
        lost: As in `Mind`: never, for events tell it no more than what befalls its bots.
    """

    lost = False

    def __init__(
        self,
        scenario: Scenario,
        layout: Layout,
        bots: Sequence[int],
        steering: Steering,
        rng: np.random.Generator,
    ) -> None:
        """Make a crew.

        Args:
            scenario: Sizes, speeds and times.
            layout: The floor.
            bots: Numbers of the bots of this crew.
            steering: How they avoid each other.
            rng: Where the steering's random draws come from.
        """
        body = scenario.bot
        self.sense_period_s = body.radius_m / body.max_speed_mps
        self.sense_offset_s = min(bots, default=0) * GOLDEN % 1.0 * self.sense_period_s
        self.next_wake = NEVER
        self._layout, self._penalty_s = layout, body.collision_penalty_s
        self.minds = {bot: self._mind(bot) for bot in bots}
        self.mistakes = Mistakes()
        self._steering = steering
        steering.rng = rng
        self._senses: Senses | None = None
        self._alone: dict[int, Steering] = {}
        if body.sensing.is_alone:
            self._senses = Senses(body.sensing, body.sensing_radius_m)
            for bot, own_rng in zip(self.minds, rng.spawn(len(self.minds)), strict=True):
                self._alone[bot] = deepcopy(steering)
                self._alone[bot].rng = own_rng
        self._contents = KnownContents(body.sensing.contents, scenario.word_station_count)
        self._limits = Limits(
            body.radius_m,
            scenario.bucket.radius_m,
            body.max_speed_mps,
            body.max_acceleration_mps2,
            body.sensing_radius_m,
            self.sense_period_s,
            layout.width_m,
            layout.height_m,
        )
        count = max(scenario.bots, max(bots, default=-1) + 1)
        self._driving = np.zeros(count, np.bool_)
        self._drivers: set[int] = set()  # the same as a set
        self._seen: Bots | None = None
        self._begun = dict.fromkeys(self.minds, 0)  # which of its drives a bot is on
        self._course = np.zeros((count, 8))  # x, y of: corner behind, next corner, corner after it, end
        self._left = np.zeros(count, np.int32)  # corners that are left
        self._mode = np.zeros(count, np.int8)
        self._command = np.zeros((count, 2))
        self._stands = np.zeros(count, np.int32)  # calls for which a steered bot has stood
        self._told = np.full(count, -1, np.int32)  # what was said about it
        self._alarms: dict[int, float] = {}
        self._say_calls = max(1, round(TOLD_AFTER_S / self.sense_period_s))
        self._ask_calls = max(self._say_calls, round(ASKS_AFTER_S / self.sense_period_s))

    def _mind(self, bot: int) -> BotMind:
        return BotMind(bot, self._layout, retry_s=self.sense_period_s, penalty_s=self._penalty_s)

    @property
    def reacts_to(self) -> frozenset[EventType]:
        """What interrupts its bots; the rest are answers to what they asked for."""
        return _REACTS_TO

    @property
    def wants_to_sense(self) -> bool:
        """Whether any bot drives, and looks around while it does."""
        return self._steering.senses and bool(self._drivers)

    # ---- messages -----------------------------------------------------------------------------------------

    def handle(self, message: Message, now: float) -> list[Message]:
        """Take in a message: for one of the bots, an event, or the snapshot. Those of other bots are ignored."""
        if isinstance(message, Event):
            if message.type in IDS_OF_ALL:
                out: list[Message] = []
                for bot in message.bots:
                    mind = self.minds.get(bot)
                    if mind is not None:
                        out += mind.handle(message, now)
                        self._look_at(mind, out, now)
                return out
            if message.type is EventType.TRANSFERRED:
                self._contents.moved(message)
        elif isinstance(message, Snapshot):
            return self._begin(message, now)
        mind = self.minds.get(message.bot)
        if mind is None:
            return []
        out = mind.handle(message, now)
        self._look_at(mind, out, now)
        return out

    def wake(self, now: float) -> list[Message]:
        """Wake the minds whose time has come."""
        out: list[Message] = []
        for bot in sorted(bot for bot, time in self._alarms.items() if time <= now):
            mind = self.minds[bot]
            out += mind.wake(now)
            self._look_at(mind, out, now)
        return out

    def kill(self, bot: int) -> list[Message]:
        """A mind dies. What its body was asked for, it still does; then it stands until there is a mind again.

        Returns:
            What those who had asked it will learn: that nobody answers any more.
        """
        dead = self.minds.pop(bot)
        self._driving[bot] = False
        self._drivers.discard(bot)
        self._alarms.pop(bot, None)
        self.next_wake = min(self._alarms.values(), default=NEVER)
        return dead.last_words("its mind is gone")

    def come_back(self, bots: Iterable[int], snapshot: Snapshot, now: float) -> list[Message]:
        """New minds take over bodies as they were in a snapshot."""
        new = {bot: self._mind(bot) for bot in bots}
        self.minds = dict(sorted((self.minds | new).items()))
        for bot, mind in new.items():
            self._begun[bot] = mind.drives
        return self._begin_all(new.values(), snapshot, now)

    def _begin(self, snapshot: Snapshot, now: float) -> list[Message]:
        self._contents.begin(snapshot)
        there = len(snapshot.bots.bucket)
        return self._begin_all([mind for bot, mind in self.minds.items() if bot < there], snapshot, now)

    def _begin_all(self, minds: Iterable[BotMind], snapshot: Snapshot, now: float) -> list[Message]:
        """Minds learn what their bodies carry and do, which may be what minds before them have asked for."""
        bodies, paths = snapshot.bots, {path.bot: path for path in snapshot.paths}
        out: list[Message] = []
        for mind in minds:
            at_work = int(bodies.state[mind.bot]) in _AT_WORK
            out += mind.begin(int(bodies.bucket[mind.bot]), now, at_work=at_work, path=paths.get(mind.bot))
            self._look_at(mind, [], now)
        return out

    def _look_at(self, mind: BotMind, out: list[Message], now: float) -> None:
        """Take over what a mind has decided, and said in `out`: a new drive, the end of one, a time to wake."""
        bot = mind.bot
        driving = mind.driving
        if driving and self._begun[bot] != mind.drives:
            self._begun[bot] = mind.drives
            if self._steering.senses:
                self._begin_drive(mind, out, now)
            elif mind.held:
                out.append(mind.path_from_here(now))
        if driving != (bot in self._drivers):
            self._driving[bot] = driving
            self._drivers ^= {bot}
        alarm = self._alarms.get(bot, NEVER)
        if mind.next_wake != alarm:
            if mind.next_wake == NEVER:
                del self._alarms[bot]
            else:
                self._alarms[bot] = mind.next_wake
            self.next_wake = min(self._alarms.values(), default=NEVER)

    def _begin_drive(self, mind: BotMind, out: list[Message], now: float) -> None:
        """Have the steering look after a new drive from now on, and before it begins where somebody is near."""
        bot = mind.bot
        if not mind.held and not self._may_start(bot, now):
            mind.hold_back()
            out[:] = [said for said in out if type(said) is not FollowPath or said.bot != bot]
        self._stands[bot] = 0
        self._told[bot] = -1
        self._command[bot] = 0.0
        self._mode[bot] = VELOCITY if mind.held else FOLLOW
        if mind.corner == 0:
            self._course[bot, 0:2] = np.nan
        self._set_course(mind)

    def _may_start(self, bot: int, now: float) -> bool:
        """Whether a bot may set off at once: nothing can touch it until the steering looks around again."""
        if not self._steering.senses:
            return True
        seen = self._seen
        if self._senses is not None or seen is None or now - seen.time > 1.5 * self.sense_period_s:
            return False
        ahead_s = now - seen.time + self.sense_period_s
        return room_to_start(bot, seen.x, seen.y, seen.vx, seen.vy, self._limits.bot_radius_m, ahead_s)

    def _set_course(self, mind: BotMind) -> None:
        route, corner = mind.route, mind.corner
        after = route[corner + 1] if corner + 1 < len(route) else route[corner]
        self._course[mind.bot, 2:8] = (*route[corner], *after, *route[-1])
        self._left[mind.bot] = len(route) - corner

    # ---- sensing ------------------------------------------------------------------------------------------

    def sense(self, bots: Bots, buckets: Buckets, now: float) -> list[Message]:
        """Look around and correct the course of the driving bots.

        Args:
            bots: All bots as they are now.
            buckets: All buckets as they are now.
            now: Simulated time (s).

        Returns:
            What changes: velocities for bots that evade, all in one message, and paths for those that are through.
        """
        out: list[Message] = []
        self._seen = bots
        if not self.wants_to_sense:
            return out
        rows = (self._driving & (bots.state <= _MOVING)).nonzero()[0]
        if len(rows) < len(self._drivers):
            self._notice_collisions(bots, now, out)
        if len(rows) == 0:
            return out
        if self._senses is None:
            steer = self._steer(rows, bots, buckets, self._steering, now)
        else:
            steer = self._steer_blind(rows, bots, buckets, self._senses, now)
        self._apply(rows, steer, bots, now, out)
        return out

    def _steer_blind(self, rows: NDArray[np.int64], bots: Bots, buckets: Buckets, senses: Senses, now: float) -> Steer:
        """Ask the steering of each bot by itself, with its own picture of the world."""
        steer = follow_all(len(rows))
        for row, bot in enumerate(rows.tolist()):
            seen = senses.bots(bot, bots)
            own = self._steer(rows[row : row + 1], seen, senses.buckets(bot, seen, buckets), self._alone[bot], now)
            steer.mode[row], steer.vx[row], steer.vy[row] = own.mode[0], own.vx[0], own.vy[0]
            steer.reason[row], steer.other[row] = own.reason[0], own.other[0]
        return steer

    def _steer(self, rows: NDArray[np.int64], bots: Bots, buckets: Buckets, steering: Steering, now: float) -> Steer:
        """Count the corners that bots have passed, and ask a steering what they should do."""
        passed = corners_passed(
            rows,
            self._course,
            self._left,
            self._mode,
            bots.x,
            bots.y,
            bots.vx,
            bots.vy,
            self._limits.bot_radius_m,
        )
        for bot in passed.tolist():
            mind = self.minds[bot]
            self._course[bot, 0:2] = mind.route[mind.corner]
            mind.corner += 1
            self._set_course(mind)
        course = self._course[rows]
        view = SteerView(
            now,
            rows,
            course[:, 2],
            course[:, 3],
            course[:, 4],
            course[:, 5],
            self._left[rows] == 1,
            course[:, 6],
            course[:, 7],
            bots.x,
            bots.y,
            bots.vx,
            bots.vy,
            bots.bucket,
            bots.state,
            buckets.x,
            buckets.y,
            buckets.bot,
            self._limits,
            bots.heading,
            self._contents.seen(buckets),
        )
        return self._checked(steering.steer(view), steering, len(rows))

    def _checked(self, steer: Steer, steering: Steering, rows: int) -> Steer:
        """What a steering decided, those without a velocity standing still."""
        if any(len(values) != rows for values in (steer.mode, steer.vx, steer.vy, steer.reason, steer.other)):
            self.mistakes.add("bot", steering, "something for other bots than it was asked for", f"not {rows}")
            return follow_all(rows)
        if not np.isfinite(steer.vx + steer.vy).all():
            wrong = ~(np.isfinite(steer.vx) & np.isfinite(steer.vy))
            first = int(wrong.argmax())
            velocity = f"({steer.vx[first]:g}, {steer.vy[first]:g}) m/s"
            self.mistakes.add("bot", steering, "a velocity that is no number", velocity)
            steer.vx = np.where(wrong, 0.0, steer.vx)
            steer.vy = np.where(wrong, 0.0, steer.vy)
        return steer

    def _apply(self, rows: NDArray[np.int64], steer: Steer, bots: Bots, now: float, out: list[Message]) -> None:
        """Tell what has changed by the steering's word."""
        todo = what_changes(
            rows, steer.mode, steer.vx, steer.vy, steer.reason, steer.other,
            self._mode, self._command, self._stands, self._told, bots.vx, bots.vy,
            SAME_VELOCITY * self._limits.max_speed_mps, STANDING * self._limits.max_speed_mps,
            self._say_calls, self._ask_calls,
        )  # fmt: skip
        at = todo.nonzero()[0]
        tell: list[int] = []
        for row, bot, what in zip(at.tolist(), rows[at].tolist(), todo[at].tolist(), strict=True):
            mind = self.minds[bot]
            if what & BACK:
                self._course[bot, 0:2] = np.nan  # the path starts here
                out.append(mind.path(now))
            if what & WHEEL:
                mind.take_wheel()
            if what & TELL:
                tell.append(row)
            if what & SILENT:
                out += mind.waits("", now)
            if what & SAY:
                other = int(steer.other[row])
                why = _REASONS[int(steer.reason[row])].format(other) if other >= 0 else "stands until the way is free"
                out += mind.waits(why, now)
            if what & ASK:
                out += self._ask_to_make_way(bot, int(steer.other[row]), bots, now)
        if tell:
            out.append(SetVelocities(rows[tell].astype(np.int32), steer.vx[tell], steer.vy[tell]))

    def _notice_collisions(self, bots: Bots, now: float, out: list[Message]) -> None:
        """A bot in its penalty knows that it has collided, should the event have been lost."""
        for bot in (self._driving & (bots.state == _PENALISED)).nonzero()[0].tolist():
            mind = self.minds[bot]
            out += mind.collided(now)
            self._look_at(mind, out, now)

    def _ask_to_make_way(self, bot: int, other: int, bots: Bots, now: float) -> list[Message]:
        """Ask the bot that stands on the goal of `bot`, or on its way, to step aside. One that is at work will not."""
        if bots.state[other] != BotState.FREE:
            return []
        if self._senses is not None:
            bots = self._senses.bots(other, bots)
        point = free_place(other, bots, self._limits)
        mind = self.minds.get(other)
        if mind is None:
            return [DriveGoal(other, int(now * 1e9), (point,))]
        out = mind.make_way((point,), f"makes way for bot {bot}", now)
        self._look_at(mind, out, now)
        return out


_REASONS = {
    EVADES: "stands until bot {0} is out of its way",
    BUCKET_IN_WAY: "stands: bucket {0} is in its way",
    BOT_ON_GOAL: "waits for bot {0}, whose turn it is at its goal",
    BUCKET_ON_GOAL: "waits: bucket {0} rests on its goal",
}
