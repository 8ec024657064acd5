"""What the fleet asks of a bot, and what the bot says of itself."""

from __future__ import annotations

from soup_msgs_py.codes import Code, Phase
from soup_msgs_py.messages.base import Point, message
from soup_msgs_py.messages.requests import TileMove


@message
class Visit:
    """One visit to a station during a trip; `route` are the corners on the way, the last one the station itself."""

    station: int
    moves: tuple[TileMove, ...]
    route: tuple[Point, ...]


@message
class Trip:
    """Fetch a bucket, visit stations, store it. Where the bot carries the bucket already, fetching is skipped.

    An empty `store_route` means: keep the bucket at the end.
    """

    trip: int
    bucket: int
    fetch_route: tuple[Point, ...]
    visits: tuple[Visit, ...]
    store_route: tuple[Point, ...]


@message
class TripGoal:
    """Ask a bot to carry a bucket through a trip."""

    bot: int
    trip: Trip


@message
class TripFeedback:
    """How far a trip has come, or what it waits for."""

    bot: int
    trip: int
    phase: Phase
    visits_done: int
    message: str


@message
class TripResult:
    """How a trip ended."""

    bot: int
    trip: int
    code: Code
    message: str


@message
class CancelTrip:
    """Ask a bot to end its trip at the next safe point."""

    bot: int
    trip: int


@message
class DriveGoal:
    """Ask a bot to drive through points and stop at the last.

    Attributes:
        bot: Whom.
        drive: Number of the drive, chosen by who asks.
        points: Where to (m).
        stamps: As in `FollowPath`.
        bucket: What it must carry, -1 for nothing, None for whatever it does: a way that was planned for a bot without
            a bucket may lead below others.
    """

    bot: int
    drive: int
    points: tuple[Point, ...]
    stamps: tuple[float, ...] = ()
    bucket: int | None = None


@message
class DriveFeedback:
    """How far a drive has come, or what it waits for; `distance_m` is still to go, through all its points."""

    bot: int
    drive: int
    phase: Phase
    message: str
    distance_m: float


@message
class DriveResult:
    """How a drive ended."""

    bot: int
    drive: int
    code: Code
    message: str


@message
class CancelDrive:
    """Ask a bot to stop driving."""

    bot: int
    drive: int


@message
class BotStatus:
    """What a bot is doing; the newest one of each bot is kept for newcomers.

    `points` and `stamps` are those of the `FollowPath` that it drives by, if that has a timetable: whoever sends bots
    about has to know where it will be when.
    """

    time: float
    bot: int
    phase: Phase
    bucket: int
    trip: Trip | None
    visits_done: int
    message: str
    points: tuple[Point, ...] = ()
    stamps: tuple[float, ...] = ()
