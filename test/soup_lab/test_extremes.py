"""Warehouses at the edge of what is allowed: refused before they are built, or run; figures are finite or none."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, NoReturn

import pytest

from soup_lab.headless import program as headless_cli
from soup_lab.headless.runs import combine
from soup_msgs_py.errors import InputError
from soup_sim.scenario_loader import load_warehouse
from soup_sim.summary import write_summary

DEMO = Path(__file__).parents[2] / "config/scenarios/demo.yaml"


def refuse(constant: str) -> NoReturn:
    raise AssertionError(f"{constant} is no JSON")


@pytest.mark.parametrize(
    "changes",
    [
        ["word_station.transfer_s=0", "letter_station.transfer_s=0", "bot.grab_s=0", "bot.release_s=0"],
        ["bot.grab_s=50"],
        ["bot.max_speed_mps=0.01"],
        ["bot.max_speed_mps=50", "bot.max_acceleration_mps2=1000", "bot.radius_m=0.05"],
        ["bucket.capacity=10000"],
        ["colours={kind: uniform, count: 10000}"],
        ["orders={kind: poisson, per_hour: 360000}"],
    ],
    ids=lambda changes: changes[0],
)
def test_an_extreme_warehouse_runs_and_its_summary_is_json(changes: list[str], tmp_path: Path):
    summary = tmp_path / "summary.json"
    options = [word for change in changes for word in ("--set", change)]
    assert headless_cli.main([*options, "--duration", "20", "--summary", str(summary)]) == 0
    figures = json.loads(summary.read_text("utf-8"), parse_constant=refuse)
    endless = changes[0] == "word_station.transfer_s=0"
    assert (figures["word_rate_bound"] is None) == endless == (figures["fraction_of_bound"] is None)


def test_a_mean_over_runs_without_a_bound_has_none():
    runs: list[dict[str, Any]] = [
        {"seed": seed, "stalled_since_s": None, "bound": None, "rate": rate, "violations": 0}
        for seed, rate in ((1, 2.0), (2, 4.0))
    ]
    mean = combine(runs)
    assert (mean["bound"], mean["rate"], set(mean["interval_95"])) == (None, 3.0, {"rate"})


def test_a_summary_is_json_whatever_is_in_it(tmp_path: Path):
    write_summary(tmp_path / "summary.json", {"a": math.inf, "b": {"c": [math.nan, 1.5, (-math.inf,)]}})
    read = json.loads((tmp_path / "summary.json").read_text("utf-8"), parse_constant=refuse)
    assert read == {"a": None, "b": {"c": [None, 1.5, [None]]}}


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (["floor.width_m=20000"], "floor: found 20000 by 30 m with 266,660 waypoints; allowed: at most 100,000"),
        (
            ["buckets=1000", "colours={kind: uniform, count: 10000}"],
            "colours: found 260,000 kinds of tiles in 1,000 buckets",
        ),
        (["buckets=1000", "bucket.capacity=10000"], "bucket.capacity: found 1,000 buckets of 10,000 tiles"),
    ],
    ids=lambda value: value[-1] if isinstance(value, list) else "",
)
def test_what_is_too_large_is_refused_before_it_is_built(changes: list[str], said: str):
    with pytest.raises(InputError) as caught:
        load_warehouse(DEMO, changes)
    assert said in str(caught.value)


def test_a_drawn_floor_may_not_be_too_large_either(tmp_path: Path):
    drawn = tmp_path / "floor.txt"
    drawn.write_text(f"L{'.' * 998}W\n" * 101)
    with pytest.raises(InputError, match="a map of 101,000 waypoints; allowed: at most 100,000"):
        load_warehouse(DEMO, [f"layout={{kind: map, path: {drawn}}}"])
    world = tmp_path / "world.txt"
    world.write_text(f"@*|{'_' * 997}\n" + f"{'_' * 1000}\n" * 100)
    with pytest.raises(InputError, match="a world of 101,000 waypoints; allowed: at most 100,000"):
        load_warehouse(world)
