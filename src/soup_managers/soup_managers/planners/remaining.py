"""How long a joint state needs at least: an admissible heuristic from exact tables for single robots.

Whatever the robots do, boxes and shelves end up divided among them, and the last robot is done no sooner than if it
were alone on the emptiest floor. So the least time, over all ways to divide them, of the robot that is done last is
never too much. Where there are too many ways, robots are allowed to use the same shelf twice, which is never more.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, lru_cache
from itertools import combinations, product
from math import comb

import numpy as np
from numpy.typing import NDArray

from soup_managers.planners.divide import NEVER, from_cell, latest_of_all, latest_of_both, room, single_robot
from soup_managers.planners.moves import State
from soup_managers.planners.plan import Rules
from soup_msgs_py.warehouse.cell_world import World

MOST_DIVISIONS = 20_000  # ways to divide boxes and shelves that are looked at for one state
MOST_OWNERS = 70_000  # ways to divide boxes alone; with more, boxes are looked at one by one
MOST_BITS = 17  # boxes and shelves together for which all subsets are looked at
_LATEST = 1e8  # more than all robots' steps together: what is done last comes first
MOST_BOXES = 10  # with more, what a single robot may get are too many, with any shelves
_NO_PLAN = float("inf"), float("inf")

Table = NDArray[np.float64]
Estimate = tuple[float, float]  # a lower bound for the steps that are left; all robots' steps together


class Remaining:
    """Least steps that are left.

    Args:
        world: The world.
        rules: Whether robots have to leave the shelves in the end.
    """

    def __init__(self, world: World, rules: Rules) -> None:
        self._rules = rules
        self._shelf_cells = frozenset(world.shelves)
        self._to_box = _steps(world, world.boxes)
        self._to_shelf = _steps(world, world.shelves)
        self._carry = np.ascontiguousarray(self._to_shelf[:, list(world.boxes)].T)
        self._back = np.ascontiguousarray(self._to_box[:, list(world.shelves)].T)
        self._shelves = len(world.shelves)
        self._boxes = len(world.boxes)
        self._alone = lru_cache(maxsize=1)(self._find_alone)
        self._one = lru_cache(maxsize=2000)(self._find_one)
        self._several = lru_cache(maxsize=2000)(self._find_several)
        self._after_drop = lru_cache(maxsize=None)(self._find_after_drop)
        self._after_pick = lru_cache(maxsize=None)(self._find_after_pick)
        self._group = lru_cache(maxsize=None)(self._find_group)
        self._times = lru_cache(maxsize=1 << 18)(self._find_times)
        self._shares = lru_cache(maxsize=1 << 18)(self._find_shares)
        self._divisions = lru_cache(maxsize=None)(self._find_divisions)

    def of(self, state: State) -> Estimate:
        """A lower bound for the steps that are left, infinite where no plan is; and, for ties, all robots' steps."""
        return self.of_all([state])[0]

    def of_all(self, states: Sequence[State]) -> list[Estimate]:
        """The same of several states; those in which the same is left to do are looked at together."""
        alike: dict[tuple[int, int, int], list[int]] = {}
        for index, state in enumerate(states):
            alike.setdefault(state[1:], []).append(index)
        found: list[Estimate] = [_NO_PLAN] * len(states)
        for indices in alike.values():
            group = [states[index] for index in indices]
            for index, estimate in zip(indices, self._of_alike(group), strict=True):
                found[index] = estimate
        return found

    def _of_alike(self, states: list[State]) -> list[Estimate]:
        """Estimates of states with the same boxes, shelves and loads."""
        robots, loaded, boxes, shelves = states[0]
        if not boxes and not loaded:
            return [self._to_leave(state) for state in states]
        loads = tuple([loaded >> robot & 1 for robot in range(len(robots))])
        if len(loads) ** boxes.bit_count() > MOST_OWNERS or boxes.bit_count() > MOST_BOXES:
            return [self._box_by_box(state, loads) for state in states]
        latest = total = None
        for robot in range(len(robots)):
            shares = [self._shares(robot, state.robots[robot], boxes, shelves, loads) for state in states]
            if shares[0] is None:
                return [_NO_PLAN] * len(states)
            times = np.array(shares)
            latest = times if latest is None else np.maximum(latest, times)
            total = times if total is None else total + times
        assert latest is not None and total is not None
        best = np.minimum.reduce(latest * _LATEST + total, axis=1).tolist()
        leave = self._rules.must_leave
        return [(key // _LATEST + leave, key % _LATEST) if key < NEVER * _LATEST else _NO_PLAN for key in best]

    def exactly(self, state: State) -> float:
        """The bound with no shelf used twice, where `of` allows that for want of time; else 0."""
        loads = tuple([state.loads >> robot & 1 for robot in range(len(state.robots))])
        if not self._is_relaxed(state.boxes, state.shelves, loads) or self._boxes + self._shelves > MOST_BITS:
            return 0.0
        *others, last = zip(state.robots, loads, strict=True)
        table = self._one(last[0], last[1], state.boxes, state.shelves)
        if not others:
            return 0.0
        front, front_loads = self._several(tuple(others), state.boxes, state.shelves), sum(loads[:-1])
        least = float(latest_of_all(front, front_loads, table, last[1], state.boxes, state.shelves))
        return least + self._rules.must_leave if least < NEVER else float("inf")

    def _is_relaxed(self, boxes: int, shelves: int, loads: tuple[int, ...]) -> bool:
        items, empty = boxes.bit_count(), shelves.bit_count()
        if comb(items + empty, items + max(loads)) > MOST_DIVISIONS:
            return True  # what a single robot may get are too many already
        return bool(boxes or any(loads)) and _count(items, empty, loads) > MOST_DIVISIONS

    def _find_several(self, robots: tuple[tuple[int, int], ...], boxes: int, shelves: int) -> Table:
        """When the last of some robots, cells and loads, is done, for all subsets of boxes and shelves."""
        *others, (cell, load) = robots
        one = self._one(cell, load, boxes, shelves)
        if not others:
            return one
        table, loads = room(self._boxes, self._shelves), sum(load for _, load in others)
        latest_of_both(self._several(tuple(others), boxes, shelves), loads, one, load, boxes, shelves, table)
        return table

    def _find_one(self, cell: int, load: int, boxes: int, shelves: int) -> Table:
        table = room(self._boxes, self._shelves)
        after = self._alone()[0 if load else 1]
        away = np.ascontiguousarray((self._to_shelf if load else self._to_box)[:, cell])
        from_cell(away, load, after, boxes, shelves, table)
        return table

    def _find_alone(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        shape = 1 << self._boxes, 1 << self._shelves
        after_drop, after_pick = np.full((self._shelves, *shape), NEVER), np.full((self._boxes, *shape), NEVER)
        single_robot(self._carry, self._back, after_drop, after_pick)
        return after_drop, after_pick

    def _to_leave(self, state: State) -> Estimate:
        left = 1.0 if self._rules.must_leave and not self._shelf_cells.isdisjoint(state.robots) else 0.0
        return left, left

    def _box_by_box(self, state: State, loads: tuple[int, ...]) -> Estimate:
        """Where there are many boxes: the one that takes longest, as if each had all robots for itself."""
        robots = list(state.robots)
        carried = [float(self._to_shelf[:, robot].min()) + 1 for robot, load in zip(robots, loads, strict=True) if load]
        # also one that has a box may come for another, and no sooner than if it had none
        times = self._to_box[:, robots].min(axis=1) + 2 + self._carry.min(axis=1)
        least = max([*carried, *(float(times[box]) for box in _members(state.boxes))])
        return (least + self._rules.must_leave, least) if least < NEVER else _NO_PLAN

    def _find_shares(self, robot: int, cell: int, boxes: int, shelves: int, loads: tuple[int, ...]) -> Table | None:
        """How long a robot takes from a cell for its share of each division; None where there are too few shelves."""
        division = self._divisions(boxes, shelves, loads)
        if division is None:
            return None
        allowed, rows = division
        return self._times(cell, loads[robot], boxes, allowed)[rows[robot]]

    def _find_divisions(
        self, boxes: int, shelves: int, loads: tuple[int, ...]
    ) -> tuple[int, list[NDArray[np.int64]]] | None:
        """All ways to divide boxes and shelves among robots: for each robot, its row in its `_group`.

        Returns:
            The shelves as `_group` wants them, -1 for any; and the rows. None where there are too few shelves.
        """
        items, robots = _members(boxes), len(loads)
        need = len(items) + sum(loads)
        if need > shelves.bit_count():
            return None
        if self._is_relaxed(boxes, shelves, loads):
            place = {taken: row for row, (taken, _) in enumerate(self._group(boxes, -1, 0)[0])}
            owners = np.array([*product(range(robots), repeat=len(items))], np.int64).reshape(-1, len(items))
            bits = np.array([1 << item for item in items], np.int64)
            masks = [(bits * (owners == robot)).sum(axis=1) for robot in range(robots)]
            return -1, [np.array([place[int(mask)] for mask in taken]) for taken in masks]
        places = [{pair: row for row, pair in enumerate(self._group(boxes, shelves, load)[0])} for load in loads]
        rows: list[list[int]] = [[] for _ in loads]

        def divide(robot: int, boxes: int, shelves: int, chosen: list[int]) -> None:
            if robot == robots:
                if not boxes:
                    for column, row in zip(rows, chosen, strict=True):
                        column.append(row)
                return
            subsets = [boxes] if robot == robots - 1 else _subsets(boxes)
            for mine in subsets:
                for stored in _of_size(shelves, mine.bit_count() + loads[robot]):
                    divide(robot + 1, boxes & ~mine, shelves & ~stored, [*chosen, places[robot][mine, stored]])

        divide(0, boxes, shelves, [])
        return shelves, [np.array(column) for column in rows]

    def _find_group(self, boxes: int, shelves: int, load: int) -> tuple[list[tuple[int, int]], Table]:
        """What one robot may get, boxes and shelves, and how long it takes from where it begins with each.

        Returns:
            The pairs, and for each the steps after arriving at its first box (with a load: shelf), shape
            (pairs, boxes or shelves); `NEVER` for what is not in the pair.
        """
        free = shelves < 0
        pairs = [
            (mine, stored)
            for mine in _subsets(boxes)
            for stored in ([-1] if free else _of_size(shelves, mine.bit_count() + load))
        ]
        table = np.full((len(pairs), len(self._to_shelf if load else self._to_box)), NEVER)
        for row, (mine, stored) in enumerate(pairs):
            if load:
                for shelf in range(self._shelves) if free else _members(stored):
                    left = stored if free else stored & ~(1 << shelf)
                    table[row, shelf] = 1 + self._after_drop(shelf, mine, left)
            else:
                for box in _members(mine):
                    table[row, box] = 1 + self._after_pick(box, mine & ~(1 << box), stored)
        return pairs, table

    def _find_times(self, cell: int, load: int, boxes: int, shelves: int) -> Table:
        """How long a robot takes for each of its pairs, from a cell."""
        pairs, table = self._group(boxes, shelves, load)
        if not table.shape[1]:
            return np.zeros(len(pairs))
        away = self._to_shelf[:, cell] if load else self._to_box[:, cell]
        times = (table + away).min(axis=1)
        if not load:
            times[[row for row, (mine, _) in enumerate(pairs) if not mine]] = 0.0
        return times

    def _find_after_drop(self, shelf: int, boxes: int, shelves: int) -> float:
        """Steps of one robot that has just filled a shelf, for boxes and shelves that are left to it."""
        steps = [
            float(self._back[shelf, box]) + 1 + self._after_pick(box, boxes & ~(1 << box), shelves)
            for box in _members(boxes)
        ]
        return min(steps, default=0.0)

    def _find_after_pick(self, box: int, boxes: int, shelves: int) -> float:
        """Steps of one robot that has just picked up a box."""
        free = shelves < 0
        steps = [
            float(self._carry[box, shelf])
            + 1
            + self._after_drop(shelf, boxes, shelves if free else shelves & ~(1 << shelf))
            for shelf in (range(self._shelves) if free else _members(shelves))
        ]
        return min(steps, default=NEVER)


def _steps(world: World, goals: tuple[int, ...]) -> Table:
    """Moves from each cell to each goal, shape (goals, cells); `NEVER` where none lead."""
    table = np.array([world.distances([goal]) for goal in goals], float).reshape(len(goals), world.cells)
    table[table < 0] = NEVER
    return table


def _members(mask: int) -> list[int]:
    return [bit for bit in range(mask.bit_length()) if mask >> bit & 1]


def _subsets(mask: int) -> list[int]:
    found, sub = [], mask
    while True:
        found.append(sub)
        if not sub:
            return found
        sub = (sub - 1) & mask


@cache
def _of_size(mask: int, size: int) -> list[int]:
    return [sum(1 << bit for bit in chosen) for chosen in combinations(_members(mask), size)]


@cache
def _count(boxes: int, shelves: int, loads: tuple[int, ...]) -> int:
    """How many ways there are to divide boxes and shelves among robots; enough is enough."""
    if len(loads) ** boxes > MOST_DIVISIONS:
        return MOST_DIVISIONS + 1
    total, factor = 0, _factorials(max(boxes, shelves))
    for shares in product(range(boxes + 1), repeat=len(loads)):
        if sum(shares) == boxes:
            ways, left, empty = 1, boxes, shelves
            for share, load in zip(shares, loads, strict=True):
                ways *= factor[left] // (factor[share] * factor[left - share])
                ways *= factor[empty] // (factor[share + load] * factor[empty - share - load])
                left, empty = left - share, empty - share - load
            total += ways
    return total


def _factorials(most: int) -> list[int]:
    found = [1]
    for number in range(1, most + 1):
        found.append(found[-1] * number)
    return found
