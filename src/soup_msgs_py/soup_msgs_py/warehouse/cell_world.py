"""A world of cells in the notation of the 2023 paper: robots bring boxes to empty shelves."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from soup_msgs_py.errors import InputError, printable
from soup_msgs_py.reading.files import read_text

ROBOT, BOX, SHELF, FULL, FLOOR = "@*|#_"
ALLOWED = "@ robot, * box, | empty shelf, # full shelf or wall, _ floor"
MOST_CELLS = 1_000_000
MOST_BYTES = 10_000_000
_FILE = "a world file"
SUFFIX = ".txt"  # of a world file, where a scenario could be one
PITCH_M = 3.0  # between two cells of a warehouse's floor
_WORDS = Path(__file__).resolve().parents[4] / "config/words/prose.txt"  # every scenario has some
MOVES = {"U": (0, -1), "D": (0, 1), "L": (-1, 0), "R": (1, 0)}


@dataclass(frozen=True)
class World:
    """Where everything is at the start. A cell is a number: `row * width + column`, the first row on top.

    Attributes:
        width: Number of columns.
        height: Number of rows.
        walls: Cells that nobody can enter: walls and shelves that are full.
        shelves: Cells with an empty shelf, ascending.
        robots: Cells where the robots start, ascending: the order of reading.
        boxes: Cells with a box, ascending.
    """

    width: int
    height: int
    walls: frozenset[int]
    shelves: tuple[int, ...]
    robots: tuple[int, ...]
    boxes: tuple[int, ...]

    @property
    def cells(self) -> int:
        """How many cells there are."""
        return self.width * self.height

    @cached_property
    def open_cells(self) -> tuple[int, ...]:
        """The cells that are no walls, ascending: on a warehouse's floor each is a waypoint, in this order."""
        return tuple(cell for cell in range(self.cells) if cell not in self.walls)

    def place(self, cell: int) -> tuple[int, int]:
        """Column and row of a cell."""
        return cell % self.width, cell // self.width

    @cached_property
    def moves(self) -> list[list[tuple[str, int]]]:
        """For each cell the moves that neither leave the world nor enter a wall: letters, and where they lead."""
        found: list[list[tuple[str, int]]] = [[] for _ in range(self.cells)]
        for row in range(self.height):
            for column in range(self.width):
                here = row * self.width + column
                for letter, (dx, dy) in MOVES.items():
                    there = here + dx + dy * self.width
                    inside = 0 <= column + dx < self.width and 0 <= row + dy < self.height
                    if inside and there not in self.walls:
                        found[here].append((letter, there))
        return found

    def distances(self, sources: Iterable[int]) -> list[int]:
        """Fewest moves from the nearest of some cells to each cell; -1 where none lead."""
        distance, moves = [-1] * self.cells, self.moves
        todo = deque(sources)
        for cell in todo:
            distance[cell] = 0
        while todo:
            cell = todo.popleft()
            for _, there in moves[cell]:
                if distance[there] < 0:
                    distance[there] = distance[cell] + 1
                    todo.append(there)
        return distance


def read_world(path: Path) -> World:
    """Read a world file.

    Raises:
        InputError: It cannot be read, or there can be no plan for what it shows.
    """
    return parse_world(read_text(path, MOST_BYTES, _FILE), path)


def world_scenario(path: Path) -> dict[str, Any]:
    """The values of a scenario in which bucketbots do what the robots of a world file do.

    Boxes are buckets, shelves are storage spots. A warehouse has stations; those of this one stand below the cells,
    and nobody orders anything.

    Raises:
        InputError: As `read_world`, or there is nothing to do.
    """
    text = read_text(path, MOST_BYTES, _FILE)
    world = parse_world(text, path)
    if not world.boxes:
        raise InputError(path, "", "no box", f"at least one {BOX}")
    return {
        "name": printable(path.stem)[:80],
        "floor": {"width_m": (max(world.width, 2) + 1) * PITCH_M, "height_m": (world.height + 2) * PITCH_M},
        "bots": len(world.robots),
        "buckets": len(world.boxes),
        "word_stations": 1,
        "letter_stations": 1,
        "words": str(_WORDS),
        "orders": {"kind": "none"},
        "bundles": {"kind": "none"},
        "layout": {"kind": "cells", "rows": text.split()[: world.height], "pitch_m": PITCH_M},
    }


def parse_world(text: str, source: object = "world") -> World:
    """Read a world from its text; as `read_world`."""
    lines = [line.rstrip() for line in text.splitlines()]
    while lines and not lines[-1]:
        lines.pop()
    if not lines:
        raise InputError(source, "", "an empty file", f"lines of cells: {ALLOWED}")
    width = len(lines[0])
    if width * len(lines) > MOST_CELLS:
        raise InputError(source, "", f"{width * len(lines)} cells", f"at most {MOST_CELLS}")
    found: dict[str, list[int]] = {kind: [] for kind in (ROBOT, BOX, SHELF, FULL, FLOOR)}
    for row, line in enumerate(lines):
        if len(line) != width:
            what = f"{len(line)} cells" if line else "an empty line"
            raise InputError(source, f"line {row + 1}", what, f"{width} cells, as in line 1")
        for column, kind in enumerate(line):
            if kind not in found:
                raise InputError(source, f"line {row + 1}, column {column + 1}", repr(kind), ALLOWED)
            found[kind].append(row * width + column)
    world = World(
        width,
        len(lines),
        frozenset(found[FULL]),
        tuple(found[SHELF]),
        tuple(found[ROBOT]),
        tuple(found[BOX]),
    )
    _check(world, source)
    return world


def _check(world: World, source: object) -> None:
    """Tell what no plan can mend."""
    if not world.robots:
        raise InputError(source, "", "no robot", f"at least one {ROBOT}")
    if len(world.shelves) < len(world.boxes):
        found = f"{len(world.boxes)} boxes and {len(world.shelves)} empty shelves"
        raise InputError(source, "", found, f"as many {SHELF} as {BOX}, or more")
    reached = world.distances(world.robots)
    for box in world.boxes:
        if reached[box] < 0:
            column, row = world.place(box)
            where = f"line {row + 1}, column {column + 1}"
            raise InputError(source, where, "a box that no robot can reach", "a way from a robot to each box")
