"""What cannot be written or shown costs one line: the run, and all that can be written, is there."""

from __future__ import annotations

import errno
import io
import json
import os
import sys
from pathlib import Path

import pytest
from rich.console import Console

from soup_lab.experiments.store import Store
from soup_lab.headless import program as headless_cli
from soup_lab.launch.warehouse_node import Progress
from soup_lab.planning import program as plan_cli

ROOT = Path(__file__).resolve().parents[2]
RUN = ["--duration", "20", "--set", "bots=2"]
WORLD = str(ROOT / "config/worlds/small1-1r.txt")


def test_a_summary_is_there_though_nobody_reads_the_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    files = [tmp_path / name for name in ("summary.json", "events.jsonl", "choices.jsonl", "plan.json", "plan.png")]
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "w") as closed:
        monkeypatch.setattr(sys, "stdout", closed)
        summary, events, choices, plan, picture = map(str, files)
        assert headless_cli.main([*RUN, "--summary", summary, "--event-log", events, "--explain", choices]) == 0
        assert plan_cli.main([WORLD, "--summary", plan, "--picture", picture, "--show"]) == 0
    assert json.loads(files[0].read_text())["sim_seconds"] == 20.0
    assert sorted(tmp_path.iterdir()) == sorted(files)


def test_a_run_whose_files_find_no_room_shows_its_table_and_says_what_is_missing(capsys: pytest.CaptureFixture[str]):
    full = ["--summary", "/dev/full", "--event-log", "/dev/full", "--explain", "/dev/full"]
    assert headless_cli.main([*RUN, *full]) == 1
    shown = capsys.readouterr()
    assert "words completed" in shown.out
    assert shown.err.count("/dev/full: No space left on device\n") == 2
    assert shown.err.count("/dev/full: could not be written: No space left on device\n") == 1
    assert "Traceback" not in shown.err


@pytest.mark.parametrize("option", ["--summary", "--event-log", "--explain"])
@pytest.mark.parametrize("path", ["n" * 256, "a/" * 3000 + "b"])
def test_names_that_no_file_can_have_are_refused_in_one_line(
    option: str, path: str, capsys: pytest.CaptureFixture[str]
):
    with pytest.raises(SystemExit) as ended:
        headless_cli.main([*RUN, option, path])
    line = capsys.readouterr().err
    assert ended.value.code == 2
    assert option in line and line.count("\n") == 1 and len(line) < 300


def test_results_of_a_sweep_that_find_no_room_are_written_with_the_next_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    told: list[str] = []
    sync = os.fsync

    def full(file: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with Store(tmp_path, told.append) as store:
        monkeypatch.setattr(os, "fsync", full)
        for run in ("a", "b"):
            store.add(run, "label", {"seed": 1})
        assert (tmp_path / "results.jsonl").read_text() == ""
        monkeypatch.setattr(os, "fsync", sync)
        store.add("c", "label", {"seed": 1})
    assert told == [f"{tmp_path}/results.jsonl: No space left on device; tried again with the next result"]
    with Store(tmp_path) as again:
        assert len(again) == 3


def test_what_the_parts_of_a_live_run_have_to_say_is_shown_once():
    screen = io.StringIO()
    progress = Progress(Console(file=screen, width=200), 60.0, 1.0)
    for _ in range(3):
        progress.tell_new({"world": {"told": "world.checkpoint: could not be written"}, "dashboard": {}})
    progress.close()
    assert screen.getvalue() == "world: world.checkpoint: could not be written\n"
