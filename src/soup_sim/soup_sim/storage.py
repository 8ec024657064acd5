"""Storage spots: which waypoints are some now, and which bucket rests or is being set down on each."""

from __future__ import annotations

import math
from typing import Any

from soup_msgs_py.codes import Code
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Layout

Problem = tuple[Code, str]


class Storage:
    """The storage spots. They are known by their waypoints; a manager or a person may change which there are.

    Attributes:
        bucket_on: The bucket of each storage spot, -1 for a free one.
        spot_of: The storage spot of each bucket, -1 for a carried one.
    """

    def __init__(self, scenario: Scenario, layout: Layout) -> None:
        """Begin with the free storage spots of a layout."""
        self._layout = layout
        self._tolerance = scenario.bot.tolerance_m
        self._body = 2.0 * max(scenario.bot.radius_m, scenario.bucket.radius_m)
        self._xy: list[tuple[float, float]] = [(x, y) for x, y in layout.waypoints.tolist()]
        self._cell = max(1.0, 2.0 * self._tolerance)
        self._near: dict[tuple[int, int], list[int]] = {}
        self.bucket_on: dict[int, int] = {}
        self.spot_of = [-1] * scenario.buckets
        for spot in layout.storage_spots.tolist():
            self._enter(spot)

    def at(self, x: float, y: float) -> int:
        """The storage spot within tolerance of a place, or -1."""
        cx, cy = int(x // self._cell), int(y // self._cell)
        best, best_square = -1, self._tolerance * self._tolerance
        for kx in (cx - 1, cx, cx + 1):
            for ky in (cy - 1, cy, cy + 1):
                for spot in self._near.get((kx, ky), ()):
                    sx, sy = self._xy[spot]
                    square = (sx - x) ** 2 + (sy - y) ** 2
                    if square <= best_square:
                        best, best_square = spot, square
        return best

    def place(self, spot: int) -> tuple[float, float]:
        """Where a storage spot, or any waypoint, is (m)."""
        return self._xy[spot]

    def reserve(self, spot: int, bucket: int) -> None:
        """A bucket is being set down on a free spot."""
        self.bucket_on[spot] = bucket

    def rest(self, bucket: int, spot: int) -> None:
        """A bucket rests on a spot now."""
        self.bucket_on[spot] = bucket
        self.spot_of[bucket] = spot

    def leave(self, bucket: int) -> None:
        """A bucket is lifted off its spot, if it rests on one."""
        spot, self.spot_of[bucket] = self.spot_of[bucket], -1
        if spot >= 0:
            self.bucket_on[spot] = -1

    # ---- changing them --------------------------------------------------------------------------------------

    def change(self, waypoint: int, storage: bool) -> Problem | None:
        """Turn a waypoint into a storage spot, or a free one into a plain waypoint; why that can't be, or None."""
        problem = self._problem(waypoint, storage)
        if problem is None:
            if storage:
                self._enter(waypoint)
            else:
                self._forget(waypoint)
        return problem

    def _problem(self, waypoint: int, storage: bool) -> Problem | None:
        if not 0 <= waypoint < len(self._xy):
            return Code.UNKNOWN, f"there is no waypoint {waypoint}; they are 0 to {len(self._xy) - 1}"
        if storage == (waypoint in self.bucket_on):
            return Code.NOT_NEEDED, f"waypoint {waypoint} {'is already' if storage else 'is not'} a storage spot"
        return self._cannot_be(waypoint) if storage else self._cannot_go(waypoint)

    def _cannot_be(self, waypoint: int) -> Problem | None:
        """Buckets on it would touch what stands, is served or rests nearby."""
        x, y = self._xy[waypoint]
        for station, other in enumerate(self._layout.stations.tolist()):
            away = self._distance(waypoint, other)
            if other == waypoint:
                return Code.BLOCKED, f"waypoint {waypoint} is {self._layout.station_name(station)}"
            if away < self._body:
                return Code.BLOCKED, f"{self._layout.station_name(station)} is {away:.3f} m away, too near for a bucket"
        for other in self.bucket_on:
            away = self._distance(waypoint, other)
            if away < self._body:
                return Code.BLOCKED, f"storage spot {other} is {away:.3f} m away, too near for two buckets"
        half = self._body / 2.0
        if not (half <= x <= self._layout.width_m - half and half <= y <= self._layout.height_m - half):
            return Code.OFF_FLOOR, f"a bucket on waypoint {waypoint} at ({x:.3f}, {y:.3f}) would not be on the floor"
        return None

    def _cannot_go(self, waypoint: int) -> Problem | None:
        bucket = self.bucket_on[waypoint]
        if bucket >= 0:
            does = "rests" if self.spot_of[bucket] == waypoint else "is being set down"
            return Code.SPOT_TAKEN, f"bucket {bucket} {does} on storage spot {waypoint}; take it away first"
        if len(self.bucket_on) <= len(self.spot_of):
            return Code.BLOCKED, f"all {len(self.bucket_on)} storage spots are needed for {len(self.spot_of)} buckets"
        return None

    def _distance(self, a: int, b: int) -> float:
        (ax, ay), (bx, by) = self._xy[a], self._xy[b]
        return math.sqrt((ax - bx) ** 2 + (ay - by) ** 2)

    def _cell_of(self, waypoint: int) -> tuple[int, int]:
        x, y = self._xy[waypoint]
        return int(x // self._cell), int(y // self._cell)

    def _enter(self, waypoint: int) -> None:
        self.bucket_on[waypoint] = -1
        self._near.setdefault(self._cell_of(waypoint), []).append(waypoint)

    def _forget(self, waypoint: int) -> None:
        del self.bucket_on[waypoint]
        self._near[self._cell_of(waypoint)].remove(waypoint)

    # ---- checkpoint -----------------------------------------------------------------------------------------

    def capture(self) -> dict[str, Any]:
        """Everything that changes, for a checkpoint."""
        return {"bucket_on": list(self.bucket_on.items()), "spot_of": self.spot_of}

    def restore(self, state: dict[str, Any]) -> None:
        """The opposite of `capture`."""
        self.bucket_on, self._near = {}, {}
        for spot, bucket in state["bucket_on"]:
            self._enter(spot)
            self.bucket_on[spot] = bucket
        self.spot_of = list(state["spot_of"])
