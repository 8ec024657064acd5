"""Letter policies: which letters come in, and on which letter station."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np

from soup_managers.explain import Explain
from soup_managers.view import WarehouseView
from soup_msgs_py.layout import Floats
from soup_msgs_py.messages import AssignBundle


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


class Minimal(LetterPolicy):
    """A steady stock: what was there at the start is brought back, the kind that is furthest below it first.

    Before that comes a kind of which open words lack more than there is: their places would be blocked for
    good. Bundles that have arrived are staged first in, first out. The station with the fewest staged bundles
    takes them.
    """

    def choose(
        self, view: WarehouseView, stations: Sequence[int], target: Floats, rng: np.random.Generator
    ) -> AssignBundle | None:
        """First arrived bundle, else the kind with the largest gap; none while the stock is full."""
        station = max(stations, key=view.free_places.__getitem__)
        if view.waiting_bundles:
            return AssignBundle(station, bundle=next(iter(view.waiting_bundles)))
        if view.scenario.bundles.kind != "chosen":
            return None
        if view.room < view.scenario.bundle_size:
            return None
        shortage = view.wanted - view.stock
        kind = int(shortage.argmax())
        if shortage[kind] > 0:
            self.explain.choice("letters", kind, np.maximum(shortage, 0), station=station)
            return AssignBundle(station, tile=kind)
        gap = target - view.stock
        kind = int(gap.argmax())
        # the sum of many small gaps must not fill the buckets with what nobody asks for
        if gap[kind] > 0 and gap.sum() > 0:
            self.explain.choice("letters", kind, gap, station=station)
            return AssignBundle(station, tile=kind)
        return None


class Ahead(Minimal):
    """As `minimal`, but rare letters are fetched early: what the waiting words will lack comes before any other gap.

    Open words come first, then the words that wait, the oldest first: a letter of which there is less than they
    need together would block a word station later.
    """

    def choose(
        self, view: WarehouseView, stations: Sequence[int], target: Floats, rng: np.random.Generator
    ) -> AssignBundle | None:
        """A kind that open or waiting words lack, else as `minimal`."""
        chosen = view.scenario.bundles.kind == "chosen" and not view.waiting_bundles
        if chosen and view.room >= view.scenario.bundle_size:
            left = view.stock - view.wanted
            if left.min() >= 0:
                for word in view.waiting_words.values():
                    for tile in word.tiles:
                        left[tile] -= 1
                        if left[tile] < 0:
                            station = max(stations, key=view.free_places.__getitem__)
                            self.explain.choice("letters", tile, np.maximum(-left, 0), station=station)
                            return AssignBundle(station, tile=tile)
        return super().choose(view, stations, target, rng)
