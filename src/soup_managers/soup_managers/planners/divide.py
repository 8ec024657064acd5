"""Compiled: the best division of boxes and shelves among robots, where there are too many to write them down.

Sets are bit masks. What a robot needs for a set of boxes and a set of shelves stands in a table of shape
(2 ** boxes, 2 ** shelves), with meaning only where the robot fills each of the shelves.
"""

from __future__ import annotations

import numpy as np

from soup_msgs_py.kernel import kernel

NEVER = 1e6


@kernel
def members(mask):
    """How many members a set has."""
    count = 0
    while mask:
        mask &= mask - 1
        count += 1
    return count


@kernel
def single_robot(carry, back, after_drop, after_pick):
    """Steps of one robot that has just filled a shelf, or picked up a box, for what is left to it.

    Args:
        carry: Steps from each box to each shelf, shape (boxes, shelves).
        back: Steps from each shelf to each box, shape (shelves, boxes).
        after_drop: Takes the result, shape (shelves, 2 ** boxes, 2 ** shelves).
        after_pick: Takes the result, shape (boxes, 2 ** boxes, 2 ** shelves).
    """
    boxes, shelves = carry.shape
    for mine in range(1 << boxes):
        count = members(mine)
        for stored in range(1 << shelves):
            filled = members(stored)
            if filled == count:
                for shelf in range(shelves):
                    best = NEVER if mine else 0.0
                    for box in range(boxes):
                        if mine >> box & 1:
                            best = min(best, back[shelf, box] + 1.0 + after_pick[box, mine & ~(1 << box), stored])
                    after_drop[shelf, mine, stored] = best
            elif filled == count + 1:
                for box in range(boxes):
                    best = NEVER
                    for shelf in range(shelves):
                        if stored >> shelf & 1:
                            best = min(best, carry[box, shelf] + 1.0 + after_drop[shelf, mine, stored & ~(1 << shelf)])
                    after_pick[box, mine, stored] = best


@kernel
def from_cell(away, load, after, boxes, shelves, table):
    """Steps of one robot from a cell, for all subsets of some boxes and shelves.

    Args:
        away: Steps from the cell to each shelf for a robot with a load, else to each box.
        load: 1 for a robot with a load, else 0.
        after: `after_drop` for a robot with a load, else `after_pick`.
        boxes: The boxes that are left.
        shelves: The shelves that are empty.
        table: Takes the result.
    """
    mine = boxes
    while True:
        count = members(mine) + load
        stored = shelves
        while True:
            if members(stored) == count:
                best = NEVER
                if load:
                    for shelf in range(len(away)):
                        if stored >> shelf & 1:
                            best = min(best, away[shelf] + 1.0 + after[shelf, mine, stored & ~(1 << shelf)])
                elif not mine:
                    best = 0.0
                else:
                    for box in range(len(away)):
                        if mine >> box & 1:
                            best = min(best, away[box] + 1.0 + after[box, mine & ~(1 << box), stored])
                table[mine, stored] = best
            if not stored:
                break
            stored = (stored - 1) & shelves
        if not mine:
            break
        mine = (mine - 1) & boxes


@kernel
def latest_of_both(first, first_loads, second, second_loads, boxes, shelves, table):
    """When the later of two is done, at the best division between them, for all subsets of boxes and shelves.

    Args:
        first: Table of the first, one robot or several.
        first_loads: How many of them have a load.
        second: Table of the second.
        second_loads: The same.
        boxes: The boxes that are left.
        shelves: The shelves that are empty.
        table: Takes the result.
    """
    both = boxes
    while True:
        stored = shelves
        while True:
            if members(stored) == members(both) + first_loads + second_loads:
                table[both, stored] = _best(first, first_loads, second, both, stored)
            if not stored:
                break
            stored = (stored - 1) & shelves
        if not both:
            break
        both = (both - 1) & boxes


@kernel
def latest_of_all(first, first_loads, second, second_loads, boxes, shelves):
    """The same for all boxes alone."""
    best, need = NEVER, members(boxes) + first_loads + second_loads
    stored = shelves
    while True:
        if members(stored) == need:
            best = min(best, _best(first, first_loads, second, boxes, stored))
        if not stored:
            return best
        stored = (stored - 1) & shelves


@kernel
def _best(first, first_loads, second, boxes, shelves):
    best = NEVER
    mine = boxes
    while True:
        need = members(mine) + first_loads
        stored = shelves
        while True:
            if members(stored) == need:
                best = min(best, max(first[mine, stored], second[boxes & ~mine, shelves & ~stored]))
            if not stored:
                break
            stored = (stored - 1) & shelves
        if not mine:
            return best
        mine = (mine - 1) & boxes


def room(boxes: int, shelves: int) -> np.ndarray:
    """An empty table."""
    return np.full((1 << boxes, 1 << shelves), NEVER)


def load_kernels() -> None:
    """Compile or load what is above, so that no search waits for it."""
    one, after = room(1, 1), np.zeros((1, 2, 2))
    single_robot(np.ones((1, 1)), np.ones((1, 1)), after, after.copy())
    from_cell(np.ones(1), 0, after, 1, 1, one)
    latest_of_both(one, 0, one, 0, 1, 1, room(1, 1))
    latest_of_all(one, 0, one, 0, 1, 1)
