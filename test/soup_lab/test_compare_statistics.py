"""Intervals and paired differences, against scipy and against figures worked out by hand."""

from __future__ import annotations

import math
import statistics

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from soup_lab.experiments.statistics import estimate, holm, paired_difference
from soup_lab.headless.runs import combine

RATES = st.floats(0.0, 10.0).map(lambda rate: round(rate, 6))
PAIRS = st.lists(st.tuples(RATES, RATES), min_size=2, max_size=12)


def test_the_interval_of_three_runs_worked_out_by_hand():
    found = estimate([1.0, 2.0, 3.0])
    assert (found.mean, found.lowest, found.highest, found.runs) == (2.0, 1.0, 3.0, 3)
    assert found.half_width == pytest.approx(4.302653 * 1.0 / math.sqrt(3), rel=1e-6)  # t(0.975; 2) s / sqrt n


def test_one_run_has_no_interval():
    found = paired_difference([0.5], [0.4])
    assert found.estimate.half_width is None
    assert found.p is None
    assert not found.significant


def test_a_paired_difference_worked_out_by_hand():
    found = paired_difference([0.52, 0.61, 0.43], [0.50, 0.57, 0.40])  # differences 0.02, 0.04, 0.03: s = 0.01
    assert found.estimate.mean == pytest.approx(0.03)
    assert found.estimate.half_width == pytest.approx(4.302653 * 0.01 / math.sqrt(3), rel=1e-6)
    assert found.share == pytest.approx(0.03 / 0.49)
    assert found.significant


def test_pairing_sees_what_the_noise_of_the_seeds_hides():
    base, other = [0.30, 0.50, 0.70, 0.90], [0.31, 0.51, 0.71, 0.92]
    assert paired_difference(other, base).significant
    assert stats.ttest_ind(other, base).pvalue > 0.9


@given(PAIRS)
def test_figures_agree_with_scipy(pairs: list[tuple[float, float]]):
    values, base = [list(column) for column in zip(*pairs, strict=True)]
    found = paired_difference(values, base)
    differences = [a - b for a, b in pairs]
    spread = statistics.stdev(differences)
    assert found.estimate.mean == pytest.approx(sum(differences) / len(pairs), abs=1e-12)
    if spread > 1e-9:
        test = stats.ttest_rel(values, base)
        low, high = test.confidence_interval(0.95)
        assert found.estimate.half_width == pytest.approx((high - low) / 2, rel=1e-6)
        assert found.p == pytest.approx(test.pvalue, rel=1e-6, abs=1e-12)
        if min(abs(low), abs(high)) > 1e-9:
            assert found.significant == (low > 0 or high < 0)


def test_runs_that_are_all_alike_do_not_differ():
    found = paired_difference([0.4, 0.5], [0.4, 0.5])
    assert (found.estimate.mean, found.estimate.half_width, found.p) == (0.0, 0.0, 1.0)
    assert not found.significant


def test_the_same_difference_with_every_seed_is_significant():
    assert paired_difference([1.0, 2.0], [0.5, 1.5]).p == 0.0


def test_no_share_of_a_base_that_builds_nothing():
    assert paired_difference([0.4, 0.5], [0.0, 0.0]).share is None


def test_comparisons_taken_together_ask_for_more():
    # 0.05 / 4, / 3, / 2: the third is too large, and so the fourth does not count either
    assert holm([0.04, 0.01, 0.016, 0.03]) == [False, True, True, False]
    assert holm([0.04]) == [True]
    assert holm([None, 0.04, None]) == [False, True, False]
    assert holm([]) == []


def test_a_figure_that_some_runs_lack_is_the_mean_of_the_others():
    alike = {"violations": 0, "stalled_since_s": None}
    runs = [{"seed": 1, "age": 2.0, **alike}, {"seed": 2, "age": None, **alike}]
    assert combine(runs)["age"] == 2.0
    assert combine([runs[1] | {"seed": 1}, runs[1]])["age"] is None
