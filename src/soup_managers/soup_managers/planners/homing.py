"""Robots with nothing left to do go home: the last wish of the 2023 paper ("Future Work")."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from soup_managers.planners.check import Picture, play
from soup_managers.planners.plan import PICK_OR_DROP, WAIT
from soup_managers.planners.spacetime import NOBODY, Calendar, letters_of, sides_of
from soup_msgs_py.warehouse.cell_world import World

LONGEST_WAY = 4  # home, times width and height of the world


def go_home(world: World, plans: Sequence[str]) -> tuple[str, ...]:
    """Plans in which each robot goes back to where it began as soon as it has dropped its last box.

    The work itself stays as it is. One after the other, in the order in which they get free, robots get the quickest
    way that keeps clear of all others; one that finds none yet stays with what its plan says, and is asked again when
    others have gone. One whose home is cut off by then stays where it is.

    Args:
        world: The world at its start.
        plans: Letters of each robot, which keep the rules.
    """
    pictures = list(play(world, plans, may_wait=True))
    ends = [plan.rfind(PICK_OR_DROP) + 1 for plan in plans]
    calendar, sides = _who_is_where(world, pictures), sides_of(world)
    cells = [[y * world.width + x for x, y in (picture.robots[robot] for picture in pictures)] for robot in
             range(len(plans))]  # fmt: skip
    found = [plan[:end] for plan, end in zip(plans, ends, strict=True)]
    left, some = sorted(range(len(plans)), key=lambda robot: (ends[robot], robot)), True
    while left and some:
        some = False
        for robot in list(left):
            way = _way_home(world, robot, cells[robot][ends[robot]], ends[robot], calendar, sides)
            if way is None:
                continue
            found[robot] += "".join(letters_of(world, way))
            left.remove(robot)
            some = True
    for robot in left:
        found[robot] = plans[robot]
    longest = max(map(len, found))
    return tuple(plan + WAIT * (longest - len(plan)) for plan in found)


def _who_is_where(world: World, pictures: list[Picture]) -> Calendar:
    """Who is where when, long after the end, too; and when each shelf was filled."""
    calendar = Calendar(len(pictures) + LONGEST_WAY * (world.width + world.height), world.cells)
    for step in range(len(calendar.who)):
        for robot, (x, y) in enumerate(pictures[min(step, len(pictures) - 1)].robots):
            calendar.who[step, y * world.width + x] = robot
    for picture in reversed(pictures):
        calendar.closed[[y * world.width + x for x, y in picture.filled]] = picture.step
    return calendar


def _way_home(
    world: World, robot: int, start: int, begins: int, calendar: Calendar, sides: NDArray[np.int32]
) -> NDArray[np.int32] | None:
    """The cells of a robot's way home; entered in the calendar, or None where there is none."""
    home, later = world.robots[robot], calendar.who[begins:]
    before = later == robot
    later[before] = NOBODY
    later[0, start] = robot
    used = np.flatnonzero((calendar.who[:, home] != NOBODY) & (calendar.who[:, home] != robot))
    calendar.last[home] = used.max(initial=-1)
    to_start, to_home = (np.array(world.distances([cell]), np.int32) for cell in (start, home))
    way = calendar.way(start, begins, start, home, sides, to_start, to_home)
    if way is None:
        later[before] = robot
        return None
    later[np.arange(len(way)), way] = robot
    later[len(way) :, home] = robot
    return way
