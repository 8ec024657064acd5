"""What a person gets wrong in a policy or its options is told in one line, exit status 2, before anything starts."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Any

import pytest

from soup_lab.headless import program as headless_cli
from soup_lab.headless.simulation import make_minds
from soup_msgs_py.blame import MOVED
from soup_msgs_py.errors import InputError
from soup_msgs_py.policies import Policies, load_policies
from soup_msgs_py.reading.yaml_input import validate

NAN = float("nan")
OWN = """\
from soup_managers.policies.word import Minimal

class Own(Minimal):
    def __init__(self, count: int, pair: tuple[float, float] = (0.0, 1.0), *, _quiet: "Nowhere" = 1, **more):
        given.append((count, pair, more))

class Failing(Minimal):
    def __init__(self):
        raise KeyError("boo")

class Leaving(Minimal):
    def __init__(self):
        raise SystemExit(7)

given = []
"""


def line_of(role: str, name: str, **options: Any) -> str:
    """What is said of a policy."""
    with pytest.raises(InputError) as caught:
        make_minds(validate(Policies, {role: {"name": name, "options": options}}, "policies.yaml"))
    assert "\n" not in str(caught.value)
    return str(caught.value)


def decision(**options: Any) -> dict[str, Any]:
    return {"buckets": {"name": "most_tiles_per_second", "options": options}}


@pytest.mark.parametrize(
    ("role", "name", "options", "said"),
    [
        (
            "fleet",
            "coordinated",
            decision(travel_weight="x"),
            "options.travel_weight: found 'x'; allowed: a valid number",
        ),
        ("fleet", "coordinated", decision(travel_weight=NAN), "options.travel_weight: found nan; allowed: a finite"),
        (
            "fleet",
            "coordinated",
            decision(travel_weight=[1]),
            "options.travel_weight: found [1]; allowed: a valid number",
        ),
        ("fleet", "coordinated", decision(weight=1), "options.weight: found an unknown key; allowed: late_weight"),
        (
            "fleet",
            "coordinated",
            {"horizons": {"least_room": "abc"}},
            "horizons.least_room: found 'abc'; allowed: a valid",
        ),
        ("fleet", "coordinated", {"horizons": {"least": 1}}, "horizons.least: found an unknown key"),
        ("fleet", "coordinated", {"horizons": [1]}, "coordinated.options.horizons: found [1]"),
        ("fleet", "coordinated", {"buckets": ""}, "buckets policy: name: found ''; allowed: at least 1 character"),
        ("fleet", "coordinated", {"buckets": {"nam": "x"}}, "buckets policy: name: found nothing"),
        ("fleet", "coordinated", {"buckets": 3}, "coordinated.options.buckets: found 3"),
        ("fleet", "planned", {"tries": 0}, "planned.options.tries: found 0; allowed: greater than or equal to 1"),
        ("fleet", "planned", {"planner": "x"}, "planned.options.planner: found 'x'; allowed: auto, "),
        ("letter", "minimal", {"station": "x"}, "options.station: found 'x'; allowed: emptiest, alike, random"),
        ("bot", "evade", {"patience_s": -1}, "evade.options.patience_s: found -1; allowed: greater than 0"),
        ("word", "minimal", {"a": 1}, "minimal.options.a: found an unknown key; allowed: none"),
        ("word", "soup_managers.policies.word:WordPolicy", {}, "a class that implements choose"),
        ("fleet", "soup_managers.fleets.minimal.policies:FleetPolicy", {}, "a class that implements plan"),
        ("fleet", "soup_managers.fleets.minimal.policies:AnyFleet", {}, "a class that extends AnyFleet"),
        ("bot", "soup_bots.steering.base:Steering", {}, "a class that extends Steering"),
        ("word", ":Own", {}, "Empty module name"),
        ("word", "a\0b.py:Own", {}, "a zero byte in its name"),
    ],
)
def test_a_wrong_option_is_told_in_one_line(role: str, name: str, options: dict[str, Any], said: str):
    assert said in line_of(role, name, **options)


@pytest.mark.parametrize("old", MOVED)
def test_a_module_that_has_moved_is_told_with_its_new_name(tmp_path: Path, old: str):
    file = tmp_path / "own.py"
    file.write_text(f"import {old}\n")
    assert f"it is {MOVED[old]} now" in line_of("word", f"{file}:Own")
    for new in MOVED[old].split(" and "):
        importlib.import_module(new)


def test_a_name_that_is_empty_is_told_wherever_it_is_given():
    assert line_of("word", "") == "policies.yaml: word.name: found ''; allowed: at least 1 character"
    with pytest.raises(InputError, match="--word-policy: name: found ''"):
        load_policies(None, {"word": ""})


@pytest.fixture
def own(tmp_path: Path) -> Path:
    file = tmp_path / "own.py"
    file.write_text(OWN)
    return file


def test_options_come_as_the_constructor_has_them(own: Path):
    choice = {"name": f"{own}:Own", "options": {"count": 3, "pair": [1, 2.5], "else": "x"}}
    minds = make_minds(validate(Policies, {"word": choice}, "policies.yaml"))
    # an annotation that names nothing leaves every option as it was written
    assert vars(sys.modules[type(minds.word).__module__])["given"] == [(3, [1, 2.5], {"else": "x"})]
    own.write_text(OWN.replace("Nowhere", "int"))
    minds = make_minds(validate(Policies, {"word": choice}, "policies.yaml"))
    assert vars(sys.modules[type(minds.word).__module__])["given"] == [(3, (1.0, 2.5), {"else": "x"})]
    assert "options.count: found 'x'; allowed: a valid integer" in line_of("word", f"{own}:Own", count="x")
    assert "options.count: found nothing" in line_of("word", f"{own}:Own")


@pytest.mark.parametrize(
    ("name", "said"), [("Failing", "KeyError: 'boo' (FILE, line 9)"), ("Leaving", "SystemExit: 7 (FILE, line 13)")]
)
def test_a_constructor_that_fails_is_told_with_file_and_line(own: Path, name: str, said: str):
    assert f"own.py:{name}: found {said.replace('FILE', str(own))}; allowed: " in line_of("word", f"{own}:{name}")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("import sys\nsys.exit(7)\n", "SystemExit: 7 (FILE, line 2)"),
        ("x = 1\n\nx / 0\n", "ZeroDivisionError: division by zero (FILE, line 3)"),
        ("import json\njson.loads('')\n", "JSONDecodeError: Expecting value: line 1 column 1 (char 0) (FILE, line 2)"),
        ("x = (\n", "(FILE, line 1)"),
        ("import nowhere\n", "ModuleNotFoundError: No module named 'nowhere' (FILE, line 1)"),
    ],
)
def test_a_module_that_fails_ends_the_program_with_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, said: str
):
    file = tmp_path / "own.py"
    file.write_text(text)
    assert headless_cli.main(["--word-policy", f"{file}:Own", "--duration", "1"]) == 2
    error = capsys.readouterr().err
    assert said.replace("FILE", str(file)) in error
    assert error.startswith(f"word policy: {file}: found ") and error.count("\n") == 1


@pytest.mark.parametrize("argument", ["--set=--", "--scenario=--", "--duration=--", "--word-policy=--", "--summary=--"])
def test_a_value_of_two_dashes_is_told(capsys: pytest.CaptureFixture[str], argument: str):
    with pytest.raises(SystemExit, match="2"):
        headless_cli.main([argument])
    assert f"{argument[:-3]}: found '--'; allowed: a value\n" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--summary", "x" * 5000], "--summary: found a name of 5,000 bytes"),
        (["--duration", "1e300"], "allowed: a number above 0, up to 1e+09"),
        (["--set", ".".join("x" * 30) + "=1"], "found 30 dotted parts; allowed: at most 20"),
        (["--scenario", "x" * 5000], "found File name too long"),
    ],
)
def test_no_argument_is_too_long_or_too_large_for_one_line(
    capsys: pytest.CaptureFixture[str], arguments: list[str], said: str
):
    try:
        status = headless_cli.main(arguments)
    except SystemExit as end:
        status = end.code
    error = capsys.readouterr().err
    assert status == 2 and said in error and error.count("\n") == 1 and len(error) < 1200
