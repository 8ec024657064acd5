"""Checkpoints: the whole state of a world in one file, as data; reading one runs no code.

A file begins with a line that says what it is, then come the checksum of the rest and the rest: compressed JSON.
Nothing in it is believed before `checkpoint_state` has checked it, and it names no other file.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import zlib
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from soup_msgs_py.codes import BotState
from soup_msgs_py.command_line.output_files import LONGEST_NAME, why, write_whole
from soup_msgs_py.errors import InputError
from soup_msgs_py.messages import SetVelocity
from soup_msgs_py.scenario import Scenario
from soup_sim.checkpoint_state import Books, check_state
from soup_sim.world import World

LONGEST_REST_S, REST_STEP_S = 600.0, 1.0  # simulated
SUFFIX = ".checkpoint"
LARGEST = 1 << 28  # bytes of its JSON, several hundred times what 1,000 bots need
_NAME = b"alphabet-soup checkpoint "
_FORMAT = _NAME + b"3\n"
_CHECKSUM = hashlib.sha256
_START = len(_FORMAT) + _CHECKSUM().digest_size
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


def make_checkpoint(world: World, books: Books | None = None) -> bytes:
    """The state of a world.

    Args:
        world: The world.
        books: What the books of the run need to go on.

    Returns:
        What a checkpoint file holds.
    """
    content = {
        "scenario": fingerprint(world.scenario),
        "world": world.capture(),
        "books": (books or Books()).model_dump(mode="json"),
    }
    text = json.dumps(content, separators=(",", ":"))
    data = zlib.compress(text.encode(), level=1)
    return _FORMAT + _CHECKSUM(data).digest() + data


def write_checkpoint(path: str | Path, world: World, books: Books | None = None) -> None:
    """Write a checkpoint, whole or not at all.

    Args:
        path: The file.
        world: The world.
        books: What the books of the run need to go on.

    Raises:
        OutputError: It cannot be written.
    """
    write_whole(path, make_checkpoint(world, books), durable=True)


def restore_checkpoint(path: str | Path, world: World) -> Books:
    """Put a world of the same scenario into the state of a checkpoint.

    Returns:
        What `write_checkpoint` was given of the run's books.

    Raises:
        InputError: The file is missing, damaged, or of another scenario.
    """
    try:
        with open(path, "rb") as file:
            data = file.read(LARGEST + 1)
    except OSError as error:
        raise InputError(path, "", why(error), _ALLOWED) from error
    return apply_checkpoint(data, world, path)


def apply_checkpoint(data: bytes, world: World, path: str | Path) -> Books:
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
    content = _read(data, path)
    if content.get("scenario") != fingerprint(world.scenario):
        raise InputError(path, "scenario", "a checkpoint of another scenario", _ALLOWED)
    try:
        books = Books.model_validate_json(json.dumps(content.get("books")))
        check_state(content.get("world"), world)
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(map(str, first["loc"]))
        raise InputError(
            path, key, f"what cannot be ({first['msg'].removeprefix('Value error, ')})", _ALLOWED
        ) from error
    try:
        world.restore(content["world"])
    except Exception as error:  # stations may have policies of a person's own, which read what is theirs in it
        raise InputError(path, "world", f"damaged state ({type(error).__name__}: {error})", _ALLOWED) from error
    return books


def _read(data: bytes, path: str | Path) -> dict[str, Any]:
    """The content of a checkpoint that is whole.

    Raises:
        InputError: It is none, or it is damaged.
    """
    if not data.startswith(_FORMAT):
        found = "a checkpoint of another version" if data.startswith(_NAME) else "no checkpoint"
        raise InputError(path, "", found, _ALLOWED)
    packed = data[_START:]
    if _CHECKSUM(packed).digest() != data[len(_FORMAT) : _START]:
        raise InputError(path, "", "a damaged checkpoint (its checksum does not fit)", _ALLOWED)
    try:
        unpacker = zlib.decompressobj()
        text = unpacker.decompress(packed, LARGEST)
        content = json.loads(text) if not unpacker.unconsumed_tail else None
    except (ValueError, RecursionError, zlib.error) as error:
        raise InputError(path, "", f"a checkpoint that cannot be read ({error})", _ALLOWED) from error
    if not isinstance(content, dict):
        found = f"more than {LARGEST:,} bytes" if unpacker.unconsumed_tail else "a checkpoint without state"
        raise InputError(path, "", found, _ALLOWED)
    return content


def hold_folder(folder: Path) -> int:
    """Keep other worlds from writing checkpoints into a folder; the descriptor that does, until it is closed.

    Raises:
        InputError: Another world keeps its checkpoints there.
    """
    file = os.open(folder, os.O_RDONLY | os.O_CLOEXEC)
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        os.close(file)
        found = f"{folder}, where another world keeps its checkpoints"
        raise InputError("--checkpoint", "", found, "a folder of its own, for instance a copy of it") from error
    return file


def place_for(folder: Path | None, asked: str) -> Path:
    """Where a checkpoint goes that somebody on the network asks for: nowhere but into the world's own folder.

    Args:
        folder: That folder; None where the world was given none.
        asked: The file that was asked for; a name alone means one in that folder.

    Raises:
        InputError: It would be another file.
    """
    if folder is None:
        raise InputError("path", "", "a world that was given no folder", "a world with --checkpoint DIR")
    allowed = f"a file in {folder} that ends in {SUFFIX}"
    found = repr(asked) if len(asked) <= LONGEST_NAME else f"{len(asked):,} characters"
    path = Path(os.path.normpath(folder / asked))
    fits = path.parent == folder and path.suffix == SUFFIX and "\0" not in asked
    if not fits or len(os.fsencode(path.name)) > LONGEST_NAME or path.is_symlink():
        raise InputError("path", "", found, allowed)
    return path


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
