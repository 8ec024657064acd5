"""Which robot brings which box to which shelf, in which order, as if nobody were in anybody's way."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from soup_msgs_py.kernel import kernel

FAR = 1_000_000
Ints = NDArray[np.int32]


class Distances:
    """Moves between what matters, `FAR` where no way leads.

    Attributes:
        first: From each robot to each box, shape (robots, boxes).
        carry: From each box to each shelf, shape (boxes, shelves).
        back: From each shelf to each box, shape (shelves, boxes).
    """

    def __init__(self, first: Ints, carry: Ints, back: Ints) -> None:
        """All as above; negative entries mean that there is no way."""
        self.first, self.carry, self.back = [np.where(table < 0, FAR, table) for table in (first, carry, back)]


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
        The boxes of each robot in order, shape (robots, boxes); how many, shape (robots,); and the shelf of each box.
    """
    first, carry, back = distances.first, distances.carry, distances.back
    robots, boxes = first.shape
    _, shelf = linear_sum_assignment(carry)
    order, count = np.full((robots, max(1, boxes)), -1, np.int32), np.zeros(robots, np.int32)
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
    """What a robot's steps are worth: late ones count most, all others a little."""
    late = max(0.0, steps - target)
    return steps * 0.05 + late * late


@kernel
def anneal(order, count, shelf, taken, steps, owner, delays, first, carry, back, target, rounds, heat, seed):
    """Improve sequences by simulated annealing: boxes change robots and places, and boxes change shelves.

    Args:
        order: As `first_sequences`; changed in place.
        count: As `first_sequences`; changed in place.
        shelf: As `first_sequences`; changed in place.
        taken: The box of each shelf, -1 for none; changed in place.
        steps: Takes the steps of each robot, shape (robots,).
        owner: Takes the robot of each box, shape (boxes,).
        delays: Steps by which each robot is later than its ways say, shape (robots,).
        first: As in `Distances`.
        carry: As in `Distances`.
        back: As in `Distances`.
        target: Steps after which a robot is late.
        rounds: How many changes to try.
        heat: How much worse a change may be at the start.
        seed: Of the random numbers.
    """
    robots, boxes, shelves = len(count), len(shelf), len(taken)
    state = np.uint64(seed + 1) * np.uint64(2862933555777941757) + np.uint64(3037000493)
    for robot in range(robots):
        steps[robot] = _route(robot, order, count, shelf, first, carry, back) + delays[robot]
    for robot in range(robots):
        for place in range(count[robot]):
            owner[order[robot, place]] = robot
    for turn in range(rounds):
        state = state * np.uint64(6364136223846793005) + np.uint64(1442695040888963407)
        draw = (state >> np.uint64(11)) * (1.0 / 9007199254740992.0)
        state = state * np.uint64(6364136223846793005) + np.uint64(1442695040888963407)
        second = (state >> np.uint64(11)) * (1.0 / 9007199254740992.0)
        state = state * np.uint64(6364136223846793005) + np.uint64(1442695040888963407)
        third = (state >> np.uint64(11)) * (1.0 / 9007199254740992.0)
        allowed = heat * (1.0 - turn / rounds) * -np.log(max(third, 1e-12))
        box = int(second * boxes)
        robot = owner[box]
        place = 0
        while order[robot, place] != box:
            place += 1
        state = state * np.uint64(6364136223846793005) + np.uint64(1442695040888963407)
        fourth = (state >> np.uint64(11)) * (1.0 / 9007199254740992.0)
        if draw < 0.5:
            # the box goes to another robot, or elsewhere in its order
            to = int(fourth * robots)
            before = _weight(steps[robot], target) + (_weight(steps[to], target) if to != robot else 0.0)
            _take(order, count, robot, place)
            at = int((fourth * robots - to) * (count[to] + 1))
            _put(order, count, to, at, box)
            mine = _route(robot, order, count, shelf, first, carry, back) + delays[robot]
            theirs = _route(to, order, count, shelf, first, carry, back) + delays[to]
            after = _weight(mine, target) + (_weight(theirs, target) if to != robot else 0.0)
            if after <= before + allowed:
                steps[robot], steps[to] = mine, theirs
                owner[box] = to
            else:
                _take(order, count, to, at)
                _put(order, count, robot, place, box)
        elif draw < 0.75:
            # two boxes change places
            other = int(fourth * boxes)
            if other == box:
                continue
            to = owner[other]
            at = 0
            while order[to, at] != other:
                at += 1
            before = _weight(steps[robot], target) + (_weight(steps[to], target) if to != robot else 0.0)
            order[robot, place], order[to, at] = other, box
            mine = _route(robot, order, count, shelf, first, carry, back) + delays[robot]
            theirs = _route(to, order, count, shelf, first, carry, back) + delays[to]
            after = _weight(mine, target) + (_weight(theirs, target) if to != robot else 0.0)
            if after <= before + allowed:
                steps[robot], steps[to] = mine, theirs
                owner[box], owner[other] = to, robot
            else:
                order[robot, place], order[to, at] = box, other
        else:
            # the box goes to another shelf; who has that one takes this one
            there, here = int(fourth * shelves), shelf[box]
            other = taken[there]
            if other == box:
                continue
            to = owner[other] if other >= 0 else robot
            before = _weight(steps[robot], target) + (_weight(steps[to], target) if to != robot else 0.0)
            shelf[box] = there
            if other >= 0:
                shelf[other] = here
            mine = _route(robot, order, count, shelf, first, carry, back) + delays[robot]
            theirs = _route(to, order, count, shelf, first, carry, back) + delays[to]
            after = _weight(mine, target) + (_weight(theirs, target) if to != robot else 0.0)
            if after <= before + allowed:
                steps[robot], steps[to] = mine, theirs
                taken[there], taken[here] = box, other
            else:
                shelf[box] = here
                if other >= 0:
                    shelf[other] = there
