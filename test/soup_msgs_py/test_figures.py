"""Figures as a person reads them: words instead of keys, units, no zeros that are none."""

from __future__ import annotations

import pytest

from soup_msgs_py.figures import FIGURES, LIVE_FIGURES, PLAN_FIGURES, rows, told, with_interval, written

ALL = {**FIGURES, **LIVE_FIGURES, **PLAN_FIGURES}


@pytest.mark.parametrize("key", ALL)
def test_every_figure_has_words_and_a_meaning(key: str):
    figure = ALL[key]
    assert figure.words and "_" not in figure.words
    assert figure.meaning


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0, "", "0"),
        (0.0, "words/s", "0"),
        (0.00001, "words/s", "1e-05"),
        (0.123456, "words/s", "0.123"),
        (0.98648, "%", "98.6"),
        (0.0003, "%", "0.03"),
        (1.0, "%", "100"),
        (12345.678, "m", "12,346"),
        (12345, "", "12,345"),
        (None, "%", "not known"),
        ("demo", "", "demo"),
        (True, "", "yes"),
    ],
)
def test_a_value_is_written_in_its_unit(value: object, unit: str, text: str):
    assert written(value, unit) == text


@pytest.mark.parametrize(
    ("mean", "half_width", "text"),
    [
        (0.548312, None, "0.548"),
        (0.548312, 0.0123, "0.548 ± 0.012"),
        (0.548312, 0.00123, "0.5483 ± 0.0012"),
        (-0.548312, 0.123, "-0.55 ± 0.12"),
        (12345.6, 234.5, "12,346 ± 234"),
        (0.548312, 0.0, "0.548 ± 0"),
        (0.548312, 1e-17, "0.548 ± 1e-17"),
    ],
)
def test_a_mean_is_written_as_far_as_it_is_known(mean: float, half_width: float | None, text: str):
    assert with_interval(mean, half_width) == text


def test_only_what_is_zero_reads_as_zero():
    assert all(float(written(10.0**-power, unit)) > 0 for power in range(1, 300) for unit in ("", "%"))


def test_a_seed_is_a_name_and_laws_that_nobody_judged_are_told_so():
    assert told("seed", 123456) == "123456"
    assert told("violations", None) == "not judged"


def test_each_role_has_a_row_of_its_own():
    assert list(rows({"policies": {"word": "served", "bot": "evade"}})) == [
        ("policies", "policy, word", "served", ""),
        ("policies", "policy, bot", "evade", ""),
    ]
