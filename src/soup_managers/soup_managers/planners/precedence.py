"""Which action of a plan has to wait for which: what lets robots carry it out at their own pace.

Robots on a real floor are never in step. So a plan's times are dropped, and its order is kept: a robot enters a cell
when whoever the plan has there before it has left (the action dependency graph of Hoenig et al. 2019, "Persistent and
robust execution of MAPF schedules in warehouses"). Whoever is late delays those who have to wait, and nothing else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from soup_managers.planners.plan import PICK_OR_DROP, WAIT
from soup_msgs_py.warehouse.cell_world import MOVES, World


@dataclass
class Action:
    """One letter of one robot.

    Attributes:
        step: Of the plan, from 0.
        here: The cell where it begins.
        there: The cell where it ends: another one for a move.
        box: The number of the box that it picks up or drops; -1 for a move.
        picks: Whether it picks it up.
        after: The action of another robot (robot, place in its list) that has to be done before; None for none.
        awaited: Whether another robot waits for it.
        ring: Robots that move into each other's cells all at once, this one among them; empty for none.
    """

    step: int
    here: int
    there: int
    box: int = -1
    picks: bool = False
    after: tuple[int, int] | None = None
    awaited: bool = False
    ring: tuple[int, ...] = ()

    @property
    def moves(self) -> bool:
        """Whether it leads to another cell."""
        return self.box < 0


def actions_of(world: World, plans: Sequence[str]) -> list[list[Action]]:
    """The actions of each robot, those in which it waits left out.

    Args:
        world: The world at its start.
        plans: Letters of each robot, all equally many, which keep the rules.
    """
    numbers = {cell: number for number, cell in enumerate(world.boxes)}
    found: list[list[Action]] = [[] for _ in plans]
    places, loads = list(world.robots), [-1] * len(plans)
    left: dict[int, tuple[int, int]] = {}  # by cell: the action by which somebody left it last
    for step, letters in enumerate(zip(*plans, strict=True)):
        moving: dict[int, Action] = {}
        for robot, letter in enumerate(letters):
            here = places[robot]
            if letter == WAIT:
                continue
            if letter == PICK_OR_DROP:
                picks = loads[robot] < 0
                box = numbers[here] if picks else loads[robot]
                loads[robot] = box if picks else -1
                found[robot].append(Action(step, here, here, box, picks))
                continue
            dx, dy = MOVES[letter]
            moving[robot] = Action(step, here, here + dx + dy * world.width)
            left[here] = robot, len(found[robot])
        for robot, action in moving.items():
            before = left.get(action.there)
            if before is not None and before[0] != robot:
                action.after = before
            found[robot].append(action)
            places[robot] = action.there
        _note_rings(moving)
    for actions in found:
        for action in actions:
            if action.after is not None:
                robot, place = action.after
                found[robot][place].awaited = True
    return found


def _note_rings(moving: dict[int, Action]) -> None:
    """Robots each of which enters the cell that the next one leaves, round to the first, can only move at once."""
    leaves = {action.here: robot for robot, action in moving.items()}
    follows = {robot: leaves[action.there] for robot, action in moving.items() if action.there in leaves}
    for robot in follows:
        ring, other = [robot], follows[robot]
        while other in follows and other not in ring:
            ring.append(other)
            other = follows[other]
        if other == robot and not moving[robot].ring:
            for member in ring:
                moving[member].ring = tuple(ring)
                moving[member].after = None
