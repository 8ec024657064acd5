"""The program behind `scripts/compare_policies.py`: a sweep, its table and its report."""

from __future__ import annotations

import argparse
import contextlib
import json
import sys
from collections.abc import Generator
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from soup_lab.experiments.analysis import Analysis, analyse, as_json
from soup_lab.experiments.experiment import Experiment, load_experiment
from soup_lab.experiments.identity import code_digest
from soup_lab.experiments.report import report
from soup_lab.experiments.runs import Failure, Job, OtherCodeError, Outcome, Outcomes, jobs, run_local, run_on_dask
from soup_lab.experiments.store import Store
from soup_lab.experiments.table import markdown, screen
from soup_lab.headless.runs import Summary
from soup_lab.lab_arguments import parse_compare
from soup_msgs_py.command_line.display import on_display
from soup_msgs_py.command_line.output_files import OutputError, write_whole
from soup_msgs_py.errors import InputError, RunError
from soup_msgs_py.figures import told

STARTS = 3
TABLE_WIDTH = 200  # characters that the table needs; a file or a pipe has them


@on_display
def main(argv: list[str] | None = None) -> int:
    """Run what is not there yet, print the table, write the report; the exit status."""
    options = parse_compare(argv)
    try:
        experiment = load_experiment(options.experiment, options.replications)
        with Store(options.out) as store:
            return _sweep(experiment, store, options)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    except RunError as error:
        print(f"{error}; run the same command again to continue with what is in {options.out}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print(
            f"stopped before the end; run the same command again to continue with what is in {options.out}",
            file=sys.stderr,
        )
        return 130


def _sweep(experiment: Experiment, store: Store, options: argparse.Namespace) -> int:
    console = Console(stderr=True)
    analysis = analyse(experiment, _outcomes(experiment, store, options, console))
    unwritten = _write(analysis, options.out)
    for line in unwritten:
        print(line, file=sys.stderr)
    shown = Console()
    if not shown.is_terminal:
        shown = Console(width=TABLE_WIDTH)
    shown.print(screen(analysis, wide=shown.width >= TABLE_WIDTH))
    if not unwritten:
        shown.print(f"report: {options.out / 'report.html'}", highlight=False, soft_wrap=True)
    return 1 if analysis.failures or analysis.violations or unwritten else 0


def _outcomes(experiment: Experiment, store: Store, options: argparse.Namespace, console: Console) -> Outcomes:
    """What came of all runs; those of this machine start again should the code be changed just while they start."""
    for _ in range(0 if options.scheduler else STARTS - 1):
        try:
            return _run(experiment, store, options, console)
        except OtherCodeError:
            console.print("the code changed while the sweep was starting; it starts again with the new code")
            code_digest.cache_clear()
    return _run(experiment, store, options, console)


def _run(experiment: Experiment, store: Store, options: argparse.Namespace, console: Console) -> Outcomes:
    """What came of all runs: those that are there, and those that are run now."""
    every = jobs(experiment)
    outcomes: Outcomes = {}
    for job in every:
        if (summary := store.get(job.run)) is not None:
            outcomes[job.case.digest, job.seed] = summary
    todo = [job for job in every if (job.case.digest, job.seed) not in outcomes]
    console.print(_what_there_is(len(every), len(outcomes), len(store)), highlight=False, soft_wrap=True)
    runs = run_on_dask(todo, options.scheduler) if options.scheduler else run_local(todo, options.processes)
    with contextlib.closing(_watched(runs, len(every), len(outcomes), console)) as watched:
        for job, outcome in watched:
            outcomes[job.case.digest, job.seed] = outcome
            if not isinstance(outcome, Failure):
                store.add(job.run, job.case.label, outcome)
    store.sort(job.run for job in every)
    return outcomes


def _what_there_is(wanted: int, found: int, stored: int) -> str:
    text = f"{wanted} runs"
    if found:
        text += f", of which {found} are done already"
    if stored > found:
        text += f"; {stored - found} others, of other settings, seeds or code, are kept"
    return text


def _watched(runs: Generator[Outcome], total: int, found: int, console: Console) -> Generator[Outcome]:
    """The same outcomes, with a bar that moves on a terminal and a line for each run elsewhere."""
    columns = (
        BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn(),
        TextColumn("{task.description}"),
    )  # fmt: skip
    live = console.is_terminal
    with Progress(*columns, console=console, transient=True, disable=not live) as bar, contextlib.closing(runs):
        task = bar.add_task("", total=total, completed=found)
        for done, (job, outcome) in enumerate(runs, start=found + 1):
            text = _told(job, outcome)
            bar.update(task, completed=done, description=escape(text))
            if not live or isinstance(outcome, Failure):
                console.print(f"{done} of {total}: {text}", highlight=False, markup=False, soft_wrap=True)
            yield job, outcome


def _told(job: Job, outcome: Summary | Failure) -> str:
    if isinstance(outcome, Failure):
        came = f"failed: {outcome.reason}"
    else:
        came = f"{told('words_per_second', outcome['words_per_second'])} words/s"
    return f"{job.case.label}, seed {job.seed}: {came}"


def _write(analysis: Analysis, folder: Path) -> list[str]:
    """The report, the table for a README, the figures as JSON, and what failed with all its details.

    Returns:
        What could not be written, a line each.
    """
    details = [
        f"{row.case.label}, seed {seed}\n{failure.details}"
        for row in analysis.rows()
        for seed, failure in row.failures.items()
    ]
    texts = {
        "report.html": report(analysis),
        "table.md": markdown(analysis),
        "figures.json": json.dumps(as_json(analysis), indent=2) + "\n",
        "failures.txt": "\n".join(details),
    }
    unwritten = []
    for name, text in texts.items():
        try:
            if text:
                write_whole(folder / name, text)
            else:
                (folder / name).unlink(missing_ok=True)
        except OutputError as error:
            unwritten.append(str(error))
    return unwritten
