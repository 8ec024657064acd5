"""A policy that decides what cannot be, or fails in the middle of a run, is told: which, what, how often, or where."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from soup_lab.headless import program as headless_cli

OWN = """\
import numpy as np

from soup_bots.steering.base import Steering
from soup_managers.decisions import BotChoice, BucketChoice, NearestSpot, ServeOn
from soup_managers.policies import LetterPolicy, WordPolicy
from soup_managers.fleets.minimal.policies import FleetPolicy
from soup_managers.fleets.minimal.plans import TripPlan
from soup_msgs_py.messages import AssignBundle, AssignWord

class NoSuchWord(WordPolicy):
    def choose(self, view, stations, rng):
        return AssignWord(999_999, stations[0])

class NoSuchStation(WordPolicy):
    def choose(self, view, stations, rng):
        return AssignWord(next(iter(view.waiting_words)), 77)

class NoRequest(WordPolicy):
    def choose(self, view, stations, rng):
        return 3

class NoSuchTile(LetterPolicy):
    def choose(self, view, stations, target, rng):
        return AssignBundle(stations[0], tile=10_000)

class NoBuckets(BucketChoice):
    def score(self, state, want):
        return np.full(len(want.tiles), np.nan)

class FewBuckets(BucketChoice):
    def score(self, state, want):
        return [1.0]

class NoBots(BotChoice):
    def match(self, state, bots, places):
        return []

    def cost(self, state, bots, place):
        return bots

class NoSpot(NearestSpot):
    def cost(self, state, bucket, spots, travel_s):
        return super().cost(state, bucket, spots, travel_s) * np.nan

class NoOnward(ServeOn):
    def score(self, state, robot):
        return super().score(state, robot) * np.nan

class NoVelocity(Steering):
    def steer_one(self, me, neighbours, limits):
        return float("nan"), 0.0

class Failing(WordPolicy):
    def choose(self, view, stations, rng):
        return stations[1000]

class Leaving(WordPolicy):
    def choose(self, view, stations, rng):
        raise SystemExit(7)

class FailingSteering(Steering):
    def steer_one(self, me, neighbours, limits):
        return 1.0 / 0.0, 0.0

class NoTrip(FleetPolicy):
    def plan(self, fleet):
        yield TripPlan(999, 0, (), 0)
"""


@pytest.fixture
def own(tmp_path: Path) -> Path:
    file = tmp_path / "own.py"
    file.write_text(OWN)
    return file


def run(own: Path, capsys: pytest.CaptureFixture[str], *policies: str) -> tuple[int, str, dict[str, int]]:
    """Exit status, what stderr says, and the mistakes in the summary of a short run."""
    summary = own.with_name("summary.json")
    options = [word.replace("OWN", str(own)) for word in policies]
    status = headless_cli.main([*options, "--duration", "300", "--set", "bots=6", "--summary", str(summary)])
    figures = json.loads(summary.read_text("utf-8")) if summary.exists() else {}
    assert figures.get("violations", 0) == 0
    return status, capsys.readouterr().err, figures.get("policy_mistakes", {})


def of_fleet(own: Path, decision: str, name: str) -> list[str]:
    file = own.with_name("policies.yaml")
    fleet = f"{{name: coordinated, options: {{{decision}: 'own.py:{name}'}}}}"
    file.write_text(f"{{word: served, letter: ahead, bot: straight, fleet: {fleet}}}")
    return ["--policies", str(file)]


MINIMAL = ["--policies", "config/policies/minimal.yaml"]


@pytest.mark.parametrize(
    ("policies", "mistake"),
    [
        (["--word-policy", "OWN:NoSuchWord"], "word policy NoSuchWord chose a word that does not wait"),
        (["--word-policy", "OWN:NoSuchStation"], "word policy NoSuchStation chose a station without a free place"),
        (["--word-policy", "OWN:NoRequest"], "word policy NoRequest chose what is no request to the world"),
        (["--letter-policy", "OWN:NoSuchTile"], "letter policy NoSuchTile chose a kind of tile that there is not"),
        ("buckets NoBuckets", "buckets policy NoBuckets chose scores that are no numbers"),
        ("buckets FewBuckets", "buckets policy FewBuckets chose scores for other things than it was asked for"),
        ("bots NoBots", "bots policy NoBots chose scores for other things than it was asked for"),
        ("storage NoSpot", "storage policy NoSpot chose scores that are no numbers"),
        ("onward NoOnward", "onward policy NoOnward chose scores that are no numbers"),
        ([*MINIMAL, "--bot-policy", "OWN:NoVelocity"], "bot policy NoVelocity chose a velocity that is no number"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_choice_that_cannot_be_is_counted_and_told(
    own: Path,
    capsys: pytest.CaptureFixture[str],
    policies: list[str] | str,
    mistake: str,
    monkeypatch: pytest.MonkeyPatch,
):
    monkeypatch.chdir(Path(__file__).parents[2])
    options = of_fleet(own, *policies.split()) if isinstance(policies, str) else policies
    status, error, mistakes = run(own, capsys, *options)
    assert status == 0
    assert set(mistakes) == {mistake} and mistakes[mistake] > 1
    assert f"\n{mistake}: {mistakes[mistake]} times\n" in error


def test_mistakes_of_all_replications_are_added_up(own: Path, capsys: pytest.CaptureFixture[str]):
    mistake = "word policy NoSuchWord chose a word that does not wait"
    one = run(own, capsys, "--word-policy", "OWN:NoSuchWord")[2][mistake]
    both = run(own, capsys, "--word-policy", "OWN:NoSuchWord", "--replications", "2", "--processes", "1")[2][mistake]
    assert both == 2 * one


@pytest.mark.parametrize(
    ("policies", "said"),
    [
        (["--word-policy", "OWN:Failing"], "IndexError: list index out of range (OWN, line 55)"),
        (["--word-policy", "OWN:Leaving"], "SystemExit: 7 (OWN, line 59)"),
        ([*MINIMAL, "--bot-policy", "OWN:FailingSteering"], "ZeroDivisionError: float division by zero (OWN, line 63)"),
        (["--word-policy", "OWN:Failing", "--replications", "2", "--processes", "1"], "IndexError: list index out"),
        (["--fleet-policy", "OWN:NoTrip"], "fleet policy NoTrip planned a trip that cannot be: bot 999 is not idle"),
    ],
)
def test_a_policy_that_fails_in_a_run_is_told_in_one_line_with_its_place(
    own: Path, capsys: pytest.CaptureFixture[str], policies: list[str], said: str, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(Path(__file__).parents[2])
    status, error, _ = run(own, capsys, *policies)
    assert status == 1
    _, line, nothing = error.split("\n")  # after the line about the words
    assert said.replace("OWN", str(own)) in line and nothing == ""
