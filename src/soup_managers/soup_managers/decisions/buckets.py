"""Buckets to stations: which resting bucket is fetched for a word station."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from soup_managers.state.planning_state import PlanningState, Want
from soup_msgs_py.warehouse.layout import Floats


class BucketChoice(ABC):
    """Scores buckets for a word station that runs out of work. Extend it and implement `score`.

    Example:
        class Fullest(BucketChoice):
            def score(self, state, want):
                return np.where(want.tiles > 0, state.stock.total, 0.0)
    """

    @abstractmethod
    def score(self, state: PlanningState, want: Want) -> Floats:
        """How good each bucket is for a station.

        Args:
            state: The warehouse.
            want: The station, how many of its uncovered tiles each bucket holds, and how far each is.

        Returns:
            Scores, shape (buckets,): the highest is taken, none that is not above 0. Buckets in use are left
            out afterwards.
        """

    def match(self, state: PlanningState, wants: Sequence[Want]) -> list[Floats]:
        """Scores for several stations that may not take the same bucket; override it to decide jointly."""
        return [self.score(state, want) for want in wants]


class FirstBucket(BucketChoice):
    """The first bucket that holds a tile that is needed."""

    def score(self, state: PlanningState, want: Want) -> Floats:
        """All that serve are alike; of equals the first is taken."""
        return np.where(want.tiles > 0, 1.0, 0.0)


class NearestBucket(BucketChoice):
    """Of the buckets that hold a tile that is needed the nearest to the station."""

    def score(self, state: PlanningState, want: Want) -> Floats:
        """Less travel is better."""
        return np.where(want.tiles > 0, 1.0 / (1.0 + want.travel_s), 0.0)


class MostTiles(BucketChoice):
    """The bucket that holds most of the tiles that are needed."""

    def score(self, state: PlanningState, want: Want) -> Floats:
        """Tiles of the visit (its pile-on)."""
        return want.tiles.astype(np.float64)


class MostTilesPerSecond(BucketChoice):
    """Most tiles per second of the time that the visit costs: of the station and, at less weight, of the bot.

    Args:
        overhead_s: What a visit costs besides: the swap at the dock, the bot's way to the bucket.
        travel_weight: What a second of the bot's way to the station counts.
        late_weight: What a second counts during which the station would stand idle until the bucket comes.
        scarce_weight: Where bots are scarce, what a second of the bot's way to the bucket and to the station counts;
            while the station has work ahead, the bot waits there at full weight.
    """

    def __init__(
        self,
        overhead_s: float = 15.0,
        travel_weight: float = 0.3,
        late_weight: float = 1.0,
        scarce_weight: float = 0.6,
    ) -> None:
        self._overhead_s, self._travel_weight, self._late_weight = overhead_s, travel_weight, late_weight
        self._scarce_weight = scarce_weight

    def score(self, state: PlanningState, want: Want) -> Floats:
        """Tiles over seconds."""
        if want.bot_s is not None:
            bot_s = np.maximum(self._scarce_weight * (want.bot_s + want.travel_s), want.ahead_s)
            return want.tiles / (bot_s + self._overhead_s + want.tiles * want.transfer_s)
        late_s = np.maximum(0.0, want.travel_s + state.fetch_s - want.ahead_s)
        cost_s = want.tiles * want.transfer_s + self._overhead_s
        return want.tiles / (cost_s + self._travel_weight * want.travel_s + self._late_weight * late_s)


class JointBuckets(MostTilesPerSecond):
    """As `most_tiles_per_second`, but for all stations that want a bucket at once: the best assignment."""

    def match(self, state: PlanningState, wants: Sequence[Want]) -> list[Floats]:
        """Each station's bucket in the assignment comes first; the others stay behind it in their order."""
        scores = np.array([self.score(state, want) for want in wants])
        scores[:, ~state.free_buckets] = 0.0
        rows, columns = linear_sum_assignment(scores, maximize=True)
        for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
            if scores[row, column] > 0.0:
                scores[row, column] += 1.0
        return list(scores)
