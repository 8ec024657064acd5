"""Compiled: one robot's quickest way through space and time, past everybody whose plan is fixed already."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from soup_managers.kernels.heap import drop_first, push
from soup_managers.planners.plan import WAIT
from soup_msgs_py.kernel import kernel
from soup_msgs_py.warehouse.cell_world import MOVES, World

NOBODY = -1
FOR_EVER = 1 << 30

Ints = NDArray[np.int32]


def sides_of(world: World) -> Ints:
    """The cells beside each cell, `NOBODY` for none, shape (cells, 4)."""
    sides = np.full((world.cells, 4), NOBODY, np.int32)
    for cell, moves in enumerate(world.moves):
        for side, (_, there) in enumerate(moves):
            sides[cell, side] = there
    return sides


def letters_of(world: World, way: Ints) -> list[str]:
    """The letters that lead from each cell of a way to the next; waiting where it stays."""
    names = {dx + dy * world.width: letter for letter, (dx, dy) in MOVES.items()}
    if world.width == 1:
        names = {1: "D", -1: "U"}
    return [names.get(step, WAIT) for step in np.diff(way).tolist()]


class Calendar:
    """Who is where when: what is fixed of a plan.

    Attributes:
        who: The robot in each cell at each step, shape (steps, cells), `NOBODY` for none.
        closed: The step from which each cell is closed for good, to all but who rests there; `FOR_EVER`: never.
        last: The last step in which each cell is used, -1 for never.
        boxed: The first step at which no box is in each cell any more, where loaded robots may not drive over boxes;
            else 0.
    """

    def __init__(self, steps: int, cells: int) -> None:
        """Nobody is anywhere."""
        self.who = np.full((steps, cells), NOBODY, np.int16)
        self.closed = np.full(cells, FOR_EVER, np.int64)
        self.last = np.full(cells, -1, np.int64)
        self.boxed = np.zeros(cells, np.int64)
        self._seen = np.zeros((steps, 2, cells), np.int32)
        self._came = np.zeros((steps, 2, cells), np.int32)
        self._keys = np.empty(1 << 20)
        self._items = np.empty(1 << 20, np.int64)
        self._way = np.empty(steps, np.int32)
        self._round = 0

    def way(
        self, start: int, begins: int, over: int, goal: int, neighbours: Ints, to_over: Ints, to_goal: Ints
    ) -> NDArray[np.int32] | None:
        """The quickest way to a cell, one step of work there, and on to another cell for good.

        Args:
            start: Where the robot is.
            begins: At which step.
            over: The cell where it works for a step.
            goal: The cell where it stays; nobody may pass there later.
            neighbours: Cells beside each cell, -1 for none, shape (cells, 4).
            to_over: Fewest moves from each cell to `over`.
            to_goal: Fewest moves from each cell to `goal`.

        Returns:
            The cell at each step from `begins`; None where no way is found within the calendar.
        """
        self._round += 1
        count = find_way(
            start, begins, over, goal, neighbours, to_over, to_goal, self.who, self.closed, int(self.last[goal]),
            self.boxed, self._seen, self._came, self._round, self._keys, self._items, self._way,
        )  # fmt: skip
        return self._way[:count].copy() if count > 0 else None

    def enter(self, robot: int, begins: int, way: NDArray[np.int32]) -> None:
        """Fix a robot's way."""
        steps = np.arange(begins, begins + len(way))
        self.who[steps, way] = robot
        np.maximum.at(self.last, way, steps)


@kernel
def find_way(
    start, begins, over, goal, neighbours, to_over, to_goal, who, closed, goal_free_from, boxed, seen, came, now, keys,
    items, way,
):  # fmt: skip
    """As `Calendar.way`; writes the cells into `way`, returns how many there are, 0 for none (A*)."""
    steps, cells = who.shape
    me = who[begins, start]
    rest = to_goal[over] + 1
    if to_over[start] < 0 or to_goal[over] < 0:
        return 0
    seen[begins, 0, start] = now
    came[begins, 0, start] = -1
    keys[0], items[0], size = float(to_over[start] + rest), (begins * 2) * cells + start, 1
    while size > 0:
        item = items[0]
        drop_first(keys, items, size)
        size -= 1
        cell, phase, step = item % cells, item // cells % 2, item // (2 * cells)
        if phase == 1 and cell == goal and step > goal_free_from:
            count = step - begins + 1
            k, c, p = step, cell, phase
            while k >= begins:
                way[k - begins] = c
                before = came[k, p, c]
                k, c, p = k - 1, before % cells, before // cells
            return count
        if step + 1 >= steps or size + 6 >= len(keys):
            return 0
        for direction in range(6):
            # to each side; stay; work
            after, there = phase, cell
            if direction < 4:
                there = neighbours[cell, direction]
                if there < 0:
                    continue
            elif direction == 5:
                if phase == 1 or cell != over:
                    continue
                after = 1
            other = who[step + 1, there]
            if (other >= 0 and other != me) or seen[step + 1, after, there] == now:
                continue
            if closed[there] <= step + 1 and there != start:
                continue
            if after == 1 and boxed[there] > step + 1 and there != over:
                continue
            if there == start and cell != start and closed[start] <= step + 1:
                continue  # who has left the shelf that it filled cannot come back
            crossing = who[step, there]
            if crossing >= 0 and crossing != me and who[step + 1, cell] == crossing:
                continue
            left = to_over[there] + rest if after == 0 else to_goal[there]
            if left < 0:
                continue
            seen[step + 1, after, there] = now
            came[step + 1, after, there] = phase * cells + cell
            push(
                keys,
                items,
                size,
                float(step + 1 - begins + left) - 1e-6 * (step + 1),
                ((step + 1) * 2 + after) * cells + there,
            )
            size += 1
    return 0
