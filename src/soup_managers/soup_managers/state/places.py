"""Which waypoints are taken: by buckets at rest, and by bots that stand there or will."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from soup_managers.view import WarehouseView

Mask = NDArray[np.bool_]


class Places:
    """What stands where.

    Attributes:
        spots: The layout's storage spots, as waypoints.
        is_spot: Whether each waypoint is one of them. Ways are planned for these: one that is taken away stays a
            place that bots with buckets do not pass, and one that is made elsewhere is not used.
        taken: How many bots stand on each waypoint or are on their way to stand there.
    """

    def __init__(self, view: WarehouseView) -> None:
        self._view = view
        self.spots: NDArray[np.int64] = view.layout.storage_spots.astype(np.int64)
        self.is_spot = np.zeros(len(view.layout.waypoints), bool)
        self.is_spot[self.spots] = True
        self.taken = np.zeros(len(view.layout.waypoints), np.int32)

    @property
    def occupied(self) -> Mask:
        """Whether a bucket rests on each waypoint, shape (waypoints,)."""
        return self._view.occupied

    @property
    def closed(self) -> Mask:
        """Where a bot with a bucket cannot pass, because a bucket or a bot is there, shape (waypoints,)."""
        return self.occupied | (self.taken > 0)

    def free_spots(self) -> NDArray[np.int64]:
        """Storage spots with neither a bucket nor a bot, as waypoints."""
        view, spots = self._view, self.spots
        return spots[view.is_storage_spot[spots] & (view.bucket_at[spots] < 0) & (self.taken[spots] == 0)]

    def is_free(self, spot: int) -> bool:
        """Whether a bucket may be set down on a storage spot, and neither a bucket nor a bot is there."""
        view = self._view
        return bool(view.is_storage_spot[spot]) and view.bucket_at[spot] < 0 and self.taken[spot] == 0

    def take(self, waypoint: int) -> None:
        """A bot stands on a waypoint, or will."""
        self.taken[waypoint] += 1

    def leave(self, waypoint: int) -> None:
        """A bot no longer stands on a waypoint."""
        self.taken[waypoint] -= 1
