"""What customers order and what suppliers bring: words drawn from a word list, colours from a profile."""

from __future__ import annotations

from typing import Any

import numpy as np

from soup_msgs_py.messages import Bundle, Floats, Word
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.scenario.demand import AllOrders, Backlog, PoissonBundles, PoissonOrders
from soup_msgs_py.warehouse.tiles import LETTERS, tile_kind, tile_letter
from soup_msgs_py.warehouse.words import WordList
from soup_sim.arrivals import Arrivals, TimedBundle, TimedWord


class Drawing:
    """Draws numbers from fixed shares, a block of randomness at a time.

    Args:
        shares: The share of each number; they add up to 1.
        rng: Where randomness comes from.
    """

    def __init__(self, shares: Floats, rng: np.random.Generator) -> None:
        self._edges = np.cumsum(shares)
        self._edges[-1] = 1.0
        self._rng = rng

    def draw(self, n: int) -> list[int]:
        """N numbers."""
        return np.searchsorted(self._edges, self._rng.random(n), side="right").tolist()


class Orders:
    """The words that customers order, in the scenario's way.

    Args:
        scenario: The scenario.
        words: The word list; each order is drawn uniformly from it.
        timed: The orders of a file.
        rng: Where randomness comes from.

    Attributes:
        mean_length: Mean number of letters of the words that can be ordered.
    """

    def __init__(
        self, scenario: Scenario, words: WordList, timed: tuple[TimedWord, ...], rng: np.random.Generator
    ) -> None:
        self._plan = scenario.orders
        self._words = words.words
        self._rng = rng
        self._colours = Drawing(np.array(scenario.colours.shares), rng)
        self._next = 0
        self._arrivals = Arrivals(self._plan, timed, rng)
        self.mean_length = words.mean_length
        if timed:
            self.mean_length = sum(len(word.letters or word.tiles) for word in timed) / len(timed)

    def at_start(self) -> list[Word]:
        """The words on order at the start."""
        plan = self._plan
        if isinstance(plan, Backlog):
            return [self.draw() for _ in range(plan.visible)]
        if isinstance(plan, AllOrders):
            return [self.draw() for _ in range(plan.count)]
        if isinstance(plan, PoissonOrders):
            return [self.draw() for _ in range(plan.at_start)]
        return []

    def keeps_waiting(self) -> int:
        """How many words always wait: the next one arrives as soon as one is taken."""
        return self._plan.visible if isinstance(self._plan, Backlog) else 0

    def next_time(self, now: float) -> float:
        """When the next word arrives by itself; infinity for never. Asked once after each arrival."""
        return self._arrivals.next_time(now)

    def draw(self) -> Word:
        """The word that arrives now."""
        coming = self._arrivals.take()
        if coming is not None and coming.tiles:
            return self._number("".join(map(tile_letter, coming.tiles)), coming.tiles)
        text = coming.letters if coming is not None else self._words[int(self._rng.integers(len(self._words)))]
        colours = self._colours.draw(len(text))
        return self._number(text, tuple(map(tile_kind, text, colours)))

    def capture(self) -> dict[str, Any]:
        """Everything that changes, for a checkpoint."""
        return _capture(self)

    def restore(self, state: dict[str, Any]) -> None:
        """The opposite of `capture`."""
        _restore(self, state)

    def _number(self, text: str, tiles: tuple[int, ...]) -> Word:
        word = Word(self._next, text, tiles)
        self._next += 1
        return word


class Supply:
    """The bundles that suppliers bring where the letter manager does not choose them itself."""

    def __init__(
        self, scenario: Scenario, profile: Floats, timed: tuple[TimedBundle, ...], rng: np.random.Generator
    ) -> None:
        self._plan, self._size = scenario.bundles, scenario.bundle_size
        self._kinds = Drawing(profile, rng)
        self._rng = rng
        self._next = 0
        self._arrivals = Arrivals(self._plan, timed, rng)

    def at_start(self) -> list[Bundle]:
        """The bundles that wait at the start."""
        count = self._plan.at_start if isinstance(self._plan, PoissonBundles) else 0
        return [self.draw() for _ in range(count)]

    def next_time(self, now: float) -> float:
        """When the next bundle arrives by itself; infinity for never. Asked once after each arrival."""
        return self._arrivals.next_time(now)

    @property
    def is_chosen(self) -> bool:
        """Whether the letter manager may order any kind at any time."""
        return self._plan.kind == "chosen"

    def draw(self) -> Bundle:
        """The bundle that arrives now."""
        coming = self._arrivals.take()
        return self.order(coming.tile if coming is not None else self._kinds.draw(1)[0])

    def order(self, tile: int) -> Bundle:
        """A new bundle of a kind."""
        bundle = Bundle(self._next, tile, self._size)
        self._next += 1
        return bundle

    def capture(self) -> dict[str, Any]:
        """Everything that changes, for a checkpoint."""
        return _capture(self)

    def restore(self, state: dict[str, Any]) -> None:
        """The opposite of `capture`."""
        _restore(self, state)


def _capture(source: Orders | Supply) -> dict[str, Any]:
    return {
        "next": source._next,
        "arrivals": source._arrivals.capture(),
        "rng": source._rng.bit_generator.state,
    }


def _restore(source: Orders | Supply, state: dict[str, Any]) -> None:
    source._next = state["next"]
    source._arrivals.restore(state["arrivals"])
    source._rng.bit_generator.state = state["rng"]


def tile_profile(words: WordList, colours: list[float]) -> Floats:
    """Expected share of each tile kind among the letters of words; adds up to 1."""
    counts = np.zeros(LETTERS)
    for word in words.words:
        for letter in word:
            counts[ord(letter) - ord("A")] += 1.0
    profile = np.outer(np.array(colours), counts / counts.sum()).ravel()
    return profile / profile.sum()


def initial_contents(
    buckets: int, capacity: int, share: float, profile: Floats, rng: np.random.Generator
) -> list[dict[int, int]]:
    """Fill all buckets alike with tiles drawn from a profile (paper, "The Alphabet Soup Testbed").

    Args:
        buckets: How many buckets.
        capacity: Tiles that fit into one.
        share: Share of the whole capacity that is filled.
        profile: Expected share of each tile kind.
        rng: Where randomness comes from.

    Returns:
        Tile kind to count, for each bucket.
    """
    contents: list[dict[int, int]] = [{} for _ in range(buckets)]
    for index, kind in enumerate(Drawing(profile, rng).draw(int(share * capacity * buckets))):
        content = contents[index % buckets]
        content[kind] = content.get(kind, 0) + 1
    return contents
