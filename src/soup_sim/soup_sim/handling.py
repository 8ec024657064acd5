"""Bots and buckets at work: grab, release and transfer, and the stations."""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np
from numpy.typing import NDArray

from soup_msgs_py.codes import BotState, Code, EventType
from soup_msgs_py.layout import Layout
from soup_msgs_py.messages import Grab, Release, Transfer
from soup_msgs_py.scenario import Scenario
from soup_sim.agenda import Common
from soup_sim.stations import LetterStation, Station, Visit, WordStation

_MOST_MOVES = 10_000


class Handling:
    """Carries out grabs, releases and transfers.

    Args:
        common: Time, bodies, statistics.
        scenario: The scenario.
        layout: The floor.
        contents: Tile kind to count, for each bucket.
    """

    def __init__(
        self,
        common: Common,
        scenario: Scenario,
        layout: Layout,
        contents: list[dict[int, int]],
    ) -> None:
        self._common, self._agenda, self._bodies = common, common.agenda, common.bodies
        self._scenario, self._layout = scenario, layout
        self.contents = contents
        self.tiles = _totals(contents)
        self.words_completed = 0
        self.words = [_word_station(scenario, layout, k) for k in range(scenario.word_station_count)]
        first = scenario.word_station_count
        self.letters = [_letter_station(scenario, layout, first + k) for k in range(scenario.letter_station_count)]
        self.stations: list[Station] = [*self.words, *self.letters]
        self._station_xy = np.array([(s.x, s.y) for s in self.stations]).reshape(-1, 2)
        self._spot_xy = layout.waypoints[layout.storage_spots]
        self._cell = max(1.0, 2.0 * scenario.bot.tolerance_m)
        self._spots_near: dict[tuple[int, int], list[int]] = {}
        for spot, (x, y) in enumerate(self._spot_xy.tolist()):
            self._spots_near.setdefault((int(x // self._cell), int(y // self._cell)), []).append(spot)
        self.spot_bucket = [-1] * len(self._spot_xy)
        self.bucket_spot = [-1] * len(contents)
        self._agenda.can(
            grabbed=self._grabbed, released=self._released, transferred=self._transferred, cleared=self._cleared
        )

    # ---- grab and release -----------------------------------------------------------------------------------

    def grab(self, request: Grab) -> None:
        """Lift a bucket that is within tolerance; takes `grab_s`."""
        bot, bucket = request.bot, request.bucket
        problem = self._stands_ready(bot) or self._grab_problem(bot, bucket)
        if problem is not None:
            self._common.answer(bot, request.request, *problem)
            return
        x, y = self._bodies.place(bot, self._agenda.now)
        if bucket == -1:
            bucket, _ = self._bodies.nearest_resting_bucket(x, y)
        self._begin(bot, BotState.GRABBING)
        self._agenda.at(self._agenda.now + self._scenario.bot.grab_s, "grabbed", bot, request.request, bucket)

    def _grab_problem(self, bot: int, bucket: int) -> tuple[Code, str] | None:
        bodies, now, tolerance = self._bodies, self._agenda.now, self._scenario.bot.tolerance_m
        carried = int(bodies.bucket[bot])
        if carried >= 0:
            return Code.ALREADY_CARRYING, f"bot {bot} carries bucket {carried}; release it first"
        if not -1 <= bucket < len(bodies.carrier):
            return Code.UNKNOWN, f"there is no bucket {bucket}; they are 0 to {len(bodies.carrier) - 1}"
        x, y = bodies.place(bot, now)
        if bucket == -1:
            bucket, away = bodies.nearest_resting_bucket(x, y)
            if away > tolerance:
                what = f"bucket {bucket} is nearest, {away:.3f} m away" if bucket >= 0 else "none rests anywhere"
                return Code.OUT_OF_TOLERANCE, f"no bucket within {tolerance:g} m of bot {bot}; {what}"
        else:
            if bodies.carrier[bucket] >= 0:
                return Code.BUCKET_TAKEN, f"bot {int(bodies.carrier[bucket])} carries bucket {bucket}"
            bx, by = bodies.bucket_place(bucket, now)
            away = float(np.sqrt((bx - x) ** 2 + (by - y) ** 2))
            if away > tolerance:
                return Code.OUT_OF_TOLERANCE, (
                    f"bucket {bucket} is {away:.3f} m from bot {bot}, at ({bx:.3f}, {by:.3f}); "
                    f"come within {tolerance:g} m"
                )
        if not bodies.bucket_fits(bucket, x, y):
            return Code.BLOCKED, f"bucket {bucket} would touch another one, lifted here; stand closer to its middle"
        return None

    def _grabbed(self, bot: int, request: int, bucket: int) -> None:
        spot, self.bucket_spot[bucket] = self.bucket_spot[bucket], -1
        if spot >= 0:
            self.spot_bucket[spot] = -1
        self._bodies.lift(bot, bucket)
        self._end(bot)
        x, y = self._bodies.place(bot, self._agenda.now)
        self._common.emit(EventType.GRABBED, bot=bot, bucket=bucket, x=x, y=y)
        self._common.answer(bot, request, Code.DONE, f"bot {bot} carries bucket {bucket}")

    def release(self, request: Release) -> None:
        """Set the carried bucket down on a free storage spot within tolerance; takes `release_s`."""
        bot = request.bot
        problem = self._stands_ready(bot)
        spot = -1
        if problem is None:
            problem, spot = self._release_problem(bot)
        if problem is not None:
            self._common.answer(bot, request.request, *problem)
            return
        self.spot_bucket[spot] = int(self._bodies.bucket[bot])
        self._begin(bot, BotState.RELEASING)
        self._agenda.at(self._agenda.now + self._scenario.bot.release_s, "released", bot, request.request, spot)

    def _release_problem(self, bot: int) -> tuple[tuple[Code, str] | None, int]:
        if self._bodies.bucket[bot] < 0:
            return (Code.NOT_CARRYING, f"bot {bot} carries no bucket"), -1
        x, y = self._bodies.place(bot, self._agenda.now)
        spot = self.spot_at(x, y)
        if spot < 0:
            tolerance = self._scenario.bot.tolerance_m
            return (
                Code.OUT_OF_TOLERANCE,
                f"no storage spot within {tolerance:g} m of bot {bot} at ({x:.3f}, {y:.3f}); buckets rest on them only",
            ), -1
        if self.spot_bucket[spot] >= 0:
            return (Code.SPOT_TAKEN, f"bucket {self.spot_bucket[spot]} rests on this storage spot already"), -1
        return None, spot

    def _released(self, bot: int, request: int, spot: int) -> None:
        bucket = self._bodies.set_down(bot, self._agenda.now)
        self.bucket_spot[bucket] = spot
        self._end(bot)
        x, y = self._bodies.place(bot, self._agenda.now)
        self._common.emit(EventType.RELEASED, bot=bot, bucket=bucket, x=x, y=y)
        self._common.answer(bot, request, Code.DONE, f"bucket {bucket} rests at ({x:.3f}, {y:.3f})")

    def spot_at(self, x: float, y: float) -> int:
        """The storage spot within tolerance of a place, or -1."""
        tolerance = self._scenario.bot.tolerance_m
        cx, cy = int(x // self._cell), int(y // self._cell)
        best, best_square = -1, tolerance * tolerance
        for kx in (cx - 1, cx, cx + 1):
            for ky in (cy - 1, cy, cy + 1):
                for spot in self._spots_near.get((kx, ky), ()):
                    sx, sy = self._spot_xy[spot]
                    square = (sx - x) ** 2 + (sy - y) ** 2
                    if square <= best_square:
                        best, best_square = spot, square
        return best

    # ---- transfer -------------------------------------------------------------------------------------------

    def transfer(self, request: Transfer) -> None:
        """Move tiles one after another; each takes the station's `transfer_s`."""
        bot = request.bot
        problem = self._stands_ready(bot) or self._transfer_problem(request)
        if problem is not None:
            self._common.answer(bot, request.request, *problem)
            return
        station = self.stations[self._station_here(bot) if request.station == -1 else request.station]
        self._begin(bot, BotState.TRANSFERRING)
        station.visits.append(Visit(bot, request.request, deque(request.moves), asked=len(request.moves)))
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
            visit = station.visits[0]
            bucket = int(self._bodies.bucket[visit.bot])
            while visit.moves:
                room = self._scenario.bucket.capacity - int(self.tiles[bucket])
                chosen = station.choose(visit.moves.popleft(), self.contents[bucket], room)
                if isinstance(chosen, tuple):
                    visit.problem = visit.problem or chosen
                    continue
                self._set_busy(station, True)
                station.move = chosen
                self._agenda.at(self._agenda.now + station.transfer_s, "transferred", station.number)
                return
            station.visits.popleft()
            self._end(visit.bot)
            code, message = visit.problem or (Code.DONE, "")
            text = f"{visit.moved} of {visit.asked} tiles moved" + (f"; {message}" if message else "")
            self._common.answer(visit.bot, visit.request, code, text)

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

    # ---- shared ---------------------------------------------------------------------------------------------

    def _stands_ready(self, bot: int) -> tuple[Code, str] | None:
        problem = self._common.hindrance(bot)
        if problem is None and self._bodies.moving[bot]:
            return Code.MOVING, f"bot {bot} is moving; stop it first"
        return problem

    def _begin(self, bot: int, state: BotState) -> None:
        self._common.operation[bot] = state
        self._common.note_state(bot)

    def _end(self, bot: int) -> None:
        self._common.operation[bot] = None
        self._common.note_state(bot)

    def _set_busy(self, station: Station, busy: bool) -> None:
        station.busy = busy
        self._common.statistics.station_busy(station.number, busy, self._agenda.now)

    # ---- checkpoint -----------------------------------------------------------------------------------------

    def capture(self) -> dict[str, Any]:
        """Everything that this part remembers, for a checkpoint."""
        return {
            "contents": [sorted(content.items()) for content in self.contents],
            "spot_bucket": self.spot_bucket,
            "bucket_spot": self.bucket_spot,
            "words_completed": self.words_completed,
            "stations": [station.capture() for station in self.stations],
        }

    def restore(self, state: dict[str, Any]) -> None:
        """The opposite of `capture`."""
        self.contents[:] = [dict(map(tuple, content)) for content in state["contents"]]
        self.tiles = _totals(self.contents)
        self.spot_bucket, self.bucket_spot = list(state["spot_bucket"]), list(state["bucket_spot"])
        self.words_completed = state["words_completed"]
        for station, captured in zip(self.stations, state["stations"], strict=True):
            station.restore(captured)


def _totals(contents: list[dict[int, int]]) -> NDArray[np.uint16]:
    """Tiles in each bucket."""
    return np.array([sum(content.values()) for content in contents], dtype=np.uint16)


def _word_station(scenario: Scenario, layout: Layout, number: int) -> WordStation:
    x, y = layout.station_xy(number)
    values = scenario.word_station
    return WordStation(
        number, x, y, values.transfer_s, values.tolerance_m, places=values.open_words, clear_s=values.clear_s
    )


def _letter_station(scenario: Scenario, layout: Layout, number: int) -> LetterStation:
    x, y = layout.station_xy(number)
    values = scenario.letter_station
    return LetterStation(number, x, y, values.transfer_s, values.tolerance_m, places=values.staged_bundles)
