"""What is in the buckets, as arrays over tile kinds, and how well buckets serve a demand."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Counts = NDArray[np.signedinteger[Any]]


def tiles_of(amount: float, capacity: int) -> int:
    """An amount in tiles, at least one: below 1 it is a share of the tiles that fit into a bucket, else tiles."""
    return max(1, round(amount * capacity if amount < 1 else amount))


class Contents:
    """Tiles in buckets: `contents[bucket]` is a bucket's, as tile kind to count.

    Attributes:
        tiles: How many tiles of each kind are in each bucket, shape (kinds, buckets).
        total: Tiles in each bucket, shape (buckets,).
        capacity: Tiles that fit into a bucket.
    """

    def __init__(self, contents: Sequence[Mapping[int, int]], kinds: int, capacity: int) -> None:
        """Take over what is in each bucket."""
        self.tiles = np.zeros((kinds, len(contents)), np.int16)
        for bucket, tiles in enumerate(contents):
            self.tiles[list(tiles), bucket] = list(tiles.values())
        self.total = self.tiles.sum(axis=0, dtype=np.int32)
        self.capacity = capacity

    def __len__(self) -> int:
        return len(self.total)

    def __getitem__(self, bucket: int) -> dict[int, int]:
        tiles = self.tiles[:, bucket]
        kinds = np.flatnonzero(tiles)
        return dict(zip(kinds.tolist(), tiles[kinds].tolist(), strict=True))

    def __iter__(self) -> Iterator[dict[int, int]]:
        return (self[bucket] for bucket in range(len(self)))

    def room(self, bucket: int) -> int:
        """How many more tiles go into a bucket."""
        return self.capacity - int(self.total[bucket])

    def put(self, bucket: int, tile: int, change: int) -> None:
        """Tiles were moved into a bucket (a negative change: out of it); a `KeyError` where they are not there."""
        if self.tiles[tile, bucket] + change < 0:
            raise KeyError(tile)
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
