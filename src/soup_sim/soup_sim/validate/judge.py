"""The judge: keeps all ledgers, one event after another, and compares them with what the world shows."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable

from soup_msgs_py.codes import EventType
from soup_msgs_py.messages import Bots, Buckets, Event, Snapshot
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Layout
from soup_msgs_py.warehouse.tiles import tile_name
from soup_sim.validate.bots import BotLedger
from soup_sim.validate.buckets import BucketLedger
from soup_sim.validate.bundles import BundleLedger
from soup_sim.validate.poses import PoseLaws
from soup_sim.validate.violations import EPSILON, Law, Record, Violation
from soup_sim.validate.words import WordLedger


class Judge:
    """Judges one run from its events, and from snapshots at its start and its end.

    Give it every event in order, poses at any instants between, and the last snapshot:

        judge = Judge(scenario, layout, start)
        judge.event(event)
        judge.poses(bots, buckets)
        judge.finish(end)
        print(judge.count, judge.violations)

    A grab, a release or a transfer is an event when it is finished, at the place where the bot is then.
    """

    def __init__(
        self, scenario: Scenario, layout: Layout, start: Snapshot, keep: int = 1000, rounding_m: float = EPSILON
    ) -> None:
        """Begin a run.

        Args:
            scenario: Its parameters.
            layout: Its floor.
            start: The world right after event `start.sequence`, which is not judged any more.
            keep: How many violations are stored; all are counted.
            rounding_m: How exactly the places of buckets in poses are told; over a network they are rounded.
        """
        self._record = Record(keep)
        self._sequence = start.sequence
        self._time = start.time
        self._poses_at = -math.inf
        self._layout = layout
        self._words = WordLedger(scenario, layout, start, self._record)
        self._bundles = BundleLedger(scenario, layout, start, self._record)
        self._buckets = BucketLedger(scenario, layout, start, self._record)
        self._bots = BotLedger(scenario, start, self._record)
        self._pose_laws = PoseLaws(scenario, layout, self._buckets, self._record, rounding_m)
        self._tiles = _count_tiles(start)

        words, letters = len(layout.word_stations), len(layout.letter_stations)
        word, letter = scenario.word_station, scenario.letter_station
        self._station_xy = [layout.station_xy(station) for station in range(words + letters)]
        self._reach = [word.tolerance_m + EPSILON] * words + [letter.tolerance_m + EPSILON] * letters
        self._transfer_s = [word.transfer_s] * words + [letter.transfer_s] * letters
        self._station_free_at = [-math.inf] * (words + letters)
        self._word_stations = words
        self._clear_s = word.clear_s
        self._grab_s, self._release_s = scenario.bot.grab_s, scenario.bot.release_s

        self._handlers: dict[EventType, Callable[[Event], None]] = {
            EventType.WORD_ARRIVED: self._words.arrived,
            EventType.WORD_ASSIGNED: self._words.assigned,
            EventType.WORD_COMPLETED: self._word_completed,
            EventType.WORD_CLEARED: self._words.cleared,
            EventType.BUNDLE_ARRIVED: self._bundles.arrived,
            EventType.BUNDLE_STAGED: self._bundles.staged,
            EventType.BUNDLE_EMPTIED: self._bundles.emptied,
            EventType.GRABBED: self._grabbed,
            EventType.RELEASED: self._released,
            EventType.TRANSFERRED: self._transferred,
            EventType.BOT_COLLISION: self._bots.collided,
            EventType.BUCKET_COLLISION: self._bots.collided,
            EventType.RESUMED: self._bots.resumed,
            EventType.SPOT_MADE: self._buckets.spot_changed,
            EventType.SPOT_REMOVED: self._buckets.spot_changed,
        }
        self.poses(start.bots, start.buckets)

    @property
    def violations(self) -> list[Violation]:
        """The first violations, at most as many as are kept."""
        return self._record.violations

    @property
    def count(self) -> int:
        """How many violations there are, those that are not kept included."""
        return self._record.count

    def event(self, event: Event) -> None:
        """Judge the next event."""
        time = event.time
        if event.sequence != self._sequence + 1:
            self._record.add(
                time, Law.SEQUENCE, f"event {event.sequence} ({event.type}) came after event {self._sequence}"
            )
        self._sequence = event.sequence
        if time >= self._time:
            self._time = time
        else:
            self._record.add(
                time,
                Law.CLOCK,
                f"event {event.sequence} ({event.type}) is at {time:g} s, after one at {self._time:g} s",
            )
        if self._words.due:
            self._words.check_due(time)
        if self._bundles.due:
            self._bundles.check_due(time)
        self._handlers[event.type](event)

    def poses(self, bots: Bots, buckets: Buckets) -> None:
        """Judge where everything is at one instant; only poses after the last event must agree with it."""
        if not bots.time >= self._poses_at:
            self._record.add(
                bots.time,
                Law.CLOCK,
                f"poses at {bots.time:g} s came after poses at {self._poses_at:g} s",
            )
        else:
            self._poses_at = bots.time
        if self._pose_laws.check(bots, buckets, current=bots.time >= self._time):
            self._bots.sighted(bots)

    def finish(self, end: Snapshot) -> None:
        """Judge the snapshot right after the last event."""
        if end.sequence != self._sequence:
            self._record.add(
                end.time,
                Law.SEQUENCE,
                f"the snapshot follows event {end.sequence}, the last event is {self._sequence}",
            )
        if not end.time >= self._time:
            self._record.add(
                end.time,
                Law.CLOCK,
                f"the snapshot is from {end.time:g} s, the last event from {self._time:g} s",
            )
        self.poses(end.bots, end.buckets)
        self._words.compare(end)
        self._bundles.compare(end)
        if len(end.contents) != len(self._buckets.contents):
            self._record.add(
                end.time,
                Law.NUMBERS,
                f"the snapshot holds the contents of {len(end.contents)} buckets, "
                f"there are {len(self._buckets.contents)}",
            )
        self._buckets.compare(end)
        self._balance(end)

    def _balance(self, end: Snapshot) -> None:
        """Tiles at the start, and those brought in, are those at the end and those taken out."""
        expected = Counter(self._tiles)
        expected.update(self._bundles.brought_in)
        expected.subtract(self._words.taken_out)
        found = _count_tiles(end)
        for tile in sorted(expected.keys() | found.keys()):
            surplus = found[tile] - expected[tile]
            if surplus:
                happened = "made" if surplus > 0 else "lost"
                self._record.add(
                    end.time, Law.TILES, f"{abs(surplus)} tiles {tile_name(tile)} were {happened} in this run"
                )

    def _exist(self, event: Event) -> bool:
        """Whether the event names a bot and a bucket that there are."""
        if 0 <= event.bot < len(self._buckets.carried) and 0 <= event.bucket < len(self._buckets.bot):
            return True
        self._record.add(
            event.time,
            Law.NUMBERS,
            f"bot {event.bot} {event.type} bucket {event.bucket}: there is no such bot or bucket",
        )
        return False

    def _grabbed(self, event: Event) -> None:
        if self._exist(event):
            self._bots.operated(event, self._grab_s)
            self._buckets.grabbed(event)

    def _released(self, event: Event) -> None:
        if self._exist(event):
            self._bots.operated(event, self._release_s)
            self._buckets.released(event)

    def _transferred(self, event: Event) -> None:
        """A tile between the bucket on a bot and a station; the station did nothing else meanwhile."""
        time, station, bucket = event.time, event.station, event.bucket
        if not self._exist(event):
            return
        if not 0 <= station < len(self._station_xy):
            self._record.add(time, Law.NUMBERS, f"bot {event.bot} transferred at station {station}: there is none")
            return
        transfer_s = self._transfer_s[station]
        self._bots.operated(event, transfer_s)
        if self._buckets.bot[bucket] != event.bot:
            self._record.add(
                time,
                Law.CARRYING,
                f"bot {event.bot} transferred from or to bucket {bucket}, which it did not carry",
            )
        x, y = self._station_xy[station]
        distance = math.hypot(event.x - x, event.y - y)
        if not distance <= self._reach[station]:
            self._record.add(
                time,
                Law.TOLERANCE,
                f"bot {event.bot} transferred {distance:g} m away from {self._layout.station_name(station)}",
            )
        free_at = self._station_free_at[station]
        if not time >= free_at + transfer_s - EPSILON:
            self._record.add(
                time,
                Law.STATIONS,
                f"{self._layout.station_name(station)} transferred {time - free_at:g} s after it was free, "
                f"it takes {transfer_s:g} s",
            )
        self._station_free_at[station] = time
        if station < self._word_stations:
            self._buckets.take(time, bucket, event.tile)
            self._words.put(event)
        else:
            self._bundles.take(event)
            self._buckets.put(time, bucket, event.tile)

    def _word_completed(self, event: Event) -> None:
        self._words.was_completed(event)
        if self._layout.is_word_station(event.station):
            self._station_free_at[event.station] = event.time + self._clear_s


def judge_log(scenario: Scenario, layout: Layout, start: Snapshot, events: Iterable[Event], end: Snapshot) -> Judge:
    """Judge a run that is over from its events and its two snapshots; the judge holds the violations."""
    judge = Judge(scenario, layout, start)
    for event in events:
        judge.event(event)
    judge.finish(end)
    return judge


def _count_tiles(snapshot: Snapshot) -> Counter[int]:
    """How many tiles of each kind there are: in buckets, in bundles and in open words."""
    tiles: Counter[int] = Counter()
    for held in snapshot.contents:
        tiles.update(held)
    for bundle in snapshot.waiting_bundles:
        tiles[bundle.tile] += bundle.count
    for state in snapshot.letter_stations:
        for bundle in state.staged_bundles:
            tiles[bundle.tile] += bundle.count
    for state in snapshot.word_stations:
        for word in state.open_words:
            tiles.update(word.tiles)
            tiles.subtract(word.missing)
    return tiles
