"""Every command of the README and of what stands in docs works as it stands there.

They stand in blocks of `sh`. Those in a block of `sh terminals` run at the same time; those in a block of `sh long`
take minutes to hours and are run shortened. In a block of `sh session` parts of a warehouse are started first; then
examples are run while they are at work, one after the other.
"""

from __future__ import annotations

import re
import shlex
import shutil
import signal
import socket
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from soup_msgs import msg

import _environment
from soup_live.diagnostics import AT_WORK
from soup_live.qos import EVERY_ONE
from soup_msgs_py import topics

from .conftest import Parts
from .person import Person

DOCUMENTS = (_environment.ROOT / "README.md", *sorted((_environment.ROOT / "docs").rglob("*.md")))
TEXTS = {file.name: file.read_text(encoding="utf-8") for file in DOCUMENTS}
BLOCK = re.compile(r"^```sh\b *(.*?)\n(.*?)^```", flags=re.DOTALL | re.MULTILINE)
ALONE, TOGETHER, LONG = (
    [
        line
        for text in TEXTS.values()
        for kind, block in BLOCK.findall(text)
        if kind == wanted
        for line in block.splitlines()
    ]
    for wanted in ("", "terminals", "long")
)
SESSIONS = [block.splitlines() for text in TEXTS.values() for kind, block in BLOCK.findall(text) if kind == "session"]
KINDS = {"", "terminals", "long", "session"}
ELSEWHERE = "hosts.md"  # needs several machines: test_hosts.py makes them
TOLD = {"plan_world": "proven shortest", "replay_bag": "messages up to", "benchmark": "times faster"}  # by program
SHORTENED = {  # what a program gets besides; of what is given twice, the second counts
    "run_headless": ("--warmup", "0", "--duration", "20", "--replications", "1"),
    "run_warehouse": ("--warmup", "0", "--duration", "20"),
    "compare_policies": ("--replications", "1"),
    "benchmark": ("--time-limit", "1"),
}
PATIENCE_S = 1200.0  # a sweep has 27 variants, and a busy machine takes ten seconds for each
EXAMPLE_S = 240.0
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
    """Somebody who types the commands of the documents."""
    parts = Parts(folder)
    try:
        yield parts
        assert parts.all_gone(), f"processes {parts.alive()} outlive their test"
    finally:
        parts.close()


def typed(reader: Parts, line: str, *more: str) -> subprocess.Popen[str]:
    """Start a command of a document."""
    python, script, *arguments = shlex.split(line)
    assert python == "python3"
    if script.startswith("examples/"):
        return reader.run_file(_environment.ROOT / script, *arguments, *more)
    return reader.start(script.removeprefix("scripts/"), *arguments, *more)


def test_the_readme_has_commands() -> None:
    assert UNTIL_CTRL_C in ALONE
    assert THESE_TESTS in ALONE
    assert TOGETHER
    assert LONG


@pytest.mark.parametrize("name", [name for name in TEXTS if name != ELSEWHERE])
def test_every_command_stands_where_these_tests_find_it(name: str) -> None:
    assert {kind for kind, _ in BLOCK.findall(TEXTS[name])} <= KINDS
    assert not re.search("python3 (scripts|examples)/", BLOCK.sub("", TEXTS[name]))


@pytest.mark.live
@pytest.mark.timeout(1300)
@pytest.mark.parametrize("line", [line for line in ALONE if line not in (UNTIL_CTRL_C, THESE_TESTS)])
def test_a_command_that_ends_by_itself_ends_well(reader: Parts, line: str) -> None:
    assert_ends_well(typed(reader, line), line)


@pytest.mark.live
@pytest.mark.timeout(1300)
@pytest.mark.parametrize("line", LONG)
def test_a_long_command_ends_well_when_it_is_shortened(reader: Parts, folder: Path, line: str) -> None:
    for name in re.findall(r"config/experiments/\S+", line):
        experiment = (folder / name).read_text(encoding="utf-8")
        experiment = re.sub(r"^warmup_s: \S+", "warmup_s: 0", experiment, flags=re.MULTILINE)
        (folder / name).write_text(re.sub(r"^duration_s: \S+", "duration_s: 20", experiment, flags=re.MULTILINE))
    port = ("--port", free_port()) if "run_warehouse" in line else ()
    assert_ends_well(typed(reader, line, *SHORTENED[program(line)], *port), line)


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
    processes = [typed(reader, line, *more.get(program(line), ())) for line in [*others, world]]
    wait_for_event("transferred")
    for process in processes:
        err = reader.interrupt(process)
        # a part that stands by begins anew, and whatever is just being loaded ends at once
        assert process.returncode == 0 or ("stands by" in err and process.returncode == -signal.SIGINT), err


@pytest.mark.live
@pytest.mark.timeout(1300)
@pytest.mark.parametrize("lines", SESSIONS, ids=lambda lines: lines[0])
def test_examples_end_well_one_after_the_other_while_a_warehouse_runs(reader: Parts, lines: list[str]) -> None:
    examples = [line for line in lines if "examples/" in line]
    parts = [typed(reader, line) for line in lines if line not in examples]
    with Person() as person:
        wanted = {"world"} if len(parts) > 1 else {"world", "word manager", "letter manager", "fleet manager"}
        at_work: set[str] = set()

        def hear(report: DiagnosticArray) -> None:
            at_work.update(status.name for status in report.status if status.message.startswith(AT_WORK))

        person.node.create_subscription(DiagnosticArray, topics.DIAGNOSTICS, hear, EVERY_ONE)
        person.wait(lambda: wanted < at_work and any("bots" in name for name in at_work), "the parts are at work")
    for line in examples:
        example = typed(reader, line)
        out, err = example.communicate(timeout=EXAMPLE_S)
        assert (example.returncode, err) == (0, ""), f"{line}: {err}"
        assert out
    for part in reversed(parts):
        reader.interrupt(part)
        assert part.returncode == 0


def program(line: str) -> str:
    """The name of the program that a command starts."""
    return Path(line.split()[1]).stem


def assert_ends_well(process: subprocess.Popen[str], line: str) -> None:
    """Wait for the end of a command: it has worked, and has said what it found."""
    out, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0, err
    assert TOLD.get(program(line), "violations") in out


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
