"""The processes of a live warehouse: start them, notice which one died and why, end them all."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from typing import IO

from soup_lab.part import STARTER
from soup_msgs_py.live.process import Lateness

GRACE_S = 2.8  # to end in order; then killed. Parts give up by themselves before
LOOK_S = 0.05
LAST_BYTES = 4096


@dataclass(frozen=True)
class Part:
    """One process of a warehouse.

    Attributes:
        name: As it calls itself in its reports.
        module: What it runs.
        arguments: Its command line.
    """

    name: str
    module: str
    arguments: tuple[str, ...] = ()


class Processes:
    """Running parts, each in a process group of its own, so that a Ctrl-C reaches only the starter."""

    def __init__(self) -> None:
        self._running: dict[str, tuple[subprocess.Popen[bytes], IO[bytes]]] = {}

    def start(self, part: Part) -> None:
        """Start a part."""
        errors = tempfile.TemporaryFile()  # noqa: SIM115 (as long as the process)
        process = subprocess.Popen(
            [sys.executable, "-m", "soup_lab.part", part.module, *part.arguments],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=errors,
            env={**os.environ, STARTER: str(os.getpid())},
            start_new_session=True,
        )
        self._running[part.name] = process, errors

    def status(self, name: str) -> int | None:
        """Exit status of a part, None while it runs."""
        return self._running[name][0].poll()

    def dead(self) -> list[str]:
        """Names of the parts that have ended."""
        return [name for name in self._running if self.status(name) is not None]

    def last_words(self, name: str) -> str:
        """How a part ended and the last line that it wrote to stderr."""
        process, errors = self._running[name]
        status = process.poll()
        how = (
            f"was killed by {signal.Signals(-status).name}" if status and status < 0 else f"ended with status {status}"
        )
        errors.seek(0, os.SEEK_END)
        errors.seek(max(0, errors.tell() - LAST_BYTES))
        lines = errors.read().decode(errors="replace").split("\n")
        last = next((line.strip() for line in reversed(lines) if line.strip()), "it said nothing")
        return f"{how}: {last}"

    def end(self, names: Sequence[str] | None = None) -> list[str]:
        """Ask parts to end (all without names), kill what does not; names of those that had to be killed."""
        chosen = list(self._running) if names is None else list(names)
        for name in chosen:
            if self.status(name) is None:
                self._running[name][0].send_signal(signal.SIGINT)
        late = {name: Lateness(self._running[name][0].pid) for name in chosen}
        killed = []
        for name in chosen:
            process, _ = self._running[name]
            while process.poll() is None and late[name].seconds() < GRACE_S:
                with contextlib.suppress(subprocess.TimeoutExpired):
                    process.wait(LOOK_S)
            if process.poll() is None:
                process.kill()
                process.wait()
                killed.append(name)
        return killed
