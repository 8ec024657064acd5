"""What the decisions of the coordinated fleet may know: stock, demand, bots, and the ways between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from soup_managers.contents import Contents, tiles_of
from soup_managers.state.jobs import StationBook
from soup_managers.state.places import Mask, Places
from soup_managers.state.robots import Activity, Purpose, Robot
from soup_managers.view import WarehouseView
from soup_msgs_py.warehouse.layout import Floats, Ints

if TYPE_CHECKING:
    from soup_managers.traffic import Traffic

IDEAL_TIMES = 2.0  # so many times the bots that an ideal fleet needs make it reach the pace of the stations
TINY_S = 1e-6  # stands for transfers that take no time
FETCH_S = 10.0  # a usual time for a bot to get to a bucket


@dataclass(frozen=True, slots=True, eq=False)
class Want:
    """A word station that needs another bucket.

    Attributes:
        station: The station.
        ahead_s: Work that it has ahead: what buckets bound for it bring (s).
        tiles: How many tiles that nobody brings yet each bucket holds, shape (buckets,).
        travel_s: The way of each bucket to the station (s), shape (buckets,).
        transfer_s: Time that a tile takes there.
        bot_s: Where bots are scarce, the way to each bucket of the bot that would fetch it (s), shape (buckets,); None
            where there is a bot for every station.
    """

    station: int
    ahead_s: float
    tiles: Ints
    travel_s: Floats
    transfer_s: float
    bot_s: Floats | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Fill:
    """A letter station that needs another bucket to fill.

    Attributes:
        station: The station.
        ahead_s: Work that it has ahead: the room in buckets bound for it (s).
        tiles: Kinds of the tiles that are staged there.
        room: How many more tiles go into each bucket, shape (buckets,).
        travel_s: The way of each bucket to the station (s), shape (buckets,).
        transfer_s: Time that a tile takes there.
    """

    station: int
    ahead_s: float
    tiles: NDArray[np.int64]
    room: Ints
    travel_s: Floats
    transfer_s: float


@dataclass(frozen=True, slots=True)
class Horizons:
    """How far the fleet looks ahead.

    Attributes:
        word_s: A word station is short if it has less work ahead (s) when a bucket from anywhere could be there.
        letter_s: The same for a letter station.
        most: Buckets bound for a station at the same time, at most.
        word_least: A word station with fewer is short, whatever they bring.
        letter_least: The same for a letter station.
        least_room: A bucket with less room is not filled, while there are others: tiles or, below 1, a share of the
            capacity of a bucket.
    """

    word_s: float = 60.0
    letter_s: float = 60.0
    most: int = 7
    word_least: int = 3
    letter_least: int = 1
    least_room: float = 0.4


class PlanningState:
    """The fleet's books, as its decisions see them. Read only for policies.

    Attributes:
        view: The warehouse as the world tells it.
        layout: The floor.
        traffic: The ways, and who has reserved them.
        places: Which waypoints are taken.
        tasks: Words and bundles that are to be served.
        robots: The bots.
        rng: For all random draws of policies.
        docks: The waypoint of each station.
        closed: Whether a bot that does not answer stands in each station's line, shape (stations,).
        bound: The bots that are bound for each station, in the order of their binding.
        first_place: Where each bucket was when the fleet manager began (m), shape (buckets, 2).
        robot_xy: Where each bot stands or will stand (m), shape (bots, 2).
        approach_s: The way from a storage spot to each station, on average (s).
        to_words_s: The way from each waypoint to the nearest word station (s), shape (waypoints,).
        kind_share: Share of each kind in all tiles in buckets at the start, shape (kinds,).
        fetch_s: A usual time for a bot to get to a bucket (s).
    """

    fetch_s = FETCH_S

    def __init__(self, view: WarehouseView, traffic: Traffic, horizons: Horizons, rng: np.random.Generator) -> None:
        scenario, layout = view.scenario, view.layout
        self.view, self.layout, self.traffic, self.horizons, self.rng = view, layout, traffic, horizons, rng
        self.places = Places(view)
        self.word_stations = len(layout.word_stations)
        self.docks: list[int] = layout.stations.tolist()
        self.robots = [Robot(bot) for bot in range(scenario.bots)]
        self.robot_xy = np.zeros((scenario.bots, 2))
        self.closed = np.zeros(len(self.docks), bool)
        self.bound: list[list[Robot]] = [[] for _ in self.docks]
        self.tasks = StationBook(len(self.docks), view.kinds, self.changed)
        self._word_transfer_s = scenario.word_station.transfer_s
        self._letter_transfer_s = scenario.letter_station.transfer_s
        self.to_words_s = np.min([traffic.times_to(dock) for dock in self.docks[: self.word_stations]], axis=0)
        spots = layout.storage_spots
        self.approach_s = [float(traffic.times_to(dock)[spots].mean()) for dock in self.docks]
        self.first_place = np.zeros((0, 2))
        self._outlooks: dict[int, tuple[float, NDArray[np.int64], Ints]] = {}
        self._is_fleet_small = self._needs_all_bots()
        self.take_over()

    def take_over(self) -> None:
        """Begin with what the view knows now."""
        view = self.view
        self._outlooks.clear()
        self.kind_share = self.stock.tiles.sum(axis=1) / max(1, int(self.stock.total.sum()))
        if len(self.first_place) != len(view.bucket_x):
            self.first_place = np.stack([view.bucket_x, view.bucket_y], axis=1).copy()

    # ---- buckets -------------------------------------------------------------------------------------------

    @property
    def stock(self) -> Contents:
        """Tiles in buckets."""
        return self.view.contents

    @property
    def spot_of(self) -> NDArray[np.int64]:
        """The storage spot of each bucket (waypoint), shape (buckets,)."""
        return self.view.spot_of

    @property
    def free_buckets(self) -> Mask:
        """Which buckets rest on storage spots and are in nobody's plans, shape (buckets,)."""
        free = np.append((self.view.bucket_bot < 0) & (self.view.spot_of >= 0), False)  # the last one: no bucket, -1
        free[[robot.bucket for robot in self.robots]] = False
        free[[robot.target for robot in self.robots]] = False
        return free[:-1]

    # ---- times ---------------------------------------------------------------------------------------------

    def is_word_station(self, station: int) -> bool:
        """Whether words are assembled there."""
        return station < self.word_stations

    def transfer_s(self, station: int) -> float:
        """Time that one tile takes at a station (s)."""
        return self._word_transfer_s if station < self.word_stations else self._letter_transfer_s

    def travel_s(self, waypoint: int, station: int) -> float:
        """The way from a waypoint to a station without other traffic (s)."""
        return self.traffic.travel_time(waypoint, self.docks[station])

    def buckets_travel_s(self, station: int) -> Floats:
        """The way of each resting bucket to a station (s), shape (buckets,)."""
        return self.traffic.times_to(self.docks[station])[np.maximum(self.spot_of, 0)]

    def idle_bots(self) -> list[int]:
        """The bots that stand with nothing to do and nothing on them, ascending."""
        stands, none = Activity.STANDS, Purpose.NONE  # looked up once: all bots are asked every second
        return [r.number for r in self.robots if r.activity is stands and r.purpose is none and r.bucket < 0]

    def bots_are_scarce(self) -> bool:
        """Whether there are too few bots for all stations, and fewer idle ones than stations that want a bucket."""
        if not self._is_fleet_small:
            return False
        return len(self.idle_bots()) < len(self.short_word_stations()) + len(self.short_letter_stations())

    def _needs_all_bots(self) -> bool:
        """Whether the stations could use more bots than there are.

        A letter costs a bot its two transfers and, in a full bucket, its share of the way from the word stations to the
        letter stations and back; with all that is not ideal, about `IDEAL_TIMES` as much.
        """
        words, letters = range(self.word_stations), range(self.word_stations, len(self.docks))
        out_s = np.mean([min(self.travel_s(self.docks[word], letter) for letter in letters) for word in words])
        back_s = np.mean([min(self.travel_s(self.docks[letter], word) for word in words) for letter in letters])
        scenario = self.view.scenario
        word_s, letter_s = self._word_transfer_s, self._letter_transfer_s
        bot_s = word_s + letter_s + float(out_s + back_s) / scenario.bucket.capacity
        # letters a second that the stations take, times bot seconds a letter
        return scenario.bots < IDEAL_TIMES * bot_s * min(
            len(words) / max(word_s, TINY_S), len(letters) / max(letter_s, TINY_S)
        )

    @property
    def missing_stock(self) -> float:
        """How much of the stock of the start is not there now, as a share of it; 0 where there is more."""
        scenario = self.view.scenario
        start = scenario.initial_inventory * scenario.bucket.capacity * scenario.buckets
        return max(0.0, 1.0 - float(self.stock.total.sum()) / start) if start > 0 else 0.0

    # ---- demand --------------------------------------------------------------------------------------------

    def room(self, bucket: int) -> int:
        """How many more tiles go into a bucket."""
        return self.stock.room(bucket)

    def tiles_of(self, amount: float) -> int:
        """An amount in tiles: below 1 it is a share of the capacity of a bucket."""
        return tiles_of(amount, self.stock.capacity)

    def changed(self, station: int) -> None:
        """What is bound for a station, or what it needs, is no longer what it was."""
        self._outlooks.pop(station, None)

    def outlook(self, station: int) -> tuple[float, NDArray[np.int64], Ints]:
        """What a word station has ahead (s), and the kinds and numbers of tiles that nobody brings yet."""
        known = self._outlooks.get(station)
        if known is None:
            known = self._outlooks[station] = self._look_ahead(station)
        return known

    def _look_ahead(self, station: int) -> tuple[float, NDArray[np.int64], Ints]:
        need = self.tasks.need(station)
        kinds = np.flatnonzero(need > 0)
        lack = need[kinds]
        ahead = 0
        for robot in self.bound[station]:
            serves = self.stock.serves(robot.load, kinds, lack)
            lack = lack - serves
            ahead += int(serves.sum())
        some = lack > 0
        return ahead * self._word_transfer_s, kinds[some], lack[some]

    def ahead_s(self, station: int) -> float:
        """Work that a station has ahead (s)."""
        if station < self.word_stations:
            return self.outlook(station)[0]
        return sum(self.room(robot.load) for robot in self.bound[station]) * self._letter_transfer_s

    def serves(self, bucket: int, station: int) -> int:
        """How many tiles a bucket could deliver to a word station that nobody else brings."""
        _, kinds, lack = self.outlook(station)
        return int(self.stock.serves(bucket, kinds, lack).sum())

    def spare(self, station: int) -> Ints:
        """Tiles in buckets bound for a word station that its open words do not need, shape (kinds,)."""
        left = self.tasks.need(station)
        spare = np.zeros(len(left), np.int32)
        for robot in self.bound[station]:
            there = self.stock.tiles[:, robot.load]
            used = np.minimum(there, left)
            left -= used
            spare += there - used
        return spare

    def short_word_stations(self) -> list[int]:
        """Word stations that want another bucket."""
        horizons = self.horizons
        short = []
        for station in range(self.word_stations):
            bound = len(self.bound[station])
            if bound < horizons.most and not self.closed[station]:
                ahead, kinds, _ = self.outlook(station)
                if len(kinds) and (bound < horizons.word_least or ahead < horizons.word_s + self.approach_s[station]):
                    short.append(station)
        return short

    def short_letter_stations(self) -> list[int]:
        """Letter stations that want another bucket."""
        horizons = self.horizons
        short = []
        for station in range(self.word_stations, len(self.docks)):
            bound = len(self.bound[station])
            few = bound < horizons.letter_least
            wanted = bound < horizons.most and self.tasks.at[station] and not self.closed[station]
            if wanted and (few or self.ahead_s(station) < horizons.letter_s + self.approach_s[station]):
                short.append(station)
        return short

    def want(self, station: int) -> Want:
        """What a word station wants."""
        ahead, kinds, lack = self.outlook(station)
        tiles = self.stock.served(kinds, lack)
        return Want(station, ahead, tiles, self.buckets_travel_s(station), self._word_transfer_s)

    def fill(self, station: int) -> Fill:
        """What a letter station wants."""
        tiles = [tile for task in self.tasks.at[station].values() for tile in task.missing]
        room = self.stock.capacity - self.stock.total
        kinds = np.array(tiles, np.int64)
        return Fill(
            station, self.ahead_s(station), kinds, room, self.buckets_travel_s(station), self._letter_transfer_s
        )

    def wanted_with(self, tiles: NDArray[np.int64]) -> Floats:
        """How often each kind is in a word, waiting or open, together with one of some kinds, shape (kinds,)."""
        asked = set(tiles.tolist())
        wanted = np.zeros(len(self.kind_share))
        words = [word.tiles for word in self.view.waiting_words.values()]
        words += [word.tiles for word in self.view.open_words.values()]
        for word in words:
            if not asked.isdisjoint(word):
                for tile in word:
                    wanted[tile] += 1.0
        return wanted
