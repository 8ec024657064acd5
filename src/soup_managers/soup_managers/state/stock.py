"""What is in the buckets, as arrays over tile kinds, and how well buckets serve a demand."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from soup_managers.view import WarehouseView

Counts = NDArray[np.signedinteger[Any]]


def tiles_of(amount: float, capacity: int) -> int:
    """An amount in tiles, at least one: below 1 it is a share of the tiles that fit into a bucket, else tiles."""
    return max(1, round(amount * capacity if amount < 1 else amount))


class Stock:
    """Tiles in buckets.

    Attributes:
        tiles: How many tiles of each kind are in each bucket, shape (kinds, buckets).
        total: Tiles in each bucket, shape (buckets,).
        capacity: Tiles that fit into a bucket.
    """

    def __init__(self, view: WarehouseView) -> None:
        """Take over what a view knows now."""
        buckets = len(view.contents)
        self.capacity = view.scenario.bucket.capacity
        self.tiles = np.zeros((view.kinds, buckets), np.int16)
        for bucket, contents in enumerate(view.contents):
            for tile, count in contents.items():
                self.tiles[tile, bucket] = count
        self.total = np.array(view.tiles_in, np.int32)

    def put(self, bucket: int, tile: int, change: int) -> None:
        """Tiles were moved into a bucket (a negative change: out of it)."""
        self.tiles[tile, bucket] += change
        self.total[bucket] += change

    def of(self, bucket: int) -> Counts:
        """Tiles of each kind in a bucket, shape (kinds,)."""
        return self.tiles[:, bucket]

    def served(self, kinds: NDArray[np.int64], lack: Counts) -> Counts:
        """How many tiles of a demand each bucket alone can serve.

        Args:
            kinds: The kinds in demand, shape (n,).
            lack: How many of each, shape (n,).

        Returns:
            Tiles, shape (buckets,).
        """
        return np.minimum(self.tiles[kinds], lack[:, None]).sum(axis=0, dtype=np.int32)

    def serves(self, bucket: int, kinds: NDArray[np.int64], lack: Counts) -> Counts:
        """How many tiles of each kind of a demand one bucket can serve, shape (n,)."""
        return np.minimum(self.tiles[kinds, bucket], lack)
