"""`--explain`: every decision is written down with its best alternatives."""

import json
from pathlib import Path

import pytest

from soup_lab.headless.program import main
from soup_managers.explain import DECISIONS
from soup_msgs_py.warehouse.tiles import parse_tile

ROOT = Path(__file__).resolve().parents[2]


def explained(tmp_path: Path, policies: str) -> list[dict]:
    file = tmp_path / "decisions.jsonl"
    arguments = ["--duration", "200", "--policies", str(ROOT / "config/policies" / policies), "--explain", str(file)]
    assert main(arguments) == 0
    return [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()]


def test_each_decision_of_the_best_policies_is_told_with_its_alternatives(tmp_path):
    entries = explained(tmp_path, "best.yaml")
    assert {entry["decision"] for entry in entries} == DECISIONS.keys() - {"trips"}
    assert all(entry.keys() >= set(DECISIONS[entry["decision"]].about) for entry in entries)
    times = [entry["time"] for entry in entries]
    assert times == sorted(times)
    assert all(0.0 <= time <= 200.0 for time in times)
    for entry in entries:
        scores = [alternative["score"] for alternative in entry["alternatives"]]
        assert scores == sorted(scores, reverse=True)


def test_what_was_chosen_is_the_best_where_nothing_stood_in_its_way(tmp_path):
    entries = [entry for entry in explained(tmp_path, "best.yaml") if entry["decision"] in ("words", "bots")]
    assert all(entry["chosen"] == entry["alternatives"][0]["choice"] for entry in entries if entry["alternatives"])


def test_the_trips_of_the_papers_minimal_fleet_are_told_too(tmp_path):
    entries = explained(tmp_path, "minimal.yaml")
    trips = [entry for entry in entries if entry["decision"] == "trips"]
    assert trips and all({*DECISIONS["trips"].about, "chosen"} <= entry.keys() for entry in trips)


def test_words_and_tiles_are_spelt_beside_their_numbers(tmp_path):
    entries = explained(tmp_path, "best.yaml")
    words = [entry for entry in entries if entry["decision"] == "words"]
    letters = [entry for entry in entries if entry["decision"] == "letters"]
    assert words and all(len(entry["name"]) > 1 and entry["name"].isalpha() for entry in words)
    assert all(other["name"].isalpha() for entry in words for other in entry["alternatives"])
    assert letters and all(parse_tile(entry["name"]) == entry["chosen"] for entry in letters)
    bundles = [entry for entry in entries if entry["decision"] == "bundles"]
    assert all(parse_tile(entry["tile_name"]) == entry["tile"] for entry in bundles)


def test_decisions_of_many_runs_go_into_no_one_file(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["--replications", "2", "--explain", str(tmp_path / "decisions.jsonl")])
    assert ended.value.code == 2
    assert "--explain" in capsys.readouterr().err
