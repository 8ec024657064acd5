"""A valid plan at once for many robots and boxes, improved for as long as there is time, with a lower bound.

Boxes and shelves are first divided as if nobody were in anybody's way, then the robots' ways are fixed one after the
other in space and time, in the order in which they get free (Ma et al. 2017: token passing). A way ends on the shelf
that it fills. That cell is closed to all others anyway, so a robot can rest there until it goes on, and the next way
can always be found unless a filled shelf cuts the floor in two; shelves that would do that are filled last. What ways
turn out longer than was thought goes into the next division.
"""

from __future__ import annotations

import heapq
import math
import time
from collections import deque

import numpy as np

from soup_managers.planners.moves import Moves
from soup_managers.planners.plan import PICK_OR_DROP, WAIT, Answer, Task
from soup_managers.planners.remaining import MOST_OWNERS, Remaining
from soup_managers.planners.sequences import Distances, Ints, anneal, first_sequences, least_makespan
from soup_managers.planners.spacetime import FOR_EVER, Calendar, letters_of, sides_of
from soup_managers.planners.successors import fewest_steps
from soup_msgs_py.errors import InputError
from soup_msgs_py.warehouse.cell_world import World

EACH_LONG = 5  # of so many plans, one has its boxes divided anew with all rounds, the others begin with its division
SHARE = 20  # the others take this part of the rounds
LONG = 0.2  # of the time: no division takes longer
PRICED_S = 15.0  # with so much time, a better lower bound is worth some seconds
HEAT, WARMTH = 300.0, 30.0  # what annealing begins with: anew, and from a good division
LATE = (1.2, 1.15, 1.1)  # steps after which a robot is late, in lower bounds
LONGEST = 12  # calendar: times the lower bound
SAME = 1e-6  # sums of fractions may be larger by so much than they are


def anytime(task: Task) -> Answer:
    """A plan at once, the best one when time is over; by the default rules only, where robots may rest."""
    if not task.rules.may_wait:
        raise InputError("--planner", "", "anytime with rules by which no robot may wait", "--rules default")
    search = _Search(task)
    return search.run()


