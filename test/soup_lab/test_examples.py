"""Each example works as its first lines say, in one process and at once."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import pytest

from soup_lab.headless import program as headless_cli

ROOT = Path(__file__).resolve().parents[2]
COMMANDS = [
    (path.name, line)
    for path in sorted((ROOT / "examples").glob("*.py"))
    for line in re.findall(r"^python3 scripts/run_headless\.py (.*)$", path.read_text("utf-8"), re.MULTILINE)
]


def test_every_example_says_how_it_is_run():
    assert {name for name, _ in COMMANDS} == {path.name for path in (ROOT / "examples").glob("*.py")}


@pytest.mark.parametrize(("name", "line"), COMMANDS)
def test_an_example_assembles_words(name, line, tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    summary = tmp_path / "summary.json"
    assert headless_cli.main([*shlex.split(line), "--duration", "300", "--seed", "1", "--summary", str(summary)]) == 0
    figures = json.loads(summary.read_text("utf-8"))
    assert figures["words_completed"] > 0
    assert figures["violations"] == 0
