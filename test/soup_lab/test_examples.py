"""Each example works as its first lines say, in one process and at once; those for a live warehouse: test_readme.py."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import pytest

from soup_lab.headless import program as headless_cli

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("[!_]*.py"))
COMMANDS = [
    (path.name, line)
    for path in EXAMPLES
    for line in re.findall(r"^python3 scripts/run_headless\.py (.*)$", path.read_text("utf-8"), re.MULTILINE)
]


LIVE = {
    path.name: re.findall(rf"^python3 examples/{path.name}.*$", path.read_text("utf-8"), re.MULTILINE)
    for path in EXAMPLES
}


def test_every_example_says_how_it_is_run():
    assert {name for name, _ in COMMANDS} | {name for name, lines in LIVE.items() if lines} == LIVE.keys()


def test_examples_for_a_live_warehouse_stand_where_they_are_tried():
    tried = (ROOT / "docs/examples.md").read_text("utf-8").splitlines()
    assert not [line for lines in LIVE.values() for line in lines if line not in tried]


@pytest.mark.parametrize(("name", "line"), COMMANDS)
def test_an_example_assembles_words(name, line, tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    summary = tmp_path / "summary.json"
    assert headless_cli.main([*shlex.split(line), "--duration", "300", "--seed", "1", "--summary", str(summary)]) == 0
    figures = json.loads(summary.read_text("utf-8"))
    assert figures["words_completed"] > 0
    assert figures["violations"] == 0
