"""What the parts of the warehouse say to each other: frozen dataclasses, the same in one process and on the wire.

Times are simulated seconds, positions metres in frame `map` (x right, y up), angles radians. A number that means
nothing in a message is -1. Tile kinds are numbered as in `tiles`, stations as in `layout`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from soup_msgs_py.codes import Code, EventType, Phase
from soup_msgs_py.mail import Counts
from soup_msgs_py.message import message, message_of_arrays

Point = tuple[float, float]
DELIVER = "deliver"
STORE = "store"
Floats = NDArray[np.float64]
Ints = NDArray[np.int32]


# ---- what a bot asks of the world -----------------------------------------------------------------------------


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


# ---- what managers ask of the world ---------------------------------------------------------------------------


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


# ---- what the world tells -------------------------------------------------------------------------------------


@message
class Event:
    """One thing that happened. `sequence` counts up by one an event, without gaps."""

    time: float
    sequence: int
    type: EventType
    bot: int = -1
    bucket: int = -1
    station: int = -1
    tile: int = -1
    job: int = -1
    count: int = -1
    x: float = -1.0
    y: float = -1.0
    bots: tuple[int, ...] = ()
    buckets: tuple[int, ...] = ()
    tiles: tuple[int, ...] = ()
    text: str = ""
    waypoint: int = -1


@message
class Word:
    """A word on order. `filled` says which of its letters are in place; it is empty while the word waits."""

    word: int
    text: str
    tiles: tuple[int, ...]
    filled: tuple[bool, ...] = ()

    @property
    def missing(self) -> tuple[int, ...]:
        """Tile kinds that are still to come, in the order of the letters."""
        if not self.filled:
            return self.tiles
        return tuple(tile for tile, there in zip(self.tiles, self.filled, strict=True) if not there)


@message
class Bundle:
    """A bundle of `count` like letter tiles."""

    bundle: int
    tile: int
    count: int


@message
class WordStationState:
    """A word station, the bot that it serves (-1: none) and its open words."""

    station: int
    x: float
    y: float
    bot: int
    open_words: tuple[Word, ...]


@message
class LetterStationState:
    """A letter station, the bot that it serves (-1: none) and its staged bundles."""

    station: int
    x: float
    y: float
    bot: int
    staged_bundles: tuple[Bundle, ...]


@message_of_arrays
class Bots:
    """Bodies of all bots at one instant; element i belongs to bot i, shape (bots,)."""

    time: float
    x: Floats
    y: Floats
    heading: Floats
    vx: Floats
    vy: Floats
    bucket: Ints
    state: NDArray[np.uint8]


@message_of_arrays
class Buckets:
    """All buckets at one instant; element i belongs to bucket i, shape (buckets,)."""

    time: float
    x: Floats
    y: Floats
    bot: Ints
    tiles: NDArray[np.uint16]


@message_of_arrays
class Stations:
    """State of all stations at one instant."""

    time: float
    word_stations: tuple[WordStationState, ...]
    letter_stations: tuple[LetterStationState, ...]


@message_of_arrays
class Snapshot:
    """Everything that a newcomer needs, true right after event `sequence`.

    `contents[b]` maps tile kind to count for bucket b. `storage_spots` are the waypoints where a bucket may rest now,
    ascending. `run` tells one run of a world from the next, which counts its events anew; 0 in one process. `paths` are
    those with a timetable that bots follow or wait to begin: a mind that is started again goes on with them.
    """

    time: float
    sequence: int
    bots: Bots
    buckets: Buckets
    contents: tuple[dict[int, int], ...]
    word_stations: tuple[WordStationState, ...]
    letter_stations: tuple[LetterStationState, ...]
    waiting_words: tuple[Word, ...]
    waiting_bundles: tuple[Bundle, ...]
    words_completed: int
    storage_spots: tuple[int, ...] = ()
    run: int = 0
    paths: tuple[FollowPath, ...] = ()


@message
class WorldState:
    """A checkpoint of the world, true right after event `sequence`: what a checkpoint file holds."""

    time: float
    run: int
    sequence: int
    checkpoint: bytes


# ---- what the fleet asks of a bot -----------------------------------------------------------------------------


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


# ---- what the word and letter managers ask of the fleet ---------------------------------------------------------


@message
class DeliverGoal:
    """Bring the letters that an open word lacks to its station.

    Tasks are known by their kind (DELIVER or STORE) and the number that their manager gives them.
    """

    task: int
    station: int
    word: int
    tiles: tuple[int, ...]


@message
class StoreGoal:
    """Bring buckets to a letter station until a staged bundle is stored."""

    task: int
    station: int
    bundle: int
    tile: int
    count: int


@message
class TaskFeedback:
    """How far a task has come: the tiles still to be moved, and why it waits, if it does."""

    kind: str
    task: int
    missing: tuple[int, ...]
    message: str


@message
class TaskResult:
    """How a task ended."""

    kind: str
    task: int
    code: Code
    message: str


@message
class CancelTask:
    """Take a task back."""

    kind: str
    task: int


@message
class TaskState:
    """One line of the fleet's list of tasks. `kind` is `deliver` or `store`."""

    task: int
    kind: str
    station: int
    job: int
    tiles: tuple[int, ...]
    bots: tuple[int, ...]
    message: str


@message
class Tasks:
    """All tasks of the fleet."""

    time: float
    tasks: tuple[TaskState, ...]


@message
class Bound:
    """Which buckets the fleet has bound for which stations now, in the order of their binding; -1 for no bucket."""

    time: float
    buckets: tuple[int, ...]
    stations: tuple[int, ...]


# ---- pace ---------------------------------------------------------------------------------------------------


@message
class Beat:
    """The world has spoken, and time stays at this instant until every part that it concerns has heard it.

    Attributes:
        time: Simulated time (s); it travels exactly, so that who wanted a beat at a time gets it at that time.
        number: Counts the beats, from 1 on.
        parts: Who has to say that it was heard.
        sequence: Number of the newest event, which they have to have heard by then.
        replies: What the world has answered to bots since the beat before.
    """

    time: float
    number: int
    parts: tuple[str, ...] = ()
    sequence: int = -1
    replies: tuple[BotReply, ...] = ()


@message
class Heard:
    """A part has heard the world up to a beat, and has said all that it wants in return.

    Attributes:
        part: Its name.
        beat: Number of the beat, 0 for none yet.
        next_time: Simulated time (s) at which it wants another beat at the latest; infinity: when something happens.
        reacts: Events upon which it may say something; the world waits for it only after those.
        bots: Whose replies it waits for, and to whose events `reacts` is restricted; empty for a part without bots.
        leaves: Whether the world is not to wait for it any more.
        sent: Messages to other parts so far, by channel (see `mail`), where that has changed.
        got: Messages of other parts that it has taken in so far, likewise.
    """

    part: str
    beat: int
    next_time: float
    reacts: frozenset[EventType] = frozenset()
    bots: frozenset[int] = frozenset()
    leaves: bool = False
    sent: Counts = ()
    got: Counts = ()


@message
class BotGone:
    """Nobody has the mind of a bot any more; what it was asked for ends by itself."""

    bot: int


@message
class Charge:
    """A process says what it is in charge of.

    Attributes:
        part: Its name.
        term: Managers: one more than that of the one before; the highest is in charge.
        rank: Decides between two: of managers of one term the lower, of processes with one bot the higher.
        policy: What it follows.
        bots: The bots whose minds it has.
    """

    part: str
    term: int
    rank: int
    policy: str
    bots: tuple[int, ...] = ()
