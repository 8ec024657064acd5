"""The program behind `scripts/benchmark.py`: speeds, where they belong; tests never assert a time."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from soup_lab.benchmarks.planner_speed import NEW, draw_searches, searches
from soup_lab.benchmarks.speed import Measured, at_constant_density, growth, measure_apart
from soup_lab.lab_arguments import ENGINE, PLANNER, parse_benchmark
from soup_msgs_py.command_line.display import on_display
from soup_msgs_py.command_line.output_files import OutputError
from soup_msgs_py.figures import written
from soup_msgs_py.policies import Policies, load_policies
from soup_sim.summary import write_summary

ROOT = Path(__file__).resolve().parents[4]
SCENARIOS = ROOT / "config/scenarios"
FLEETS = (125, 250, 500, 1000)


@on_display
def main(argv: list[str] | None = None) -> int:
    """Measure what the command line names; the exit status."""
    options = parse_benchmark(argv)
    console = Console(width=max(Console().width, 120))  # a file or pipe is as wide as the table needs
    if options.what == PLANNER:
        return _planner(options, console)
    with console.status("measuring"):
        measured, relative = (_engine if options.what == ENGINE else _policies)(options.seconds)
    shown = Table(
        "run", "bots", "compile and load, s", "real-time factor", "ms/simulated s", "cost / n log n", "memory, MB"
    )
    for one, cost in zip(measured, relative, strict=True):
        shown.add_row(
            one.name, written(one.bots), written(one.compile_s), written(one.real_time_factor), written(one.cost),
            "" if cost is None else written(cost), written(one.memory_mb),
        )  # fmt: skip
    figures = [{**vars(one), "cost_relative_to_n_log_n": r} for one, r in zip(measured, relative, strict=True)]
    saved = write_summary(options.summary, {options.what: figures})
    console.print(shown)
    return 0 if saved else 1


def _planner(options: argparse.Namespace, console: Console) -> int:
    """The paper's planners and the optimal one on the worlds of its figures."""
    with console.status("searching"):
        found = searches(ROOT / "config/worlds", options.time_limit)
    shown = Table("figure", "robots", "boxes", "planner", "steps", "generated", "expanded", "search, s", "times faster")
    fastest = {(one.figure, one.robots, one.boxes): one.answer.search_s for one in found if one.planner == NEW}
    rows: list[dict[str, Any]] = []
    for one in found:
        answer, times = one.answer, one.answer.search_s / fastest[one.figure, one.robots, one.boxes]
        steps = str(answer.makespan) if answer.plans is not None else "given up"
        shown.add_row(
            one.figure, str(one.robots), str(one.boxes), one.planner, steps, f"{answer.nodes_generated:,}",
            f"{answer.nodes_expanded:,}", written(answer.search_s), "" if one.planner == NEW else written(times),
        )  # fmt: skip
        rows.append({
            "figure": one.figure, "robots": one.robots, "boxes": one.boxes, "planner": one.planner,
            "makespan": answer.makespan, "nodes_generated": answer.nodes_generated,
            "nodes_expanded": answer.nodes_expanded, "search_seconds": answer.search_s,
        })  # fmt: skip
    saved = write_summary(options.summary, {PLANNER: rows})
    if options.picture is not None:
        try:
            draw_searches(found, options.picture)
        except OutputError as error:
            print(error, file=sys.stderr)
            saved = False
    console.print(shown)
    console.print(
        "times faster: than this planner, the optimal one. The paper's medium1: 796,228 generated, 145,842 expanded."
    )
    return 0 if saved else 1


def _engine(seconds: float) -> tuple[list[Measured], list[float | None]]:
    minimal = _load("minimal")
    runs: list[Any] = [(name, name, ()) for name in ("paper.yaml", "large.yaml")]
    runs += [(f"paper.yaml with {n} bots", "paper.yaml", at_constant_density(n)) for n in FLEETS]
    measured = [measure_apart(name, SCENARIOS / file, changes, minimal, seconds) for name, file, changes in runs]
    return measured, [None, None, *growth(measured[2:])]


def _policies(seconds: float) -> tuple[list[Measured], list[float | None]]:
    measured = [
        measure_apart(f"{file} {name}", SCENARIOS / file, (), _load(name), seconds)
        for file in ("paper.yaml", "large.yaml")
        for name in ("minimal", "best")
    ]
    return measured, [None] * len(measured)


def _load(name: str) -> Policies:
    return load_policies(ROOT / "config/policies" / f"{name}.yaml")
