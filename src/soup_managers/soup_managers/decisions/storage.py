"""Where a bucket is stored when its bot is done with it."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from soup_managers.contents import Counts
from soup_managers.state.planning_state import PlanningState
from soup_msgs_py.warehouse.layout import Floats


class StorageChoice(ABC):
    """Scores free storage spots for a bucket. Extend it and implement `cost`."""

    @abstractmethod
    def cost(self, state: PlanningState, bucket: int, spots: Counts, travel_s: Floats) -> Floats:
        """What it costs to store a bucket on each free spot; the least is taken.

        Args:
            state: The warehouse.
            bucket: The bucket.
            spots: Free storage spots, as waypoints, shape (n,).
            travel_s: The way there from where the bucket is (s), shape (n,).

        Returns:
            Costs, shape (n,).
        """


class Fixed(StorageChoice):
    """Every bucket has its place: where it stood at the start."""

    def cost(self, state: PlanningState, bucket: int, spots: Counts, travel_s: Floats) -> Floats:
        """Distance from the bucket's first place."""
        away = np.abs(state.layout.waypoints[spots] - state.first_place[bucket])
        return away[:, 0] + away[:, 1]


class RandomSpot(StorageChoice):
    """Any free spot."""

    def cost(self, state: PlanningState, bucket: int, spots: Counts, travel_s: Floats) -> Floats:
        """Random numbers."""
        return state.rng.random(len(spots))


class NearestSpot(StorageChoice):
    """The nearest free spot."""

    def cost(self, state: PlanningState, bucket: int, spots: Counts, travel_s: Floats) -> Floats:
        """Travel time."""
        return travel_s


class NearWords(StorageChoice):
    """Near, and near to the word stations, where the bucket is wanted next.

    Args:
        weight: What a second from the spot to the nearest word station counts, against one on the way there.
    """

    def __init__(self, weight: float = 3.0) -> None:
        self._weight = weight

    def cost(self, state: PlanningState, bucket: int, spots: Counts, travel_s: Floats) -> Floats:
        """Seconds, weighted."""
        return travel_s + self._weight * state.to_words_s[spots]


class PopularityZones(StorageChoice):
    """As `near_words`, but the fuller a bucket is, the nearer to the word stations it may be.

    Args:
        weight: As for `near_words`, for a full bucket; an empty one goes to the nearest spot.
    """

    def __init__(self, weight: float = 3.0) -> None:
        self._weight = weight

    def cost(self, state: PlanningState, bucket: int, spots: Counts, travel_s: Floats) -> Floats:
        """Seconds, weighted by how full the bucket is."""
        full = float(state.stock.total[bucket]) / state.stock.capacity
        return travel_s + self._weight * full * state.to_words_s[spots]


class StationCache(NearWords):
    """Near the word station whose open words the bucket serves best, to be back at once; else as `near_words`.

    Args:
        weight: As for `near_words`.
    """

    def cost(self, state: PlanningState, bucket: int, spots: Counts, travel_s: Floats) -> Floats:
        """Seconds, weighted."""
        serves = [state.serves(bucket, station) for station in range(state.word_stations)]
        best = int(np.argmax(serves))
        if serves[best] == 0:
            return super().cost(state, bucket, spots, travel_s)
        return travel_s + self._weight * state.traffic.times_to(state.docks[best])[spots]
