"""Checkpoints: the whole state of a world in one file, as data; reading one runs no code."""

from __future__ import annotations

import hashlib
import json
import os
import zlib
from pathlib import Path
from typing import Any

from soup_msgs_py.codes import BotState
from soup_msgs_py.errors import InputError
from soup_msgs_py.messages import SetVelocity
from soup_msgs_py.scenario import Scenario
from soup_sim.world import World

LONGEST_REST_S, REST_STEP_S = 600.0, 1.0  # simulated
_FORMAT = "alphabet-soup checkpoint 2"
_ALLOWED = "a checkpoint of this scenario"


def fingerprint(scenario: Scenario) -> str:
    """What tells one scenario from another: a checkpoint fits only the scenario that it was taken from.

    Its files may have been moved to another folder.
    """
    values = scenario.model_dump(mode="json", exclude={"words": True, "orders": {"path"}, "bundles": {"path"}})
    for station in ("word_station", "letter_station"):
        policy = values[station]["policy"]
        policy["name"] = Path(policy["name"]).name
    return hashlib.sha256(json.dumps(values).encode()).hexdigest()


def make_checkpoint(world: World, record: dict[str, Any] | None = None) -> bytes:
    """The state of a world.

    Args:
        world: The world.
        record: What the books of the run need to go on, plain JSON values.

    Returns:
        What a checkpoint file holds.
    """
    content = {"format": _FORMAT, "scenario": fingerprint(world.scenario), "world": world.capture(), "record": record}
    return zlib.compress(json.dumps(content, separators=(",", ":")).encode(), level=1)


def write_checkpoint(path: str | Path, world: World, record: dict[str, Any] | None = None) -> None:
    """Write a checkpoint, whole or not at all.

    Args:
        path: The file.
        world: The world.
        record: What the books of the run need to go on, plain JSON values.
    """
    path = Path(path)
    data = make_checkpoint(world, record)
    half = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with half.open("wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        half.replace(path)
    finally:
        half.unlink(missing_ok=True)


def restore_checkpoint(path: str | Path, world: World) -> dict[str, Any]:
    """Put a world of the same scenario into the state of a checkpoint.

    Returns:
        What `write_checkpoint` was given of the run's books.

    Raises:
        InputError: The file is missing, damaged, or of another scenario.
    """
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise InputError(path, "", error.strerror or error, _ALLOWED) from error
    return apply_checkpoint(data, world, path)


def apply_checkpoint(data: bytes, world: World, path: str | Path) -> dict[str, Any]:
    """Put a world of the same scenario into the state of a checkpoint.

    Args:
        data: What `make_checkpoint` made.
        world: The world.
        path: Where it comes from, for messages to a person.

    Returns:
        What `make_checkpoint` was given of the run's books.

    Raises:
        InputError: It is damaged, or of another scenario.
    """
    try:
        content: Any = json.loads(zlib.decompress(data))
        if content.get("format") != _FORMAT:
            raise ValueError("another format")
    except (ValueError, AttributeError, zlib.error) as error:
        raise InputError(path, "", "no checkpoint, or a damaged one", _ALLOWED) from error
    if content["scenario"] != fingerprint(world.scenario):
        raise InputError(path, "scenario", "a checkpoint of another scenario", _ALLOWED)
    try:
        world.restore(content["world"])
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise InputError(path, "world", f"damaged state ({error})", _ALLOWED) from error
    return content.get("record") or {}


def come_to_rest(world: World) -> list[Any]:
    """Run a restored world on until no bot is on a way that the new minds of its fleet cannot know of.

    They learn of timetabled paths and go on with them. On others bots drive to the end, which brings nobody into
    anybody's way, and stations work meanwhile. Those that go on and on, by a target velocity, brake. What is moved
    between buckets and stations ends soon, whoever has asked for it.

    Returns:
        What the world says meanwhile.
    """
    said: list[Any] = []
    for bot in sorted(_moving(world).difference(world.bots_on_paths())):
        said += world.handle(SetVelocity(bot, 0.0, 0.0))
    end = world.now + LONGEST_REST_S
    while world.now < end and _moves_unknown(world):
        said += world.advance(world.now + REST_STEP_S)
    return [*said, *world.end_transfers()]


def _moves_unknown(world: World) -> bool:
    """Whether a bot moves, or will, in a way that snapshots do not tell."""
    known = {path.bot for path in world.snapshot().paths}
    return not known.issuperset(_moving(world).union(world.bots_on_paths()))


def _moving(world: World) -> set[int]:
    return set((world.bots().state == BotState.MOVING).nonzero()[0].tolist())
