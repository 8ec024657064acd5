"""The ledger of bundles: waiting, staged on a letter station, emptied."""

from __future__ import annotations

from dataclasses import dataclass

from soup_msgs_py.messages import Bundle, Event, Snapshot
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Layout
from soup_msgs_py.warehouse.tiles import tile_name
from soup_sim.validate.violations import EPSILON, Law, Record


@dataclass(slots=True)
class _StagedBundle:
    """A bundle that has a place on a station; `left` tiles are still in it."""

    station: int
    tile: int
    left: int


class BundleLedger:
    """What events say about bundles.

    Attributes:
        due: Bundles without tiles that are not emptied yet, with the time their last one left.
        brought_in: Tiles of each kind that came into the warehouse since the start.
    """

    def __init__(self, scenario: Scenario, layout: Layout, start: Snapshot, record: Record) -> None:
        """Begin with the bundles of a snapshot."""
        self._limit = scenario.letter_station.staged_bundles
        self._size = scenario.bundle_size
        self._layout = layout
        self._record = record
        self.due: dict[int, float] = {}
        self.brought_in: dict[int, int] = {}
        self._waiting: dict[int, Bundle] = {bundle.bundle: bundle for bundle in start.waiting_bundles}
        self._staged: dict[int, _StagedBundle] = {}
        self._at = [0] * len(layout.stations)
        for state in start.letter_stations:
            for bundle in state.staged_bundles:
                self._staged[bundle.bundle] = _StagedBundle(state.station, bundle.tile, bundle.count)
                self._occupy(start.time, state.station)
        self._known = {*self._waiting, *self._staged}

    def arrived(self, event: Event) -> None:
        """A bundle comes to the warehouse."""
        self._bring_in(event)
        self._waiting[event.job] = Bundle(event.job, event.tile, event.count)

    def staged(self, event: Event) -> None:
        """A bundle gets a place on a station: one that has arrived, or one that the letter manager orders."""
        bundle = self._waiting.pop(event.job, None)
        if bundle is None:
            self._bring_in(event)
        elif (bundle.tile, bundle.count) != (event.tile, event.count):
            self._record.add(
                event.time,
                Law.TILES,
                f"bundle {event.job} arrived with {bundle.count} tiles {tile_name(bundle.tile)} and "
                f"was staged with {event.count} tiles {tile_name(event.tile)}",
            )
        if not self._layout.is_letter_station(event.station):
            self._record.add(
                event.time,
                Law.NUMBERS,
                f"bundle {event.job} was staged on station {event.station}: no letter station",
            )
            return
        if event.job in self._staged:
            self._at[self._staged[event.job].station] -= 1
        self._staged[event.job] = _StagedBundle(event.station, event.tile, event.count)
        self._occupy(event.time, event.station)

    def take(self, event: Event) -> None:
        """A tile leaves a staged bundle."""
        bundle = self._staged.get(event.job)
        if bundle is None or bundle.station != event.station:
            fault = f"which is not staged at {self._layout.station_name(event.station)}"
        elif bundle.tile != event.tile:
            fault = f"which holds tiles {tile_name(bundle.tile)}"
        elif bundle.left < 1:
            fault = "which is empty"
        else:
            bundle.left -= 1
            if bundle.left == 0:
                self.due[event.job] = event.time
            return
        self._record.add(event.time, Law.TILES, f"tile {tile_name(event.tile)} came out of bundle {event.job}, {fault}")

    def emptied(self, event: Event) -> None:
        """The last tile of a bundle has left, its place is free."""
        self.due.pop(event.job, None)
        bundle = self._staged.get(event.job)
        if bundle is None or bundle.station != event.station:
            name = self._layout.station_name(event.station)
            self._record.add(event.time, Law.BUNDLES, f"bundle {event.job} was emptied: it is not staged at {name}")
            return
        if bundle.left:
            self._record.add(event.time, Law.BUNDLES, f"bundle {event.job} was emptied with {bundle.left} tiles in it")
        del self._staged[event.job]
        self._at[bundle.station] -= 1

    def check_due(self, time: float) -> None:
        """Bundles without tiles must be emptied at that instant."""
        for job, empty_at in list(self.due.items()):
            if time > empty_at + EPSILON:
                del self.due[job]
                self._record.add(
                    time,
                    Law.BUNDLES,
                    f"bundle {job} was not emptied when its last tile left at {empty_at:g} s",
                )

    def compare(self, end: Snapshot) -> None:
        """The bundles of a snapshot must be those of the ledger."""
        for job, empty_at in self.due.items():
            self._record.add(
                end.time,
                Law.SNAPSHOT,
                f"bundle {job} has no tiles since {empty_at:g} s and was never emptied",
            )
        shown = {bundle.bundle: (-1, bundle.tile, bundle.count) for bundle in end.waiting_bundles}
        for state in end.letter_stations:
            for bundle in state.staged_bundles:
                shown[bundle.bundle] = (state.station, bundle.tile, bundle.count)
        ours = {job: (-1, bundle.tile, bundle.count) for job, bundle in self._waiting.items()}
        ours |= {job: (bundle.station, bundle.tile, bundle.left) for job, bundle in self._staged.items()}
        for job in sorted(shown.keys() | ours.keys()):
            if shown.get(job) != ours.get(job):
                self._record.add(
                    end.time,
                    Law.SNAPSHOT,
                    f"bundle {job} is {self._written(shown.get(job))} in the snapshot, "
                    f"{self._written(ours.get(job))} by the events",
                )

    def _written(self, bundle: tuple[int, int, int] | None) -> str:
        """Station, tile kind and count of a bundle as text."""
        if bundle is None:
            return "nowhere"
        station, tile, count = bundle
        place = "waiting" if station < 0 else f"on {self._layout.station_name(station)}"
        return f"{place} with {count} tiles {tile_name(tile)}"

    def _bring_in(self, event: Event) -> None:
        """New tiles, in a bundle that nobody has seen yet."""
        if event.job in self._known:
            self._record.add(event.time, Law.BUNDLES, f"bundle {event.job} came in a second time")
        if event.count != self._size:
            self._record.add(
                event.time,
                Law.BUNDLES,
                f"bundle {event.job} came in with {event.count} tiles, the size of a bundle is {self._size}",
            )
        self._known.add(event.job)
        self.brought_in[event.tile] = self.brought_in.get(event.tile, 0) + event.count

    def _occupy(self, time: float, station: int) -> None:
        """Take one of a station's places."""
        self._at[station] += 1
        if self._at[station] > self._limit:
            name = self._layout.station_name(station)
            self._record.add(time, Law.CAPACITY, f"{name} has {self._at[station]} staged bundles, {self._limit} fit")
