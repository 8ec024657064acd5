"""A world that goes on from a checkpoint: new minds take over what they find, the books are whole."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from soup_lab.headless import Headless
from soup_msgs_py.codes import BotState
from soup_msgs_py.messages import Event
from soup_msgs_py.policies import load_policies
from soup_sim.checkpoint import come_to_rest, restore_checkpoint, write_checkpoint
from soup_sim.run_record import RunRecord
from soup_sim.setup import Warehouse, load_warehouse
from soup_sim.world import World

CONFIG = Path(__file__).resolve().parents[2] / "config"
POLICIES = load_policies(CONFIG / "policies/best.yaml", {})
FIRST_S, THEN_S = 60.0, 200.0


@pytest.fixture(scope="module")
def warehouse() -> Warehouse:
    """The demonstration."""
    return load_warehouse(CONFIG / "scenarios/demo.yaml", [f"words={CONFIG / 'words/prose.txt'}"])


def begun(warehouse: Warehouse, folder: Path) -> tuple[World, RunRecord, Path]:
    """A run in the middle, whose process is about to die; what was written since its checkpoint is in its log."""
    world = warehouse.world(1)
    record = RunRecord(world, 1, folder / "summary.json", folder / "events.jsonl")
    run = Headless(world, POLICIES, 1, record.event)
    run.run(FIRST_S)
    file = folder / "world.checkpoint"
    write_checkpoint(file, world, record.capture())
    run.run(FIRST_S + 20.0)
    record.capture()
    return world, record, file


def test_a_run_that_goes_on_has_whole_books_and_breaks_no_law(warehouse: Warehouse, tmp_path: Path):
    _, _, file = begun(warehouse, tmp_path)
    world = warehouse.world(1)
    books = restore_checkpoint(file, world)
    record = RunRecord(world, 1, tmp_path / "summary.json", tmp_path / "events.jsonl", books)
    for said in come_to_rest(world):
        if isinstance(said, Event):
            record.event(said)
    assert world.now == FIRST_S
    assert (world.bots().state == BotState.MOVING).any()
    words = world.statistics(1.0)["words_completed"]
    Headless(world, POLICIES, 1, record.event).run(THEN_S)
    record.poses(world.bots(), world.buckets())
    summary = record.finish(1.0, POLICIES)
    assert summary["words_completed"] > words
    assert summary["violations"] == 0
    assert summary["bot_collisions"] == summary["bucket_collisions"] == 0
    log = [json.loads(line) for line in (tmp_path / "events.jsonl").read_text().splitlines()]
    assert [event["sequence"] for event in log] == list(range(1, len(log) + 1))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["events.jsonl", "summary.json", "world.checkpoint"]


def test_bots_without_a_path_brake(warehouse: Warehouse, tmp_path: Path):
    world = warehouse.world(1)
    minimal = load_policies(CONFIG / "policies/minimal.yaml", {})
    Headless(world, minimal, 1).run(30.0)
    file = tmp_path / "world.checkpoint"
    write_checkpoint(file, world)
    restored = warehouse.world(1)
    assert restore_checkpoint(file, restored) == {}
    assert restored.now == 30.0
    assert (restored.bots().state == BotState.MOVING).any()
    come_to_rest(restored)
    assert not (restored.bots().state == BotState.MOVING).any()
