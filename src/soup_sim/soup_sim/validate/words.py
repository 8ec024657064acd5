"""The ledger of words: waiting, open on a station, completed, cleared."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass

from soup_msgs_py.messages import Event, Snapshot, Word
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Layout
from soup_msgs_py.warehouse.tiles import tile_name
from soup_sim.validate.violations import EPSILON, Law, Record


@dataclass(slots=True)
class _OpenWord:
    """A word that has a place on a station; `missing` maps tile kind to how many are to come."""

    station: int
    tiles: tuple[int, ...]
    missing: dict[int, int]
    left: int
    completed_at: float | None = None

    @classmethod
    def read(cls, station: int, word: Word) -> _OpenWord:
        missing = word.missing
        completed_at = None if missing else -math.inf
        return cls(station, word.tiles, dict(Counter(missing)), len(missing), completed_at)


class WordLedger:
    """What events say about words.

    Attributes:
        due: Words whose letters are all in and that are not completed yet, with the time they were.
        taken_out: Tiles of each kind that left the warehouse in cleared words.
        completed: How many words are completed, those before the start included.
    """

    def __init__(self, scenario: Scenario, layout: Layout, start: Snapshot, record: Record) -> None:
        """Begin with the words of a snapshot."""
        self._limit = scenario.word_station.open_words
        self._clear_s = scenario.word_station.clear_s
        self._layout = layout
        self._record = record
        self.due: dict[int, float] = {}
        self.taken_out: dict[int, int] = {}
        self.completed = start.words_completed
        self._waiting = {word.word: word.tiles for word in start.waiting_words}
        self._open: dict[int, _OpenWord] = {}
        self._at = [0] * len(layout.word_stations)
        for state in start.word_stations:
            for word in state.open_words:
                self._open[word.word] = _OpenWord.read(state.station, word)
                self._occupy(start.time, state.station)
        self._known = {*self._waiting, *self._open}

    def arrived(self, event: Event) -> None:
        """A customer orders a word."""
        if event.job in self._known:
            self._record.add(event.time, Law.WORDS, f"word {event.job} arrived a second time")
        self._known.add(event.job)
        self._waiting[event.job] = event.tiles

    def assigned(self, event: Event) -> None:
        """A waiting word gets a place on a station."""
        tiles = self._waiting.pop(event.job, None)
        name = self._layout.station_name(event.station)
        if not self._layout.is_word_station(event.station):
            self._record.add(event.time, Law.NUMBERS, f"word {event.job} was assigned to {name}, no word station")
        elif tiles is None:
            self._record.add(event.time, Law.WORDS, f"word {event.job} was assigned to {name}, but it was not waiting")
        else:
            self._open[event.job] = _OpenWord(event.station, tiles, dict(Counter(tiles)), len(tiles))
            self._occupy(event.time, event.station)

    def put(self, event: Event) -> None:
        """A tile goes into an open word."""
        word = self._open.get(event.job)
        if word is None or word.station != event.station:
            self._record.add(
                event.time,
                Law.TILES,
                f"tile {tile_name(event.tile)} went into word {event.job}, which is not open at "
                f"{self._layout.station_name(event.station)}",
            )
            return
        missing = word.missing.get(event.tile, 0)
        if missing < 1:
            self._record.add(
                event.time,
                Law.TILES,
                f"tile {tile_name(event.tile)} went into word {event.job}, which does not need it",
            )
            return
        word.missing[event.tile] = missing - 1
        word.left -= 1
        if word.left == 0:
            self.due[event.job] = event.time

    def was_completed(self, event: Event) -> None:
        """All letters of a word are in."""
        self.completed += 1
        self.due.pop(event.job, None)
        word = self._open.get(event.job)
        if word is None or word.station != event.station:
            fault = f"it is not open at {self._layout.station_name(event.station)}"
        elif word.completed_at is not None:
            fault = "it was already"
        else:
            word.completed_at = event.time
            if word.left:
                fault = f"{word.left} of its letters are missing"
            elif event.count != len(word.tiles):
                fault = f"with {event.count} letters instead of {len(word.tiles)}"
            else:
                return
        self._record.add(event.time, Law.WORDS, f"word {event.job} was completed: {fault}")

    def cleared(self, event: Event) -> None:
        """A completed word leaves, its place is free."""
        word = self._open.get(event.job)
        if word is None or word.station != event.station:
            name = self._layout.station_name(event.station)
            self._record.add(event.time, Law.WORDS, f"word {event.job} was cleared: it is not open at {name}")
            return
        if word.completed_at is None:
            self._record.add(event.time, Law.WORDS, f"word {event.job} was cleared before it was completed")
        elif not event.time >= word.completed_at + self._clear_s - EPSILON:
            self._record.add(
                event.time,
                Law.WORDS,
                f"word {event.job} was cleared {event.time - word.completed_at:g} s after it was completed "
                f"instead of {self._clear_s:g} s",
            )
        del self._open[event.job]
        self._at[word.station] -= 1
        for tile in word.tiles:
            self.taken_out[tile] = self.taken_out.get(tile, 0) + 1
        for tile, missing in word.missing.items():
            self.taken_out[tile] -= missing

    def check_due(self, time: float) -> None:
        """Words whose letters are all in must be completed at that instant."""
        for job, full_at in list(self.due.items()):
            if time > full_at + EPSILON:
                del self.due[job]
                self._record.add(
                    time,
                    Law.WORDS,
                    f"word {job} was not completed when its last letter came in at {full_at:g} s",
                )

    def compare(self, end: Snapshot) -> None:
        """The words of a snapshot must be those of the ledger."""

        def differ(sentence: str) -> None:
            self._record.add(end.time, Law.SNAPSHOT, sentence)

        for job, full_at in self.due.items():
            differ(f"word {job} has all its letters since {full_at:g} s and was never completed")
        if end.words_completed != self.completed:
            differ(f"the snapshot counts {end.words_completed} completed words, the events {self.completed}")
        waiting = {word.word: word.tiles for word in end.waiting_words}
        for job in sorted(waiting.keys() ^ self._waiting.keys()):
            there = "waits in the snapshot, not" if job in waiting else "does not wait in the snapshot, but does"
            differ(f"word {job} {there} by the events")
        for job in waiting.keys() & self._waiting.keys():
            if waiting[job] != self._waiting[job]:
                differ(f"word {job} waits with other letters than it arrived with")
        shown = {
            word.word: _OpenWord.read(state.station, word) for state in end.word_stations for word in state.open_words
        }
        for job in sorted(shown.keys() ^ self._open.keys()):
            there = "is open in the snapshot, not" if job in shown else "is not open in the snapshot, but is"
            differ(f"word {job} {there} by the events")
        for job in shown.keys() & self._open.keys():
            theirs, ours = shown[job], self._open[job]
            if (theirs.station, theirs.tiles) != (ours.station, ours.tiles):
                differ(f"word {job} is on another station or has other letters than the events say")
            elif +Counter(theirs.missing) != +Counter(ours.missing):
                differ(f"word {job} lacks {theirs.left} letters in the snapshot, {ours.left} or others by events")

    def _occupy(self, time: float, station: int) -> None:
        """Take one of a station's places."""
        self._at[station] += 1
        if self._at[station] > self._limit:
            name = self._layout.station_name(station)
            self._record.add(
                time, Law.CAPACITY, f"{name} has {self._at[station]} open words, at most {self._limit} fit"
            )
