"""A world that goes on from a checkpoint: new minds take over what they find, the books are whole."""

from __future__ import annotations

import errno
import json
import os
from pathlib import Path

import pytest

from soup_lab.headless.simulation import Headless
from soup_msgs_py.codes import BotState
from soup_msgs_py.errors import InputError
from soup_msgs_py.messages import Event
from soup_msgs_py.policies import load_policies
from soup_sim.checkpoint import (
    apply_checkpoint,
    come_to_rest,
    make_checkpoint,
    restore_checkpoint,
    write_checkpoint,
)
from soup_sim.checkpoint_state import Books
from soup_sim.run_recorder import RunRecorder
from soup_sim.scenario_loader import Warehouse, load_warehouse
from soup_sim.world import World

CONFIG = Path(__file__).resolve().parents[2] / "config"
POLICIES = load_policies(CONFIG / "policies/best.yaml", {})
FIRST_S, THEN_S = 60.0, 200.0


@pytest.fixture(scope="module")
def warehouse() -> Warehouse:
    """The demonstration."""
    return load_warehouse(CONFIG / "scenarios/demo.yaml", [f"words={CONFIG / 'words/prose.txt'}"])


def begun(warehouse: Warehouse, folder: Path) -> tuple[Headless, RunRecorder, Path]:
    """A run in the middle; what was written since its checkpoint is in its log, and no file is open after its end."""
    world = warehouse.world(1)
    record = RunRecorder(world, 1, folder / "summary.json", folder / "events.jsonl")
    run = Headless(world, POLICIES, 1, record.event)
    run.run(FIRST_S)
    file = folder / "world.checkpoint"
    write_checkpoint(file, world, record.capture())
    run.run(FIRST_S + 20.0)
    record.capture()
    return run, record, file


def go_on(warehouse: Warehouse, checkpoint: Path, log: Path) -> tuple[World, RunRecorder]:
    """Another process that goes on from a checkpoint."""
    world = warehouse.world(1)
    books = restore_checkpoint(checkpoint, world)
    record = RunRecorder(world, 1, log.with_name("summary.json"), log, books)
    for said in come_to_rest(world):
        if isinstance(said, Event):
            record.event(said)
    return world, record


def sequences(log: Path) -> list[int]:
    """The numbers of the events in a log."""
    return [json.loads(line)["sequence"] for line in log.read_text().splitlines()]


def test_a_run_that_goes_on_has_whole_books_and_breaks_no_law(warehouse: Warehouse, tmp_path: Path):
    _, killed, file = begun(warehouse, tmp_path)
    killed.close()
    world, record = go_on(warehouse, file, tmp_path / "events.jsonl")
    assert world.now == FIRST_S
    assert (world.bots().state == BotState.MOVING).any()
    words = world.statistics(1.0)["words_completed"]
    Headless(world, POLICIES, 1, record.event).run(THEN_S)
    record.poses(world.bots(), world.buckets())
    summary = record.finish(1.0, POLICIES)
    assert summary["words_completed"] > words
    assert summary["violations"] == 0
    assert summary["bot_collisions"] == summary["bucket_collisions"] == 0
    numbers = sequences(tmp_path / "events.jsonl")
    assert numbers == list(range(1, len(numbers) + 1))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["events.jsonl", "summary.json", "world.checkpoint"]


def test_a_run_that_goes_on_takes_nothing_from_one_that_still_runs(warehouse: Warehouse, tmp_path: Path):
    run, record, file = begun(warehouse, tmp_path)
    with pytest.raises(InputError, match="another run writes"):
        go_on(warehouse, file, tmp_path / "events.jsonl")
    copy = tmp_path / "copy"
    copy.mkdir()
    world, other = go_on(warehouse, file, copy / "events.jsonl")
    Headless(world, POLICIES, 1, other.event).run(THEN_S)
    other.finish(1.0, POLICIES)
    run.run(THEN_S)
    record.finish(1.0, POLICIES)
    numbers = sequences(tmp_path / "events.jsonl")
    assert numbers == list(range(1, len(numbers) + 1))
    later = sequences(copy / "events.jsonl")
    assert later == list(range(later[0], later[0] + len(later))) and later[0] > 1


def test_a_run_and_its_summary_go_on_without_a_log_that_fails(
    warehouse: Warehouse, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    told: list[str] = []
    world = warehouse.world(1)
    record = RunRecorder(world, 1, tmp_path / "summary.json", tmp_path / "events.jsonl", tell=told.append)
    run = Headless(world, POLICIES, 1, record.event)
    run.run(FIRST_S)
    written = record.capture().log
    write = os.write

    def full(file: int, data: bytes) -> int:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "write", full)
    run.run(FIRST_S + 20.0)
    checkpoint = make_checkpoint(world, record.capture())
    monkeypatch.setattr(os, "write", write)
    run.run(THEN_S)
    assert record.finish(1.0, POLICIES)["violations"] == 0
    assert json.loads((tmp_path / "summary.json").read_text())["words_completed"] > 0
    half = tmp_path / "events.jsonl.incomplete"
    assert written is not None and written.size == half.stat().st_size > 0
    assert not (tmp_path / "events.jsonl").exists()
    assert len(told) == 1 and "No space left on device" in told[0]
    # nor does a run that goes on from there hide the gap
    books = apply_checkpoint(checkpoint, warehouse.world(1), "checkpoint")
    again = RunRecorder(world, 1, None, tmp_path / "events.jsonl", books, told.append)
    again.close()
    assert written.size == half.stat().st_size
    assert "has ended before" in told[-1]


def test_a_summary_that_cannot_be_written_is_told_and_the_log_is_whole(warehouse: Warehouse, tmp_path: Path):
    told: list[str] = []
    world = warehouse.world(1)
    record = RunRecorder(world, 1, Path("/dev/full"), tmp_path / "events.jsonl", tell=told.append)
    Headless(world, POLICIES, 1, record.event).run(FIRST_S)
    assert record.finish(1.0, POLICIES)["sim_seconds"] == FIRST_S
    assert not record.is_written
    assert told == ["/dev/full: could not be written: No space left on device"]
    assert sequences(tmp_path / "events.jsonl")


def test_bots_without_a_path_brake(warehouse: Warehouse, tmp_path: Path):
    world = warehouse.world(1)
    minimal = load_policies(CONFIG / "policies/minimal.yaml", {})
    Headless(world, minimal, 1).run(30.0)
    file = tmp_path / "world.checkpoint"
    write_checkpoint(file, world)
    restored = warehouse.world(1)
    assert restore_checkpoint(file, restored) == Books()
    assert restored.now == 30.0
    assert (restored.bots().state == BotState.MOVING).any()
    come_to_rest(restored)
    assert not (restored.bots().state == BotState.MOVING).any()
