"""From the summaries of a sweep to what a person wants to know of each variant."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

from soup_lab.experiments.experiment import Case, Experiment, Group
from soup_lab.experiments.identity import versions
from soup_lab.experiments.runs import Failure, Outcomes
from soup_lab.experiments.statistics import Difference, Estimate, estimate, holm, paired_difference
from soup_lab.headless.runs import Summary


def _ratio(above: str, below: str) -> Callable[[Summary], float | None]:
    return lambda summary: summary[above] / summary[below] if summary[below] else None


FIGURES: dict[str, Callable[[Summary], float | None]] = {
    "words_per_second": lambda summary: summary["words_per_second"],
    "fraction_of_bound": lambda summary: summary["fraction_of_bound"],
    "pile_on_word": lambda summary: summary["pile_on_word"] or None,  # 0 stands for no visit
    "pile_on_letter": lambda summary: summary["pile_on_letter"] or None,
    "metres_per_letter": _ratio("distance_total_m", "letters_in_words"),
    "inventory_end_to_start": _ratio("inventory_fill_end", "inventory_fill_start"),
    "real_time_factor": lambda summary: summary["real_time_factor"],
}
TOTALS = ("bot_collisions", "bucket_collisions", "violations")


@dataclass(frozen=True)
class Row:
    """What came of one case.

    Attributes:
        case: The case.
        is_base: Whether it is the base, or the same runs.
        summaries: Of the runs that came to their end, by seed.
        failures: Why others did not, by seed.
        figures: Mean and interval of each figure; None where no run has it.
        totals: Sums over all runs of what should be 0.
        difference: Of words per second to the base, over the seeds that both have; None for the base.
    """

    case: Case
    is_base: bool
    summaries: dict[int, Summary]
    failures: dict[int, Failure]
    figures: dict[str, Estimate | None]
    totals: dict[str, int]
    difference: Difference | None


@dataclass(frozen=True)
class Analysis:
    """A sweep and all its rows, group by group."""

    experiment: Experiment
    base: Row
    groups: tuple[tuple[Group, tuple[Row, ...]], ...]
    comparisons: int  # how many different variants were compared with the base

    def rows(self) -> list[Row]:
        """Each different row once, the base first."""
        first: dict[str, Row] = {self.base.case.digest: self.base}
        for _, rows in self.groups:
            for row in rows:
                first.setdefault(row.case.digest, row)
        return list(first.values())

    @property
    def failures(self) -> int:
        """How many runs did not come to their end."""
        return sum(len(row.failures) for row in self.rows())

    @property
    def violations(self) -> int:
        """How often a law of the warehouse was broken, in all runs."""
        return sum(row.totals["violations"] for row in self.rows())


def analyse(experiment: Experiment, outcomes: Outcomes) -> Analysis:
    """Put together what came of all runs."""
    base = _row(experiment, experiment.base, outcomes, None)
    cases = [case for case in experiment.cases() if case.digest != base.case.digest]
    rows = {case.digest: _row(experiment, case, outcomes, base) for case in cases}
    together = holm([row.difference.p if row.difference else None for row in rows.values()])
    for row, significant in zip(list(rows.values()), together, strict=True):
        if row.difference is not None:
            rows[row.case.digest] = replace(row, difference=replace(row.difference, family=significant))
    rows[base.case.digest] = base
    groups = tuple(
        (group, tuple(replace(rows[case.digest], case=case) for case in experiment.shown(group)))
        for group in experiment.groups
    )
    return Analysis(experiment, base, groups, len(cases))


def as_json(analysis: Analysis) -> dict[str, Any]:
    """All figures of a sweep, for other programs."""
    experiment = analysis.experiment
    plan = experiment.base.plan
    return {
        "experiment": experiment.name,
        "warmup_s": plan.warmup_s,
        "duration_s": plan.duration_s,
        "seeds": list(experiment.seeds),
        "versions": versions(),
        "base": _row_as_json(analysis.base),
        "groups": {group.name: [_row_as_json(row) for row in rows] for group, rows in analysis.groups},
    }


def _row(experiment: Experiment, case: Case, outcomes: Outcomes, base: Row | None) -> Row:
    came = {seed: outcomes[case.digest, seed] for seed in experiment.seeds if (case.digest, seed) in outcomes}
    summaries = {seed: outcome for seed, outcome in came.items() if not isinstance(outcome, Failure)}
    failures = {seed: outcome for seed, outcome in came.items() if isinstance(outcome, Failure)}
    figures: dict[str, Estimate | None] = {}
    for key, figure in FIGURES.items():
        values = [value for value in map(figure, summaries.values()) if value is not None]
        figures[key] = estimate(values) if values else None
    totals = {key: sum(summary[key] for summary in summaries.values()) for key in TOTALS}
    difference = None
    if base is not None and (pairs := [seed for seed in summaries if seed in base.summaries]):
        own, others = ([of[seed]["words_per_second"] for seed in pairs] for of in (summaries, base.summaries))
        difference = paired_difference(own, others)
    return Row(case, base is None, summaries, failures, figures, totals, difference)


def _row_as_json(row: Row) -> dict[str, Any]:
    difference = row.difference
    return {
        "variant": row.case.name,
        "is_base": row.is_base,
        "settings": row.case.digest,
        "runs": len(row.summaries),
        "failures": {str(seed): failure.reason for seed, failure in row.failures.items()},
        "figures": {key: asdict(figure) if figure is not None else None for key, figure in row.figures.items()},
        "totals": row.totals,
        "words_per_second_to_base": None
        if difference is None
        else {
            **asdict(difference.estimate),
            "share": difference.share,
            "p": difference.p,
            "significant": difference.significant,
            "significant_together": difference.family,
        },
    }
