"""What a bot's mind does whatever its work is: number requests, drive a route, sit out penalties, tell about itself."""

from __future__ import annotations

import math
from enum import IntEnum
from itertools import pairwise

from soup_bots.trip.waypoint_progress import corner_ahead
from soup_msgs_py.codes import Phase
from soup_msgs_py.messages import BotStatus, DriveFeedback, FollowPath, Point, Trip, TripFeedback
from soup_msgs_py.mind import NEVER, Message
from soup_msgs_py.warehouse.layout import Layout

LOOK_AGAIN_S = 20.0  # simulated: between two looks whether the body still works for a mind before
OVERDUE_S = 2.0  # simulated: so long after a path should have ended, nobody will say any more that it has


class Step(IntEnum):
    """The request that a bot is at."""

    STAND = 0
    DRIVE = 1
    GRAB = 2
    TRANSFER = 3
    RELEASE = 4


class Driver:
    """A bot that drives where it is told, and says what it is doing. `BotMind` adds what it drives for.

    Attributes:
        bot: Number of the bot.
        bucket: The bucket that it carries, -1 for none.
        phase: Which part of its work it is at.
        trip: The trip that it is on.
        route: Corners of the drive that it is on; empty when it is on none.
        stamps: When to be at each of them (s), or empty: as soon as possible.
        corner: How many of them are behind it. The crew, which senses where the bot is, counts this up.
        place: Where the world last said that it was.
        drives: Counts the drives that were begun, so that the crew notices a new one.
        next_wake: Simulated time (s) when `wake` is due.
    """

    def __init__(self, bot: int, layout: Layout, *, retry_s: float, penalty_s: float) -> None:
        """Make the mind of a bot that stands idle.

        Args:
            bot: Number of the bot.
            layout: For the names of stations.
            retry_s: Shortest pause before a refused request is tried again.
            penalty_s: How long a collision keeps the bot standing.
        """
        self.bot = bot
        self.bucket = -1
        self.phase = Phase.IDLE
        self.trip: Trip | None = None
        self.route: tuple[Point, ...] = ()
        self.stamps: tuple[float, ...] = ()
        self.corner = 0
        self.place: Point | None = None
        self.drives = 0
        self.held = False  # the next path waits for the steering's word
        self.next_wake = NEVER
        self._layout = layout
        self._retry_s = retry_s
        self._penalty_s = penalty_s
        self._step = Step.STAND
        self._request = -1  # the request under way; -1 while none is, or while the steering has the wheel
        self._last_request = -1
        self._struck = False  # stands in the penalty of a collision
        self._tries = 0
        self._moved = 0  # tiles moved during this visit
        self._visits_done = 0
        self._cancelled = False
        self._drive = -1  # number of a drive that somebody asked for
        self._note = ""  # what the trip's result should mention
        self._text = "stands idle"
        self._reason = ""  # what the bot waits for
        self._hands: dict[int, tuple[int, Message]] = {}  # request by hand -> token, request
        self._pending = False  # a request of an operation (not a drive) is with the world
        self._goes_on = False  # follows a path that a mind before this one asked for

    # ---- what the crew needs ------------------------------------------------------------------------------

    @property
    def driving(self) -> bool:
        """Whether the bot is to be steered now."""
        return self._step is Step.DRIVE and not self._struck and self.next_wake == NEVER

    def begin(self, bucket: int, now: float, *, at_work: bool = False, path: FollowPath | None = None) -> list[Message]:
        """Learn from a snapshot what the bot carries; tell everybody what it is doing.

        Args:
            bucket: What it carries, -1 for none.
            now: Simulated time (s).
            at_work: Whether its body still does what a mind before this one asked for.
            path: The path with a timetable that its body follows, or waits to begin. It goes on with it: others keep
                clear of where it says that it will be.
        """
        self.bucket = bucket
        if path is not None and self.phase is Phase.IDLE and self._step is Step.STAND:
            self.phase, self._step, self._goes_on = Phase.DRIVING, Step.DRIVE, True
            self.route, self.stamps, self._request = path.points, path.stamps, path.request
            self._text = "drives on, as it was asked before"
            # in case it is there already, and the world's reply was not heard
            self.next_wake = max(now, path.stamps[-1]) + OVERDUE_S
            return [self._status(now)]
        if at_work and self.phase is Phase.IDLE:
            self.phase = Phase.FINISHING
            self._text = "ends what it was asked for before"
            # the world tells when that is done; in case it has told already
            self.next_wake = now + LOOK_AGAIN_S
        return [self._status(now)]

    def take_wheel(self) -> None:
        """The steering drives by velocities now; the reply to the path that it replaces is of no interest."""
        self._request = -1

    def hold_back(self) -> None:
        """The path that was begun just now is not to be told to the world: the steering looks first."""
        self.held = True
        self._request = -1

    def path(self, now: float) -> FollowPath:
        """The path that is left of the drive, under a new request number."""
        self.held = False
        self._request = self._number(now)
        return FollowPath(self.bot, self._request, self.route[self.corner :], self.stamps[self.corner :])

    def path_from_here(self, now: float) -> FollowPath:
        """The same for a bot that nobody steers, and that a collision stopped: nobody has counted its corners."""
        if self.place is not None:
            self.corner = corner_ahead(self.route, self.corner, self.place)
        return self.path(now)

    def waits(self, reason: str, now: float) -> list[Message]:
        """Tell why the bot stands on its way; an empty reason: it drives again."""
        if reason == self._reason:
            return []
        self._reason = reason
        return self._tell(now)

    def collided(self, now: float) -> list[Message]:
        """A collision keeps the bot standing until the world tells that it has resumed."""
        if self._struck or self._step is Step.STAND:
            return []
        self._struck = True
        # in case the event is lost: the world refuses a try that comes too early
        self.next_wake = now + self._penalty_s + 2.0 * self._retry_s
        return self.waits("stands after a collision until its penalty is over", now)

    def _start_drive(self, points: tuple[Point, ...], now: float, stamps: tuple[float, ...] = ()) -> list[Message]:
        self.next_wake = NEVER
        self._goes_on = False
        self._step = Step.DRIVE
        self._reason = ""
        self._struck = False
        self.route, self.stamps, self.corner = points, stamps, 0
        self.drives += 1
        return [self.path(now)]

    def _stop_driving(self) -> None:
        self._goes_on = False
        self._step = Step.STAND
        self.route, self.stamps, self.corner, self.held = (), (), 0, False
        self._request = -1
        self._struck = False
        self.next_wake = NEVER

    def _number(self, now: float) -> int:
        """Request numbers grow even over a restart of the bot, so an old reply never fits a new request."""
        self._last_request = max(self._last_request + 1, int(now * 1e9))
        return self._last_request

    def _tell(self, now: float) -> list[Message]:
        said: list[Message] = [self._status(now)]
        if self.trip is not None:
            said.append(self._feedback())
        elif self._drive >= 0:
            said.append(DriveFeedback(self.bot, self._drive, self.phase, self._message, self._left_m()))
        return said

    def _left_m(self) -> float:
        """How far it is to the end of the drive (m), from where the bot was last known to be."""
        way = self.route[self.corner :]
        places = way if self.place is None else (self.place, *way)
        return sum(math.dist(here, there) for here, there in pairwise(places))

    @property
    def _current_trip(self) -> Trip:
        assert self.trip is not None
        return self.trip

    @property
    def _message(self) -> str:
        return f"{self._text}; {self._reason}" if self._reason else self._text

    def _status(self, now: float) -> BotStatus:
        points = self.route if self.stamps else ()
        return BotStatus(
            now, self.bot, self.phase, self.bucket, self.trip, self._visits_done, self._message, points, self.stamps
        )

    def _feedback(self) -> TripFeedback:
        return TripFeedback(self.bot, self._current_trip.trip, self.phase, self._visits_done, self._message)
