"""An independent judge of plans: it plays them letter by letter, and shares nothing with the planners."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from soup_msgs_py.warehouse.cell_world import BOX, FLOOR, FULL, ROBOT, SHELF, World

LOADED = "$"  # a robot that has a box, where a world is shown as text


class BadPlan(ValueError):
    """A plan breaks a rule; says which robot at which step."""


@dataclass
class Picture:
    """The world after some steps.

    Attributes:
        step: How many steps.
        robots: Column and row of each robot.
        loaded: Whether each robot has a box.
        boxes: Where boxes are on the floor.
        filled: Shelves that were filled.
    """

    step: int
    robots: list[tuple[int, int]]
    loaded: list[bool]
    boxes: set[tuple[int, int]]
    filled: set[tuple[int, int]]


def play(world: World, plans: Sequence[str], *, may_wait: bool, carries_over: bool = True) -> Iterator[Picture]:
    """Play plans step by step, the start included.

    Args:
        world: The world at its start.
        plans: Letters of each robot.
        may_wait: Whether W is allowed.
        carries_over: Whether a robot that has a box may drive over another box.

    Raises:
        BadPlan: At the step that breaks a rule.
    """
    if len(plans) != len(world.robots):
        raise BadPlan(f"{len(plans)} plans for {len(world.robots)} robots")
    if len(set(map(len, plans))) > 1:
        raise BadPlan(f"plans of {sorted(set(map(len, plans)))} steps; all robots act in every step")
    walls, shelves = set(map(world.place, world.walls)), set(map(world.place, world.shelves))
    now = Picture(0, [*map(world.place, world.robots)], [False] * len(plans), {*map(world.place, world.boxes)}, set())
    yield now
    for step, letters in enumerate(zip(*plans, strict=True)):
        after = Picture(step + 1, list(now.robots), list(now.loaded), set(now.boxes), set(now.filled))
        for robot, letter in enumerate(letters):
            x, y = now.robots[robot]
            who = f"robot {robot + 1}, step {step + 1}, letter {letter!r}"
            if letter in "UDLR":
                dx, dy = {"U": (0, -1), "D": (0, 1), "L": (-1, 0), "R": (1, 0)}[letter]
                x, y = x + dx, y + dy
                if not (0 <= x < world.width and 0 <= y < world.height):
                    raise BadPlan(f"{who}: leaves the world")
                if (x, y) in walls or (x, y) in now.filled:
                    raise BadPlan(f"{who}: enters a wall or a full shelf")
                if not carries_over and now.loaded[robot] and (x, y) in now.boxes:
                    raise BadPlan(f"{who}: carries a box over another one")
                after.robots[robot] = x, y
            elif letter == "P" and now.loaded[robot]:
                if (x, y) not in shelves or (x, y) in now.filled:
                    raise BadPlan(f"{who}: drops a box where no empty shelf is")
                after.filled.add((x, y))
                after.loaded[robot] = False
            elif letter == "P":
                if (x, y) not in now.boxes:
                    raise BadPlan(f"{who}: picks up where no box is")
                after.boxes.discard((x, y))
                after.loaded[robot] = True
            elif letter != "W":
                raise BadPlan(f"{who}: no such action")
            elif not may_wait:
                raise BadPlan(f"{who}: waits, which these rules forbid")
        _keep_apart(now.robots, after.robots, step + 1)
        now = after
        yield now


def _keep_apart(before: list[tuple[int, int]], after: list[tuple[int, int]], step: int) -> None:
    for one, place in enumerate(after):
        for other in range(one):
            if after[other] == place:
                raise BadPlan(f"robots {other + 1} and {one + 1}, step {step}: in one cell {place}")
            if before[one] == after[other] and before[other] == place:
                raise BadPlan(f"robots {other + 1} and {one + 1}, step {step}: change places")


def check_plan(
    world: World,
    plans: Sequence[str],
    *,
    may_wait: bool = True,
    must_leave: bool = False,
    carries_over: bool = True,
) -> int:
    """The makespan of a plan that keeps all rules and shelves all boxes.

    Args:
        world: The world at its start.
        plans: Letters of each robot.
        may_wait: Whether W is allowed.
        must_leave: Whether no robot may be on a shelf at the end.
        carries_over: Whether a robot that has a box may drive over another box.

    Returns:
        The step of the last drop; with `must_leave` all steps.

    Raises:
        BadPlan: It does not.
    """
    last = makespan = 0
    end: Picture | None = None
    for end in play(world, plans, may_wait=may_wait, carries_over=carries_over):
        if len(end.filled) > last:
            last, makespan = len(end.filled), end.step
    assert end is not None
    if end.boxes or any(end.loaded):
        raise BadPlan(f"{len(end.boxes) + sum(end.loaded)} boxes are not on shelves")
    if must_leave:
        for robot, place in enumerate(end.robots):
            if place in set(map(world.place, world.shelves)):
                raise BadPlan(f"robot {robot + 1} ends on a shelf")
        return end.step
    return makespan


def draw(world: World, now: Picture) -> str:
    """The world as text, in the notation of its file; a robot that has a box is a `$`."""
    cells = [[FLOOR] * world.width for _ in range(world.height)]
    walls = map(world.place, world.walls)
    for places, kind in ((walls, FULL), (map(world.place, world.shelves), SHELF), (now.boxes, BOX), (now.filled, FULL)):
        for x, y in places:
            cells[y][x] = kind
    for (x, y), loaded in zip(now.robots, now.loaded, strict=True):
        cells[y][x] = LOADED if loaded else ROBOT
    return "\n".join("".join(row) for row in cells)
