"""The reference documents say what the code does; each key, figure, policy and decision is in them, and explained."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from soup_lab.reference.policies import GROUPS, described, options_of
from soup_lab.reference.program import PAGES, main, outdated
from soup_managers.explain import DECISIONS
from soup_msgs_py.scenario import Scenario
from soup_sim.summary import KEYS

REFERENCE = Path(__file__).resolve().parents[2] / "docs" / "reference"


def rows(name: str) -> list[list[str]]:
    """The rows of all tables of a document, without their headers."""
    lines = [line for line in (REFERENCE / name).read_text(encoding="utf-8").splitlines() if line.startswith("| `")]
    return [[cell.strip() for cell in re.split(r" *\| *", line.strip("|").strip())] for line in lines]


def test_the_documents_are_those_that_the_code_gives():
    assert outdated(REFERENCE) == []


def test_a_document_that_differs_is_named_and_only_then_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    assert main([], folder=tmp_path) == 0
    capsys.readouterr()
    assert main(["--check"], folder=tmp_path) == 0
    page = tmp_path / "figures.md"
    page.write_text(page.read_text(encoding="utf-8").replace("seed", "sid"), encoding="utf-8")
    assert main(["--check"], folder=tmp_path) == 1
    assert re.fullmatch(r".*figures\.md: found [^\n]*scripts/make_reference\.py\n", capsys.readouterr().err)
    assert main([], folder=tmp_path) == 0
    assert capsys.readouterr().out == f"wrote {page}\n"
    assert sorted(file.name for file in tmp_path.iterdir()) == sorted(PAGES)


def test_every_key_of_a_scenario_is_there_and_explained():
    parts = Scenario.model_json_schema()["$defs"]
    keys = {key for part in parts.values() if part["title"] != "PolicyChoice" for key in part.get("properties", ())}
    told = rows("scenario.md")
    assert {row[0].strip("`").rpartition(".")[2] for row in told} == (keys | Scenario.model_fields.keys()) - {"kind"}
    assert [row[0] for row in told if not row[-1]] == []


def test_every_figure_of_a_summary_is_there_and_explained():
    told = {row[0].strip("`"): row for row in rows("figures.md")}
    assert told.keys() >= set(KEYS)
    assert all(row[1] and row[3] for row in told.values())


@pytest.mark.parametrize("known", [group[3] for group in GROUPS], ids=[group[0] for group in GROUPS])
def test_every_policy_and_every_option_is_explained(known: dict[str, type]):
    for name, policy in known.items():
        assert described(policy), name
        for option, (allowed, _, meaning) in options_of(policy):
            assert allowed and meaning, f"{name}: {option}"


def test_every_decision_is_there():
    assert {row[0].strip("`") for row in rows("explain.md")} >= DECISIONS.keys()
