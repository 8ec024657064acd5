"""The charts of a sweep's report, as SVG that is the same for the same figures."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import matplotlib
from matplotlib.figure import Figure

from soup_lab.experiments.analysis import Row
from soup_lab.experiments.experiment import Case
from soup_msgs_py.figures import told

BASE, BETTER, WORSE, ALIKE = "#3d4852", "#1b7f5c", "#c8553d", "#93acc4"  # told apart by colour-blind eyes too
SETTINGS: Any = {
    "svg.hashsalt": "alphabet soup",
    "font.size": 10.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
}
WIDTH_IN = 8.6


@matplotlib.rc_context(SETTINGS)
def bars(rows: Sequence[Row]) -> str:
    """Words per second of each row: a bar, its interval, a dot a run; the bound as a dashed line.

    Raises:
        ValueError: No row has a run.
    """
    shown = [(row, figure) for row in rows if (figure := row.figures["words_per_second"]) is not None]
    figure, axes = _canvas(0.42 * len(shown) + 1.1)
    for place, (row, rate) in enumerate(shown):
        axes.barh(place, rate.mean, height=0.62, color=_colour(row), xerr=rate.half_width, capsize=4.0, ecolor="black")
        runs = [summary["words_per_second"] for summary in row.summaries.values()]
        axes.plot(runs, [place] * len(runs), "o", color="black", markerfacecolor="white", markersize=4.0)
    bounds = {s["word_rate_bound"] for row, _ in shown for s in row.summaries.values()}
    if len(bounds) == 1 and None not in bounds:
        _bound_line(axes, axes.axvline, bounds.pop())
    axes.set_yticks(range(len(shown)), [row.case.name for row, _ in shown])
    axes.set_ylim(len(shown) - 0.4, -0.6)
    axes.set_xlim(left=0.0)
    axes.set_xlabel("words/s")
    return _svg(figure)


@matplotlib.rc_context(SETTINGS)
def curve(rows: Sequence[Row], key: str) -> str:
    """Words per second and metres per letter over the value of a key of the scenario."""
    points = sorted(((scenario_value(row.case, key), row) for row in rows if row.summaries), key=lambda p: p[0])
    figure = Figure(figsize=(WIDTH_IN, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    for axes, name, label in (
        (left, "words_per_second", "words/s"),
        (right, "metres_per_letter", "metres driven per letter"),
    ):
        there = [(value, found) for value, row in points if (found := row.figures[name]) is not None]
        widths = [found.half_width or 0.0 for _, found in there]
        axes.errorbar([v for v, _ in there], [f.mean for _, f in there], yerr=widths, fmt="o-", color=BETTER, capsize=4)
        axes.set_xlabel(key)
        axes.set_ylabel(label)
        axes.set_ylim(bottom=0.0)
        axes.set_xlim(left=0.0)
    bounds = {summary["word_rate_bound"] for _, row in points for summary in row.summaries.values()}
    if len(bounds) == 1 and None not in bounds:
        _bound_line(left, left.axhline, bounds.pop())
    return _svg(figure)


@matplotlib.rc_context(SETTINGS)
def differences(rows: Sequence[tuple[str, Row]]) -> str:
    """The difference in words per second to the base of each row, with its interval."""
    figure, axes = _canvas(0.3 * len(rows) + 1.0)
    for place, (_, row) in enumerate(rows):
        assert row.difference is not None
        found = row.difference.estimate
        axes.errorbar(
            found.mean, place, xerr=found.half_width, fmt="o", color=_colour(row), capsize=4.0, markersize=6.0
        )
    axes.axvline(0.0, color=BASE, linewidth=1.0)
    axes.set_yticks(range(len(rows)), [label for label, _ in rows])
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.set_xlabel("difference to the base, words/s")
    return _svg(figure)


def curve_key(rows: Sequence[Row]) -> str | None:
    """The one key of the scenario, a number, that all variants of a group change; None where there is none."""
    changes = [row.case.changed for row in rows if row.case.group]
    keys = {key for change in changes for key in change}
    if len(keys) != 1 or not all(changes):
        return None
    key = keys.pop()
    values = [scenario_value(row.case, key) for row in rows]
    numbers = all(isinstance(value, (int, float)) and not isinstance(value, bool) for value in values)
    one_policy = len({row.case.plan.policies.model_dump_json() for row in rows}) == 1
    return key if numbers and one_policy and len(set(values)) > 2 else None


def scenario_value(case: Case, key: str) -> Any:
    """What the scenario of a case has under a dotted key."""
    value: Any = case.plan.warehouse.scenario.model_dump(mode="json")
    for part in key.split("."):
        value = value.get(part) if isinstance(value, dict) else None
    return value


def _canvas(height_in: float) -> tuple[Figure, Any]:
    figure = Figure(figsize=(WIDTH_IN, height_in), layout="constrained")
    return figure, figure.subplots()


def _colour(row: Row) -> str:
    if row.is_base:
        return BASE
    if row.difference is None or not row.difference.significant:
        return ALIKE
    return BETTER if row.difference.estimate.mean > 0.0 else WORSE


def _bound_line(axes: Any, draw: Any, bound: float) -> None:
    draw(bound, color="black", linestyle="--", linewidth=1.0)
    axes.set_title(f"dashed: bound of stations, {told('word_rate_bound', bound)} words/s", fontsize=8.5, loc="right")


def _svg(figure: Figure) -> str:
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()
