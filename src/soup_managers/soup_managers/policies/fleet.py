"""Fleet policies: which bot carries which bucket where, for which letters."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable

from soup_managers.bitset import first, members
from soup_managers.fleet_state import FleetState
from soup_managers.plans import PlannedVisit, TripPlan
from soup_msgs_py.messages import STORE


class FleetPolicy(ABC):
    """Decides what the bots do. Extend it and implement `plan`; nothing else is needed.

    A policy gets its options from the policies file as keyword arguments of its constructor.
    """

    @abstractmethod
    def plan(self, fleet: FleetState) -> Iterable[TripPlan]:
        """Trips to start now; asked when letters wait that may be moved and bots are idle.

        Written best as a generator: each trip is in the books before the next is asked for, so `fleet` always
        says what is still free. Whether a plan can be is checked; `PlanError` says why not.

        Args:
            fleet: Idle bots, free buckets and spots, waiting letters, ways. A letter that no bucket can serve
                is to be set aside with `fleet.defer`: then it comes up again when that may have changed.
        """


class Minimal(FleetPolicy):
    """The paper's minimal coordination: tasks first in, first out, one letter a trip.

    The first bucket that will do is fetched by the first idle bot and goes back to where it came from. Where
    an idle bot stands under the bucket, that one takes it, because no other gets there.
    """

    def plan(self, fleet: FleetState) -> Iterable[TripPlan]:
        """One trip for each waiting letter, as long as bots are idle."""
        for letter in fleet.letters():
            if not fleet.free_bots:
                return
            storing = letter.key[0] == STORE
            able = fleet.view.with_room if storing else fleet.view.holders(letter.tile)
            for bucket in members(able & fleet.free_buckets):
                under = fleet.bot_under(bucket)
                bot = first(fleet.free_bots) if under < 0 else under
                if fleet.free_bots >> bot & 1:
                    yield TripPlan(bot, bucket, (PlannedVisit(letter.station, (letter,)),), fleet.view.spot_of[bucket])
                    break
            else:
                fleet.defer(letter)
