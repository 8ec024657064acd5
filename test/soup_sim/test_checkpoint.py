"""A checkpoint is believed only if it is whole and possible; whatever else there is, is told in one line."""

from __future__ import annotations

import hashlib
import json
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from soup_msgs_py.errors import InputError
from soup_msgs_py.messages import FollowPath, Grab, SetVelocity
from soup_sim import checkpoint
from soup_sim.checkpoint import apply_checkpoint, hold_folder, make_checkpoint, place_for, restore_checkpoint
from soup_sim.scenario_loader import Warehouse, load_warehouse
from soup_sim.world import World

DEMO = Path(__file__).parents[2] / "config/scenarios/demo.yaml"
HEAD = b"alphabet-soup checkpoint 3\n"
WAREHOUSE = load_warehouse(DEMO)


def busy_world(warehouse: Warehouse = WAREHOUSE) -> World:
    """One with bots on paths, on velocities and at a bucket."""
    world = warehouse.world(1)
    bots = world.bots()
    world.handle(FollowPath(0, 1, ((10.0, 10.0), (20.0, 12.0))))
    world.handle(FollowPath(1, 2, ((float(bots.x[1]), float(bots.y[1])), (12.0, 14.0)), (1.0, 90.0)))
    world.handle(SetVelocity(2, 0.5, 0.2))
    world.handle(Grab(3, 3, 0))
    world.advance(4.0)
    return world


DATA = make_checkpoint(busy_world())


def content() -> dict[str, Any]:
    """What is in the checkpoint."""
    return json.loads(zlib.decompress(DATA[len(HEAD) + 32 :]))


def packed(values: Any) -> bytes:
    """A checkpoint of other values, with the checksum that is theirs."""
    data = zlib.compress(json.dumps(values).encode())
    return HEAD + hashlib.sha256(data).digest() + data


def told(data: bytes) -> str:
    """The one line with which a checkpoint is refused."""
    with pytest.raises(InputError) as refused:
        apply_checkpoint(data, WAREHOUSE.world(1), "world.checkpoint")
    line = str(refused.value)
    assert "\n" not in line and len(line) < 400 and line.startswith("world.checkpoint")
    return line


def test_a_whole_one_is_taken_and_the_world_goes_on_alike():
    world, restored = busy_world(), WAREHOUSE.world(1)
    apply_checkpoint(DATA, restored, "world.checkpoint")
    assert world.advance(60.0) == restored.advance(60.0)
    assert restored.capture() == world.capture()


