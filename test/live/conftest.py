"""Live tests: real nodes in real processes, each test in a ROS domain of its own; no process outlives its test."""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import uuid
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import _environment
from soup_lab.launch.bound_program import bound

SCRIPTS = _environment.ROOT / "scripts"
MARK = "SOUP_TEST"  # environment variable by which a test knows its processes, grandchildren included
PATIENCE_S = 240.0
ENDS_S = 3.0  # what is promised; the tests grant what a busy machine takes on top


@pytest.fixture(autouse=True)
def environment() -> Iterator[None]:
    """What a test sets for its own process, as a warehouse's client does, is not there for what the next one starts."""
    before = dict(os.environ)
    yield
    os.environ.clear()
    os.environ.update(before)


@pytest.fixture
def domain(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """A ROS domain that no other test of this machine has, in this process and all that it starts."""
    for number in range(20, 100):  # higher ones use ports that outgoing connections may have
        with open(Path(tempfile.gettempdir()) / f"soup-test-domain-{number}", "w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
            yield str(number)
            return
    pytest.fail("no free ROS domain")


class Parts:
    """The processes of one test."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.mark = uuid.uuid4().hex
        self._started: list[subprocess.Popen[str]] = []

    def start(self, script: str, *arguments: str) -> subprocess.Popen[str]:
        """Start a program of `scripts/`, away from any terminal."""
        return self._start([sys.executable, str(SCRIPTS / script), *arguments])

    def run_file(self, file: Path, *arguments: str) -> subprocess.Popen[str]:
        """Start a program of the tests."""
        return self._start([sys.executable, str(file), *arguments])

    def start_in(self, namespace: str, script: str, *arguments: str) -> subprocess.Popen[str]:
        """Start a program of `scripts/` in a network namespace."""
        program = [sys.executable, str(SCRIPTS / script), *arguments]
        return self._start(["ip", "netns", "exec", namespace, *program])

    def _start(self, command: list[str]) -> subprocess.Popen[str]:
        process = subprocess.Popen(
            bound(command, signal.SIGKILL),
            cwd=self.folder,
            env={**os.environ, MARK: self.mark},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        self._started.append(process)
        return process

    def run(self, script: str, *arguments: str) -> tuple[int, str, str]:
        """Run a program to its end: status, stdout, stderr."""
        process = self.start(script, *arguments)
        out, err = process.communicate(timeout=PATIENCE_S)
        return process.returncode, out, err

    def interrupt(self, process: subprocess.Popen[str], number: int = signal.SIGINT) -> str:
        """End a program as Ctrl-C does; it has to end within 3 s. Returns what it wrote to stderr."""
        began, allowed = time.monotonic(), ENDS_S * slowness()
        process.send_signal(number)
        _, err = process.communicate(timeout=PATIENCE_S)
        took = time.monotonic() - began
        assert took < allowed, f"{process.args} took {took:.1f} s to end"
        return err

    def alive(self) -> list[int]:
        """All processes of the test that still run, whoever started them."""
        found = []
        for entry in Path("/proc").iterdir():
            with contextlib.suppress(OSError):
                if entry.name.isdecimal() and f"{MARK}={self.mark}".encode() in (entry / "environ").read_bytes():
                    found.append(int(entry.name))
        return found

    def all_gone(self) -> bool:
        """Whether no process is left, now or within some seconds."""
        deadline = time.monotonic() + ENDS_S * slowness()
        while self.alive() and time.monotonic() < deadline:
            time.sleep(0.05)
        return not self.alive()

    def shared_memory(self) -> set[str]:
        """The files of DDS in /dev/shm that processes of the test use: who is killed would leave them behind."""
        used = set()
        for number in self.alive():
            with contextlib.suppress(OSError):
                used |= set(re.findall(r"/dev/shm/\S*fastrtps\S*", Path(f"/proc/{number}/maps").read_text()))
        return used

    def close(self) -> None:
        """Kill what is left; what each part said is shown where the test has failed."""
        status = {process: process.poll() for process in self._started}
        for number in self.alive():
            with contextlib.suppress(ProcessLookupError):
                os.kill(number, signal.SIGKILL)
        for process in self._started:
            said = "\n".join(process.communicate())[-2000:]
            print(process.args, "ran" if status[process] is None else f"had ended with {status[process]}", said)


@pytest.fixture
def parts(domain: str, tmp_path: Path) -> Iterator[Parts]:
    """Starts programs; whatever is left at the end of the test is killed, and the test has failed."""
    parts = Parts(tmp_path)
    try:
        yield parts
        assert parts.all_gone(), f"processes {parts.alive()} outlive their test"
    finally:
        parts.close()


def slowness() -> float:
    """How many times longer things take now than on an idle machine; a little more than that."""
    wall, processor = time.monotonic(), time.process_time()
    while time.process_time() - processor < 0.1:
        pass
    return 1.5 + 2.0 * ((time.monotonic() - wall) / 0.1 - 1.0)


def wait_until(condition: Callable[[], object], what: str, patience_s: float = PATIENCE_S) -> None:
    """Wait for something that other processes do."""
    deadline = time.monotonic() + patience_s
    while not condition():
        assert time.monotonic() < deadline, f"waited in vain: {what}"
        time.sleep(0.05)


@pytest.fixture
def prose() -> str:
    """A text file of plain English, whose words are short."""
    return str(_environment.ROOT / "config" / "words" / "prose.txt")
