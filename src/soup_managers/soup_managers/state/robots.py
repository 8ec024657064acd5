"""What the fleet knows of each bot: where it stands or goes to, and what for. The record alone changes itself."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

from soup_msgs_py.mind import NEVER


class Purpose(Enum):
    """What a bot drives for."""

    NONE = "none"
    FETCH = "fetch"
    SERVE = "serve"
    STORE = "store"
    PARK = "park"


class Activity(Enum):
    """What a bot does now."""

    UNKNOWN = "unknown"  # it has not told yet
    AWAY = "away"  # something went wrong, or nobody answers for it
    STANDS = "stands"
    DRIVES = "drives"
    WORKS = "works"  # grabs, releases, moves tiles


@dataclass(slots=True, eq=False)
class Robot:
    """One bot in the fleet's books.

    Attributes:
        number: Of the bot.
        waypoint: Where it stands or, while it drives, where it will stand.
        bucket: The bucket that it carries, -1 for none.
        purpose: What it is for now.
        target: The bucket that it is to fetch, -1 for none.
        station: The station that it is bound for, -1 for none.
        slot: Its place in that station's line: 0 is the dock; -1 for none yet.
        order: The number of the drive or trip that it was asked for last.
        arrives: When its drive ends (s).
        asked_at: When it was asked for that (s).
        blocked_since: Since when it has waited for a way to its station (s).
        retry_at: When a way that could not be planned is tried again (s).
        failed_at: When it last told that something went wrong (s).
        adopted: Whether it is on a drive that an earlier fleet asked it for.
        note: What it waits for, for people.
    """

    number: int
    waypoint: int = -1
    bucket: int = -1
    activity: Activity = Activity.UNKNOWN
    purpose: Purpose = Purpose.NONE
    target: int = -1
    station: int = -1
    slot: int = -1
    order: int = -1
    arrives: float = 0.0
    asked_at: float = 0.0
    blocked_since: float = NEVER
    retry_at: float = 0.0
    failed_at: float = 0.0
    adopted: bool = False
    note: str = field(default="")

    @property
    def load(self) -> int:
        """The bucket that it carries, or is to fetch."""
        return self.bucket if self.bucket >= 0 else self.target

    # ---- what it is for --------------------------------------------------------------------------------------

    def is_for(self, purpose: Purpose, target: int = -1) -> None:
        """It has something to do; `target` is the bucket that it is to fetch."""
        self.purpose, self.target = purpose, target

    def has_nothing_to_do(self) -> None:
        """It is for nothing now."""
        self.purpose, self.target = Purpose.NONE, -1

    def takes_place(self, station: int, slot: int) -> None:
        """It is bound for a station, -1 for none, and has a place in its line, -1 for none."""
        self.station, self.slot = station, slot

    # ---- legs and operations ---------------------------------------------------------------------------------

    def sent(self, goal: int, arrives: float) -> None:
        """It is on its way to a waypoint."""
        self.activity, self.waypoint, self.arrives = Activity.DRIVES, goal, arrives
        self.note, self.blocked_since = "", NEVER

    def asked(self, order: int, now: float) -> None:
        """It was asked for a drive or a trip."""
        self.order, self.asked_at = order, now

    def arrived(self) -> None:
        """It stands where it was to go."""
        self.activity = Activity.STANDS

    def works(self) -> None:
        """It lifts, sets down or serves."""
        self.activity = Activity.WORKS

    def lifted(self) -> None:
        """It has the bucket that it was to fetch."""
        self.bucket, self.target = self.target, -1
        self.purpose = Purpose.SERVE if self.station >= 0 else Purpose.NONE

    def set_down(self) -> None:
        """It has set its bucket down."""
        self.bucket, self.purpose = -1, Purpose.NONE

    # ---- waiting ---------------------------------------------------------------------------------------------

    def waits(self, why: str, retry_at: float) -> None:
        """What it is to do is not possible now; it is tried again."""
        self.note, self.retry_at = why, retry_at

    def may_retry(self, now: float) -> None:
        """What was not possible may be tried at once."""
        self.retry_at = min(self.retry_at, now)

    def blocked(self, now: float) -> float:
        """It cannot get on with its station; for how long already (s)."""
        self.blocked_since = min(self.blocked_since, now)
        return now - self.blocked_since

    def unblocked(self) -> None:
        """It gets on."""
        self.blocked_since = NEVER

    # ---- what goes wrong, and what an earlier fleet has begun ------------------------------------------------

    def is_lost(self, now: float) -> None:
        """It is left alone until it says that it is idle, and is seen where it stands."""
        self.activity, self.failed_at = Activity.AWAY, now

    def not_seen_before(self, time: float) -> None:
        """Where it was seen until a time (s), it may not be any more."""
        self.failed_at = max(self.failed_at, time)

    def failed(self, why: str, retry_at: float) -> None:
        """What it was asked for went wrong."""
        self.has_nothing_to_do()
        self.waits(why, retry_at)

    def stops_here(self, now: float) -> None:
        """Its drive is over before its end."""
        self.arrives = now

    def found(self, bucket: int, waypoint: int) -> None:
        """It is seen where it stands, with a bucket or, -1, without."""
        self.bucket, self.waypoint, self.adopted = bucket, waypoint, False
        self.has_nothing_to_do()

    def adopted_on(self, goal: int, bucket: int, arrives: float) -> None:
        """It is on a drive that an earlier fleet asked it for."""
        self.activity, self.waypoint, self.bucket, self.arrives = Activity.DRIVES, goal, bucket, arrives
        self.drives_for_nobody()

    def drives_for_nobody(self) -> None:
        """The drive that it is on is no order of this fleet, which does not hear how it ends."""
        self.adopted, self.order, self.asked_at = True, -1, NEVER

    def ended_adopted(self, bucket: int) -> None:
        """The drive of an earlier fleet has ended."""
        self.adopted, self.bucket = False, bucket

    def lifts(self, bucket: int) -> None:
        """It is found lifting a bucket."""
        self.bucket = -1
        self.is_for(Purpose.FETCH, bucket)
