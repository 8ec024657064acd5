"""Fleet policies: which bot carries which bucket where, for which letters."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable

from soup_managers.fleets.minimal.plans import Letter, PlannedVisit, TripPlan
from soup_managers.fleets.minimal.state import FleetState
from soup_managers.kernels.bitset import first, members
from soup_msgs_py.messages import STORE


class AnyFleet:
    """What every fleet policy is: one that plans whole trips (`FleetPolicy`), or `Coordinated`."""


class FleetPolicy(AnyFleet, ABC):
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
    """The paper's minimal coordination ("Simulation Parameters and Metrics"), taken at its word.

    It "simply assigns tasks first in, first out": a task is a word to build or a bundle to store, and the oldest
    that waits comes first. "Each task only involves one letter at a time": for each task at most one bot is under
    way. It "requires buckets to be returned to storage between every task": a trip moves one letter and takes the
    bucket back to where it came from, and only then may the next letter of its task be fetched.

    Nothing is near or far: the first bucket that will do is fetched by the first idle bot. Where an idle bot stands
    under the bucket, that one takes it, because no other gets there.
    """

    def plan(self, fleet: FleetState) -> Iterable[TripPlan]:
        """One trip for each task that waits, as long as bots are idle."""
        for letter in fleet.letters():
            if not fleet.free_bots:
                return
            if fleet.is_served(letter.key):
                fleet.hold(letter)
                continue
            trip = self._trip(letter, fleet)
            if trip is None:
                fleet.defer(letter)
            else:
                yield trip

    def _trip(self, letter: Letter, fleet: FleetState) -> TripPlan | None:
        able = fleet.view.with_room if letter.key[0] == STORE else fleet.view.holders(letter.tile)
        for bucket in members(able & fleet.free_buckets):
            under = fleet.bot_under(bucket)
            bot = first(fleet.free_bots) if under < 0 else under
            if fleet.free_bots >> bot & 1:
                return TripPlan(
                    bot, bucket, (PlannedVisit(letter.station, (letter,)),), int(fleet.view.spot_of[bucket])
                )
        return None
