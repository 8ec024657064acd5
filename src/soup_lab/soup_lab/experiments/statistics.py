"""Means with intervals, and differences of runs that share their seeds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

LEVEL = 0.95  # of every interval


@dataclass(frozen=True)
class Estimate:
    """A mean over independent runs.

    Attributes:
        mean: The mean.
        half_width: Half the width of its interval (Student's t); None with one run.
        lowest: The smallest value.
        highest: The largest.
        runs: How many values.
    """

    mean: float
    half_width: float | None
    lowest: float
    highest: float
    runs: int


@dataclass(frozen=True)
class Difference:
    """A mean difference to the base over pairs of runs with the same seed.

    Attributes:
        estimate: The difference, with its interval.
        p: How likely so large a mean difference is if there is none (paired t test, two-sided); None with one pair.
        share: The difference as a share of the base's mean; None where that is 0.
        family: Whether it is significant also with all comparisons of the sweep taken together; see `holm`.
    """

    estimate: Estimate
    p: float | None
    share: float | None
    family: bool = False

    @property
    def significant(self) -> bool:
        """Whether the interval excludes 0."""
        return self.p is not None and self.p < 1.0 - LEVEL


def estimate(values: Sequence[float]) -> Estimate:
    """The mean of at least one value, with its interval."""
    n = len(values)
    mean = math.fsum(values) / n
    half_width = None
    if n > 1:
        half_width = float(student.ppf((1.0 + LEVEL) / 2.0, n - 1)) * _standard_error(values)
    return Estimate(mean, half_width, min(values), max(values), n)


def paired_difference(values: Sequence[float], base: Sequence[float]) -> Difference:
    """The mean difference of pairs, seed by seed in the same order; at least one pair."""
    differences = [value - other for value, other in zip(values, base, strict=True)]
    found = estimate(differences)
    p = None
    if found.runs > 1:
        error = _standard_error(differences)
        ratio = abs(found.mean) / error if error > 0.0 else (math.inf if found.mean else 0.0)
        p = 2.0 * float(student.sf(ratio, found.runs - 1))
    mean = math.fsum(base) / len(base)
    return Difference(found, p, found.mean / mean if mean else None)


def holm(ps: Sequence[float | None]) -> list[bool]:
    """Which of several comparisons stay significant together, after Holm (1979); those without p never do."""
    order = sorted((p, index) for index, p in enumerate(ps) if p is not None)
    significant = [False] * len(ps)
    for place, (p, index) in enumerate(order):
        if p >= (1.0 - LEVEL) / (len(order) - place):
            break
        significant[index] = True
    return significant


def _standard_error(values: Sequence[float]) -> float:
    return float(np.std(values, ddof=1)) / math.sqrt(len(values))
