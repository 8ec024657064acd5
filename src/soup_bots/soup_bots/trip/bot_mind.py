"""The mind of one bucketbot: a state machine that carries out trips, drives and requests by hand.

A trip is a chain of steps; each step is one request to the world and ends with its reply:

    drive fetch_route -> grab -> (drive route -> transfer) for each visit -> drive store_route -> release

A step that fails for a reason that passes (a collision, a station that is busy) is tried again; any other reason
ends the trip. Whatever the bot waits for stands in the message of its status.
"""

from __future__ import annotations

from dataclasses import dataclass

from soup_bots.trip.driver import LOOK_AGAIN_S, Driver, Step
from soup_msgs_py.codes import Code, EventType, Phase
from soup_msgs_py.messages import (
    BotReply,
    CancelDrive,
    CancelTrip,
    DriveGoal,
    DriveResult,
    Event,
    Grab,
    Point,
    Release,
    SetVelocity,
    Transfer,
    TripGoal,
    TripResult,
)
from soup_msgs_py.mind import NEVER, Message

PASSES = frozenset({Code.BUSY, Code.MOVING, Code.BLOCKED})
STRUCK = frozenset({Code.COLLIDED, Code.PENALISED})
TILES_REFUSED = frozenset({Code.NOT_NEEDED, Code.NOT_IN_BUCKET, Code.BUCKET_FULL, Code.NOTHING_STAGED})
APPROACHES = 3  # how often a point is driven to before "out of tolerance" is believed
SLOWEST_RETRY = 4  # times the retry period: the longest pause between two tries


@dataclass(frozen=True, slots=True)
class ByHandReply:
    """The answer to a request by hand; `token` is the request number that the shell gave (-1: a velocity)."""

    token: int
    reply: BotReply


