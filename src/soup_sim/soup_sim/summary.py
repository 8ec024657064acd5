"""The summary of a run: one JSON file and one table, the same figures for every way of running."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.table import Table

from soup_msgs_py.command_line.output_files import OutputError, Tell, tell_on_stderr, write_whole
from soup_msgs_py.figures import FIGURES, rows
from soup_msgs_py.policies import ROLES, Policies
from soup_msgs_py.scenario import Scenario

KEYS = tuple(FIGURES)

# Share of a run in which simulated time may go on though something is under way, before a person is warned.
MOST_LATENCY = 0.01


def make_summary(
    figures: Mapping[str, Any], scenario: Scenario, policies: Policies, seed: int, violations: int | None
) -> dict[str, Any]:
    """All keys of a summary, in their order.

    Args:
        figures: What `World.statistics` gives.
        scenario: The scenario of the run.
        policies: Its policies.
        seed: Its seed.
        violations: Broken laws that the judge has counted; None where he could not judge.
    """
    values = {
        "latency_s": 0.0,  # but for parts in processes of their own
        **figures,
        "bots": scenario.bots,
        "buckets": scenario.buckets,
        "word_stations": scenario.word_station_count,
        "letter_stations": scenario.letter_station_count,
        "scenario": scenario.name,
        "policies": {role: getattr(policies, role).name for role in ROLES},
        "seed": seed,
        "violations": violations,
        "station_policies": {
            "word_station": scenario.word_station.policy.name,
            "letter_station": scenario.letter_station.policy.name,
        },
    }
    return {key: finite(values[key]) for key in KEYS}


def write_summary(path: Path | None, summary: Mapping[str, Any], tell: Tell = tell_on_stderr) -> bool:
    """Write a summary as JSON, whole or not at all. Do it before anything is shown: a screen may fail.

    Args:
        path: Where to, if anybody wants it.
        summary: The figures.
        tell: Says why it could not be written.

    Returns:
        Whether all is as asked for.
    """
    if path is not None:
        try:
            write_whole(path, json.dumps(finite(summary), indent=2, allow_nan=False) + "\n")
        except OutputError as error:
            tell(str(error))
            return False
    return True


def lateness(summary: Mapping[str, Any]) -> str:
    """A warning where simulated time went on for long though messages were under way; empty where it did not."""
    latency_s, seconds = summary["latency_s"], summary["sim_seconds"]
    if latency_s <= MOST_LATENCY * seconds:
        return ""
    share = 100.0 * latency_s / seconds
    return (
        f"warning: {latency_s:.0f} s of the run ({share:.0f} %) went on without a part or a message that the world had "
        "waited for in vain; compare its figures with those of run_headless.py before you rely on them"
    )


def table(summary: Mapping[str, Any]) -> Table:
    """A summary as a table for the screen."""
    shown = Table("figure", "value", "unit", title=f"Warehouse {summary['scenario']}", title_justify="left")
    shown.columns[1].justify = "right"
    for key, words, value, unit in rows(summary):
        is_fault = key == "violations" and bool(summary[key])
        shown.add_row(words, value, unit, style="bold red" if is_fault else None)
    return shown


def finite(value: Any) -> Any:
    """A value that JSON knows: numpy's own ones as Python's, and None for a figure that no number can be, or any."""
    if isinstance(value, Mapping):
        return {key: finite(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [finite(part) for part in value]
    value = value.item() if hasattr(value, "item") else value
    return None if isinstance(value, float) and not math.isfinite(value) else value
