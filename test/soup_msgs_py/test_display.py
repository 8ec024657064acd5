"""A screen that fails ends the showing, and nothing else."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from typing import TextIO

import pytest
from rich.console import Console

from soup_msgs_py.command_line.display import on_display


@on_display
def program() -> int:
    """Shows more than fits into any buffer, and comes to its end."""
    for _ in range(1000):
        print("a line " * 20)
    Console().print("a table")
    return 7


@pytest.fixture(params=["closed pipe", "full disk"])
def broken(request: pytest.FixtureRequest) -> Iterator[TextIO]:
    """A screen that takes nothing."""
    if request.param == "full disk":
        with open("/dev/full", "w") as screen:
            yield screen
    else:
        reader, writer = os.pipe()
        os.close(reader)
        with os.fdopen(writer, "w") as screen:
            yield screen


def test_a_program_comes_to_its_end_without_its_screen(broken: TextIO, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(sys, "stdout", broken)
    assert program() == 7
    assert sys.stdout is broken


def test_a_program_comes_to_its_end_without_anything_to_speak_through(broken: TextIO, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(sys, "stdout", broken)
    monkeypatch.setattr(sys, "stderr", broken)
    assert program() == 7


def test_a_full_disk_is_told_once(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    with open("/dev/full", "w") as screen:
        monkeypatch.setattr(sys, "stdout", screen)
        program()
    assert capsys.readouterr().err == "stdout: No space left on device; the run goes on without it\n"


def test_letters_that_a_screen_does_not_have_are_no_end(monkeypatch: pytest.MonkeyPatch, tmp_path):
    with open(tmp_path / "screen", "w", encoding="ascii") as screen:
        monkeypatch.setattr(sys, "stdout", screen)
        on_display(lambda: print("30 s · words 3"))()
    assert (tmp_path / "screen").read_text() == "30 s ? words 3\n"
