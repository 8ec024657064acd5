"""The 2023 paper's figures 3, 4 and 5 measured anew: how long its planners and the optimal one search."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.figure import Figure

from soup_managers.planners.known import PLANNERS
from soup_managers.planners.plan import PAPER, Answer, Task
from soup_msgs_py.command_line.output_files import whole
from soup_msgs_py.warehouse.cell_world import World, parse_world, read_world

OLD, NEW = ("single-action", "multi-action"), "optimal"
COLOURS = {"single-action": "#c8553d", "multi-action": "#3d4852", NEW: "#1b7f5c"}
ROBOTS = (1, 2, 3)
BOXES = (1, 2, 3, 4)
# small1 with a fourth empty shelf nearer to the boxes, as in the paper's section "Main Results"
FOUR_SHELVES = "_______\n_|___#_\n_#___|_\n_|___#_\n__@__|_\n*__@__*\n___*_*_\n"
SETTINGS: Any = {"svg.hashsalt": "alphabet soup", "font.size": 10.0}


@dataclass(frozen=True)
class Searched:
    """One search.

    Attributes:
        figure: Of the paper.
        robots: How many.
        boxes: How many.
        planner: Its name.
        answer: What it found.
    """

    figure: str
    robots: int
    boxes: int
    planner: str
    answer: Answer


def searches(worlds: Path, limit_s: float) -> list[Searched]:
    """Search all worlds of the paper's figures by its own rules.

    Args:
        worlds: The folder of the world files.
        limit_s: Wall seconds after which a search is given up.
    """
    medium = read_world(worlds / "medium1.txt")
    found = _all("figure 3: medium1", [medium], ("multi-action", NEW), limit_s)
    small = [read_world(worlds / f"small1-{robots}r.txt") for robots in ROBOTS]
    found += _all("figure 4: robots", small, (*OLD, NEW), limit_s)
    return found + _all("figure 5: boxes", [_with(boxes) for boxes in BOXES], ("multi-action", NEW), limit_s)


def _with(boxes: int) -> World:
    """The world of figure 5 with its first boxes alone."""
    kept, text = 0, ""
    for kind in FOUR_SHELVES:
        kept += kind == "*"
        text += "_" if kind == "*" and kept > boxes else kind
    return parse_world(text)


def _all(figure: str, worlds: list[World], planners: tuple[str, ...], limit_s: float) -> list[Searched]:
    found = []
    for world in worlds:
        for planner in planners:
            answer = PLANNERS[planner](Task(world, PAPER, time_limit_s=limit_s))
            found.append(Searched(figure, len(world.robots), len(world.boxes), planner, answer))
    return found


@matplotlib.rc_context(SETTINGS)
def draw_searches(found: list[Searched], path: Path) -> None:
    """Figures 4 and 5 of the paper side by side, seconds on a logarithmic scale; hollow: given up.

    Raises:
        OutputError: It cannot be written.
    """
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    for axes, name, along in zip(
        figure.subplots(1, 2, sharey=True), ("figure 4: robots", "figure 5: boxes"), ("robots", "boxes"), strict=True
    ):
        for planner in (*OLD, NEW):
            points = [
                (getattr(one, along), one.answer.search_s, one.answer.plans is not None)
                for one in found
                if one.figure == name and one.planner == planner
            ]
            if not points:
                continue
            numbers, seconds, _ = zip(*points, strict=True)
            axes.plot(numbers, seconds, label=planner, color=COLOURS[planner])
            for number, second, done in points:
                axes.plot(number, second, "o", color=COLOURS[planner], markerfacecolor=None if done else "white")
            axes.set_xticks(numbers)
        axes.set_yscale("log")
        axes.set_xlabel(along)
        axes.set_title(name)
    figure.axes[0].set_ylabel("seconds of search")
    figure.axes[0].legend(frameon=False)
    with whole(path) as half:
        figure.savefig(half)
