"""The two planners of the 2023 paper: A* through joint states, one robot or all robots acting in a node."""

from __future__ import annotations

import heapq
import time
from collections.abc import Callable, Iterator

from soup_managers.planners.moves import Moves, State, Step
from soup_managers.planners.plan import Answer, Task
from soup_managers.planners.remaining import Remaining
from soup_msgs_py.warehouse.cell_world import World

MOST_NODES = 8_000_000  # some 4 GB
_LOOK_EVERY = 256  # expansions between two looks at the clock


def single_action(task: Task) -> Answer:
    """Nodes in which one robot acts ("Multi-agent Planning"); all others wait, also where rules forbid it."""
    return _search(task, Moves.alone)


def multi_action(task: Task) -> Answer:
    """Nodes in which all robots act ("Multi-action Nodes")."""
    return _search(task, Moves.together)


def nearest_goals(world: World) -> Callable[[State], int]:
    """The paper's heuristic: each robot's Manhattan distance to the nearest box, or empty shelf if it has one, added.

    It is not admissible: robots act at once, and not every robot has to get to what is nearest to it.
    """
    boxes, shelves = [*map(world.place, world.boxes)], [*map(world.place, world.shelves)]
    known: dict[tuple[int, bool, int], int] = {}

    def of_robot(cell: int, loaded: bool, left: int) -> int:
        key = cell, loaded, left
        if key not in known:
            x, y = world.place(cell)
            goals = shelves if loaded else boxes
            away = [abs(gx - x) + abs(gy - y) for goal, (gx, gy) in enumerate(goals) if left >> goal & 1]
            known[key] = min(away, default=0)
        return known[key]

    def estimate(state: State) -> int:
        total = 0
        for robot, cell in enumerate(state.robots):
            loaded = bool(state.loads >> robot & 1)
            total += of_robot(cell, loaded, state.shelves if loaded else state.boxes)
        return total

    return estimate


def _search(task: Task, steps: Callable[[Moves, State], Iterator[Step]]) -> Answer:
    begun = time.perf_counter()
    moves, estimate = Moves(task.world, task.rules), nearest_goals(task.world)
    bound = Remaining(task.world, task.rules).of(moves.start)[0]
    cost = {moves.start: 0}
    came: dict[State, tuple[State, str]] = {}
    heap = [(task.weight * estimate(moves.start), 0, 0, moves.start)]
    generated, expanded = 1, 0

    def answer(plans: tuple[str, ...] | None, note: str) -> Answer:
        proven = plans is not None and len(plans[0]) == bound
        return Answer(plans, bound, proven, generated, expanded, time.perf_counter() - begun, note)

    while heap:
        _, _, so_far, state = heapq.heappop(heap)
        if so_far > cost[state]:
            continue
        if moves.is_done(state):
            return answer(trace(came, state, len(task.world.robots)), "")
        expanded += 1
        if expanded % _LOOK_EVERY == 0:
            if time.perf_counter() - begun > task.time_limit_s:
                return answer(None, f"no plan within {task.time_limit_s:g} s")
            if len(cost) > MOST_NODES:
                return answer(None, f"gave up after {MOST_NODES} states, for want of memory")
        for letters, there in steps(moves, state):
            known = cost.get(there)
            if known is not None and known <= so_far + 1:
                continue
            generated += 1
            cost[there] = so_far + 1
            came[there] = state, letters
            heapq.heappush(heap, (so_far + 1 + task.weight * estimate(there), generated, so_far + 1, there))
    bound = float("inf")
    return answer(None, "there is no plan: all states that can be reached were looked at")


def trace(came: dict[State, tuple[State, str]], state: State, robots: int) -> tuple[str, ...]:
    """The letters of each robot on the way to a state."""
    steps: list[str] = []
    while state in came:
        state, letters = came[state]
        steps.append(letters)
    steps.reverse()
    return tuple("".join(letters[robot] for letters in steps) for robot in range(robots))
