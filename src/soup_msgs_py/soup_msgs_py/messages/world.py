"""What the world tells everybody."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from soup_msgs_py.codes import EventType
from soup_msgs_py.messages.base import Floats, Ints, message, message_of_arrays
from soup_msgs_py.messages.requests import FollowPath


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
