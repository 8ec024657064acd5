"""Which robot brings which box to which shelf, in which order, as if nobody were in anybody's way."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from soup_msgs_py.kernel import kernel

FAR = 1_000_000
NEAR = 12
Ints = NDArray[np.int32]


class Distances:
    """Moves between what matters, `FAR` where no way leads.

    Attributes:
        first: From each robot to each box, shape (robots, boxes).
        carry: From each box to each shelf, shape (boxes, shelves).
        back: From each shelf to each box, shape (shelves, boxes).
        near_boxes: The boxes nearest to each box, shape (boxes, `NEAR` or fewer).
        near_shelves: The shelves nearest to each box, shape (boxes, twice as many or fewer).
    """

    def __init__(self, first: Ints, carry: Ints, back: Ints, between: Ints) -> None:
        """All as above, `between` the boxes themselves; negative entries mean that there is no way."""
        self.first, self.carry, self.back = [np.where(table < 0, FAR, table) for table in (first, carry, back)]
        self.near_boxes = np.ascontiguousarray(np.argsort(between, axis=1, kind="stable")[:, 1 : 1 + NEAR])
        self.near_shelves = np.ascontiguousarray(np.argsort(self.carry, axis=1, kind="stable")[:, : 2 * NEAR])


def least_makespan(distances: Distances) -> int:
    """A lower bound for the makespan.

    Each box is brought to a shelf of its own, and before that somebody comes to it from its start or from a shelf,
    no start and no shelf twice. The robots share the least of both; and no box is there before it can be.
    """
    first, carry, back = distances.first, distances.carry, distances.back
    boxes = carry.shape[0]
    if not boxes:
        return 0
    rows, columns = linear_sum_assignment(carry)
    ways = int(carry[rows, columns].sum())
    come = np.concatenate([first, back]).T
    rows, columns = linear_sum_assignment(come)
    ways += int(come[rows, columns].sum())
    alone = int((first.min(axis=0) + carry.min(axis=1)).max()) + 2
    return max(alone, -(-(ways + 2 * boxes) // len(first)))


def first_sequences(distances: Distances) -> tuple[Ints, Ints, Ints]:
    """Sequences to begin with: shelves by least carrying, then each box to the robot that has it done first.

    Returns:
        The boxes of each robot in order, shape (robots, boxes + 2); how many, shape (robots,); and each box's shelf.
    """
    first, carry, back = distances.first, distances.carry, distances.back
    robots, boxes = first.shape
    _, shelf = linear_sum_assignment(carry)
    order, count = np.full((robots, boxes + 2), -1, np.int32), np.zeros(robots, np.int32)
    done = np.zeros(robots, np.int64)
    away = first.astype(np.int64).copy()
    left = np.ones(boxes, bool)
    for _ in range(boxes):
        finish = done[:, None] + away + carry[np.arange(boxes), shelf] + 2
        finish[:, ~left] = FAR * FAR
        robot, box = (int(i) for i in np.unravel_index(int(finish.argmin()), finish.shape))
        order[robot, count[robot]] = box
        count[robot] += 1
        done[robot] = finish[robot, box]
        away[robot] = back[shelf[box]]
        left[box] = False
    return order, count, shelf.astype(np.int32)


@kernel
def _route(robot, order, count, shelf, first, carry, back):
    """Steps of one robot for its sequence."""
    steps = 0
    for place in range(count[robot]):
        box = order[robot, place]
        steps += first[robot, box] if place == 0 else back[shelf[order[robot, place - 1]], box]
        steps += carry[box, shelf[box]] + 2
    return steps


@kernel
def _take(order, count, robot, place):
    box = order[robot, place]
    for k in range(place, count[robot] - 1):
        order[robot, k] = order[robot, k + 1]
    count[robot] -= 1
    return box


@kernel
def _put(order, count, robot, place, box):
    for k in range(count[robot], place, -1):
        order[robot, k] = order[robot, k - 1]
    order[robot, place] = box
    count[robot] += 1


@kernel
def _weight(steps, target):
    """What a robot's steps cost: after the target each of them the more, the later."""
    late = max(0.0, steps - target)
    return 3.0 * steps + late * late * late


@kernel
def _swap_tails(order, count, one, at, other, there):
    """What two robots do from some place on, they do for each other."""
    tail, others = count[one] - at, count[other] - there
    for k in range(max(tail, others)):
        mine, theirs = order[one, at + k], order[other, there + k]
        if k < others:
            order[one, at + k] = theirs
        if k < tail:
            order[other, there + k] = mine
    count[one], count[other] = at + others, there + tail


@kernel
def _place_of(order, robot, box):
    place = 0
    while order[robot, place] != box:
        place += 1
    return place


