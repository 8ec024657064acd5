"""Tasks to bots: which idle bot fetches a bucket."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from soup_managers.state.planning_state import PlanningState
from soup_msgs_py.warehouse.layout import Floats, Ints


class BotChoice(ABC):
    """Scores idle bots for buckets that are to be fetched. Extend it and implement `cost`.

    A bot that stands under a bucket is not asked for here: nobody else can get to that bucket.
    """

    @abstractmethod
    def cost(self, state: PlanningState, bots: Ints, place: tuple[float, float]) -> Floats:
        """What it costs that each idle bot fetches the bucket at a place; the least is taken.

        Args:
            state: The warehouse.
            bots: Numbers of the idle bots, ascending, shape (n,).
            place: Where the bucket rests (m).

        Returns:
            Costs, shape (n,).
        """

    def match(self, state: PlanningState, bots: Ints, places: Sequence[tuple[float, float]]) -> list[Floats]:
        """Costs for several buckets that need bots of their own; override it to decide jointly."""
        return [self.cost(state, bots, place) for place in places]


class FirstBot(BotChoice):
    """The first idle bot."""

    def cost(self, state: PlanningState, bots: Ints, place: tuple[float, float]) -> Floats:
        """The bot's number."""
        return bots.astype(np.float64)


class NearestBot(BotChoice):
    """The nearest idle bot, along the aisles."""

    def cost(self, state: PlanningState, bots: Ints, place: tuple[float, float]) -> Floats:
        """Distance along x and y (m)."""
        away = np.abs(state.robot_xy[bots] - place)
        return away[:, 0] + away[:, 1]


class Assignment(NearestBot):
    """The bots that drive least altogether, for all buckets that are to be fetched at once."""

    def match(self, state: PlanningState, bots: Ints, places: Sequence[tuple[float, float]]) -> list[Floats]:
        """Each bucket's bot in the assignment comes first."""
        costs = np.array([self.cost(state, bots, place) for place in places])
        rows, columns = linear_sum_assignment(costs)
        for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
            costs[row, column] -= 1e6
        return list(costs)
