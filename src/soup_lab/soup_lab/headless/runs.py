"""One run from start to summary, and many runs with independent seeds on all cores."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from scipy.stats import t as student

from soup_lab.headless.pool import share_out
from soup_lab.headless.simulation import Headless
from soup_managers.explain import write_lines
from soup_msgs_py.blame import blaming
from soup_msgs_py.command_line.output_files import Lines
from soup_msgs_py.messages import Event
from soup_msgs_py.policies import Policies
from soup_sim.checkpoint import come_to_rest
from soup_sim.event_log import EventLog
from soup_sim.scenario_loader import Warehouse
from soup_sim.summary import make_summary
from soup_sim.validate import Judge
from soup_sim.world import World

JUDGED_EVERY_S = 10.0  # simulated seconds between two looks of the judge at all places
MISTAKES = "policy_mistakes"  # the key of a summary that only those of runs with some have
Progress = Callable[[Headless], None]
Summary = dict[str, Any]


@dataclass(frozen=True)
class RunPlan:
    """What to run: a warehouse, its policies, and how long (simulated s)."""

    warehouse: Warehouse
    policies: Policies
    duration_s: float
    warmup_s: float = 0.0


@blaming()
def run_once(
    plan: RunPlan,
    seed: int,
    event_log: Lines | None = None,
    progress: Progress | None = None,
    explain: Lines | None = None,
    world: World | None = None,
) -> Summary:
    """Run a warehouse in this process and judge it.

    Args:
        plan: What to run.
        seed: Seed of all randomness.
        event_log: Where to write events as JSON lines.
        progress: Called every few simulated seconds.
        explain: Where to write the managers' decisions as JSON lines.
        world: A world to go on with, as a checkpoint restored it; without: a new one.

    Returns:
        The summary; with `policy_mistakes` where policies chose what cannot be: what, and how often.

    Raises:
        RunError: A policy failed; where in its file.
    """
    warehouse = plan.warehouse
    judges: list[Judge] = []
    log = EventLog(event_log) if event_log is not None else None

    def on_event(event: Event) -> None:
        judges[0].event(event)
        if log is not None:
            log(event)

    started = time.perf_counter()
    restored = world is not None
    world = world or warehouse.world(seed, plan.warmup_s)
    judges.append(Judge(warehouse.scenario, warehouse.layout, world.snapshot()))
    if restored:
        for said in come_to_rest(world):
            if isinstance(said, Event):
                on_event(said)
    run = Headless(world, plan.policies, seed, on_event, write_lines(explain) if explain is not None else None)
    now = world.now
    while now < plan.duration_s:
        now = min(now + JUDGED_EVERY_S, plan.duration_s)
        run.run(now)
        judges[0].poses(world.bots(), world.buckets())
        if progress is not None:
            progress(run)
    judges[0].finish(world.snapshot())
    figures = world.statistics(time.perf_counter() - started)
    summary = make_summary(figures, warehouse.scenario, plan.policies, seed, judges[0].count)
    return {**summary, MISTAKES: run.mistakes} if run.mistakes else summary


def run_many(plan: RunPlan, seeds: list[int], processes: int | None = None) -> Iterator[Summary]:
    """Run a plan once a seed, on all cores; summaries as they come.

    Args:
        plan: What to run.
        seeds: One a run.
        processes: How many at once; without: one a core.
    """
    for _, summary in share_out(run_once, [(plan, seed) for seed in seeds], processes):
        yield summary


def combine(summaries: list[Summary]) -> Summary:
    """The mean of each figure over independent runs, with the half width of its 95 % interval.

    Returns:
        A summary of means, and since when the first run that stalled did; `interval_95` holds the half widths,
        `replications` the single summaries.
    """
    summaries = sorted(summaries, key=lambda summary: summary["seed"])
    first = summaries[0]
    means: Summary = {}
    widths: dict[str, float] = {}
    for key, value in first.items():
        if key == MISTAKES:
            continue
        values = [float(summary[key]) for summary in summaries if isinstance(summary[key], (int, float))]
        if values and key not in ("seed", "violations", "stalled_since_s"):
            n = len(values)  # a figure may have no value in some
            mean = sum(values) / n
            means[key] = mean
            spread = (sum((v - mean) ** 2 for v in values) / (n - 1)) ** 0.5 if n > 1 else 0.0
            widths[key] = float(student.ppf(0.975, n - 1)) * spread / n**0.5 if n > 1 else 0.0
        else:
            means[key] = value
    stalled = [summary["stalled_since_s"] for summary in summaries if summary["stalled_since_s"] is not None]
    means["stalled_since_s"] = min(stalled, default=None)
    means["violations"] = sum(summary["violations"] for summary in summaries)
    mistakes = sum((Counter(summary.get(MISTAKES, {})) for summary in summaries), Counter[str]())
    if mistakes:
        means[MISTAKES] = dict(mistakes)
    means["interval_95"] = widths
    means["replications"] = summaries
    return means
