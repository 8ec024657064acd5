"""The ledger of buckets: what is in each, who carries it, where it rests."""

from __future__ import annotations

import math
from collections.abc import Iterable

from soup_msgs_py.codes import EventType
from soup_msgs_py.messages import Event, Snapshot
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Layout
from soup_msgs_py.warehouse.tiles import tile_name
from soup_sim.validate.violations import EPSILON, Law, Record


class _Spots:
    """Finds the storage spot at a place, by a grid whose cells list the spots in reach of their points.

    Storage spots go by the numbers of their waypoints.
    """

    def __init__(self, layout: Layout, spots: Iterable[int], tolerance: float) -> None:
        self.xy: dict[int, tuple[float, float]] = {}
        self._waypoints: list[tuple[float, float]] = layout.waypoints.tolist()
        self._tolerance = tolerance
        self._cell = 4.0 * tolerance
        self._cells: dict[tuple[int, int], list[int]] = {}
        for spot in spots:
            self.add(spot)

    def add(self, spot: int) -> None:
        """One more."""
        self.xy[spot] = self._waypoints[spot]
        for cell in self._reaches(spot):
            self._cells.setdefault(cell, []).append(spot)

    def remove(self, spot: int) -> None:
        """One less."""
        for cell in self._reaches(spot):
            self._cells[cell].remove(spot)
        del self.xy[spot]

    def at(self, x: float, y: float) -> int:
        """The nearest storage spot within tolerance, or -1."""
        best, found = self._tolerance, -1
        if not (math.isfinite(x) and math.isfinite(y)):
            return found
        for spot in self._cells.get((math.floor(x / self._cell), math.floor(y / self._cell)), ()):
            spot_x, spot_y = self.xy[spot]
            distance = math.hypot(x - spot_x, y - spot_y)
            if distance <= best:
                best, found = distance, spot
        return found

    def _reaches(self, spot: int) -> list[tuple[int, int]]:
        """The cells with points within tolerance of a spot."""
        x, y = self.xy[spot]
        columns = {math.floor((x + d) / self._cell) for d in (-self._tolerance, self._tolerance)}
        rows = {math.floor((y + d) / self._cell) for d in (-self._tolerance, self._tolerance)}
        return [(column, row) for column in columns for row in rows]


