"""The program behind `scripts/run_headless.py`: a whole run in one process, or many on all cores."""

from __future__ import annotations

import argparse
import sys
from contextlib import ExitStack
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from soup_lab.headless import Headless, make_minds
from soup_lab.runs import RunPlan, Summary, combine, open_log, run_many, run_once
from soup_msgs_py import arguments as args
from soup_msgs_py.errors import InputError, RunError
from soup_msgs_py.policies import ROLES, load_policies
from soup_sim.setup import load_warehouse
from soup_sim.summary import table, write_summary

ROOT = Path(__file__).resolve().parents[3]
DEFAULT_DURATION_S = 3600.0


def parse(argv: list[str] | None) -> argparse.Namespace:
    """Read the command line."""
    parser = args.Parser("Run a warehouse in one process, as fast as the machine can.")
    args.add_scenario(parser, ROOT / "config/scenarios/demo.yaml")
    args.add_policies(parser, ROOT / "config/policies/best.yaml", ROLES)
    args.add_run(parser)
    args.add_explain(parser)
    parser.add_argument("--replications", type=args.replications, default=1, metavar="N", help="runs with other seeds")
    parser.add_argument("--processes", type=args.processes, metavar="N", help="runs at once; without: one a core")
    args.add_live_only(parser)
    parsed = parser.parse_args(argv)
    parsed.duration = parsed.duration or DEFAULT_DURATION_S
    args.check_run(parser, parsed)
    for name in ("event_log", "explain"):
        if parsed.replications > 1 and getattr(parsed, name) is not None:
            parser.error(f"--{name.replace('_', '-')}: found --replications above 1; allowed: one run")
    return parsed


def main(argv: list[str] | None = None) -> int:
    """Run, print the table, write the summary; the exit status."""
    options = parse(argv)
    console = Console(stderr=True)
    try:
        policies = load_policies(options.policies, {role: getattr(options, f"{role}_policy") for role in ROLES})
        warehouse = load_warehouse(options.scenario, options.set)
        make_minds(policies)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    console.print(f"words: {warehouse.words.describe()}", highlight=False)
    plan = RunPlan(warehouse, policies, options.duration, options.warmup)
    try:
        summary = _one(plan, options, console) if options.replications == 1 else _several(plan, options, console)
    except RunError as error:
        print(error, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("stopped before the end; no summary", file=sys.stderr)
        return 130
    if options.summary is not None:
        write_summary(options.summary, summary)
    return 0 if summary["violations"] == 0 else 1


def _one(plan: RunPlan, options: argparse.Namespace, console: Console) -> Summary:
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:,.0f} s"),
        TimeRemainingColumn(),
    )
    with ExitStack() as files:
        log, decisions = [
            files.enter_context(open_log(path)) if path is not None else None
            for path in (options.event_log, options.explain)
        ]
        bar = files.enter_context(Progress(*columns, console=console, transient=True, disable=not console.is_terminal))
        task = bar.add_task(plan.warehouse.scenario.name, total=plan.duration_s)

        def show(run: Headless) -> None:
            bar.update(task, completed=run.world.now)

        summary = run_once(plan, options.seed, log, show, decisions)
    Console().print(table(summary))
    return summary


def _several(plan: RunPlan, options: argparse.Namespace, console: Console) -> Summary:
    seeds = [options.seed + k for k in range(options.replications)]
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    summaries: list[Summary] = []
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("replications", total=len(seeds))
        for summary in run_many(plan, seeds, options.processes):
            summaries.append(summary)
            bar.advance(task)
    combined = combine(summaries)
    shown = Table("figure", "mean", "± 95 %", title=f"{len(seeds)} replications", title_justify="left")
    for key, width in combined["interval_95"].items():
        shown.add_row(key, f"{combined[key]:,.4f}", f"{width:,.4f}")
    shown.add_row("violations", str(combined["violations"]), "")
    Console().print(shown)
    return combined
