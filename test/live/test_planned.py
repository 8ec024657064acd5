"""A plan of the 2023 paper on the live fleet: every bot a node, all boxes shelved, nobody collides."""

from __future__ import annotations

import json

import pytest

import _environment
from soup_msgs_py.warehouse.cell_world import PITCH_M, read_world

from .conftest import Parts

pytestmark = [pytest.mark.live, pytest.mark.timeout(600)]
WORLD = _environment.ROOT / "config" / "worlds" / "medium1.txt"


def test_all_boxes_are_shelved(parts: Parts):
    status, _, err = parts.run(
        "run_warehouse.py", "--scenario", str(WORLD), "--no-dashboard", "--speed", "5", "--duration", "60",
        "--summary", "out.json", "--event-log", "events.jsonl",
    )  # fmt: skip
    assert status == 0, err
    summary = json.loads((parts.folder / "out.json").read_text())
    assert summary["grabs"] == summary["releases"] == 4
    assert summary["bot_collisions"] == summary["bucket_collisions"] == summary["violations"] == 0
    assert summary["policies"]["fleet"] == "planned"
    world = read_world(WORLD)
    log = [json.loads(line) for line in (parts.folder / "events.jsonl").read_text().splitlines()]
    ends = {event["bucket"]: event for event in log if event["type"] == "released"}
    # the cell whose middle is nearest: the first row of cells lies on top, one cell from the floor's edge
    cells = {
        bucket: round(event["x"] / PITCH_M) - 1 + (world.height + 1 - round(event["y"] / PITCH_M)) * world.width
        for bucket, event in ends.items()
    }
    assert len(set(cells.values())) == len(world.boxes)
    assert set(cells.values()) <= set(world.shelves)