@kernel
def anneal(
    order, count, shelf, taken, steps, owner, delays, first, carry, back, near_boxes, near_shelves, target, rounds,
    heat, seed,
):  # fmt: skip
    """Improve sequences by simulated annealing: boxes and the ends of sequences change robots, boxes change shelves.

    Args:
        order: As `first_sequences`, with room for all boxes and one more; changed in place.
        count: As `first_sequences`; changed in place.
        shelf: As `first_sequences`; changed in place.
        taken: The box of each shelf, -1 for none; changed in place.
        steps: Takes the steps of each robot, shape (robots,).
        owner: Takes the robot of each box, shape (boxes,).
        delays: Steps by which each robot is later than its ways say, shape (robots,).
        first: As in `Distances`.
        carry: As in `Distances`.
        back: As in `Distances`.
        near_boxes: Boxes near each box, shape (boxes, k).
        near_shelves: Shelves near each box, shape (boxes, k).
        target: Steps after which a robot is late.
        rounds: How many changes to try.
        heat: How much worse a change may be at the start; a hundredth of it at the end.
        seed: Of the random numbers.
    """
    robots, boxes = len(count), len(shelf)
    for robot in range(robots):
        steps[robot] = _route(robot, order, count, shelf, first, carry, back) + delays[robot]
        for place in range(count[robot]):
            owner[order[robot, place]] = robot
    state = np.uint64(seed + 1) * np.uint64(2862933555777941757) + np.uint64(3037000493)
    multiplier, step, scale = np.uint64(6364136223846793005), np.uint64(1442695040888963407), 1.0 / 9007199254740992.0
    for turn in range(rounds):
        state = state * multiplier + step
        kind = (state >> np.uint64(11)) * scale
        state = state * multiplier + step
        draw = (state >> np.uint64(11)) * scale
        state = state * multiplier + step
        luck = (state >> np.uint64(11)) * scale
        state = state * multiplier + step
        choice = (state >> np.uint64(11)) * scale
        box = int(draw * boxes)
        robot = owner[box]
        place = _place_of(order, robot, box)
        other, at, here, there = -1, 0, shelf[box], 0
        if kind < 0.75:
            # another robot: who has a box near this one, or anybody
            if luck < 0.9:
                other = near_boxes[box, int(choice * near_boxes.shape[1])]
                to = owner[other]
                at = _place_of(order, to, other)
            else:
                to = int(choice * robots)
                at = int((choice * robots - to) * (count[to] + 1))
                other = order[to, at] if at < count[to] else -1
            if other == box or (kind >= 0.3 and (to == robot or other < 0)):
                continue
        else:
            there = near_shelves[box, int(choice * near_shelves.shape[1])]
            other = taken[there]
            if other == box:
                continue
            to = owner[other] if other >= 0 else robot
        before = _weight(steps[robot], target) + (_weight(steps[to], target) if to != robot else 0.0)
        if kind < 0.3:
            # the box goes before the other one, or behind it
            _take(order, count, robot, place)
            if other >= 0:
                at = _place_of(order, to, other) + (1 if luck * 1000.0 % 1.0 < 0.5 else 0)
            else:
                at = count[to]
            _put(order, count, to, at, box)
        elif kind < 0.5:
            order[robot, place], order[to, at] = other, box
        elif kind < 0.75:
            _swap_tails(order, count, robot, place, to, at)
        else:
            shelf[box] = there
            if other >= 0:
                shelf[other] = here
        mine = _route(robot, order, count, shelf, first, carry, back) + delays[robot]
        theirs = _route(to, order, count, shelf, first, carry, back) + delays[to]
        after = _weight(mine, target) + (_weight(theirs, target) if to != robot else 0.0)
        # luck is used twice, its digits only once
        if after <= before - heat * 0.01 ** (turn / rounds) * np.log(max(luck * 4096.0 % 1.0, 1e-12)):
            steps[robot], steps[to] = mine, theirs
            if kind < 0.3:
                owner[box] = to
            elif kind < 0.5:
                owner[box], owner[other] = to, robot
            elif kind < 0.75:
                for k in range(place, count[robot]):
                    owner[order[robot, k]] = robot
                for k in range(at, count[to]):
                    owner[order[to, k]] = to
            else:
                taken[there], taken[here] = box, other
        elif kind < 0.3:
            _take(order, count, to, at)
            _put(order, count, robot, place, box)
        elif kind < 0.5:
            order[robot, place], order[to, at] = box, other
        elif kind < 0.75:
            _swap_tails(order, count, robot, place, to, at)
        else:
            shelf[box] = here
            if other >= 0:
                shelf[other] = there
