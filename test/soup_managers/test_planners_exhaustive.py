"""`optimal` against a search through all states, breadth first, which shares nothing with the planners."""

from __future__ import annotations

import random

import numpy as np
import pytest
from numba import njit

from soup_managers.planners.check import check_plan
from soup_managers.planners.known import PLANNERS
from soup_managers.planners.plan import DEFAULT, FLEET, PAPER, Rules, Task
from soup_msgs_py.errors import InputError
from soup_msgs_py.warehouse.cell_world import World, parse_world

WORLDS = 80
LARGEST = 8  # rows and columns
ROBOTS, BOXES = 3, 4
MOST_STATES = 10_000_000


def shortest(world: World, *, may_wait: bool, must_leave: bool, carries_over: bool = True) -> int | None:
    """The makespan of a shortest plan; None where there is none. Robots are interchangeable."""
    number = {cell: k for k, cell in enumerate(world.open_cells)}
    beside = np.full((len(number), 4), -1, np.int64)
    for cell, here in number.items():
        x, y = cell % world.width, cell // world.width
        for side, (a, b) in enumerate(((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1))):
            if 0 <= a < world.width and 0 <= b < world.height:
                beside[here, side] = number.get(b * world.width + a, -1)
    box, shelf = np.full(len(number), -1, np.int64), np.full(len(number), -1, np.int64)
    for items, table in ((world.boxes, box), (world.shelves, shelf)):
        for k, cell in enumerate(items):
            table[number[cell]] = k
    layers = [np.zeros(states(world) // 64 + 1, np.uint64) for _ in range(3)]
    start = np.array(sorted(2 * number[cell] for cell in world.robots), np.int64)
    steps = search(
        beside, box, shelf, len(world.boxes), len(world.shelves), start, may_wait, must_leave, carries_over, *layers
    )
    return steps if steps >= 0 else None


@njit(cache=True)
def encode(robots, gone, filled, cells, boxes, shelves):
    """The number of a state; robots in ascending order."""
    state = 0
    for robot in robots:
        state = state * 2 * cells + robot
    return (state << (boxes + shelves)) | (gone << shelves) | filled


@njit(cache=True)
def search(beside, box, shelf, boxes, shelves, start, may_wait, must_leave, carries_over, seen, layer, following):
    """Steps to the first state in which all is done, -1 for none."""
    cells, count = len(beside), len(start)
    robots, after, ordered = start.copy(), start.copy(), start.copy()
    choice = np.zeros(count, np.int64)
    one = np.uint64(1)
    first = encode(start, 0, 0, cells, boxes, shelves)
    seen[first >> 6] |= one << np.uint64(first & 63)
    layer[first >> 6] |= one << np.uint64(first & 63)
    everything, steps, some = (1 << boxes) - 1, 0, True
    while some:
        some = False
        for word in range(len(layer)):
            bits = layer[word]
            if bits == 0:
                continue
            layer[word] = 0
            for bit in range(64):
                if not (bits >> np.uint64(bit)) & one:
                    continue
                state = (word << 6) | bit
                filled, gone = state & ((1 << shelves) - 1), (state >> shelves) & everything
                rest = state >> (boxes + shelves)
                done = gone == everything
                for k in range(count - 1, -1, -1):
                    robots[k] = rest % (2 * cells)
                    rest //= 2 * cells
                    if robots[k] & 1 or (must_leave and shelf[robots[k] >> 1] >= 0):
                        done = False
                if done:
                    return steps
                # all ways in which all robots act: 0 to 3 a move, 4 pick up or drop, 5 wait
                k, choice[0] = 0, -1
                while k >= 0:
                    choice[k] += 1
                    if choice[k] > 5:
                        k -= 1
                        continue
                    here, loaded = robots[k] >> 1, robots[k] & 1
                    there = here
                    if choice[k] < 4:
                        there = beside[here, choice[k]]
                        if there < 0 or (shelf[there] >= 0 and (filled >> shelf[there]) & 1):
                            continue
                        if loaded and not carries_over and box[there] >= 0 and not (gone >> box[there]) & 1:
                            continue
                        after[k] = 2 * there + loaded
                    elif choice[k] == 4:
                        item, of = (shelf[here], filled) if loaded else (box[here], gone)
                        if item < 0 or (of >> item) & 1:
                            continue
                        after[k] = 2 * here + 1 - loaded
                    else:
                        if not may_wait:
                            continue
                        after[k] = robots[k]
                    apart = True
                    for other in range(k):
                        place = after[other] >> 1
                        if place == there or (place == here and robots[other] >> 1 == there):
                            apart = False
                    if not apart:
                        continue
                    if k + 1 < count:
                        k += 1
                        choice[k] = -1
                        continue
                    new_gone, new_filled = gone, filled
                    for robot in range(count):
                        ordered[robot] = after[robot]
                        if choice[robot] == 4:
                            if robots[robot] & 1:
                                new_filled |= 1 << shelf[robots[robot] >> 1]
                            else:
                                new_gone |= 1 << box[robots[robot] >> 1]
                    ordered.sort()
                    state = encode(ordered, new_gone, new_filled, cells, boxes, shelves)
                    place, mark = state >> 6, one << np.uint64(state & 63)
                    if not seen[place] & mark:
                        seen[place] |= mark
                        following[place] |= mark
                        some = True
        layer, following = following, layer
        steps += 1
    return -1


def states(world: World) -> int:
    """How many there are: each robot's cell and whether it is loaded, boxes that are gone, shelves that are filled."""
    bits = len(world.boxes) + len(world.shelves)
    return (2 * len(world.open_cells)) ** len(world.robots) << bits


def drawn() -> list[World]:
    """Small worlds of all sizes, those without a plan among them.

    One in ten has more than `MOST_STATES` states; they would take a hundred times as long as all others together.
    """
    found: list[World] = []
    draw = random.Random(1)
    while len(found) < WORLDS:
        width, height = draw.randint(2, LARGEST), draw.randint(2, LARGEST)
        robots, boxes = draw.randint(1, ROBOTS), draw.randint(1, BOXES)
        kinds = "@" * robots + "*" * boxes + "|" * (boxes + draw.randint(0, 1))
        kinds += "#" * int(width * height * draw.choice((0.0, 0.1, 0.2, 0.3)))
        if len(kinds) > width * height:
            continue
        cells = list(kinds.ljust(width * height, "_"))
        draw.shuffle(cells)
        rows = ["".join(cells[row * width : (row + 1) * width]) for row in range(height)]
        try:
            world = parse_world("\n".join(rows))
        except InputError:
            continue
        if states(world) <= MOST_STATES:
            found.append(world)
    return found


@pytest.mark.timeout(600)
@pytest.mark.parametrize("rules", [DEFAULT, PAPER, FLEET], ids=lambda rules: rules.name)
def test_optimal_is_as_short_as_an_exhaustive_search(rules: Rules):
    for world in drawn()[:: 4 if rules is FLEET else 1]:
        answer = PLANNERS["optimal"](Task(world, rules))
        found = shortest(world, may_wait=rules.may_wait, must_leave=rules.must_leave, carries_over=rules.carries_over)
        assert answer.makespan == found
        if answer.plans is None:
            assert answer.lower_bound == float("inf")
            continue
        length = check_plan(
            world,
            answer.plans,
            may_wait=rules.may_wait,
            must_leave=rules.must_leave,
            carries_over=rules.carries_over,
        )
        assert length == answer.makespan == answer.lower_bound
