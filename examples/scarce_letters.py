"""A letter policy of one's own: what the words on order need most of, against what there is.

python3 scripts/run_headless.py --letter-policy examples/scarce_letters.py:ScarceLetters
"""

from __future__ import annotations

import numpy as np

from soup_managers.policies.letter import LetterPolicy
from soup_msgs_py.messages import AssignBundle


class ScarceLetters(LetterPolicy):
    """Brings in the kind of which open and waiting words need most for each tile in stock, while buckets have room.

    Args:
        room: Room (tiles) that always stays free in the buckets altogether.
    """

    def __init__(self, room: int = 400) -> None:
        """Options of the policies file come in as keyword arguments."""
        self._room = room

    def choose(self, view, stations, target, rng):
        """One bundle and one station, or None; see `LetterPolicy.choose`."""
        station = max(stations, key=view.free_places.__getitem__)
        if view.waiting_bundles:  # a scenario may send its own
            return AssignBundle(station, bundle=next(iter(view.waiting_bundles)))
        if view.scenario.bundles.kind != "chosen" or view.room - view.scenario.bundle_size < self._room:
            return None
        need = (view.wanted + view.on_order) / (1.0 + view.stock)
        self.explain.choice("letters", int(need.argmax()), need, station=station)
        return AssignBundle(station, tile=int(np.argmax(need)))
