"""Every command of the README works as it stands there."""

from __future__ import annotations

import re
import shlex
import shutil
import socket
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from soup_msgs import msg

import _environment
from soup_msgs_py import topics
from soup_msgs_py.qos import EVERY_ONE

from .conftest import Parts
from .person import Person

README = (_environment.ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```sh( terminals)?\n(.*?)```", README, flags=re.DOTALL)
ALONE = [line for together, block in BLOCKS if not together for line in block.splitlines()]
TOGETHER = [line for together, block in BLOCKS if together for line in block.splitlines()]
TOLD = {"plan_world": "proven shortest", "replay_bag": "messages up to"}  # by program
UNTIL_CTRL_C = "python3 scripts/run_warehouse.py"
THESE_TESTS = "python3 scripts/run_tests.py"  # CI runs it; it runs this test


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the reader types: a folder like the project's. One command makes a bag there, others read it."""
    folder = tmp_path_factory.mktemp("reader")
    for name in ("config", "examples"):
        shutil.copytree(_environment.ROOT / name, folder / name)
    return folder


@pytest.fixture
def reader(domain: str, folder: Path) -> Iterator[Parts]:
    """Somebody who types the commands of the README."""
    parts = Parts(folder)
    try:
        yield parts
        assert parts.all_gone(), f"processes {parts.alive()} outlive their test"
    finally:
        parts.close()


def typed(reader: Parts, line: str, *more: str) -> subprocess.Popen[str]:
    """Start a command of the README."""
    program, script, *arguments = shlex.split(line)
    assert program == "python3"
    return reader.start(script.removeprefix("scripts/"), *arguments, *more)


def test_the_readme_has_commands() -> None:
    assert UNTIL_CTRL_C in ALONE
    assert THESE_TESTS in ALONE
    assert TOGETHER


@pytest.mark.live
@pytest.mark.timeout(600)
@pytest.mark.parametrize("line", [line for line in ALONE if line not in (UNTIL_CTRL_C, THESE_TESTS)])
def test_a_command_that_ends_by_itself_ends_well(reader: Parts, line: str) -> None:
    process = typed(reader, line)
    out, err = process.communicate(timeout=500)
    assert process.returncode == 0, err
    assert TOLD.get(Path(line.split()[1]).stem, "violations") in out


@pytest.mark.live
@pytest.mark.timeout(600)
def test_the_live_warehouse_runs_until_ctrl_c(reader: Parts) -> None:
    process = typed(reader, UNTIL_CTRL_C, "--port", free_port())
    wait_for_event("grabbed")
    reader.interrupt(process)
    assert process.returncode == 0
    assert reader.all_gone()


@pytest.mark.live
@pytest.mark.timeout(600)
def test_the_parts_in_their_own_terminals_move_letters(reader: Parts) -> None:
    world, *others = TOGETHER
    more = {"run_dashboard": ("--port", free_port())}
    processes = [typed(reader, line, *more.get(Path(line.split()[1]).stem, ())) for line in [*others, world]]
    wait_for_event("transferred")
    for process in processes:
        err = reader.interrupt(process)
        assert process.returncode == 0, err


def free_port() -> str:
    """A port that nobody uses now: the page's own may be taken by another run."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        return str(server.getsockname()[1])


def wait_for_event(kind: str) -> None:
    """Listen until something has happened in the warehouse."""
    heard: set[str] = set()

    def hear(event: Any) -> None:
        heard.add(event.type)

    with Person() as person:
        person.node.create_subscription(msg.Event, topics.EVENTS, hear, EVERY_ONE)
        person.wait(lambda: kind in heard, f"the event {kind}")
