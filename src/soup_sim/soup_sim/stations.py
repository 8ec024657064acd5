"""Stations: each does one thing at a time, and blocks until it is done (paper, "Architecture")."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import Any

from soup_msgs_py.codes import Code
from soup_msgs_py.messages import Bundle, LetterStationState, TileMove, Word, WordStationState
from soup_msgs_py.tiles import tile_name

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
    """A bot's request to move tiles, while the station works on it."""

    bot: int
    request: int
    moves: deque[TileMove]
    moved: int = 0
    asked: int = 0
    problem: tuple[Code, str] | None = None


@dataclass(slots=True)
class Station:
    """What both kinds have in common: a place, a queue of requests, one thing at a time.

    Attributes:
        number: Number of the station, over both kinds.
        transfer_s: Time that moving one tile takes.
        visits: Requests, the one being served first.
        busy: Whether something is under way: a transfer, or clearing a finished word.
        move: The transfer under way, kind and job chosen.
    """

    number: int
    x: float
    y: float
    transfer_s: float
    tolerance_m: float
    visits: deque[Visit] = field(default_factory=deque)
    busy: bool = False
    move: TileMove | None = None

    @property
    def bot(self) -> int:
        """The bot that is served now, -1 for none."""
        return self.visits[0].bot if self.visits else -1

    def choose(self, wanted: TileMove, contents: Contents, room: int) -> TileMove | tuple[Code, str]:
        """Which tile a wished move really is, or why it can't be.

        Args:
            wanted: The wish; -1 leaves the kind or the job open.
            contents: What the bucket holds.
            room: Tiles that still fit into it.
        """
        raise NotImplementedError

    def capture(self) -> dict[str, Any]:
        """Everything that changes, for a checkpoint."""
        return {
            "visits": [
                [v.bot, v.request, [(move.tile, move.job) for move in v.moves], v.moved, v.asked, v.problem]
                for v in self.visits
            ],
            "busy": self.busy,
            "move": None if self.move is None else (self.move.tile, self.move.job),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """The opposite of `capture`."""
        self.visits = deque(
            Visit(
                bot,
                request,
                deque(TileMove(*move) for move in moves),
                moved,
                asked,
                None if problem is None else (Code(problem[0]), problem[1]),
            )
            for bot, request, moves, moved, asked, problem in state["visits"]
        )
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

    def choose(self, wanted: TileMove, contents: Contents, room: int) -> TileMove | tuple[Code, str]:
        """See `Station.choose`: the oldest open word that needs the tile gets it."""
        words = [o for o in self.open_words if wanted.job in (-1, o.word.word)]
        if not words:
            return Code.NOT_NEEDED, f"word {wanted.job} is not open on word station {self.number}"
        for word in words:
            for kind, there in zip(word.word.tiles, word.filled, strict=True):
                if not there and wanted.tile in (-1, kind) and contents.get(kind, 0) > 0:
                    return TileMove(kind, word.word.word)
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

    def choose(self, wanted: TileMove, contents: Contents, room: int) -> TileMove | tuple[Code, str]:
        """See `Station.choose`: the oldest staged bundle that fits gives the tile."""
        if room <= 0:
            return Code.BUCKET_FULL, "the bucket is full; bring one with room"
        for staged in self.staged:
            if wanted.job in (-1, staged.bundle) and wanted.tile in (-1, staged.tile) and staged.left > 0:
                return TileMove(staged.tile, staged.bundle)
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
