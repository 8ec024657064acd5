"""What bots are told of the world around them, and what not (paper, section "Bucketbot Sensing and Control")."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from soup_msgs_py.codes import BotState
from soup_msgs_py.messages import Bots, Buckets, Event, Floats, Snapshot
from soup_msgs_py.scenario.parameters import Sensing

NOWHERE = -1e6  # m: where a bot is told to be what it does not see
Flags = NDArray[np.bool_]


class Senses:
    """The pictures that blinded bots have of the world, each its own.

    Args:
        sensing: What they are told.
        radius_m: How far they see.
    """

    def __init__(self, sensing: Sensing, radius_m: float) -> None:
        self._sensing = sensing
        self._radius_m = radius_m
        angle = sensing.view_angle_rad
        self._least_cosine = -1.0 if angle is None else math.cos(angle / 2.0)

    def bots(self, me: int, bots: Bots) -> Bots:
        """All bots as bot `me` is told of them: those that it does not see are `NOWHERE`, free, empty and stand."""
        others = np.arange(len(bots.x)) != me
        seen = self._seen(me, bots, bots.x, bots.y, others) | ~others
        moves = seen if self._sensing.velocities else ~others
        return replace(
            bots,
            x=np.where(seen, bots.x, NOWHERE),
            y=np.where(seen, bots.y, NOWHERE),
            heading=np.where(seen, bots.heading, 0.0),
            vx=np.where(moves, bots.vx, 0.0),
            vy=np.where(moves, bots.vy, 0.0),
            bucket=np.where(seen, bots.bucket, -1).astype(bots.bucket.dtype),
            state=np.where(seen, bots.state, BotState.FREE).astype(bots.state.dtype),
        )

    def buckets(self, me: int, bots: Bots, buckets: Buckets) -> Buckets:
        """All buckets as bot `me` is told of them; a carried one is seen with its bot.

        Args:
            me: The bot.
            bots: All bots as it is told of them.
            buckets: All buckets as they are.
        """
        seen = self._seen(me, bots, buckets.x, buckets.y, buckets.bot < 0)
        carried = bots.bucket[bots.bucket >= 0]
        seen[carried] = True
        tiles = buckets.tiles if self._sensing.contents else np.zeros_like(buckets.tiles)
        return replace(
            buckets,
            x=np.where(seen, buckets.x, NOWHERE),
            y=np.where(seen, buckets.y, NOWHERE),
            bot=np.where(seen, buckets.bot, -1).astype(buckets.bot.dtype),
            tiles=np.where(seen, tiles, 0).astype(buckets.tiles.dtype),
        )

    def _seen(self, me: int, bots: Bots, x: Floats, y: Floats, which: Flags) -> Flags:
        """Those of the discs `which` that a bot sees; of equally near ones the lower numbers."""
        dx, dy = x - bots.x[me], y - bots.y[me]
        away2 = dx * dx + dy * dy
        seen = which & (away2 <= self._radius_m * self._radius_m)
        if self._least_cosine > -1.0:
            heading = float(bots.heading[me])
            ahead = dx * math.cos(heading) + dy * math.sin(heading)
            seen &= ahead >= self._least_cosine * np.sqrt(away2)
        nearest = self._sensing.nearest
        if nearest is not None and np.count_nonzero(seen) > nearest:
            order = np.argsort(np.where(seen, away2, np.inf), kind="stable")
            seen[order[nearest:]] = False
        return seen


class KnownContents:
    """What is in the buckets, by the snapshot and the transfers after it.

    Args:
        told: Whether bots are told at all.
        word_stations: How many there are: at the stations after them tiles go into buckets.
    """

    def __init__(self, told: bool, word_stations: int) -> None:
        self._told = told
        self._word_stations = word_stations
        self._contents: list[dict[int, int]] = []

    def begin(self, snapshot: Snapshot) -> None:
        """Begin with the contents of a snapshot."""
        if self._told:
            self._contents = [dict(contents) for contents in snapshot.contents]

    def moved(self, event: Event) -> None:
        """A tile was moved between a bucket and a station."""
        if not 0 <= event.bucket < len(self._contents):
            return
        contents, tile = self._contents[event.bucket], event.tile
        contents[tile] = contents.get(tile, 0) + (-1 if event.station < self._word_stations else 1)
        if contents[tile] <= 0:
            del contents[tile]

    def seen(self, buckets: Buckets) -> Callable[[int], Mapping[int, int]] | None:
        """What tells the contents of a bucket, empty for those that are `NOWHERE`; None where bots are not told."""
        if not self._told:
            return None
        contents = self._contents
        return lambda bucket: contents[bucket] if bucket < len(contents) and buckets.x[bucket] != NOWHERE else {}
