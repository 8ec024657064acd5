"""A* through joint states with an admissible heuristic: the first plan that it finds is a shortest one."""

from __future__ import annotations

import heapq
import math
import time
from dataclasses import replace

from soup_managers.planners.anytime import anytime
from soup_managers.planners.divide import load_kernels
from soup_managers.planners.joint import trace
from soup_managers.planners.moves import Moves, State, Step
from soup_managers.planners.plan import Answer, Task
from soup_managers.planners.remaining import Estimate, Remaining

_LOOK_EVERY = 16
SEARCHES = 0.9  # of the time; the rest is for some plan, should there be no proof


def optimal(task: Task) -> Answer:
    """A shortest plan, proven; or, where time or memory ends, some plan if robots may rest, and the lower bound.

    The heuristic says exactly what is left where robots are not in each other's way, so the search goes straight to
    the end of one of the shortest plans. Of states that look equally good, it takes the one with most steps behind
    it, and of these the one whose robots have least to do.
    """
    if len(task.world.robots) > 2:
        load_kernels()
    begun = time.perf_counter()
    moves, remaining = Moves(task.world, task.rules), Remaining(task.world, task.rules)
    cost = {moves.start: 0}
    came: dict[State, tuple[State, str]] = {}
    estimates: dict[State, tuple[float, float]] = {moves.start: remaining.of(moves.start)}
    bound, tie = estimates[moves.start]
    generated, expanded = 1, 0
    heap = [(bound, 0, tie, 0, moves.start)] if bound < math.inf else []
    exact: set[State] = set()  # states whose estimate cannot be better
    stopped = ""
    while heap:
        total, minus, tie, number, state = heapq.heappop(heap)
        if -minus > cost[state]:
            continue
        bound = max(bound, total)
        if moves.is_done(state):
            plans = trace(came, state, len(task.world.robots))
            return Answer(plans, bound, True, generated, expanded, time.perf_counter() - begun)
        if state not in exact:
            exact.add(state)
            sure = -minus + remaining.exactly(state)
            if sure > total:
                heapq.heappush(heap, (sure, minus, tie, number, state))
                continue
        expanded += 1
        if expanded % _LOOK_EVERY == 0 and time.perf_counter() - begun > SEARCHES * task.time_limit_s:
            stopped = f"no proof within {task.time_limit_s:g} s"
            break
        if len(cost) > task.most_states:
            stopped = f"gave up after {task.most_states} states, for want of memory"
            break
        so_far = 1 - minus
        for letters, there in _new(moves, remaining, state, so_far, cost, estimates):
            estimate, there_tie = estimates[there]
            if estimate == math.inf:
                continue
            generated += 1
            cost[there] = so_far
            came[there] = state, letters
            heapq.heappush(heap, (max(total, so_far + estimate), -so_far, there_tie, generated, there))
    if not stopped:
        bound, stopped = math.inf, "there is no plan: all states that can be reached were looked at"
    nothing = Answer(None, bound, False, generated, expanded, time.perf_counter() - begun, stopped)
    if bound == math.inf or not task.rules.may_wait:
        return nothing
    found = anytime(replace(task, time_limit_s=(1.0 - SEARCHES) * task.time_limit_s))
    bound, spent = max(bound, found.lower_bound), time.perf_counter() - begun
    proven = found.makespan == bound
    return Answer(found.plans, bound, proven, generated, expanded, spent, "" if proven else stopped)


def _new(
    moves: Moves,
    remaining: Remaining,
    state: State,
    cost: int,
    costs: dict[State, int],
    estimates: dict[State, Estimate],
) -> list[Step]:
    """What a state leads to at less cost than so far; all of it is in `estimates` then."""
    found: dict[State, str] = {}
    for letters, there in moves.together(state):
        if costs.get(there, math.inf) > cost:
            found.setdefault(there, letters)
    unknown = [there for there in found if there not in estimates]
    if unknown:
        estimates.update(zip(unknown, remaining.of_all(unknown), strict=True))
    return [(letters, there) for there, letters in found.items()]
