"""Word policies: which waiting word is opened on which word station."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from soup_managers.explain import Explain
from soup_managers.policies import room
from soup_managers.view import WarehouseView
from soup_msgs_py.messages import AssignWord
from soup_msgs_py.warehouse.layout import Floats, Ints


class WordPolicy(ABC):
    """Decides what the word stations work at. Extend it and implement `choose`; nothing else is needed.

    A policy gets its options from the policies file as keyword arguments of its constructor. It may tell
    `self.explain` what its choices are made of: `--explain FILE` writes that down.

    Example:
        class NewestFirst(WordPolicy):
            def choose(self, view, stations, rng):
                return AssignWord(max(view.waiting_words), stations[0])
    """

    explain = Explain()

    @abstractmethod
    def choose(self, view: WarehouseView, stations: Sequence[int], rng: np.random.Generator) -> AssignWord | None:
        """Open one word; asked again while words wait and places are free.

        Args:
            view: The warehouse. `view.waiting_words` holds at least one word.
            stations: The word stations with a free place, in order; at least one.
            rng: For all random draws.

        Returns:
            A waiting word and one of the stations, or None: rather none now. Then it is asked again when a
            word arrives, a place becomes free or a second has passed.
        """


class Minimal(WordPolicy):
    """The paper's example: the oldest waiting word goes to the station with the fewest open words."""

    def choose(self, view: WarehouseView, stations: Sequence[int], rng: np.random.Generator) -> AssignWord | None:
        """First word, emptiest station; of equals the first."""
        station = max(stations, key=view.free_places.__getitem__)
        return AssignWord(next(iter(view.waiting_words)), station)


class InStock(WordPolicy):
    """The oldest word whose letters are all there, beyond what open words lack, so that none waits for a delivery.

    The station with the fewest open words gets it; where no word is complete, the one that lacks fewest letters.
    """

    def choose(self, view: WarehouseView, stations: Sequence[int], rng: np.random.Generator) -> AssignWord | None:
        """Fewest letters that are not there."""
        station = max(stations, key=view.free_places.__getitem__)
        spare = {int(tile): int(view.stock[tile] - view.wanted[tile]) for tile in np.flatnonzero(view.on_order)}
        best, least = -1, np.inf
        for word in view.waiting_words.values():
            lacks = len(word.tiles) - _served(word.tiles, spare)
            if lacks < least:
                best, least = word.word, lacks
            if lacks == 0:
                break
        self.explain.choice("words", best, np.array([-least]), np.array([best]), _spelt(view), station=station)
        return AssignWord(best, station)


class Served(WordPolicy):
    """The word that the buckets at a station, or bound for it, serve best with what its open words leave over.

    The station with the fewest open words gets it. Age counts too, so that no word waits for ever. Where the room in
    the buckets gets scarce, the word is taken that leaves most of it, and none that could not be completed.

    Args:
        age_weight: What a word's age counts against the share of its letters that are served. A word is as many
            queues old as words have arrived since, for each word that waits now.
        patience: So many queues old a word may get before its age counts.
    """

    def __init__(self, age_weight: float = 0.5, patience: float = 3.0) -> None:
        """Know no word yet."""
        self._age_weight, self._patience = age_weight, patience
        self._letters: dict[int, tuple[Ints, Ints]] = {}

    def choose(self, view: WarehouseView, stations: Sequence[int], rng: np.random.Generator) -> AssignWord | None:
        """Largest share of letters that are there or come anyway, and age."""
        station = max(stations, key=view.free_places.__getitem__)
        known = self._letters
        self._letters = {n: known.get(n) or _letters(word.tiles) for n, word in view.waiting_words.items()}
        numbers = np.fromiter(view.waiting_words, np.int64)
        lengths = np.array([len(tiles) for tiles, _ in self._letters.values()])
        tiles = np.concatenate([tiles for tiles, _ in self._letters.values()])
        before = np.concatenate([before for _, before in self._letters.values()])
        starts = np.cumsum(lengths) - lengths
        spare = np.zeros(view.kinds, np.int64)
        for tile, count in _spare(view, station).items():
            spare[tile] = count
        served = np.add.reduceat((spare[tiles] > before).astype(np.int64), starts)
        scores = served / lengths + self._age_weight * self._ages(numbers)
        best = int(scores.argmax())
        if view.scenario.bundles.kind == "chosen":
            left = room.left(view, tiles, before, starts)
            if left[best] < room.kept(view):
                best, scores = int(left.argmax()), left.astype(np.float64)
                if left[best] < 0:
                    return None
        self.explain.choice("words", int(numbers[best]), scores, numbers, _spelt(view), station=station)
        return AssignWord(int(numbers[best]), station)

    def _ages(self, numbers: NDArray[np.int64]) -> Floats:
        """How many queues of words have arrived since each waiting word, beyond the patience."""
        return np.maximum(0.0, (numbers[-1] - numbers) / len(numbers) - self._patience)


def _spelt(view: WarehouseView) -> Callable[[int], str]:
    """How a waiting word reads."""
    return lambda word: view.waiting_words[word].text


def _letters(tiles: tuple[int, ...]) -> tuple[Ints, Ints]:
    """The letters of a word, and how many of the same kind come before each in it."""
    before = [tiles[:place].count(tile) for place, tile in enumerate(tiles)]
    return np.array(tiles, np.int32), np.array(before, np.int32)


def _spare(view: WarehouseView, station: int) -> dict[int, int]:
    """Tiles in the buckets bound for a station beyond what its open words lack."""
    spare: dict[int, int] = {}
    for bucket in view.bound.get(station, ()):
        for tile, count in view.contents[bucket].items():
            spare[tile] = spare.get(tile, 0) + count
    for word in view.open_words.values():
        if word.station == station:
            for tile in word.missing:
                spare[tile] = spare.get(tile, 0) - 1
    return spare


def _served(tiles: tuple[int, ...], spare: dict[int, int]) -> int:
    """How many letters of a word are among spare tiles."""
    served = 0
    used: dict[int, int] = {}
    for tile in tiles:
        taken = used.get(tile, 0)
        if spare.get(tile, 0) > taken:
            used[tile] = taken + 1
            served += 1
    return served
