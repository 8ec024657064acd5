"""Stations: each does one thing at a time, and blocks until it is done (paper, "Architecture")."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from soup_msgs_py.codes import Code
from soup_msgs_py.errors import RunError
from soup_msgs_py.messages import Bundle, LetterStationState, TileMove, Word, WordStationState
from soup_msgs_py.warehouse.tiles import tile_name
from soup_sim.station_policies import StationPolicy, Waiting

Contents = dict[int, int]


@dataclass(slots=True)
class OpenWord:
    """A word that a word station works on."""

    word: Word
    filled: list[bool]

    def place_for(self, tile: int) -> int:
        """The first place that still needs this tile kind, or -1."""
        for place, (kind, there) in enumerate(zip(self.word.tiles, self.filled, strict=True)):
            if kind == tile and not there:
                return place
        return -1


@dataclass(slots=True)
class StagedBundle:
    """A bundle that is staged on a letter station."""

    bundle: int
    tile: int
    left: int


@dataclass(slots=True)
class Visit:
    """A bot's request to move tiles, while it waits and while the station works on it."""

    bot: int
    request: int
    moves: list[TileMove]
    moved: int = 0
    asked: int = 0
    problem: tuple[Code, str] | None = None
    begun: bool = False


@dataclass(slots=True)
class Station:
    """What both kinds have in common: a place, a queue of requests, one thing at a time.

    Attributes:
        number: Number of the station, over both kinds.
        transfer_s: Time that moving one tile takes.
        policy: What it decides by itself.
        rng: For the policy's random draws; all stations share it.
        visits: Requests in the order in which they came, but the one being served first.
        busy: Whether something is under way: a transfer, or clearing a finished word.
        move: The transfer under way, kind and job chosen.
    """

    number: int
    x: float
    y: float
    transfer_s: float
    tolerance_m: float
    policy: StationPolicy[Any]
    rng: np.random.Generator
    visits: list[Visit] = field(default_factory=list)
    busy: bool = False
    move: TileMove | None = None

    @property
    def bot(self) -> int:
        """The bot that is served now, -1 for none."""
        return self.visits[0].bot if self.visits and self.visits[0].begun else -1

    def begin_visit(self, contents_of: Callable[[int], Contents]) -> Visit:
        """Go on with the request being served, or take the next one, which the policy names.

        Args:
            contents_of: What the bucket on a bot holds.
        """
        if not self.visits[0].begun:
            if len(self.visits) > 1:
                waiting = [Waiting(v.bot, tuple(v.moves), contents_of(v.bot)) for v in self.visits]
                chosen = self._checked(self.policy.next_visit(waiting, self.rng), len(waiting))
                self.visits.insert(0, self.visits.pop(chosen))
            self.visits[0].begun = True
        return self.visits[0]

    def next_move(self, visit: Visit, contents: Contents, room: int) -> TileMove | None:
        """What is moved next of what a visit asks for; None for nothing, and the visit knows why.

        Args:
            visit: The visit; the move is taken out of it.
            contents: What the bucket holds.
            room: Tiles that still fit into it.
        """
        moves: dict[TileMove, TileMove] = {}  # what can be done, and the wish that it fulfils
        for wanted in dict.fromkeys(visit.moves):
            possible = self.possible(wanted, contents, room)
            if isinstance(possible, tuple):
                visit.problem = visit.problem or possible
            else:
                for move in possible:
                    moves.setdefault(move, wanted)
                if self.policy.takes_first:
                    break
        if not moves:
            visit.moves.clear()
            return None
        visit.problem = None  # what was impossible is looked at again
        move = self._decide(list(moves), contents)
        visit.moves.remove(moves[move])
        return move

    def possible(self, wanted: TileMove, contents: Contents, room: int) -> list[TileMove] | tuple[Code, str]:
        """Which moves would fulfil a wish (-1 leaves the kind or the job open), or why none can be."""
        raise NotImplementedError

    def state(self) -> Any:
        """What others see."""
        raise NotImplementedError

    def _decide(self, moves: list[TileMove], contents: Contents) -> TileMove:
        """One of the moves that are possible."""
        if len(moves) == 1 or self.policy.takes_first:
            return moves[0]
        return moves[self._checked(self.policy.choose(moves, self.state(), contents, self.rng), len(moves))]

    def _checked(self, index: object, count: int) -> int:
        if not (isinstance(index, (int, np.integer)) and 0 <= index < count):
            name = type(self.policy).__name__
            raise RunError(f"station {self.number}: policy {name} chose number {index}; allowed: 0 to {count - 1}")
        return int(index)

    def capture(self) -> dict[str, Any]:
        """Everything that changes, for a checkpoint."""
        return {
            "visits": [
                [v.bot, v.request, [(move.tile, move.job) for move in v.moves], v.moved, v.asked, v.problem, v.begun]
                for v in self.visits
            ],
            "policy": self.policy.capture(),
            "busy": self.busy,
            "move": None if self.move is None else (self.move.tile, self.move.job),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """The opposite of `capture`."""
        self.visits = [
            Visit(
                bot,
                request,
                [TileMove(*move) for move in moves],
                moved,
                asked,
                None if problem is None else (Code(problem[0]), problem[1]),
                begun,
            )
            for bot, request, moves, moved, asked, problem, begun in state["visits"]
        ]
        self.policy.restore(state["policy"])
        self.busy = state["busy"]
        self.move = None if state["move"] is None else TileMove(*state["move"])


@dataclass(slots=True)
class WordStation(Station):
    """Takes tiles out of buckets and builds words. It takes only tiles that its open words need."""

    places: int = 4
    clear_s: float = 0.0
    open_words: list[OpenWord] = field(default_factory=list)

    def has_place(self) -> bool:
        """Whether another word can be opened."""
        return len(self.open_words) < self.places

    def find(self, word: int) -> OpenWord | None:
        """An open word by its number."""
        return next((o for o in self.open_words if o.word.word == word), None)

    def possible(self, wanted: TileMove, contents: Contents, room: int) -> list[TileMove] | tuple[Code, str]:
        """See `Station.possible`: the oldest word first, its letters in order."""
        if wanted.job != -1 and contents.get(wanted.tile, 0) > 0:  # what is asked for most, and quickly answered
            word = self.find(wanted.job)
            if word is not None and word.place_for(wanted.tile) >= 0:
                return [wanted]
        words = [o for o in self.open_words if wanted.job in (-1, o.word.word)]
        if not words:
            return Code.NOT_NEEDED, f"word {wanted.job} is not open on word station {self.number}"
        moves = {
            TileMove(kind, word.word.word): None
            for word in words
            for kind, there in zip(word.word.tiles, word.filled, strict=True)
            if not there and wanted.tile in (-1, kind) and contents.get(kind, 0) > 0
        }
        if moves:
            return list(moves)
        name = tile_name(wanted.tile)
        if wanted.tile != -1 and contents.get(wanted.tile, 0) == 0:
            return Code.NOT_IN_BUCKET, f"the bucket holds no {name}"
        if wanted.tile == -1:
            return Code.NOT_NEEDED, f"the bucket holds no letter that word station {self.number} needs"
        return Code.NOT_NEEDED, f"no open word of word station {self.number} needs {name}"

    def state(self) -> WordStationState:
        """What others see."""
        words = tuple(Word(o.word.word, o.word.text, o.word.tiles, tuple(o.filled)) for o in self.open_words)
        return WordStationState(self.number, self.x, self.y, self.bot, words)

    def capture(self) -> dict[str, Any]:
        """See `Station.capture`."""
        words = [(o.word.word, o.word.text, o.word.tiles, o.filled) for o in self.open_words]
        return {**Station.capture(self), "open_words": words}

    def restore(self, state: dict[str, Any]) -> None:
        """See `Station.restore`."""
        Station.restore(self, state)
        self.open_words = [
            OpenWord(Word(number, text, tuple(tiles)), list(filled))
            for number, text, tiles, filled in state["open_words"]
        ]


@dataclass(slots=True)
class LetterStation(Station):
    """Puts the tiles of staged bundles into buckets that have room."""

    places: int = 4
    staged: list[StagedBundle] = field(default_factory=list)

    def has_place(self) -> bool:
        """Whether another bundle can be staged."""
        return len(self.staged) < self.places

    def find(self, bundle: int) -> StagedBundle | None:
        """A staged bundle by its number."""
        return next((s for s in self.staged if s.bundle == bundle), None)

    def possible(self, wanted: TileMove, contents: Contents, room: int) -> list[TileMove] | tuple[Code, str]:
        """See `Station.possible`: the oldest bundle first."""
        if room <= 0:
            return Code.BUCKET_FULL, "the bucket is full; bring one with room"
        moves = [
            TileMove(staged.tile, staged.bundle)
            for staged in self.staged
            if wanted.job in (-1, staged.bundle) and wanted.tile in (-1, staged.tile) and staged.left > 0
        ]
        if moves:
            return moves
        what = tile_name(wanted.tile) or (f"bundle {wanted.job}" if wanted.job != -1 else "bundle")
        return Code.NOTHING_STAGED, f"no {what} is staged on letter station {self.number}"

    def state(self) -> LetterStationState:
        """What others see."""
        bundles = tuple(Bundle(s.bundle, s.tile, s.left) for s in self.staged)
        return LetterStationState(self.number, self.x, self.y, self.bot, bundles)

    def capture(self) -> dict[str, Any]:
        """See `Station.capture`."""
        return {**Station.capture(self), "staged": [(s.bundle, s.tile, s.left) for s in self.staged]}

    def restore(self, state: dict[str, Any]) -> None:
        """See `Station.restore`."""
        Station.restore(self, state)
        self.staged = [StagedBundle(*values) for values in state["staged"]]
