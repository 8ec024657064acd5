"""What bots and managers ask of the world, and what it answers."""

from __future__ import annotations

from soup_msgs_py.codes import Code
from soup_msgs_py.messages.base import Floats, Ints, Point, message, message_of_arrays


@message
class SetVelocity:
    """Make (vx, vy) the bot's target velocity (equations 1 to 5) until another motion command comes.

    A standing bot turns at `turn_radps` when the target velocity is zero.
    """

    bot: int
    vx: float
    vy: float
    turn_radps: float = 0.0


@message_of_arrays
class SetVelocities:
    """`SetVelocity` for many bots at once; arrays of one shape (n,)."""

    bots: Ints
    vx: Floats
    vy: Floats


@message
class FollowPath:
    """Drive through `points`, stopping where the direction changes and at the last one (equation 6).

    `stamps`, one a point, are the times to be there, or empty: as soon as possible. A point that cannot be
    reached in time is reached as soon as possible. Where the first point is the bot's own place, the first stamp is
    its departure: a path that comes after it is refused as late, because others rely on its times.
    Answered by a `BotReply` when the last point is reached.
    """

    bot: int
    request: int
    points: tuple[Point, ...]
    stamps: tuple[float, ...] = ()


@message
class Grab:
    """Lift the bucket (-1: the one that is here)."""

    bot: int
    request: int
    bucket: int = -1


@message
class Release:
    """Set the carried bucket down on the storage spot that is here."""

    bot: int
    request: int


@message
class TileMove:
    """One letter tile to move between a carried bucket and a station: its kind, and the word or bundle (-1: any)."""

    tile: int = -1
    job: int = -1


@message
class Transfer:
    """Move letter tiles between the carried bucket and the station (-1: the one that is here), one after another."""

    bot: int
    request: int
    station: int = -1
    moves: tuple[TileMove, ...] = (TileMove(),)


@message
class BotReply:
    """How a bot's request ended, when, and where the bot was."""

    bot: int
    request: int
    code: Code
    message: str
    time: float
    x: float
    y: float

    @property
    def success(self) -> bool:
        """Whether the request was carried out."""
        return self.code is Code.DONE


@message
class AssignWord:
    """Open a waiting word on a word station."""

    word: int
    station: int


@message
class AssignBundle:
    """Stage a bundle on a letter station: one that has arrived (`bundle`), or a new one of a kind (`tile`)."""

    station: int
    bundle: int = -1
    tile: int = -1


@message
class SetStorageSpot:
    """Turn a waypoint into a storage spot, or a free storage spot into a plain waypoint."""

    waypoint: int
    storage: bool


@message
class Reply:
    """The world's answer to a manager: `number` is the bundle that was staged, if one was."""

    code: Code
    message: str
    number: int = -1

    @property
    def success(self) -> bool:
        """Whether the request was carried out."""
        return self.code is Code.DONE
