"""A plan as a picture of all ways, or played as an animation."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from soup_managers.planners.check import Picture, play
from soup_msgs_py.cell_world import World
from soup_msgs_py.output_files import whole

INCHES_A_CELL = 0.3
FRAMES_A_SECOND = 4
WALL, SHELF, BOX, FILLED = "#444444", "#d8c8a8", "#b5651d", "#8a6d3b"


def draw_plan(world: World, plans: Sequence[str], path: Path) -> None:
    """Draw a plan into a file: `.gif` plays it, anything else shows the ways.

    Raises:
        OutputError: It cannot be written.
    """
    pictures = list(play(world, plans, may_wait=True))
    figure = Figure(figsize=(max(2.0, world.width * INCHES_A_CELL), max(2.0, world.height * INCHES_A_CELL)))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    if path.suffix == ".gif":
        animation = FuncAnimation(figure, lambda step: _floor(axes, world, pictures[step]), frames=len(pictures))
        with whole(path) as half:
            animation.save(str(half), writer=PillowWriter(fps=FRAMES_A_SECOND))
        return
    _floor(axes, world, pictures[0])
    for robot in range(len(plans)):
        way = np.array([now.robots[robot] for now in pictures], float)
        aside = 0.3 * (robot / max(1, len(plans) - 1) - 0.5)  # so that ways along one aisle can be told apart
        axes.plot(way[:, 0] + aside, way[:, 1] + aside, color=f"C{robot % 10}", linewidth=1.5)
    with whole(path) as half:
        figure.savefig(half, dpi=120)


def _floor(axes: Axes, world: World, now: Picture) -> list[Any]:
    axes.clear()
    axes.set_axis_off()
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
