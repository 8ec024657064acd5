"""The program behind `scripts/run_headless.py`: a whole run in one process, or many on all cores."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from contextlib import ExitStack, closing

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from soup_lab.headless.arguments import POLICIES, parse
from soup_lab.headless.runs import MISTAKES, RunPlan, Summary, combine, run_many, run_once
from soup_lab.headless.simulation import Headless, make_minds
from soup_msgs_py.command_line.display import on_display
from soup_msgs_py.command_line.output_files import GrowingFile
from soup_msgs_py.errors import InputError, RunError
from soup_msgs_py.figures import rows, told
from soup_msgs_py.policies import ROLES, load_policies
from soup_sim.scenario_loader import load_warehouse
from soup_sim.summary import table, write_summary
from soup_sim.world import World


@on_display
def main(argv: list[str] | None = None) -> int:
    """Run, write the summary, print the table; the exit status."""
    options = parse(argv)
    console = Console(stderr=True)
    if options.from_bag is not None:
        return _what_if(options, console)
    try:
        policies = load_policies(options.policies, {role: getattr(options, f"{role}_policy") for role in ROLES})
        warehouse = load_warehouse(options.scenario, options.set)
        make_minds(policies, warehouse.scenario)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    console.print(f"words: {warehouse.words.describe()}", highlight=False)
    plan = RunPlan(warehouse, policies, options.duration, options.warmup)
    if options.replications > 1:
        return _to_the_end(options, lambda: _several(plan, options, console), _means)
    return _to_the_end(options, lambda: _one(plan, options, console), table)


def _to_the_end(options: argparse.Namespace, run: Callable[[], Summary], show: Callable[[Summary], Table]) -> int:
    """Run, write the summary, then show the table: a screen may fail; the exit status, whatever ends the run."""
    try:
        summary = run()
    except InputError as error:  # also of a world of cells that has no plan
        print(error, file=sys.stderr)
        return 2
    except RunError as error:
        print(error, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("stopped before the end; no summary", file=sys.stderr)
        return 130
    shown = show(summary)
    written = write_summary(options.summary, summary)
    for line, count in summary.get(MISTAKES, {}).items():
        print(f"{line}: {count} times", file=sys.stderr)
    Console().print(shown)
    return 0 if written and summary["violations"] == 0 else 1


def _what_if(options: argparse.Namespace, console: Console) -> int:
    """Run on from a bag, and show what came of it beside what was recorded."""
    # a run without a bag needs no ROS
    from soup_lab.bags.reader import open_bag
    from soup_lab.bags.what_if import beside, take_moment

    try:
        overrides = {role: getattr(options, f"{role}_policy") for role in ROLES}
        with open_bag(options.from_bag.absolute()) as bag:
            moment = take_moment(bag, options.at, options.duration)
        policies = load_policies(options.policies or POLICIES, overrides)
        if options.policies is None:
            policies = moment.policies(policies, overrides)
        make_minds(policies)
        world = moment.world()
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    begin, end = world.now, options.duration or moment.course.last
    console.print(f"goes on from {begin:g} s, the newest checkpoint; all bots first come to rest", highlight=False)
    options.duration, options.seed = end, options.seed or moment.announcement.seed
    plan = RunPlan(moment.warehouse, policies, end)
    counted_from = max(begin, moment.announcement.warmup_s)
    return _to_the_end(
        options,
        lambda: _one(plan, options, console, world),
        lambda summary: beside(moment.original(), summary, counted_from),
    )


def _one(plan: RunPlan, options: argparse.Namespace, console: Console, world: World | None = None) -> Summary:
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:,.0f} s"),
        TimeRemainingColumn(),
    )
    with ExitStack() as files:
        log, decisions = [
            files.enter_context(closing(GrowingFile(path))) if path is not None else None
            for path in (options.event_log, options.explain)
        ]
        bar = files.enter_context(Progress(*columns, console=console, transient=True, disable=not console.is_terminal))
        task = bar.add_task(plan.warehouse.scenario.name, total=plan.duration_s)

        told = False

        def show(run: Headless) -> None:
            nonlocal told
            bar.update(task, completed=run.world.now)
            why = run.stalled()
            if why and not told:
                console.print(why, highlight=False)
            told = bool(why)

        summary = run_once(plan, options.seed, log, show, decisions, world)
        bar.stop()
        for file in (log, decisions):
            if file is not None:
                file.finish()
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
    return combine(summaries)


def _means(combined: Summary) -> Table:
    """The means of many runs for the screen."""
    title = f"{len(combined['replications'])} replications"
    shown = Table("figure", "mean", "± 95 %", "unit", title=title, title_justify="left")
    shown.columns[1].justify = shown.columns[2].justify = "right"
    for key, words, mean, unit in rows({key: combined[key] for key in combined["interval_95"]}):
        shown.add_row(words, mean, told(key, combined["interval_95"][key]), unit)
    stalled = sum(summary["stalled_since_s"] is not None for summary in combined["replications"])
    if stalled:
        shown.add_row("stalled", str(stalled), "", f"of {len(combined['replications'])} runs", style="bold red")
    shown.add_row("violations", told("violations", combined["violations"]), "", "in all runs")
    return shown
