"""Stations at work: letter tiles between the buckets on bots and the words and bundles on stations."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from soup_msgs_py.codes import BotState, Code, EventType
from soup_msgs_py.messages import Transfer
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Layout
from soup_sim.agenda import Common
from soup_sim.station_policies import station_policies
from soup_sim.stations import Contents, LetterStation, Station, Visit, WordStation

_MOST_MOVES = 10_000


class Serving:
    """Carries out transfers.

    Attributes:
        contents: Tile kind to count, for each bucket.
        tiles: Tiles in each bucket.
        words: The word stations.
        letters: The letter stations.
        stations: Both, by number.
        words_completed: Since the start.
    """

    def __init__(
        self,
        common: Common,
        scenario: Scenario,
        layout: Layout,
        contents: list[Contents],
        station_rng: np.random.Generator,
    ) -> None:
        """Begin with empty stations and full buckets; `station_rng` is for the station policies' random draws."""
        self._common, self._agenda, self._bodies = common, common.agenda, common.bodies
        self._scenario, self._layout = scenario, layout
        self.contents = contents
        self.tiles = _totals(contents)
        self.words_completed = 0
        self._rng = station_rng
        self.words, self.letters = _make_stations(scenario, layout, station_rng)
        self.stations: list[Station] = [*self.words, *self.letters]
        self._station_xy = np.array([(s.x, s.y) for s in self.stations]).reshape(-1, 2)
        self._agenda.can(transferred=self._transferred, cleared=self._cleared)

    def transfer(self, request: Transfer) -> None:
        """Move tiles one after another; each takes the station's `transfer_s`."""
        bot = request.bot
        problem = self._common.stands_ready(bot) or self._transfer_problem(request)
        if problem is not None:
            self._common.answer(bot, request.request, *problem)
            return
        station = self.stations[self._station_here(bot) if request.station == -1 else request.station]
        self._common.begin(bot, BotState.TRANSFERRING)
        station.visits.append(Visit(bot, request.request, list(request.moves), asked=len(request.moves)))
        self._serve(station)

    def end_soon(self) -> None:
        """End all requests with the tiles that are being moved now."""
        for station in self.stations:
            for visit in station.visits:
                visit.moves.clear()
            self._serve(station)

    def _transfer_problem(self, request: Transfer) -> tuple[Code, str] | None:
        bot, station = request.bot, request.station
        if self._bodies.bucket[bot] < 0:
            return Code.NOT_CARRYING, f"bot {bot} carries no bucket"
        if not -1 <= station < len(self.stations):
            return Code.UNKNOWN, f"there is no station {station}; they are 0 to {len(self.stations) - 1}"
        if not 1 <= len(request.moves) <= _MOST_MOVES:
            return Code.INVALID, f"{len(request.moves)} moves; ask for 1 to {_MOST_MOVES}"
        nearest = self._station_here(bot) if station == -1 else station
        there = self.stations[nearest]
        x, y = self._bodies.place(bot, self._agenda.now)
        away = float(np.sqrt((there.x - x) ** 2 + (there.y - y) ** 2))
        if away > there.tolerance_m:
            name = self._layout.station_name(nearest)
            return Code.OUT_OF_TOLERANCE, (
                f"{name} is {away:.3f} m from bot {bot}, at ({there.x:.3f}, {there.y:.3f}); "
                f"come within {there.tolerance_m:g} m"
            )
        return None

    def _station_here(self, bot: int) -> int:
        d = self._station_xy - self._bodies.place(bot, self._agenda.now)
        return int((d[:, 0] * d[:, 0] + d[:, 1] * d[:, 1]).argmin())

    def _serve(self, station: Station) -> None:
        """Start the next transfer of a station that has nothing under way."""
        while not station.busy and station.visits:
            visit = station.begin_visit(self._contents_on)
            bucket = int(self._bodies.bucket[visit.bot])
            room = self._scenario.bucket.capacity - int(self.tiles[bucket])
            move = station.next_move(visit, self.contents[bucket], room)
            if move is not None:
                self._set_busy(station, True)
                station.move = move
                self._agenda.at(self._agenda.now + station.transfer_s, "transferred", station.number)
                return
            station.visits.pop(0)
            self._common.end(visit.bot)
            code, message = visit.problem or (Code.DONE, "")
            text = f"{visit.moved} of {visit.asked} tiles moved" + (f"; {message}" if message else "")
            self._common.answer(visit.bot, visit.request, code, text)

    def _contents_on(self, bot: int) -> Contents:
        return self.contents[int(self._bodies.bucket[bot])]

    def _transferred(self, number: int) -> None:
        station = self.stations[number]
        visit, move = station.visits[0], station.move
        assert move is not None
        station.move = None
        self._set_busy(station, False)
        bucket = int(self._bodies.bucket[visit.bot])
        visit.moved += 1
        x, y = self._bodies.place(visit.bot, self._agenda.now)
        fields = {"bot": visit.bot, "bucket": bucket, "tile": move.tile, "job": move.job, "x": x, "y": y}
        if isinstance(station, WordStation):
            self._put(bucket, move.tile, -1)
            self._common.emit(EventType.TRANSFERRED, station=station.number, **fields)
            self._into_word(station, move.job, move.tile)
        elif isinstance(station, LetterStation):
            self._put(bucket, move.tile, 1)
            self._common.emit(EventType.TRANSFERRED, station=station.number, **fields)
            self._out_of_bundle(station, move.job)
        self._serve(station)

    def _put(self, bucket: int, tile: int, change: int) -> None:
        content = self.contents[bucket]
        count = content.get(tile, 0) + change
        if count:
            content[tile] = count
        else:
            del content[tile]
        self.tiles[bucket] = int(self.tiles[bucket]) + change

    def _into_word(self, station: WordStation, word: int, tile: int) -> None:
        entry = station.find(word)
        assert entry is not None
        entry.filled[entry.place_for(tile)] = True
        if all(entry.filled):
            self.words_completed += 1
            self._common.emit(EventType.WORD_COMPLETED, station=station.number, job=word, count=len(entry.filled))
            if station.clear_s > 0.0:
                self._set_busy(station, True)
                self._agenda.at(self._agenda.now + station.clear_s, "cleared", station.number, word)
            else:
                self._cleared(station.number, word)

    def _cleared(self, number: int, word: int) -> None:
        station = self.words[number]
        if station.clear_s > 0.0:
            self._set_busy(station, False)
        station.open_words = [o for o in station.open_words if o.word.word != word]
        self._common.emit(EventType.WORD_CLEARED, station=station.number, job=word)
        if station.clear_s > 0.0:
            self._serve(station)

    def _out_of_bundle(self, station: LetterStation, bundle: int) -> None:
        entry = station.find(bundle)
        assert entry is not None
        entry.left -= 1
        if entry.left == 0:
            station.staged.remove(entry)
            self._common.emit(EventType.BUNDLE_EMPTIED, station=station.number, job=bundle, tile=entry.tile)

    def _set_busy(self, station: Station, busy: bool) -> None:
        station.busy = busy
        self._common.statistics.station_busy(station.number, busy, self._agenda.now)

    def capture(self) -> dict[str, Any]:
        """Everything that this part remembers, for a checkpoint."""
        return {
            "contents": [sorted(content.items()) for content in self.contents],
            "words_completed": self.words_completed,
            "stations": [station.capture() for station in self.stations],
            "rng": self._rng.bit_generator.state,
        }

    def restore(self, state: dict[str, Any]) -> None:
        """The opposite of `capture`."""
        self.contents[:] = [dict(map(tuple, content)) for content in state["contents"]]
        self.tiles = _totals(self.contents)
        self.words_completed = state["words_completed"]
        for station, captured in zip(self.stations, state["stations"], strict=True):
            station.restore(captured)
        self._rng.bit_generator.state = state["rng"]


def _totals(contents: list[Contents]) -> NDArray[np.uint16]:
    """Tiles in each bucket."""
    return np.array([sum(content.values()) for content in contents], dtype=np.uint16)


def _make_stations(
    scenario: Scenario, layout: Layout, rng: np.random.Generator
) -> tuple[list[WordStation], list[LetterStation]]:
    make_word_policy, make_letter_policy = station_policies(scenario)
    first, word, letter = scenario.word_station_count, scenario.word_station, scenario.letter_station
    words = [
        WordStation(
            number, *layout.station_xy(number), word.transfer_s, word.tolerance_m, make_word_policy(), rng,
            places=word.open_words, clear_s=word.clear_s,
        )
        for number in range(first)
    ]  # fmt: skip
    letters = [
        LetterStation(
            number, *layout.station_xy(number), letter.transfer_s, letter.tolerance_m, make_letter_policy(), rng,
            places=letter.staged_bundles,
        )
        for number in range(first, first + scenario.letter_station_count)
    ]  # fmt: skip
    return words, letters
