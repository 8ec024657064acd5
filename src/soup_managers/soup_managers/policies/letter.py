"""Letter policies: which letters come in, and on which letter station."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np

from soup_managers.explain import Explain
from soup_managers.policies import room
from soup_managers.view import WarehouseView
from soup_msgs_py.errors import InputError
from soup_msgs_py.messages import AssignBundle
from soup_msgs_py.warehouse.layout import Floats
from soup_msgs_py.warehouse.tiles import tile_name


class LetterPolicy(ABC):
    """Decides what the letter stations dispense. Extend it and implement `choose`; nothing else is needed.

    A policy gets its options from the policies file as keyword arguments of its constructor. It may tell
    `self.explain` what its choices are made of: `--explain FILE` writes that down.
    """

    explain = Explain()

    @abstractmethod
    def choose(
        self, view: WarehouseView, stations: Sequence[int], target: Floats, rng: np.random.Generator
    ) -> AssignBundle | None:
        """Stage one bundle; asked again while places are free.

        Args:
            view: The warehouse. `view.stock` is what there is of each tile kind, `view.wanted` what open
                words lack.
            stations: The letter stations with a free place, in order; at least one.
            target: The stock of each tile kind at the start as it is expected, shape (kinds,).
            rng: For all random draws.

        Returns:
            A bundle that has arrived or, where the scenario's bundles are `chosen`, a new one of a tile kind;
            and one of the stations. Or None: rather none now. Then it is asked again when tiles leave the
            stock, a place becomes free or a second has passed.
        """


def emptiest(view: WarehouseView, stations: Sequence[int], tile: int, rng: np.random.Generator) -> int:
    """The station with the fewest staged bundles; of equals the first."""
    return max(stations, key=view.free_places.__getitem__)


def alike(view: WarehouseView, stations: Sequence[int], tile: int, rng: np.random.Generator) -> int:
    """A station where a bundle of the same kind is staged, so that buckets hold more of it; else the emptiest."""
    same = {bundle.station for bundle in view.staged_bundles.values() if bundle.tile == tile}
    return emptiest(view, [station for station in stations if station in same] or stations, tile, rng)


def anywhere(view: WarehouseView, stations: Sequence[int], tile: int, rng: np.random.Generator) -> int:
    """Any station."""
    return stations[int(rng.integers(len(stations)))]


STATIONS = {"emptiest": emptiest, "alike": alike, "random": anywhere}


class Minimal(LetterPolicy):
    """A steady stock: what was there at the start is brought back, the kind that is furthest below it first.

    Before that comes a kind of which open words lack more than there is: their places would be blocked for
    good. Bundles that have arrived are staged first in, first out.

    Args:
        station: Which station takes a bundle: `emptiest` (with the fewest), `alike` (with one of the same kind)
            or `random`.
    """

    def __init__(self, station: str = "emptiest") -> None:
        """Set the options; see the class."""
        if station not in STATIONS:
            raise InputError("letter policy", "options.station", repr(station), ", ".join(STATIONS))
        self._choose_station = STATIONS[station]

    def choose(
        self, view: WarehouseView, stations: Sequence[int], target: Floats, rng: np.random.Generator
    ) -> AssignBundle | None:
        """First arrived bundle, else the kind with the largest gap; none while the stock is full."""
        if view.waiting_bundles:
            bundle = next(iter(view.waiting_bundles.values()))
            return AssignBundle(self._station(view, stations, bundle.tile, rng), bundle=bundle.bundle)
        if view.scenario.bundles.kind != "chosen" or view.room < view.scenario.bundle_size:
            return None
        kind = self.choose_kind(view, target, rng)
        return AssignBundle(self._station(view, stations, kind, rng), tile=kind) if kind >= 0 else None

    def _station(self, view: WarehouseView, stations: Sequence[int], tile: int, rng: np.random.Generator) -> int:
        station = self._choose_station(view, stations, tile, rng)
        places = np.array([view.free_places[each] for each in stations])
        self.explain.choice("bundles", station, places, np.array(stations), tile=tile)
        return station

    def choose_kind(self, view: WarehouseView, target: Floats, rng: np.random.Generator) -> int:
        """The kind of the next bundle, where the letter manager decides what comes in; -1 for none now."""
        shortage = view.wanted - view.stock
        kind = int(shortage.argmax())
        if shortage[kind] > 0:
            self.explain.choice("letters", kind, np.maximum(shortage, 0), spelt=tile_name)
            return kind
        gap = target - view.stock
        kind = int(gap.argmax())
        # the sum of many small gaps must not fill the buckets with what nobody asks for
        if gap[kind] > 0 and gap.sum() > 0:
            self.explain.choice("letters", kind, gap, spelt=tile_name)
            return kind
        return -1


class Ahead(Minimal):
    """As `minimal`, but rare letters are fetched early: what the waiting words will lack comes before any other gap.

    Open words come first, then the words that wait, the oldest first: a letter of which there is less than they
    need together would block a word station later. What no open word lacks comes only while there is room for more.
    """

    def choose_kind(self, view: WarehouseView, target: Floats, rng: np.random.Generator) -> int:
        """A kind that open or waiting words lack, else as `minimal`."""
        left = view.stock - view.wanted
        if left.min() >= 0 and view.room - view.scenario.bundle_size < room.kept(view):
            return -1
        if left.min() >= 0 and (left - view.on_order).min() < 0:
            for word in view.waiting_words.values():
                for tile in word.tiles:
                    left[tile] -= 1
                    if left[tile] < 0:
                        self.explain.choice("letters", tile, np.maximum(-left, 0), spelt=tile_name)
                        return tile
        return super().choose_kind(view, target, rng)


class Drawn(Minimal):
    """As `minimal`, but while the stock is below what it was at the start, kinds are drawn as often as they were there.

    Nothing is known of the orders but what open words lack.
    """

    def choose_kind(self, view: WarehouseView, target: Floats, rng: np.random.Generator) -> int:
        """A kind that open words lack, else a random one."""
        if (view.wanted - view.stock).max() > 0:
            return super().choose_kind(view, target, rng)
        total = target.sum()
        return int(rng.choice(len(target), p=target / total)) if view.stock.sum() < total else -1