@given(st.integers(0, 8 * len(DATA) - 1))
def test_any_flipped_bit_is_told(bit: int):
    damaged = bytearray(DATA)
    damaged[bit // 8] ^= 1 << bit % 8
    told(bytes(damaged))


@pytest.mark.parametrize(
    ("data", "found"),
    [
        (b"", "no checkpoint"),
        (b"\x78\x01", "no checkpoint"),
        (DATA[:-1], "damaged"),
        (DATA[: len(HEAD)], "damaged"),
        (DATA + b"\0", "damaged"),
        (DATA.replace(b"checkpoint 3", b"checkpoint 2"), "another version"),
        (packed([]), "without state"),
        (packed({**content(), "scenario": "0"}), "another scenario"),
    ],
    ids=str,
)
def test_what_is_no_checkpoint_is_told(data: bytes, found: str):
    assert found in told(data)


def test_one_that_grows_without_end_is_not_unpacked(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(checkpoint, "LARGEST", 1000)
    assert "more than 1,000 bytes" in told(DATA)


def put(*path: Any) -> Callable[[dict[str, Any]], None]:
    """Put the last one where the others lead to."""
    *way, key, value = path

    def change(values: dict[str, Any]) -> None:
        place: Any = values
        for step in way:
            place = place[step]
        place[key] = value

    return change


IMPOSSIBLE = {
    "another file as log": put("books", {"violations": 0, "log": "/etc/passwd", "bytes": 0}),
    "a log of less than nothing": put("books", "log", [1.5, 0, True]),
    "no world": put("world", None),
    "no bodies": put("world", "bodies", {}),
    "time that goes back": put("world", "agenda", "now", -1.0),
    "no time": put("world", "agenda", "now", "soon"),
    "endless time": put("world", "agenda", "now", 1e300),
    "something else to do": put("world", "agenda", "due", [[9.0, 1, "__init__", []]]),
    "something to do for nobody": put("world", "agenda", "due", [[9.0, 1, "motion_ends", [99, 1]]]),
    "something to do before now": put("world", "agenda", "due", [[1.0, 1, "window", []]]),
    "things to do out of order": put("world", "agenda", "due", [[9.0, 2, "window", []], [8.0, 1, "window", []]]),
    "a bot beside the floor": put("world", "bodies", "_state", 0, 1, 1e6),
    "a bot that is nowhere": put("world", "bodies", "_state", 0, 1, float("nan")),
    "a bot that flies": put("world", "bodies", "_state", 0, 3, 1e3),
    "one bot too few": lambda values: values["world"]["bodies"]["_state"].pop(),
    "a bucket on two bots": put("world", "bodies", "bucket", [0] * 20),
    "a bucket that nobody carries": put("world", "bodies", "carrier", 0, 5),
    "cells in a circle": lambda values: values["world"]["bodies"]["grids"].__setitem__(
        1, [0] * len(values["world"]["bodies"]["grids"][1])
    ),
    "a path beside the floor": put("world", "driving", "paths", 0, "points", [[-5.0, 1.0]]),
    "a path past its end": put("world", "driving", "paths", 0, "index", 7),
    "two buckets on one spot": lambda values: values["world"]["lifting"]["spot_of"].__setitem__(
        0, values["world"]["lifting"]["spot_of"][1]
    ),
    "a tile that there is not": put("world", "serving", "contents", 0, [[10**6, 1]]),
    "too many tiles": put("world", "serving", "contents", 0, [[0, 10**6]]),
    "a visit of nobody": put("world", "serving", "stations", 0, "visits", [[-1, 0, [], 0, 0, None, True]]),
    "no randomness": put("world", "orders", "rng", "state", {}),
    "a word of no tile": put("world", "waiting_words", [[1, "SOUP", [-1]]]),
    "figures that are texts": put("world", "statistics", "grabs", "many"),
    "figures of one bot alone": put("world", "statistics", "_idle_since", [0.0]),
    "an unknown key": put("world", "more", 1),
}


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_a_crafted_one_is_told(name: str):
    values = content()
    IMPOSSIBLE[name](values)
    assert "found what cannot be" in told(packed(values))


def test_a_folder_is_one_worlds(tmp_path: Path):
    held = hold_folder(tmp_path)
    with pytest.raises(InputError, match="another world keeps its checkpoints"):
        hold_folder(tmp_path)
    checkpoint.os.close(held)
    checkpoint.os.close(hold_folder(tmp_path))


def test_the_network_has_checkpoints_written_into_the_worlds_own_folder_alone(tmp_path: Path):
    assert place_for(tmp_path, "now.checkpoint") == tmp_path / "now.checkpoint"
    assert place_for(tmp_path, f"{tmp_path}/now.checkpoint") == tmp_path / "now.checkpoint"
    (tmp_path / "link.checkpoint").symlink_to(tmp_path / "elsewhere")
    for asked in (
        "", ".", "now", "/etc/now.checkpoint", "../now.checkpoint", "a/b.checkpoint", "link.checkpoint",
        "a\0.checkpoint", "n" * 250 + ".checkpoint", "n" * 10_000,
    ):  # fmt: skip
        with pytest.raises(InputError) as refused:
            place_for(tmp_path, asked)
        assert len(str(refused.value)) < 800
    with pytest.raises(InputError, match="no folder"):
        place_for(None, "now.checkpoint")


def test_a_checkpoint_that_is_a_folder_or_gone_is_told(tmp_path: Path):
    for path in (tmp_path, tmp_path / "none"):
        with pytest.raises(InputError):
            restore_checkpoint(path, WAREHOUSE.world(1))