class _Search:
    """One search.

    Attributes:
        best: The shortest plan so far.
    """

    def __init__(self, task: Task) -> None:
        self._task, self._world = task, task.world
        world = task.world
        self.best: tuple[str, ...] | None = None
        _load_kernels()
        self._begun = time.perf_counter()
        self._neighbours = sides_of(world)
        self._to_box = [np.array(world.distances([box]), np.int32) for box in world.boxes]
        self._to_shelf = [np.array(world.distances([shelf]), np.int32) for shelf in world.shelves]
        self._distances = Distances(
            np.array([[table[robot] for table in self._to_box] for robot in world.robots], np.int32),
            np.array([[table[box] for table in self._to_shelf] for box in world.boxes], np.int32),
            np.array([[table[shelf] for table in self._to_box] for shelf in world.shelves], np.int32),
            np.array([[table[box] for table in self._to_box] for box in world.boxes], np.int32),
        )
        self.bound = float(least_makespan(self._distances)) if world.boxes else 0.0
        if len(world.robots) ** len(world.boxes) <= MOST_OWNERS:
            self.bound = max(self.bound, Remaining(world, task.rules).of(Moves(world, task.rules).start)[0])
        self._tried = 0

    def run(self) -> Answer:
        """Search until time is over or the plan is as short as the bound."""
        world, limit = self._world, self._task.time_limit_s
        if not world.boxes:
            return self._answer(tuple("" for _ in world.robots))
        if not math.isfinite(self.bound) or self.bound >= 1_000_000:
            self.bound = math.inf
            return self._answer(None, "there is no plan: a box has no way to a shelf of its own")
        boxes, robots = len(world.boxes), len(world.robots)
        start = first_sequences(self._distances)
        delays = np.zeros(robots)
        kept: tuple[Ints, Ints, Ints] = start
        shortest, target = math.inf, self.bound
        rounds, few = self._task.rounds, self._task.rounds // SHARE
        d = self._distances
        while True:
            order, count, shelf = (table.copy() for table in kept)
            if self._tried:  # the first plan has to be there at once
                taken = np.full(len(world.shelves), -1, np.int32)
                taken[shelf] = np.arange(boxes)
                anew = self._tried % EACH_LONG == 2  # the second plan is to be there soon
                heat = HEAT if anew or self._tried == 1 else WARMTH
                began = time.perf_counter()
                late_from = target * LATE[self._tried // EACH_LONG % len(LATE)]
                anneal(
                    order, count, shelf, taken, np.empty(robots), np.empty(boxes, np.int64), delays, d.first, d.carry,
                    d.back, d.near_boxes, d.near_shelves, late_from, rounds if anew else few, heat,
                    self._task.seed + self._tried,
                )  # fmt: skip
                if self._tried == 1 and math.isfinite(limit):
                    a_round = (time.perf_counter() - began) / few
                    rounds = min(rounds, int(LONG * limit / a_round))
                    few = min(few, rounds)
                if anew:
                    kept = order.copy(), count.copy(), shelf.copy()
            found = self._play(order, count, shelf, shortest)
            self._tried += 1
            if self._tried == 2 and limit >= PRICED_S and math.isfinite(limit):
                self.bound = max(self.bound, math.ceil((fewest_steps(d) + 2 * boxes) / robots - SAME))
            if found is not None:
                plans, makespan, late = found
                delays = 0.5 * delays + 0.5 * late
                if makespan < shortest:
                    shortest, self.best, kept = makespan, plans, (order, count, shelf)
            is_over = time.perf_counter() - self._begun > limit or self._tried >= self._task.most_tries
            if shortest <= self.bound or is_over:
                break
        note = "" if self.best is not None else f"no plan within {limit:g} s"
        return self._answer(self.best, note)

    def _answer(self, plans: tuple[str, ...] | None, note: str = "") -> Answer:
        proven = plans is not None and len(plans[0]) <= self.bound
        spent = time.perf_counter() - self._begun
        return Answer(plans, self.bound, proven, self._tried, self._tried, spent, note)

    def _play(
        self, order: Ints, count: Ints, shelf: Ints, shortest: float
    ) -> tuple[tuple[str, ...], int, np.ndarray] | None:
        """Fix all ways in the order in which robots get free.

        Returns:
            The plans, their makespan, and how much later each robot is than its distances say; None where somebody
            finds no way, or the plan would not be shorter.
        """
        world = self._world
        robots = len(world.robots)
        steps = int(min(shortest, LONGEST * self.bound + 200)) + 2
        calendar = Calendar(steps, world.cells)
        cells, cut = list(world.robots), _Floor(world)
        if not self._task.rules.carries_over:
            calendar.boxed[list(world.boxes)] = FOR_EVER
        for robot, cell in enumerate(cells):
            calendar.closed[cell] = 0
            calendar.who[0, cell] = robot
        shelf_of = shelf.copy()
        queues = [deque(order[robot, : count[robot]].tolist()) for robot in range(robots)]
        letters: list[list[str]] = [[] for _ in range(robots)]
        asked = np.zeros(robots)
        # those with most to do set off first
        free = [(0, -len(queues[robot]), robot) for robot in range(robots) if queues[robot]]
        heapq.heapify(free)
        left, makespan, stuck = len(world.boxes), 0, 0
        while free:
            now, _, robot = heapq.heappop(free)
            box = queues[robot][0]
            self._choose_shelf(box, queues, shelf_of, cut, left)
            goal = world.shelves[shelf_of[box]]
            calendar.who[now, cells[robot]] = robot
            way = calendar.way(
                cells[robot], now, world.boxes[box], goal, self._neighbours, self._to_box[box],
                self._to_shelf[shelf_of[box]],
            )  # fmt: skip
            if way is None:
                stuck += 1
                if stuck > 2 * robots or now + 8 >= steps:
                    return None
                heapq.heappush(free, (now + 4, 0, robot))  # the others make room
                continue
            stuck = 0
            asked[robot] += self._to_box[box][cells[robot]] + self._to_shelf[shelf_of[box]][world.boxes[box]] + 2
            if cells[robot] in world.robots and not cut.is_filled(cells[robot]):
                calendar.closed[cells[robot]] = FOR_EVER  # it leaves its start
                start = cells[robot]
                calendar.who[len(letters[robot]) : now, start] = robot
                calendar.last[start] = max(calendar.last[start], now)
            calendar.enter(robot, now, way)
            dropped = now + len(way)  # at the step after its arrival
            if dropped >= steps:
                return None
            calendar.closed[goal] = dropped - 1
            calendar.who[dropped, goal] = robot
            letters[robot] += [WAIT] * (now - len(letters[robot]))
            added = self._letters(way, world.boxes[box])
            if not self._task.rules.carries_over:
                calendar.boxed[world.boxes[box]] = now + added.index(PICK_OR_DROP) + 1
            letters[robot] += added
            cells[robot] = goal
            cut.fill(goal)
            left -= 1
            queues[robot].popleft()
            makespan = max(makespan, dropped)
            if queues[robot]:
                heapq.heappush(free, (dropped, -len(queues[robot]), robot))
        ends = np.array([len(row) for row in letters], float)
        plans = tuple("".join(row) + WAIT * (makespan - len(row)) for row in letters)
        return plans, makespan, np.maximum(0.0, ends - asked)

    def _letters(self, way: np.ndarray, box: int) -> list[str]:
        """The letters of a way over a box to a shelf, the drop included."""
        cells = way.tolist()
        found = letters_of(self._world, way)
        # the last step that it stands at its box is the one in which it picks it up; any is as good
        at = next(k for k in range(len(cells) - 1) if cells[k] == cells[k + 1] == box)
        found[at] = PICK_OR_DROP
        return [*found, PICK_OR_DROP]

    def _choose_shelf(self, box: int, queues: list[deque[int]], shelf_of: Ints, cut: _Floor, left: int) -> None:
        """Where filling a box's shelf would cut off others, let it change shelves with a box that comes later."""
        world = self._world
        if cut.may_fill(world.shelves[shelf_of[box]], left):
            return
        later = [other for queue in queues for other in queue if other != box]
        others = sorted(later, key=lambda other: int(self._to_shelf[shelf_of[other]][world.boxes[box]]))
        for other in others:
            if cut.may_fill(world.shelves[shelf_of[other]], left):
                shelf_of[box], shelf_of[other] = shelf_of[other], shelf_of[box]
                return
        used = set(shelf_of.tolist())
        for number, cell in enumerate(world.shelves):
            if number not in used and not cut.is_filled(cell) and cut.may_fill(cell, left):
                shelf_of[box] = number
                return


class _Floor:
    """Which shelves can be filled without cutting off what is still needed."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._filled: set[int] = set()
        self._wanted = set(world.robots) | set(world.boxes)

    def is_filled(self, cell: int) -> bool:
        """Whether a cell is a shelf that was filled."""
        return cell in self._filled

    def fill(self, cell: int) -> None:
        """A shelf is filled; a robot rests there until it goes on."""
        self._filled.add(cell)

    def may_fill(self, cell: int, left: int) -> bool:
        """Whether all is within reach of each other after a shelf is filled, with `left` boxes to go before it."""
        world, closed = self._world, self._filled | {cell}
        around = [there for _, there in world.moves[cell] if there not in closed]
        if len(around) == 1 or (len(around) > 1 and self._is_open_around(cell, closed)):
            return True  # nothing can be cut off where those beside it touch each other
        if not around:
            return left <= 1
        seen, todo = {around[0]}, [around[0]]
        while todo:
            for _, there in world.moves[todo.pop()]:
                if there not in seen and there not in closed:
                    seen.add(there)
                    todo.append(there)
        if not all(there in seen for there in around):
            shelves = sum(shelf in seen for shelf in world.shelves)
            return shelves >= left - 1 and all(box in seen or box in closed for box in self._wanted)
        return True

    def _is_open_around(self, cell: int, closed: set[int]) -> bool:
        """Whether the eight cells around one that are open form one piece, each beside the next."""
        width, (x, y) = self._world.width, self._world.place(cell)
        ring = [(x - 1, y - 1), (x, y - 1), (x + 1, y - 1), (x + 1, y), (x + 1, y + 1), (x, y + 1), (x - 1, y + 1)]
        ring.append((x - 1, y))
        open_ = [
            0 <= a < width
            and 0 <= b < self._world.height
            and b * width + a not in closed
            and b * width + a not in self._world.walls
            for a, b in ring
        ]
        pieces = sum(open_[k] and not open_[k - 1] for k in range(8))
        return pieces <= 1


def _load_kernels() -> None:
    """Compile or load what a search needs, before its clock starts."""
    few = Distances(*(np.ones((2, 2), np.int32) for _ in range(4)))
    anneal(
        *first_sequences(few), np.arange(2, dtype=np.int32), np.empty(2), np.empty(2, np.int64), np.zeros(2),
        few.first, few.carry, few.back, few.near_boxes, few.near_shelves, 1.0, 2, 1.0, 1,
    )  # fmt: skip
    zero = np.zeros(1, np.int32)
    calendar = Calendar(4, 1)
    calendar.way(0, 0, 0, 0, np.full((1, 4), -1, np.int32), zero, zero)
