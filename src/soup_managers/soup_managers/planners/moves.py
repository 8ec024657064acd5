"""What all robots together can do in one step, shared by the planners that search through joint states."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from soup_managers.planners.plan import PICK_OR_DROP, WAIT, Rules
from soup_msgs_py.warehouse.cell_world import World


class State(NamedTuple):
    """Where everything is.

    Attributes:
        robots: The cell of each robot.
        loads: Bit r is set while robot r has a box.
        boxes: Bit b is set while the world's box b is on the floor.
        shelves: Bit s is set while the world's shelf s is empty.
    """

    robots: tuple[int, ...]
    loads: int
    boxes: int
    shelves: int


Step = tuple[str, State]  # a letter for each robot, and where that leads


class Moves:
    """Actions of robots in a world.

    Args:
        world: The world.
        rules: Whether robots may wait, what they may drive over, and when a plan is done.
    """

    def __init__(self, world: World, rules: Rules) -> None:
        self.start = State(world.robots, 0, (1 << len(world.boxes)) - 1, (1 << len(world.shelves)) - 1)
        self._rules = rules
        self._moves = world.moves
        self._box = {cell: 1 << number for number, cell in enumerate(world.boxes)}
        self._shelf = {cell: 1 << number for number, cell in enumerate(world.shelves)}

    def is_done(self, state: State) -> bool:
        """Whether all boxes are on shelves, and nobody is in the way where the rules say so."""
        if state.boxes or state.loads:
            return False
        return not (self._rules.must_leave and self.on_shelf(state))

    def on_shelf(self, state: State) -> bool:
        """Whether any robot is on a shelf."""
        return any(cell in self._shelf for cell in state.robots)

    def of_robot(self, state: State, robot: int) -> list[tuple[str, int]]:
        """The letters of one robot, and the cell where it is after each; first of all it waits."""
        cell = state.robots[robot]
        found = [(WAIT, cell)] if self._rules.may_wait else []
        found += [(letter, there) for letter, there in self._moves[cell] if self._is_open(there, state, robot)]
        if self._may_handle(cell, state, robot):
            found.append((PICK_OR_DROP, cell))
        return found

    def together(self, state: State) -> Iterator[Step]:
        """All ways in which all robots can act at once."""
        choices = [self.of_robot(state, robot) for robot in range(len(state.robots))]
        yield from self._combine(state, choices, [], "")

    def alone(self, state: State) -> Iterator[Step]:
        """All ways in which one robot acts, and all others stand."""
        robots = state.robots
        for robot in range(len(robots)):
            for letter, there in self.of_robot(state, robot):
                if letter == WAIT or (there != robots[robot] and there in robots):
                    continue
                letters = WAIT * robot + letter + WAIT * (len(robots) - robot - 1)
                yield letters, self._after(state, letters, (*robots[:robot], there, *robots[robot + 1 :]))

    def _is_open(self, cell: int, state: State, robot: int) -> bool:
        shelf = self._shelf.get(cell, 0)
        if shelf and not state.shelves & shelf:
            return False
        return self._rules.carries_over or not (state.loads >> robot & 1 and self._box.get(cell, 0) & state.boxes)

    def _may_handle(self, cell: int, state: State, robot: int) -> bool:
        if state.loads >> robot & 1:
            return bool(self._shelf.get(cell, 0) & state.shelves)
        return bool(self._box.get(cell, 0) & state.boxes)

    def _combine(
        self, state: State, choices: list[list[tuple[str, int]]], cells: list[int], letters: str
    ) -> Iterator[Step]:
        robot = len(cells)
        if robot == len(choices):
            yield letters, self._after(state, letters, tuple(cells))
            return
        before = state.robots
        for letter, there in choices[robot]:
            for other, taken in enumerate(cells):
                if taken == there or (taken == before[robot] and there == before[other]):
                    break
            else:
                cells.append(there)
                yield from self._combine(state, choices, cells, letters + letter)
                cells.pop()

    def _after(self, state: State, letters: str, cells: tuple[int, ...]) -> State:
        _, loads, boxes, shelves = state
        if PICK_OR_DROP in letters:
            for robot, letter in enumerate(letters):
                if letter == PICK_OR_DROP:
                    if loads >> robot & 1:
                        shelves &= ~self._shelf[cells[robot]]
                    else:
                        boxes &= ~self._box[cells[robot]]
                    loads ^= 1 << robot
        return State(cells, loads, boxes, shelves)