class BucketLedger:
    """What events say about buckets. Bots and buckets are handed in checked: they exist.

    Attributes:
        contents: Tile kind to count, for each bucket.
        fill: Tiles in each bucket.
        bot: The bot that carries it, or -1, for each bucket.
        carried: The bucket on it, or -1, for each bot.
        x, y: Where each bucket rests, or was when it was grabbed (m).
        spot_xy: Where each storage spot is, by its waypoint (m).
        spot_changes: How many storage spots were made or removed; the last one at `spots_changed_at` (s).
    """

    def __init__(self, scenario: Scenario, layout: Layout, start: Snapshot, record: Record) -> None:
        """Begin with the buckets of a snapshot."""
        self._capacity = scenario.bucket.capacity
        self._tolerance = scenario.bot.tolerance_m + EPSILON
        self._record = record
        self.contents = [{tile: n for tile, n in held.items() if n} for held in start.contents]
        self.fill = [sum(held.values()) for held in self.contents]
        self.bot: list[int] = start.buckets.bot.tolist()
        self.carried: list[int] = start.bots.bucket.tolist()
        self.x: list[float] = start.buckets.x.tolist()
        self.y: list[float] = start.buckets.y.tolist()
        self._spots = _Spots(layout, start.storage_spots, self._tolerance)
        self.spot_xy = self._spots.xy
        self.spot_changes, self.spots_changed_at = 0, -math.inf
        self._waypoints = layout.waypoints
        self._stations = frozenset(layout.stations.tolist())
        self._apart = 2.0 * scenario.bucket.radius_m - EPSILON
        self._spot = [-1] * len(self.bot)
        self._taken: dict[int, int] = {}
        for bucket, held in enumerate(self.contents):
            if self.fill[bucket] > self._capacity or any(n < 0 for n in held.values()):
                record.add(start.time, Law.CAPACITY, f"bucket {bucket} starts with the contents {held}")
            if self.bot[bucket] < 0:
                self._rest(start.time, bucket, self.x[bucket], self.y[bucket])

    def take(self, time: float, bucket: int, tile: int) -> None:
        """A tile leaves a bucket."""
        held = self.contents[bucket]
        count = held.get(tile, 0)
        self.fill[bucket] -= 1
        if count == 1:
            del held[tile]
            return
        held[tile] = count - 1
        if count < 1:
            self._record.add(time, Law.TILES, f"tile {tile_name(tile)} came out of bucket {bucket}, which holds none")

    def put(self, time: float, bucket: int, tile: int) -> None:
        """A tile goes into a bucket."""
        held = self.contents[bucket]
        held[tile] = held.get(tile, 0) + 1
        self.fill[bucket] += 1
        if self.fill[bucket] > self._capacity:
            self._record.add(
                time,
                Law.CAPACITY,
                f"bucket {bucket} holds {self.fill[bucket]} tiles, at most {self._capacity} fit",
            )

    def grabbed(self, event: Event) -> None:
        """A bot lifts a bucket."""
        bot, bucket = event.bot, event.bucket
        holder, other = self.bot[bucket], self.carried[bot]
        if other >= 0:
            self._record.add(
                event.time, Law.CARRYING, f"bot {bot} grabbed bucket {bucket} while it carried bucket {other}"
            )
            self.bot[other] = -1
        if holder >= 0:
            self._record.add(event.time, Law.CARRYING, f"bot {bot} grabbed bucket {bucket}, which bot {holder} carried")
            self.carried[holder] = -1
        else:
            distance = math.hypot(event.x - self.x[bucket], event.y - self.y[bucket])
            if not distance <= self._tolerance:
                self._record.add(
                    event.time, Law.TOLERANCE, f"bot {bot} grabbed bucket {bucket} from {distance:g} m away"
                )
        self.bot[bucket], self.carried[bot] = bot, bucket
        self._taken.pop(self._spot[bucket], None)
        self._spot[bucket] = -1

    def released(self, event: Event) -> None:
        """A bot sets its bucket down."""
        bot, bucket = event.bot, event.bucket
        if self.carried[bot] != bucket or self.bot[bucket] != bot:
            self._record.add(event.time, Law.CARRYING, f"bot {bot} released bucket {bucket}, which it did not carry")
            return
        self.bot[bucket] = self.carried[bot] = -1
        if self._rest(event.time, bucket, event.x, event.y) < 0:
            self._record.add(
                event.time,
                Law.TOLERANCE,
                f"bot {bot} released bucket {bucket} at ({event.x:g}, {event.y:g}), where no storage spot is",
            )

    def spot_changed(self, event: Event) -> None:
        """A waypoint becomes a storage spot, or a free one is none any more."""
        spot, made = event.waypoint, event.type is EventType.SPOT_MADE
        self.spot_changes += 1
        self.spots_changed_at = event.time
        if not 0 <= spot < len(self._waypoints):
            self._record.add(event.time, Law.NUMBERS, f"{event.type} at waypoint {spot}, which is none")
            return
        if made == (spot in self.spot_xy):
            there = "one is already" if made else "none is"
            self._record.add(event.time, Law.STORAGE, f"{event.type} at waypoint {spot}, where {there}")
            return
        x, y = self._waypoints[spot]
        if not math.hypot(event.x - x, event.y - y) <= EPSILON:
            self._record.add(
                event.time,
                Law.STORAGE,
                f"{event.type} at ({event.x:g}, {event.y:g}), waypoint {spot} is at ({x:g}, {y:g})",
            )
        if not made:
            if spot in self._taken:
                self._record.add(
                    event.time, Law.STORAGE, f"storage spot {spot} was removed under bucket {self._taken[spot]}"
                )
            self._spots.remove(spot)
            return
        if spot in self._stations:
            self._record.add(event.time, Law.STORAGE, f"waypoint {spot} is a station and became a storage spot")
        for other, (other_x, other_y) in self.spot_xy.items():
            if not math.hypot(other_x - x, other_y - y) >= self._apart:
                self._record.add(
                    event.time, Law.STORAGE, f"storage spots {spot} and {other} are too near for two buckets"
                )
        self._spots.add(spot)

    def compare(self, end: Snapshot) -> None:
        """The storage spots and the contents of a snapshot must be those of the ledger."""
        for spot in sorted(set(end.storage_spots) ^ self.spot_xy.keys()):
            ours = "no storage spot in the snapshot, but is" if spot in self.spot_xy else "one in the snapshot, not"
            self._record.add(end.time, Law.SNAPSHOT, f"waypoint {spot} is {ours} by the events")
        for bucket, (theirs, ours) in enumerate(zip(end.contents, self.contents, strict=False)):
            for tile in sorted(theirs.keys() | ours.keys()):
                shown, known = theirs.get(tile, 0), ours.get(tile, 0)
                if shown != known:
                    self._record.add(
                        end.time,
                        Law.TILES,
                        f"bucket {bucket} holds {shown} tiles {tile_name(tile)} in the snapshot, {known} by the events",
                    )

    def _rest(self, time: float, bucket: int, x: float, y: float) -> int:
        """Set a bucket down at a place; the storage spot there, or -1."""
        self.x[bucket], self.y[bucket] = x, y
        spot = self._spots.at(x, y)
        if spot in self._taken:
            self._record.add(
                time,
                Law.STORAGE,
                f"bucket {bucket} rests at ({x:g}, {y:g}), where bucket {self._taken[spot]} rests already",
            )
        elif spot >= 0:
            self._taken[spot] = bucket
            self._spot[bucket] = spot
        return spot
