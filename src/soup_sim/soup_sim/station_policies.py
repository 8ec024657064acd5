"""Station policies: what a station decides by itself. Extend one and name it in the scenario.

word_station: {policy: nearly_done}
letter_station: {policy: ../../examples/alike.py:Alike}
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from numpy.random import Generator

from soup_msgs_py.messages import LetterStationState, TileMove, WordStationState
from soup_msgs_py.policies import policy_maker
from soup_msgs_py.scenario import Scenario

State = TypeVar("State", WordStationState, LetterStationState)
Contents = Mapping[int, int]
Moves = Sequence[TileMove]


@dataclass(frozen=True, slots=True)
class Waiting:
    """A request that waits for a station: the bot, the tiles it asks to be moved, what its bucket holds."""

    bot: int
    moves: tuple[TileMove, ...]
    contents: Contents


class StationPolicy(ABC, Generic[State]):
    """What the policies of both kinds of stations have in common; extend one of the two below.

    Each station has a policy of its own, made with the options of the scenario as keyword arguments.

    Attributes:
        takes_first: Whether `choose` says 0 whatever it is asked; then it is not asked at all.
    """

    takes_first = False

    @abstractmethod
    def choose(self, moves: Moves, station: State, contents: Contents, rng: Generator) -> int:
        """Which tile is moved next of all that the bot asks for: the index of a move.

        Args:
            moves: What can be done, at least two: each a tile kind, and the word or the bundle that it goes to or
                comes from. They are in the order in which the bot asks; where it leaves the kind or the job open,
                the oldest word or bundle comes first, the letters of a word in order.
            station: The station, its open words or its staged bundles.
            contents: What the bucket holds, as tile kind to count.
            rng: For all random draws.
        """

    def next_visit(self, waiting: Sequence[Waiting], rng: Generator) -> int:
        """The request that is served next, by its index; unless overridden the one that came first.

        Args:
            waiting: All requests that wait, in the order in which they came; at least two.
            rng: For all random draws.
        """
        return 0

    def capture(self) -> Any:
        """What a policy remembers, for a checkpoint: plain JSON values. Override it, and `restore`, if it does."""
        return None

    def restore(self, state: Any) -> None:
        """The opposite of `capture`."""
        return None


class WordStationPolicy(StationPolicy[WordStationState]):
    """Decides which tile comes next, and which open word it goes to. Implement `choose`; nothing else is needed."""


class LetterStationPolicy(StationPolicy[LetterStationState]):
    """Decides which staged bundle the next tile comes from. Implement `choose`; nothing else is needed."""


class WordsAsAsked(WordStationPolicy):
    """First come, first served, as the bots ask; where they leave it open, the oldest word that lacks a tile."""

    takes_first = True

    def choose(self, moves: Moves, station: WordStationState, contents: Contents, rng: Generator) -> int:
        """The first."""
        return 0


class NearlyDone(WordStationPolicy):
    """What ends soonest comes first: the word that lacks the fewest letters, the request for the fewest tiles."""

    def choose(self, moves: Moves, station: WordStationState, contents: Contents, rng: Generator) -> int:
        """Of equals the first."""
        lacks = {word.word: len(word.missing) for word in station.open_words}
        return min(range(len(moves)), key=lambda index: lacks[moves[index].job])

    def next_visit(self, waiting: Sequence[Waiting], rng: Generator) -> int:
        """The shortest; of equals the first."""
        return shortest(waiting)


class BundlesAsAsked(LetterStationPolicy):
    """First come, first served, as the bots ask; where they leave it open, the oldest bundle."""

    takes_first = True

    def choose(self, moves: Moves, station: LetterStationState, contents: Contents, rng: Generator) -> int:
        """The first."""
        return 0


class NearlyEmpty(LetterStationPolicy):
    """What ends soonest comes first: the bundle with the fewest tiles left, the request for the fewest tiles."""

    def choose(self, moves: Moves, station: LetterStationState, contents: Contents, rng: Generator) -> int:
        """Of equals the first."""
        left = {bundle.bundle: bundle.count for bundle in station.staged_bundles}
        return min(range(len(moves)), key=lambda index: left[moves[index].job])

    def next_visit(self, waiting: Sequence[Waiting], rng: Generator) -> int:
        """The shortest; of equals the first."""
        return shortest(waiting)


def shortest(waiting: Sequence[Waiting]) -> int:
    """The request for the fewest tiles; of equals the first."""
    return min(range(len(waiting)), key=lambda index: len(waiting[index].moves))


WORD_STATION: dict[str, type[WordStationPolicy]] = {"as_asked": WordsAsAsked, "nearly_done": NearlyDone}
LETTER_STATION: dict[str, type[LetterStationPolicy]] = {"as_asked": BundlesAsAsked, "nearly_empty": NearlyEmpty}
Maker = Callable[[], StationPolicy[Any]]


def station_policies(scenario: Scenario, source: object = "scenario") -> tuple[Maker, Maker]:
    """What makes the policies of a scenario's word stations, and of its letter stations.

    Raises:
        InputError: There is no such policy, or it is of the wrong kind; from a maker: its options do not fit.
    """
    word, letter = scenario.word_station.policy, scenario.letter_station.policy
    return (
        policy_maker(word, f"{source}: word_station.policy", WORD_STATION, WordStationPolicy),
        policy_maker(letter, f"{source}: letter_station.policy", LETTER_STATION, LetterStationPolicy),
    )
