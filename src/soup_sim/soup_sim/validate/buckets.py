"""The ledger of buckets: what is in each, who carries it, where it rests."""

from __future__ import annotations

import math

from soup_msgs_py.layout import Layout
from soup_msgs_py.messages import Event, Snapshot
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.tiles import tile_name
from soup_sim.validate.violations import EPSILON, Law, Record


class _Spots:
    """Finds the storage spot at a place, by a grid whose cells list the spots in reach of their points."""

    def __init__(self, layout: Layout, tolerance: float) -> None:
        self._xy: list[tuple[float, float]] = layout.waypoints[layout.storage_spots].tolist()
        self._tolerance = tolerance
        self._cell = 4.0 * tolerance
        self._cells: dict[tuple[int, int], list[int]] = {}
        for spot, (x, y) in enumerate(self._xy):
            columns = {math.floor((x + d) / self._cell) for d in (-tolerance, tolerance)}
            rows = {math.floor((y + d) / self._cell) for d in (-tolerance, tolerance)}
            for column in columns:
                for row in rows:
                    self._cells.setdefault((column, row), []).append(spot)

    def at(self, x: float, y: float) -> int:
        """The nearest storage spot within tolerance, or -1."""
        best, found = self._tolerance, -1
        if not (math.isfinite(x) and math.isfinite(y)):
            return found
        for spot in self._cells.get((math.floor(x / self._cell), math.floor(y / self._cell)), ()):
            spot_x, spot_y = self._xy[spot]
            distance = math.hypot(x - spot_x, y - spot_y)
            if distance <= best:
                best, found = distance, spot
        return found


class BucketLedger:
    """What events say about buckets. Bots and buckets are handed in checked: they exist.

    Attributes:
        contents: Tile kind to count, for each bucket.
        fill: Tiles in each bucket.
        bot: The bot that carries it, or -1, for each bucket.
        carried: The bucket on it, or -1, for each bot.
        x, y: Where each bucket rests, or was when it was grabbed (m).
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
        self._spots = _Spots(layout, self._tolerance)
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

    def compare(self, end: Snapshot) -> None:
        """The contents of a snapshot must be those of the ledger."""
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