class BotMind(Driver):
    """One bucketbot's mind: see `Driver` for its attributes."""

    def make_way(self, points: tuple[Point, ...], reason: str, now: float) -> list[Message]:
        """Step aside for another bot, if there is nothing else to do. The bot stays free for a trip."""
        if self.phase is not Phase.IDLE or self._step is not Step.STAND or self._struck:
            return []
        self._text = reason
        return [*self._start_drive(points, now), self._status(now)]

    def last_words(self, why: str) -> list[Message]:
        """How everything ends that the bot was asked for and has not done, when it goes."""
        out = self._end_drive(Code.STOPPED, why)
        if self.trip is not None:
            out.append(TripResult(self.bot, self.trip.trip, Code.STOPPED, why))
        return out

    # ---- messages -----------------------------------------------------------------------------------------

    def handle(self, message: Message, now: float) -> list[Message]:
        """Take in a message for this bot; see `soup_msgs_py.mind.Mind`."""
        return _HANDLERS[type(message)](self, message, now)

    def wake(self, now: float) -> list[Message]:
        """Try again what was refused, or what a collision interrupted."""
        self.next_wake = NEVER
        if self._goes_on:
            return self._idle(now)
        if self.phase is Phase.FINISHING:
            self.next_wake = now + LOOK_AGAIN_S
            self._request = self._number(now)
            return [Transfer(self.bot, self._request, -1, ())]  # nothing; a body at work refuses even that as busy
        self._struck = False
        return self._try_again(now)

    def _on_trip_goal(self, goal: TripGoal, now: float) -> list[Message]:
        trip = goal.trip
        if self.trip is not None and self.trip.trip == trip.trip:
            return [self._feedback()]
        code, why = Code.BUSY, self._why_busy()
        if not why and self.bucket not in (-1, trip.bucket):
            code, why = (
                Code.INVALID,
                f"carries bucket {self.bucket} already; it can only go on a trip with that one",
            )
        if why:
            return [TripResult(self.bot, trip.trip, code, f"bot {self.bot} {why}")]
        self.trip = trip
        self._visits_done, self._note, self._cancelled = 0, "", False
        if self.bucket == trip.bucket:
            return self._next_visit(now)
        self.phase = Phase.FETCHING
        return self._drive_then(Step.GRAB, trip.fetch_route, f"drives to bucket {trip.bucket}", now)

    def _on_cancel_trip(self, cancel: CancelTrip, now: float) -> list[Message]:
        if self.trip is None or self.trip.trip != cancel.trip:
            return []
        if self._pending:
            self._cancelled = True
            self._reason = "the trip ends as soon as this is done"
            return self._tell(now)
        stop = [SetVelocity(self.bot, 0.0, 0.0)] if self._step is Step.DRIVE else []
        return [*stop, *self._end_trip(Code.CANCELLED, "cancelled", now)]

    def _on_drive_goal(self, goal: DriveGoal, now: float) -> list[Message]:
        why = self._why_busy(drives_too=False)
        if why:
            return [DriveResult(self.bot, goal.drive, Code.BUSY, f"bot {self.bot} {why}")]
        if not goal.points:
            return [DriveResult(self.bot, goal.drive, Code.INVALID, "no point to drive to")]
        if goal.bucket not in (None, self.bucket):
            loads = [f"bucket {bucket}" if bucket >= 0 else "nothing" for bucket in (self.bucket, goal.bucket)]
            why = f"bot {self.bot} carries {loads[0]}, the way is for one that carries {loads[1]}"
            return [DriveResult(self.bot, goal.drive, Code.INVALID, why)]
        out = self._end_drive(Code.REPLACED, f"replaced by drive {goal.drive}")
        self._drive = goal.drive
        self.phase = Phase.DRIVING
        x, y = goal.points[-1]
        self._text = f"drives to ({x:.1f}, {y:.1f})"
        return [*out, *self._start_drive(goal.points, now, goal.stamps), *self._tell(now)]

    def _on_cancel_drive(self, cancel: CancelDrive, now: float) -> list[Message]:
        if self._drive < 0 or self._drive != cancel.drive:
            return self._tell(now)  # whoever asks is wrong about this bot
        return [
            SetVelocity(self.bot, 0.0, 0.0),
            *self._end_drive(Code.CANCELLED, "cancelled"),
            *self._idle(now),
        ]

    def _on_hand(self, request: Grab | Release | Transfer, now: float) -> list[Message]:
        why = self._why_busy()
        if why:
            return [self._refuse_hand(request.request, f"bot {self.bot} {why}", now)]
        number = self._number(now)
        self._hands[number] = (request.request, request)
        self._stop_driving()
        self.phase = Phase.BY_HAND
        self._text = f"is told by hand to {type(request).__name__.lower()}"
        match request:
            case Grab():
                forwarded: Message = Grab(self.bot, number, request.bucket)
            case Release():
                forwarded = Release(self.bot, number)
            case Transfer():
                forwarded = Transfer(self.bot, number, request.station, request.moves)
        return [forwarded, *self._tell(now)]

    def _on_velocity(self, request: SetVelocity, now: float) -> list[Message]:
        if self.trip is not None or self.phase is Phase.FINISHING:
            return [self._refuse_hand(-1, f"bot {self.bot} {self._why_busy()}", now)]
        out: list[Message] = [
            request,
            *self._end_drive(Code.REPLACED, "replaced by a velocity that was set by hand"),
        ]
        self._stop_driving()
        if self._hands:
            return out
        moves = request.vx != 0.0 or request.vy != 0.0 or request.turn_radps != 0.0
        if moves and self.phase is not Phase.BY_HAND:
            self.phase = Phase.BY_HAND
            self._text = "is driven by hand"
            return [*out, *self._tell(now)]
        return out if moves else [*out, *self._idle(now)]

    def _on_event(self, event: Event, now: float) -> list[Message]:
        match event.type:
            case EventType.RESUMED:
                if not self._struck:
                    return []
                return self.wake(now)
            case EventType.BOT_COLLISION | EventType.BUCKET_COLLISION:
                # a path answers for itself; a bot under the steering's velocities has no request that could
                return self.collided(now) if self._request < 0 else []
            case EventType.GRABBED:
                self.bucket = event.bucket
            case EventType.RELEASED:
                self.bucket = -1
            case EventType.TRANSFERRED:
                self._moved += 1
        return []

    def _on_reply(self, reply: BotReply, now: float) -> list[Message]:
        self.place = reply.x, reply.y
        if reply.request in self._hands:
            return self._on_hand_reply(reply, now)
        if self.phase is Phase.FINISHING:
            still = reply.request == self._request and reply.code is Code.BUSY
            return [] if still else self._idle(now)
        if self._request < 0 or reply.request != self._request:
            return []
        self._request = -1
        self._pending = False
        code = reply.code
        if self._cancelled and self._step is not Step.DRIVE:
            self._learn_bucket(reply)
            return self._end_trip(Code.CANCELLED, "cancelled", now)
        if code in STRUCK and not self._timed:
            return self.collided(now)
        if code in PASSES and not self._timed:
            self._tries += 1
            self.next_wake = now + self._retry_s * min(self._tries, SLOWEST_RETRY)
            return self.waits(f"tries again: {reply.message}", now)
        self._learn_bucket(reply)
        if self._step is Step.DRIVE:
            return self._drive_ended(reply, now)
        if code is Code.OUT_OF_TOLERANCE and self._tries < APPROACHES - 1:
            self._tries += 1
            return self._approach_again(now)
        if self._step is Step.TRANSFER and code in TILES_REFUSED:
            visit = self._current_trip.visits[self._visits_done]
            self._note += f"; {self._layout.station_name(visit.station)}: {reply.message or code.value}"
        elif code is not Code.DONE:
            return self._end_trip(code, reply.message or code.value, now)
        return self._step_done(now)

    # ---- steps --------------------------------------------------------------------------------------------

    def _step_done(self, now: float) -> list[Message]:
        if self._step is Step.GRAB:
            return self._next_visit(now)
        if self._step is Step.TRANSFER:
            self._visits_done += 1
            return self._next_visit(now)
        return self._end_trip(Code.DONE, f"trip {self._current_trip.trip} is done{self._note}", now)

    def _next_visit(self, now: float) -> list[Message]:
        trip = self._current_trip
        if self._visits_done < len(trip.visits):
            visit = trip.visits[self._visits_done]
            self.phase = Phase.VISITING
            self._moved = 0
            name = self._layout.station_name(visit.station)
            return self._drive_then(Step.TRANSFER, visit.route, f"drives to {name}", now)
        if not trip.store_route:
            return self._end_trip(Code.DONE, f"trip {trip.trip} is done, keeps the bucket{self._note}", now)
        self.phase = Phase.STORING
        x, y = trip.store_route[-1]
        return self._drive_then(
            Step.RELEASE, trip.store_route, f"drives to the storage spot at ({x:.1f}, {y:.1f})", now
        )

    def _drive_then(self, operation: Step, points: tuple[Point, ...], text: str, now: float) -> list[Message]:
        self._tries = 0
        if not points:
            return self._operate(operation, now)
        self._text = text
        self._reason = ""
        return [*self._start_drive(points, now), *self._tell(now)]

    @property
    def _timed(self) -> bool:
        """Whether it drives by a timetable: late is worse than not at all, because others rely on its times."""
        return self._step is Step.DRIVE and bool(self.stamps)

    def _drive_ended(self, reply: BotReply, now: float) -> list[Message]:
        done = reply.code is Code.DONE
        if self.trip is None:
            out = self._end_drive(reply.code, "is there" if done else reply.message)
            return [*out, *self._idle(now)]
        if not done:
            return self._end_trip(reply.code, reply.message or "another command moved the bot", now)
        return self._operate(_OPERATION[self.phase], now)

    def _operate(self, operation: Step, now: float) -> list[Message]:
        self._stop_driving()
        trip = self._current_trip
        self._step = operation
        self._pending = True
        self._reason = ""
        self._request = number = self._number(now)
        if operation is Step.GRAB:
            request: Message = Grab(self.bot, number, trip.bucket)
            self._text = f"grabs bucket {trip.bucket}"
        elif operation is Step.RELEASE:
            request = Release(self.bot, number)
            self._text = f"releases bucket {trip.bucket}"
        else:
            visit = trip.visits[self._visits_done]
            moves = visit.moves[self._moved :]
            if not moves:
                self._pending, self._request = False, -1
                return self._step_done(now)
            request = Transfer(self.bot, number, visit.station, moves)
            self._text = f"moves {len(moves)} tiles at {self._layout.station_name(visit.station)}"
        return [request, *self._tell(now)]

    def _approach_again(self, now: float) -> list[Message]:
        trip = self._current_trip
        if self._step is Step.GRAB:
            route = trip.fetch_route
        elif self._step is Step.RELEASE:
            route = trip.store_route
        else:
            route = trip.visits[self._visits_done].route
        if not route:
            return self._end_trip(Code.OUT_OF_TOLERANCE, "the bot is not there, and has no route", now)
        self._text = "drives to the point again, it was out of tolerance"
        return [*self._start_drive(route[-1:], now), *self._tell(now)]

    def _try_again(self, now: float) -> list[Message]:
        out = self.waits("", now)
        if self._step is Step.DRIVE:
            # what it ran into is still there: the steering has to look before the bot moves
            self.held = True
            self.drives += 1
            return out
        if self._step is Step.STAND:
            return out
        return [*out, *self._operate(self._step, now)]

    # ---- ends ---------------------------------------------------------------------------------------------

    def _end_trip(self, code: Code, message: str, now: float) -> list[Message]:
        result = TripResult(self.bot, self._current_trip.trip, code, message)
        self.trip = None
        self._cancelled = False
        return [result, *self._idle(now)]

    def _end_drive(self, code: Code, message: str) -> list[Message]:
        if self._drive < 0:
            return []
        number, self._drive = self._drive, -1
        return [DriveResult(self.bot, number, code, message)]

    def _idle(self, now: float) -> list[Message]:
        self._stop_driving()
        self._pending = False
        self.phase = Phase.IDLE
        self._visits_done = 0
        self._text = "stands idle" if self.bucket < 0 else f"stands idle with bucket {self.bucket}"
        self._reason = ""
        return [self._status(now)]

    # ---- by hand ------------------------------------------------------------------------------------------

    def _why_busy(self, *, drives_too: bool = True) -> str:
        if self.trip is not None:
            return f"is on trip {self.trip.trip}; cancel it first"
        if self._drive >= 0 and drives_too:
            return f"is on drive {self._drive}; cancel it first"
        if self._goes_on and drives_too:
            return "ends the drive that it was on before it was started again"
        if self.phase is Phase.FINISHING:
            return "ends what it was asked for before it was started again"
        if self.phase is Phase.BY_HAND:
            return "is driven by hand; set its velocity to zero first"
        return ""

    def _refuse_hand(self, token: int, why: str, now: float) -> ByHandReply:
        # the mind does not know where the bot is; nan is no place
        return ByHandReply(token, BotReply(self.bot, token, Code.BUSY, why, now, float("nan"), float("nan")))

    def _on_hand_reply(self, reply: BotReply, now: float) -> list[Message]:
        token, request = self._hands.pop(reply.request)
        if reply.code is Code.DONE:
            if isinstance(request, Grab) and request.bucket >= 0:
                self.bucket = request.bucket
            elif isinstance(request, Release):
                self.bucket = -1
        out: list[Message] = [ByHandReply(token, reply)]
        return out if self._hands else [*out, *self._idle(now)]

    # ---- small things -------------------------------------------------------------------------------------

    def _learn_bucket(self, reply: BotReply) -> None:
        if reply.code is Code.DONE:
            if self._step is Step.GRAB:
                self.bucket = self._current_trip.bucket
            elif self._step is Step.RELEASE:
                self.bucket = -1


_OPERATION = {Phase.FETCHING: Step.GRAB, Phase.VISITING: Step.TRANSFER, Phase.STORING: Step.RELEASE}
_HANDLERS = {
    TripGoal: BotMind._on_trip_goal,
    CancelTrip: BotMind._on_cancel_trip,
    DriveGoal: BotMind._on_drive_goal,
    CancelDrive: BotMind._on_cancel_drive,
    Grab: BotMind._on_hand,
    Release: BotMind._on_hand,
    Transfer: BotMind._on_hand,
    SetVelocity: BotMind._on_velocity,
    Event: BotMind._on_event,
    BotReply: BotMind._on_reply,
}
