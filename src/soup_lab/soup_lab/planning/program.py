"""The program behind `scripts/plan_world.py`: a joint plan for the robots of a world file, checked and shown."""

from __future__ import annotations

import argparse
import math
import sys
import time
from typing import Any

from rich.console import Console
from rich.table import Table

from soup_lab.lab_arguments import parse_plan
from soup_lab.planning.picture import draw_plan
from soup_managers.planners.check import LOADED, check_plan, draw, play
from soup_managers.planners.known import PLANNERS
from soup_managers.planners.plan import RULES, Answer, Task
from soup_msgs_py.command_line.display import on_display
from soup_msgs_py.command_line.output_files import OutputError
from soup_msgs_py.errors import InputError
from soup_msgs_py.figures import PLAN_FIGURES, rows
from soup_msgs_py.warehouse.cell_world import BOX, FLOOR, FULL, ROBOT, SHELF, read_world
from soup_sim.summary import write_summary

SHOWN_STEP_S = 0.15
LETTERS = "U up, D down, L left, R right, P pick up or put down, W wait"
KEY = (
    f"{ROBOT} robot, {LOADED} robot with a box, {BOX} box, {SHELF} empty shelf, {FULL} wall or full shelf, "
    f"{FLOOR} floor"
)


@on_display
def main(argv: list[str] | None = None) -> int:
    """Plan, check, write and show; the exit status: 0 for a plan, 1 for none."""
    options = parse_plan(argv)
    try:
        world = read_world(options.world)
        task = Task(world, RULES[options.rules], options.weight, options.time_limit)
        answer = PLANNERS[options.planner](task)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("stopped before there was a plan", file=sys.stderr)
        return 130
    if answer.plans is not None:
        may_wait = task.rules.may_wait or options.planner == "single-action"
        rules = task.rules
        check_plan(world, answer.plans, may_wait=may_wait, must_leave=rules.must_leave, carries_over=rules.carries_over)
    summary = figures(options, answer, len(world.robots), len(world.boxes))
    written, drawn = write_summary(options.summary, summary), False
    if options.picture is not None and answer.plans is not None:
        try:
            draw_plan(world, answer.plans, options.picture)
            drawn = True
        except OutputError as error:
            print(error, file=sys.stderr)
            written = False
    _print(summary, answer)
    if answer.plans is None:
        print(f"{options.world}: {answer.note}; lower bound {_text(answer.lower_bound)}", file=sys.stderr)
        return 1
    if drawn:
        print(f"wrote {options.picture}")
    if options.show:
        print(f"\n{KEY}")
        for now in play(world, answer.plans, may_wait=True):
            print(f"\nstep {now.step}\n{draw(world, now)}", flush=True)
            if sys.stdout.isatty():
                time.sleep(SHOWN_STEP_S)
    return 0 if written else 1


def figures(options: argparse.Namespace, answer: Answer, robots: int, boxes: int) -> dict[str, Any]:
    """The figures of a plan, under the names of the design."""
    return {
        "planner": options.planner,
        "rules": options.rules,
        "makespan": answer.makespan,
        "proven_optimal": answer.proven_optimal,
        "lower_bound": answer.lower_bound if math.isfinite(answer.lower_bound) else None,
        "gap": answer.gap,
        "nodes_generated": answer.nodes_generated,
        "nodes_expanded": answer.nodes_expanded,
        "search_seconds": answer.search_s,
        "robots": robots,
        "boxes": boxes,
        "plans": list(answer.plans) if answer.plans is not None else None,
        "note": answer.note,
    }


def _text(bound: float) -> str:
    return f"{bound:g}" if math.isfinite(bound) else "none: it is proven that there is no plan"


def _print(summary: dict[str, Any], answer: Answer) -> None:
    table = Table("figure", "value", "unit")
    table.columns[1].justify = "right"
    for _, words, value, unit in rows({key: summary[key] for key in PLAN_FIGURES if summary[key] not in (None, "")}):
        table.add_row(words, value, unit)
    Console().print(table)
    if answer.plans:
        print(LETTERS)
    for robot, letters in enumerate(answer.plans or ()):
        print(f"robot {robot + 1}: {' '.join(letters)}")
