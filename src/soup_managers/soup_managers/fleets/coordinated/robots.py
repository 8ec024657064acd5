"""What the fleet knows of each bot: where it stands or goes to, and what for."""

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
