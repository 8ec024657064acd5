"""What a manager knows of the world: a snapshot, kept true by events."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from soup_managers.contents import Contents
from soup_managers.kernels.bitset import bits
from soup_msgs_py.codes import EventType
from soup_msgs_py.messages import Bots, Bundle, Event, Snapshot, Word
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Layout
from soup_msgs_py.warehouse.tiles import LETTERS

MOST_REFUSED = 2  # snapshots in a row


@dataclass(slots=True)
class OpenWord:
    """A word on a word station; one that is finished holds its place until it is cleared away."""

    word: int
    station: int
    tiles: tuple[int, ...]
    filled: list[bool]

    @property
    def missing(self) -> tuple[int, ...]:
        """Tile kinds that are still to come, in the order of the letters."""
        return tuple([tile for tile, there in zip(self.tiles, self.filled, strict=True) if not there])


@dataclass(slots=True)
class StagedBundle:
    """A bundle on a letter station and how many of its tiles are still there."""

    bundle: int
    station: int
    tile: int
    count: int


class WarehouseView:
    """The world as told by one `Snapshot` and the `Event`s after it.

    Several managers in one process may share a view: what it has seen already it ignores. After a gap in the
    events it stands still and is `lost` until the next snapshot. The snapshot of another run is always taken over.

    Attributes:
        run: The run of the world that is in the view.
        sequence: Number of the last event that is in the view; -1 before the first snapshot.
        ready: Whether there has been a snapshot.
        resets: How many snapshots were taken over.
        lost: Whether events are missing, so that a new snapshot is needed.
        bucket_x: Positions of the buckets in metres, shape (buckets,); `bucket_y` likewise. A carried bucket
            is where its bot was last known to be.
        bucket_bot: The bot that carries each bucket, -1 for none, shape (buckets,).
        is_storage_spot: Whether each waypoint is a storage spot now, shape (waypoints,). A manager may ask the world
            to change that.
        spot_of: The storage spot (waypoint) where each bucket rests or last rested, -1 where unknown, shape
            (buckets,). The one where it last rested may be none any more.
        bucket_at: The bucket that rests on each waypoint, -1 for none, shape (waypoints,).
        contents: Tiles in each bucket: `contents[bucket]` is tile kind to count.
        bot_x: Last known positions of the bots in metres, shape (bots,); `bot_y` likewise.
        seen_at: When all of them were last seen (s).
        bot_bucket: The bucket that each bot carries, -1 for none, shape (bots,).
        waiting_words: Words on order, the oldest first, by number.
        open_words: Words on word stations, by number.
        waiting_bundles: Bundles that have arrived and are on no station, the oldest first, by number.
        staged_bundles: Bundles on letter stations, by number.
        free_places: How many more words can be opened, or bundles staged, on each station.
        stock: Tiles in buckets and staged bundles, by tile kind, shape (kinds,).
        wanted: Tiles that open words lack, by tile kind, shape (kinds,).
        on_order: Tiles in words that wait, by tile kind, shape (kinds,).
        bound: The buckets that the fleet has bound for each station, where it tells.
    """

    def __init__(self, scenario: Scenario, layout: Layout) -> None:
        self.scenario = scenario
        self.layout = layout
        self.run = 0
        self.sequence = -1
        self._heard = -1
        self._refused = 0  # snapshots in a row that were older than what was heard
        self.ready = False
        self.lost = False
        self.resets = 0
        self.bound: dict[int, list[int]] = {}
        self.kinds = LETTERS * len(scenario.colours.shares)
        self._waypoints = KDTree(layout.waypoints)
        self._clear((), 0)

    def _clear(self, contents: Sequence[Mapping[int, int]], bots: int) -> None:
        buckets, waypoints = len(contents), len(self.layout.waypoints)
        self.bucket_x, self.bucket_y = np.zeros(buckets), np.zeros(buckets)
        self.bucket_bot = np.full(buckets, -1)
        self.is_storage_spot = np.zeros(waypoints, bool)
        self.spot_of = np.full(buckets, -1)
        self.bucket_at = np.full(waypoints, -1)
        self.contents = Contents(contents, self.kinds, self.scenario.bucket.capacity)
        self.bot_x, self.bot_y = np.zeros(bots), np.zeros(bots)
        self.seen_at = -np.inf
        self.bot_bucket = np.full(bots, -1)
        self.waiting_words: dict[int, Word] = {}
        self.open_words: dict[int, OpenWord] = {}
        self.waiting_bundles: dict[int, Bundle] = {}
        self.staged_bundles: dict[int, StagedBundle] = {}
        words, letters = len(self.layout.word_stations), len(self.layout.letter_stations)
        self._first_letter_station = words
        self.free_places = [self.scenario.word_station.open_words] * words
        self.free_places += [self.scenario.letter_station.staged_bundles] * letters
        self.stock = self.contents.tiles.sum(axis=1, dtype=np.int64)
        self.wanted = np.zeros(self.kinds, np.int64)
        self.on_order = np.zeros(self.kinds, np.int64)

    # ---- what it can be asked ------------------------------------------------------------------------------

    def holders(self, tile: int) -> int:
        """The buckets that hold a tile kind, as a bit set."""
        return bits(self.contents.tiles[tile] > 0)

    @property
    def with_room(self) -> int:
        """The buckets that are not full, as a bit set."""
        return bits(self.contents.total < self.contents.capacity)

    @property
    def resting(self) -> int:
        """The buckets that no bot carries, as a bit set."""
        return bits(self.bucket_bot < 0)

    @property
    def storage_spots(self) -> set[int]:
        """The waypoints that are storage spots now."""
        return set(np.flatnonzero(self.is_storage_spot).tolist())

    @property
    def occupied(self) -> NDArray[np.bool_]:
        """Whether a bucket rests on each waypoint, shape (waypoints,)."""
        return self.bucket_at >= 0

    @property
    def room(self) -> int:
        """How many more tiles go into all buckets, once what is staged is in them."""
        return len(self.contents) * self.contents.capacity - int(self.stock.sum())

    def room_in(self, bucket: int) -> int:
        """How many more tiles go into a bucket."""
        return self.contents.room(bucket)

    def spot_at(self, x: float, y: float) -> int:
        """The storage spot that a bucket at a place in metres rests on, as a waypoint; -1 for none."""
        return next(iter(self.spots_within(x, y, self.scenario.bucket.radius_m)), -1)

    def spots_within(self, x: float, y: float, radius: float) -> list[int]:
        """The storage spots nearer to a place than `radius` metres, as waypoints, the nearest first."""
        near = np.array(self._waypoints.query_ball_point((x, y), radius, return_sorted=True), np.int64)
        steps = self.layout.waypoints[near] - (x, y)
        squares = steps[:, 0] * steps[:, 0] + steps[:, 1] * steps[:, 1]
        order = np.argsort(squares, kind="stable")
        return near[order][(squares[order] < radius * radius) & self.is_storage_spot[near[order]]].tolist()

    # ---- how it is kept true -------------------------------------------------------------------------------

    def reset(self, snapshot: Snapshot) -> bool:
        """Take over a snapshot, where one is needed or it holds more than is known; whether it was.

        One that is older than an event that was heard would leave a gap: it is refused, the view is `lost`. Where the
        next one is older, too, that event was nobody's: no snapshot is so late. In another run of the world, which
        numbers its events anew, nothing has been heard yet.
        """
        if snapshot.run != self.run:
            self.run, self._heard, self.ready = snapshot.run, -1, False
            self._refused = 0
        if self.ready and not self.lost and snapshot.sequence <= self.sequence:
            return False
        if snapshot.sequence < self._heard:
            self.lost = True
            self._refused += 1
            if self._refused < MOST_REFUSED:
                return False
        self._refused = 0
        self._heard = snapshot.sequence
        self._clear(snapshot.contents, len(snapshot.bots.x))
        self.is_storage_spot[list(snapshot.storage_spots)] = True
        self.observe(snapshot.bots)
        self.bot_bucket[:] = snapshot.bots.bucket
        self.bucket_x[:], self.bucket_y[:] = snapshot.buckets.x, snapshot.buckets.y
        self.bucket_bot[:] = snapshot.buckets.bot
        for bucket in np.flatnonzero(self.bucket_bot < 0).tolist():
            self._set_down(bucket)
        for word_station in snapshot.word_stations:
            for word in word_station.open_words:
                self._open(word, word_station.station)
        for letter_station in snapshot.letter_stations:
            for bundle in letter_station.staged_bundles:
                self._stage(bundle, letter_station.station)
        for word in snapshot.waiting_words:
            self._order(word)
        self.waiting_bundles = {bundle.bundle: bundle for bundle in snapshot.waiting_bundles}
        self.sequence = snapshot.sequence
        self.ready, self.lost = True, False
        self.resets += 1
        return True

    def observe(self, bots: Bots) -> None:
        """Take over where the bots are."""
        self.bot_x[:], self.bot_y[:] = bots.x, bots.y
        self.seen_at = bots.time

    def apply(self, event: Event) -> bool:
        """Take in an event; whether it was new.

        One that leaves a gap makes the view `lost`, as one that cannot be: of what is in no book, or not there.
        """
        if event.sequence <= self.sequence:
            return False
        self._heard = max(self._heard, event.sequence)
        if not self.ready or self.lost:
            return False
        if event.sequence != self.sequence + 1:
            self.lost = True
            return False
        self.sequence = event.sequence
        try:
            self._take_in(event)
        except (KeyError, IndexError):
            self.lost = True
        return not self.lost

    def _take_in(self, event: Event) -> None:
        kind = event.type
        if kind is EventType.TRANSFERRED:
            self._transferred(event)
        elif kind is EventType.GRABBED:
            self._lift(event.bucket, event.bot)
            self._see(event)
        elif kind is EventType.RELEASED:
            self.bot_bucket[event.bot] = -1
            self.bucket_bot[event.bucket] = -1
            self.bucket_x[event.bucket], self.bucket_y[event.bucket] = event.x, event.y
            self._set_down(event.bucket)
            self._see(event)
        elif kind is EventType.WORD_ARRIVED:
            self._order(Word(event.job, event.text, event.tiles))
        elif kind is EventType.WORD_ASSIGNED:
            word = self.waiting_words.pop(event.job, None)
            for tile in word.tiles if word is not None else ():
                self.on_order[tile] -= 1
            self._open(word or Word(event.job, event.text, event.tiles), event.station)
        elif kind is EventType.WORD_CLEARED:
            if self.open_words.pop(event.job, None) is not None:
                self.free_places[event.station] += 1
        elif kind is EventType.BUNDLE_ARRIVED:
            self.waiting_bundles[event.job] = Bundle(event.job, event.tile, event.count)
        elif kind is EventType.BUNDLE_STAGED:
            self.waiting_bundles.pop(event.job, None)
            self._stage(Bundle(event.job, event.tile, event.count), event.station)
        elif kind is EventType.BUNDLE_EMPTIED:
            if self.staged_bundles.pop(event.job, None) is not None:
                self.free_places[event.station] += 1
        elif kind is EventType.RESUMED:
            self._see(event)
        elif kind is EventType.SPOT_MADE:
            self.is_storage_spot[event.waypoint] = True
        elif kind is EventType.SPOT_REMOVED:
            self.is_storage_spot[event.waypoint] = False

    def _order(self, word: Word) -> None:
        self.waiting_words[word.word] = word
        for tile in word.tiles:
            self.on_order[tile] += 1

    def _transferred(self, event: Event) -> None:
        bucket, tile = event.bucket, event.tile
        self._see(event)
        if event.station < self._first_letter_station:
            self.contents.put(bucket, tile, -1)
            self.stock[tile] -= 1
            word = self.open_words.get(event.job)
            if word is None:
                return
            for letter, wanted in enumerate(word.tiles):
                if wanted == tile and not word.filled[letter]:
                    word.filled[letter] = True
                    self.wanted[tile] -= 1
                    return
        else:
            self.contents.put(bucket, tile, 1)
            bundle = self.staged_bundles.get(event.job)
            if bundle is not None:
                bundle.count -= 1

    def _see(self, event: Event) -> None:
        """Take the bot's place from an event, where it says one (nothing is at negative coordinates)."""
        if event.x < 0 or event.bot < 0:
            return
        self.bot_x[event.bot], self.bot_y[event.bot] = event.x, event.y
        carried = self.bot_bucket[event.bot]
        if carried >= 0:
            self.bucket_x[carried], self.bucket_y[carried] = event.x, event.y

    def _lift(self, bucket: int, bot: int) -> None:
        self.bot_bucket[bot] = bucket
        self.bucket_bot[bucket] = bot
        spot = self.spot_of[bucket]
        if spot >= 0:
            self.bucket_at[spot] = -1

    def _set_down(self, bucket: int) -> None:
        spot = self.spot_of[bucket] = self.spot_at(self.bucket_x[bucket], self.bucket_y[bucket])
        if spot >= 0:
            self.bucket_at[spot] = bucket

    def _open(self, word: Word, station: int) -> None:
        opened = OpenWord(word.word, station, word.tiles, list(word.filled or (False,) * len(word.tiles)))
        self.open_words[word.word] = opened
        self.free_places[station] -= 1
        for tile in opened.missing:
            self.wanted[tile] += 1

    def _stage(self, bundle: Bundle, station: int) -> None:
        self.staged_bundles[bundle.bundle] = StagedBundle(bundle.bundle, station, bundle.tile, bundle.count)
        self.free_places[station] -= 1
        self.stock[bundle.tile] += bundle.count
