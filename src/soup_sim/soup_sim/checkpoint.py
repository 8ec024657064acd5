"""Checkpoints: the whole state of a world in one file, as data; reading one runs no code."""

from __future__ import annotations

import hashlib
import json
import os
import zlib
from pathlib import Path
from typing import Any

from soup_msgs_py.errors import InputError
from soup_msgs_py.scenario import Scenario
from soup_sim.world import World

_FORMAT = "alphabet-soup checkpoint 2"


def fingerprint(scenario: Scenario) -> str:
    """What tells one scenario from another: a checkpoint fits only the scenario that it was taken from.

    Its files may have been moved to another folder.
    """
    values = scenario.model_dump(mode="json", exclude={"words": True, "orders": {"path"}, "bundles": {"path"}})
    for station in ("word_station", "letter_station"):
        policy = values[station]["policy"]
        policy["name"] = Path(policy["name"]).name
    return hashlib.sha256(json.dumps(values).encode()).hexdigest()


def write_checkpoint(path: str | Path, world: World) -> None:
    """Write a checkpoint, whole or not at all."""
    path = Path(path)
    content = {"format": _FORMAT, "scenario": fingerprint(world.scenario), "world": world.capture()}
    data = zlib.compress(json.dumps(content, separators=(",", ":")).encode(), level=1)
    half = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with half.open("wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        half.replace(path)
    finally:
        half.unlink(missing_ok=True)


def restore_checkpoint(path: str | Path, world: World) -> None:
    """Put a world of the same scenario into the state of a checkpoint.

    Raises:
        InputError: The file is missing, damaged, or of another scenario.
    """
    allowed = "a checkpoint of this scenario"
    try:
        content: Any = json.loads(zlib.decompress(Path(path).read_bytes()))
        if content.get("format") != _FORMAT:
            raise ValueError("another format")
    except OSError as error:
        raise InputError(path, "", error.strerror or error, allowed) from error
    except (ValueError, AttributeError, zlib.error) as error:
        raise InputError(path, "", "no checkpoint, or a damaged one", allowed) from error
    if content["scenario"] != fingerprint(world.scenario):
        raise InputError(path, "scenario", "a checkpoint of another scenario", allowed)
    try:
        world.restore(content["world"])
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise InputError(path, "world", f"damaged state ({error})", allowed) from error
