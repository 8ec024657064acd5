"""Tiles to buckets: which bucket takes in the tiles of a letter station (paper, "Research Challenges")."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from soup_managers.state.planning_state import Fill, PlanningState
from soup_msgs_py.warehouse.layout import Floats


class FillChoice(ABC):
    """Scores buckets for a letter station that runs out of buckets to fill. Extend it and implement `score`."""

    @abstractmethod
    def score(self, state: PlanningState, fill: Fill) -> Floats:
        """How good each bucket is for the tiles that are staged at a station.

        Args:
            state: The warehouse.
            fill: The station, its staged tiles, the room in each bucket and how far each is.

        Returns:
            Scores, shape (buckets,): the highest is taken, none that is not above 0. Buckets in use and
            without enough room are left out afterwards.
        """


class RandomFill(FillChoice):
    """Any bucket."""

    def score(self, state: PlanningState, fill: Fill) -> Floats:
        """Random numbers."""
        return 1.0 - state.rng.random(len(fill.room))


class Emptiest(FillChoice):
    """The emptiest bucket; with `travel_weight`, most room per second.

    Args:
        overhead_s: What a visit costs besides its transfers.
        travel_weight: What a second of the way to the station counts.
    """

    def __init__(self, overhead_s: float = 15.0, travel_weight: float = 0.3) -> None:
        self._overhead_s, self._travel_weight = overhead_s, travel_weight

    def score(self, state: PlanningState, fill: Fill) -> Floats:
        """Room over seconds."""
        cost_s = fill.room * fill.transfer_s + self._overhead_s + self._travel_weight * fill.travel_s
        return fill.room / cost_s


class NearestWithRoom(FillChoice):
    """The nearest bucket with room."""

    def score(self, state: PlanningState, fill: Fill) -> Floats:
        """Less travel is better."""
        return 1.0 / (1.0 + fill.travel_s)


class Popular(FillChoice):
    """Popular tiles go where popular tiles are: the staged tiles' popularity times the bucket's.

    The popularity of a kind is its share in all tiles that there are.
    """

    def score(self, state: PlanningState, fill: Fill) -> Floats:
        """How popular the tiles of a bucket are on average, signed by how popular the staged ones are."""
        share = state.kind_share
        staged = float(share[fill.tiles].mean()) if len(fill.tiles) else 0.0
        mean = share @ state.stock.tiles / np.maximum(1, state.stock.total)
        like = mean if staged >= float(share @ share) else -mean
        return 1.0 + like - like.min()


class Association(FillChoice):
    """Tiles that are wanted together are put together: the paper's q with u.

    Two kinds are associated as often as they are in one of the words that wait or are open.
    """

    def score(self, state: PlanningState, fill: Fill) -> Floats:
        """How often the tiles of a bucket are wanted in one word with the staged ones."""
        wanted = state.wanted_with(fill.tiles)
        return 1e-6 + wanted @ np.minimum(state.stock.tiles, 2)
