"""A plan as a picture of all paths, or played as an animation, with a legend."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from soup_managers.planners.check import Picture, play
from soup_msgs_py.command_line.output_files import whole
from soup_msgs_py.warehouse.cell_world import World

INCHES_A_CELL = 0.3
FRAMES_A_SECOND = 4
LEGEND_INCHES = 0.55  # below the floor
ARROW_STEPS = 6  # along a path, one arrow in so many
WALL, SHELF, BOX, FILLED = "#444444", "#d8c8a8", "#b5651d", "#8a6d3b"


def draw_plan(world: World, plans: Sequence[str], path: Path) -> None:
    """Draw a plan into a file: `.gif` plays it, anything else shows the paths.

    Raises:
        OutputError: It cannot be written.
    """
    pictures = list(play(world, plans, may_wait=True))
    if path.suffix == ".gif":
        figure, axes = _empty(world, is_played=True)
        animation = FuncAnimation(figure, lambda step: _floor(axes, world, pictures[step]), frames=len(pictures))
        with whole(path) as half:
            animation.save(str(half), writer=PillowWriter(fps=FRAMES_A_SECOND))
        return
    with whole(path) as half:
        draw_paths(world, pictures).savefig(half, dpi=120)


def draw_paths(world: World, pictures: Sequence[Picture]) -> Figure:
    """The world at its start and the path of each robot, with its direction."""
    figure, axes = _empty(world, is_played=False)
    _floor(axes, world, pictures[0])
    robots = len(pictures[0].robots)
    for robot in range(robots):
        way = np.array([now.robots[robot] for now in pictures], float)
        aside = 0.3 * (robot / max(1, robots - 1) - 0.5)  # so that paths along one aisle can be told apart
        axes.plot(way[:, 0] + aside, way[:, 1] + aside, color=f"C{robot % 10}", linewidth=1.5)
        _arrows(axes, way + aside, f"C{robot % 10}")
    return figure


def _empty(world: World, is_played: bool) -> tuple[Figure, Axes]:
    """A figure as large as the world, with a legend below."""
    width, height = max(4.5, world.width * INCHES_A_CELL), max(2.0, world.height * INCHES_A_CELL) + LEGEND_INCHES
    figure = Figure(figsize=(width, height))
    axes = figure.add_axes((0.0, LEGEND_INCHES / height, 1.0, 1.0 - LEGEND_INCHES / height))
    figure.legend(handles=_legend(is_played), loc="lower center", ncols=3, frameon=False, fontsize=8)
    return figure, axes


def _legend(is_played: bool) -> list[Line2D]:
    """What each sign stands for."""

    def sign(marker: str, color: str, text: str, size: float = 8.0) -> Line2D:
        return Line2D([], [], linestyle="", marker=marker, color=color, markersize=size, label=text)

    where = "robot; brown: with a box" if is_played else "robot, where it begins"
    signs = [sign("s", WALL, "wall or full shelf"), sign("s", SHELF, "empty shelf"), sign("s", BOX, "box", 5.0)]
    last = sign("s", FILLED, "shelf that was filled") if is_played else sign(">", "C0", "path, in its direction", 6.0)
    return [*signs, sign("o", "C0", where), last]


def _arrows(axes: Axes, way: NDArray[np.float64], color: str) -> None:
    """Heads along a path that show its direction, and one where it ends."""
    moves = np.diff(way, axis=0)
    steps = np.flatnonzero(np.abs(moves).sum(axis=1))
    for step in {*steps[ARROW_STEPS // 2 :: ARROW_STEPS].tolist(), *steps[-1:].tolist()}:
        middle = way[step] + 0.5 * moves[step]
        head = {"arrowstyle": "-|>", "color": color, "mutation_scale": 11.0}
        axes.annotate("", xy=tuple(middle + 0.3 * moves[step]), xytext=tuple(middle), arrowprops=head)


def _floor(axes: Axes, world: World, now: Picture) -> list[Any]:
    axes.clear()
    axes.set_axis_off()
    axes.set_aspect("equal")
    axes.set_xlim(-0.5, world.width - 0.5)
    axes.set_ylim(world.height - 0.5, -0.5)
    size = (72.0 * INCHES_A_CELL * 0.8) ** 2
    for places, color, share in (
        (map(world.place, world.walls), WALL, 1.0),
        (map(world.place, world.shelves), SHELF, 1.0),
        (now.filled, FILLED, 1.0),
        (now.boxes, BOX, 0.4),
    ):
        spots = np.array(sorted(places), float).reshape(-1, 2)
        axes.scatter(spots[:, 0], spots[:, 1], s=size * share, c=color, marker="s")
    for robot, (x, y) in enumerate(now.robots):
        axes.scatter([x], [y], s=0.6 * size, c=f"C{robot % 10}", edgecolors="black")
        if now.loaded[robot]:
            axes.scatter([x], [y], s=0.2 * size, c=BOX, marker="s")
    return []
