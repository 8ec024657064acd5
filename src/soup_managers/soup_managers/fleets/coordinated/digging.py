"""Deep blocks of storage spots: which can be reached with a bucket, and what must be dug out for those that cannot.

The tile problem of dense storage (paper, "Research Challenges"; Gue 2006): a bucket inside a block comes out only
through free spots.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from soup_managers.state.places import Places
from soup_msgs_py.kernel import maker
from soup_msgs_py.warehouse.layout import Ints, Layout

Mask = NDArray[np.bool_]
Indices = NDArray[np.int64]


class Digging:
    """The storage spots of a deep layout and their neighbours.

    Attributes:
        needed: Whether some spots can only be reached through others; if not, all are open at all times.
    """

    def __init__(self, layout: Layout, places: Places) -> None:
        self._places, spots = places, places.spots
        count = len(layout.waypoints)
        self._number = np.full(count, -1, np.int32)
        self._number[spots] = np.arange(len(spots), dtype=np.int32)
        self._spots = spots
        # edges between spots, and spots beside lanes: ways in and out are the same
        tails, heads = self._number[layout.edges[:, 0]], self._number[layout.edges[:, 1]]
        self._beside_lane = np.zeros(len(spots), bool)
        self._beside_lane[heads[(tails < 0) & (heads >= 0)]] = True
        inner = (tails >= 0) & (heads >= 0)
        order = np.lexsort((heads[inner], tails[inner]))
        self._heads: Ints = heads[inner][order].astype(np.int32)
        counts = np.bincount(tails[inner], minlength=len(spots))
        self._first: Ints = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
        self.needed = not bool(self._beside_lane.all())
        self._all_open = np.ones(count, bool)
        self._no_depth = np.zeros(count, np.int32)

    @property
    def _closed(self) -> Mask:
        """The spots through which a bot with a bucket cannot pass, shape (spots,)."""
        return self._places.closed[self._spots]

    def open_spots(self) -> Mask:
        """Which spots a bot with a bucket can get to or away from, shape (waypoints,); True for lanes. Read only."""
        if not self.needed:
            return self._all_open
        open_ = np.ones(len(self._number), bool)
        open_[self._spots] = _dig(self._first, self._heads, self._beside_lane, self._closed)[0] == 0
        return open_

    def in_the_way(self, spot: int) -> list[int]:
        """The closed spots on the way out of one spot that passes the fewest, the outermost first."""
        closed = self._closed
        parent = _dig(self._first, self._heads, self._beside_lane, closed)[1]
        passed = []
        here = int(parent[self._number[spot]])
        while here >= 0:
            if closed[here]:
                passed.append(int(self._spots[here]))
            here = int(parent[here])
        return passed[::-1]

    def depths(self) -> Ints:
        """How many closed spots are in the way of each spot, shape (waypoints,). Read only."""
        if not self.needed:
            return self._no_depth
        depth = np.zeros(len(self._number), np.int32)
        depth[self._spots] = _dig(self._first, self._heads, self._beside_lane, self._closed)[0]
        return depth

    def buried(self, spots: Indices) -> Ints:
        """How many closed spots more would be cut off if each of some open spots were closed, shape (n,)."""
        if not self.needed:
            return np.zeros(len(spots), np.int32)
        return _buried(self._first, self._heads, self._beside_lane, self._closed, self._number[spots])


@maker
def _dig(first, heads, beside_lane, closed):
    """The fewest closed spots between each spot and the lanes, and the next spot on that way, -1 for a lane."""
    n = len(beside_lane)
    depth, parent = np.full(n, n, np.int32), np.full(n, -1, np.int32)
    here, ahead = np.empty(n, np.int32), np.empty(n, np.int32)
    count, level = 0, 0
    for spot in range(n):
        if beside_lane[spot]:
            depth[spot] = 0
            here[count] = spot
            count += 1
    while count > 0:
        later = 0
        k = 0
        while k < count:
            spot = here[k]
            k += 1
            if depth[spot] != level:
                continue
            reach = level + 1 if closed[spot] else level
            for e in range(first[spot], first[spot + 1]):
                other = heads[e]
                if depth[other] > reach:
                    depth[other], parent[other] = reach, spot
                    if reach == level:
                        here[count] = other
                        count += 1
                    else:
                        ahead[later] = other
                        later += 1
        here, ahead = ahead, here
        count = later
        level += 1
    return depth, parent


@maker
def _buried(first, heads, beside_lane, closed, spots):
    before = _dig(first, heads, beside_lane, closed)[0]
    buried = np.zeros(len(spots), np.int32)
    for k in range(len(spots)):
        closed[spots[k]] = True
        after = _dig(first, heads, beside_lane, closed)[0]
        closed[spots[k]] = False
        for spot in range(len(closed)):
            if closed[spot] and before[spot] == 0 and after[spot] > 0:
                buried[k] += 1
    return buried
