"""Which waypoints are taken: by buckets at rest, and by bots that stand there or will."""

from __future__ import annotations

from collections.abc import Mapping, Set

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from soup_msgs_py.warehouse.layout import Layout


class Places:
    """What stands where.

    Attributes:
        spots: The layout's storage spots, as waypoints.
        is_spot: Whether each waypoint is one of them. Ways are planned for these: one that is taken away stays a
            place that bots with buckets do not pass, and one that is made elsewhere is not used.
        occupied: Whether a bucket rests on each waypoint.
        taken: How many bots stand on each waypoint or are on their way to stand there.
    """

    def __init__(self, layout: Layout, bots: int) -> None:
        waypoints = len(layout.waypoints)
        self.spots: NDArray[np.int64] = layout.storage_spots.astype(np.int64)
        self.is_spot = np.zeros(waypoints, bool)
        self.is_spot[self.spots] = True
        self.occupied = np.zeros(waypoints, bool)
        self.taken = np.zeros(waypoints, np.int32)
        self._may_store = self.is_spot.copy()
        self._near = KDTree(layout.waypoints)

    def nearest(self, x: float, y: float) -> int:
        """The waypoint nearest to a place (m)."""
        return int(self._near.query((x, y))[1])

    def take_over(self, bucket_on: Mapping[int, int], storage_spots: Set[int]) -> None:
        """Learn anew where buckets rest, and which spots there are."""
        self.occupied[:] = False
        self.occupied[list(bucket_on)] = True
        self._may_store[:] = False
        self._may_store[list(storage_spots)] = True

    def allow(self, waypoint: int, allowed: bool) -> None:
        """A storage spot was made or taken away."""
        self._may_store[waypoint] = allowed

    @property
    def closed(self) -> NDArray[np.bool_]:
        """Where a bot with a bucket cannot pass, because a bucket or a bot is there, shape (waypoints,)."""
        return self.occupied | (self.taken > 0)

    def free_spots(self) -> NDArray[np.int64]:
        """Storage spots with neither a bucket nor a bot, as waypoints."""
        spots = self.spots
        return spots[self._may_store[spots] & ~self.occupied[spots] & (self.taken[spots] == 0)]

    def is_free(self, spot: int) -> bool:
        """Whether a bucket may be set down on a storage spot, and neither a bucket nor a bot is there."""
        return bool(self._may_store[spot]) and not self.occupied[spot] and self.taken[spot] == 0

    def take(self, waypoint: int) -> None:
        """A bot stands on a waypoint, or will."""
        self.taken[waypoint] += 1

    def leave(self, waypoint: int) -> None:
        """A bot no longer stands on a waypoint."""
        self.taken[waypoint] -= 1

    def lifted(self, spot: int) -> None:
        """The bucket on a spot was lifted."""
        if spot >= 0:
            self.occupied[spot] = False

    def set_down(self, spot: int) -> None:
        """A bucket was set down on a spot."""
        if spot >= 0:
            self.occupied[spot] = True
