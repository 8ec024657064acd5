"""A lower bound for many robots and boxes: which box is fetched after which, were shelves as good as priced.

Robots that bring all boxes to shelves make chains: a robot's start, its first box, the shelf for that, the next box and
so on. Without what keeps a chain from closing to a ring, and with a price on each shelf instead of the rule that it is
filled once (Lagrange), the cheapest chains are an assignment of successors. Whatever the prices are, no plan's robots
take fewer steps together; a subgradient raises prices of shelves that are used too often.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import linear_sum_assignment

from soup_managers.planners.sequences import FAR, Distances

ROUNDS = 200
MOST_WORK = 60_000_000  # boxes times boxes times shelves for which a round takes a moment
FIRST_STEP, SHRINKS = 2.0, 0.985
HOPED = 1.02  # times the bound so far


def fewest_steps(distances: Distances) -> float:
    """The fewest moves of all robots together, at least; 0 where there is too much to look at."""
    first, carry, back = (table.astype(float) for table in (distances.first, distances.carry, distances.back))
    robots, boxes = first.shape
    shelves = carry.shape[1]
    if boxes * boxes * shelves > MOST_WORK:
        return 0.0
    prices, step, best = np.zeros(shelves), FIRST_STEP, 0.0
    costs = np.zeros((boxes + robots, boxes + robots))  # who comes before, who comes after; beyond boxes: nobody
    costs[boxes:, :boxes] = first
    over = np.zeros((boxes, boxes), int)  # the shelf between two boxes
    every = np.arange(boxes)
    for _ in range(ROUNDS):
        priced = carry + prices
        for box in range(boxes):
            ways = priced[box][:, None] + back
            over[box] = ways.argmin(axis=0)
            costs[box, :boxes] = ways[over[box], every]
        costs[every, every] = FAR
        last = priced.argmin(axis=1)
        costs[:boxes, boxes:] = priced[every, last][:, None]
        before, after = linear_sum_assignment(costs)
        total = float(costs[before, after].sum() - prices.sum())
        best = max(best, total)
        next_box = after[:boxes]
        used = np.where(next_box < boxes, over[every, np.minimum(next_box, boxes - 1)], last)
        slope = np.bincount(used, minlength=shelves) - 1.0
        slope[(prices <= 0.0) & (slope < 0.0)] = 0.0
        square = float(slope @ slope)
        if square == 0.0:
            break
        prices = np.maximum(0.0, prices + step * max(HOPED * best - total, 1.0) / square * slope)
        step *= SHRINKS
    return best
