"""The processes of a live warehouse: start them, notice which one died and why, end them all."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Sequence
from dataclasses import dataclass
from multiprocessing import forkserver, resource_tracker
from multiprocessing.context import ForkServerProcess
from pathlib import Path

from soup_lab.launch.guardian import GRACE_S, LOOK_S
from soup_lab.launch.part import become
from soup_live.ending import Lateness

LAST_BYTES = 4096


@dataclass(frozen=True)
class Part:
    """One process of a warehouse.

    Attributes:
        name: As it calls itself in its reports.
        module: What it runs.
        arguments: Its command line.
        again: What to add to it when the part is started again.
        needed: Whether the run cannot go on without it.
    """

    name: str
    module: str
    arguments: tuple[str, ...] = ()
    again: tuple[str, ...] = ()
    needed: bool = True


def load_ahead() -> None:
    """Begin to load what all parts need, in a process of its own, from which they are forked later."""
    ahead = [f"soup_lab.launch.{module}" for module in ("parent_death", "forkserver_preload")]
    multiprocessing.get_context("forkserver").set_forkserver_preload(ahead)
    resource_tracker.ensure_running()  # else the fork server's start does it, which lets SIGINT through again
    # It inherits that: a Ctrl-C is the starter's to act on. Ignored meanwhile, it would be lost; so it waits.
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        forkserver.ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


class Processes:
    """Running parts, each in a session of its own, so that a Ctrl-C reaches only the starter."""

    def __init__(self, folder: Path) -> None:
        """Begin with none.

        Args:
            folder: Where what they write to stderr is kept.
        """
        self._folder = folder
        self._running: dict[str, tuple[ForkServerProcess, Path]] = {}
        self._started = 0
        load_ahead()

    def start(self, part: Part) -> None:
        """Start a part; one of that name that has ended is forgotten."""
        self._started += 1
        errors = self._folder / f"errors-{self._started}"
        process = multiprocessing.get_context("forkserver").Process(
            target=become, args=(part.name, part.module, part.arguments, errors, dict(os.environ)), name=part.name
        )
        process.start()
        self._running[part.name] = process, errors

    def number(self, name: str) -> int:
        """Process number of a part."""
        return self._running[name][0].pid or 0

    def status(self, name: str) -> int | None:
        """Exit status of a part, None while it runs; a signal that killed it is negative."""
        return self._running[name][0].exitcode

    def dead(self) -> list[str]:
        """Names of the parts that have ended."""
        return [name for name in self._running if self.status(name) is not None]

    def last_words(self, name: str) -> str:
        """How a part ended and the last line that it wrote to stderr."""
        _, errors = self._running[name]
        status = self.status(name)
        how = (
            f"was killed by {signal.Signals(-status).name}" if status and status < 0 else f"ended with status {status}"
        )
        said = errors.read_bytes()[-LAST_BYTES:] if errors.exists() else b""
        lines = said.decode(errors="replace").split("\n")
        last = next((line.strip() for line in reversed(lines) if line.strip()), "it said nothing")
        return f"{how}: {last}"

    def end(self, names: Sequence[str] | None = None) -> list[str]:
        """Ask parts to end (all without names), kill what does not; names of those that had to be killed."""
        chosen = list(self._running) if names is None else list(names)
        for name in chosen:
            if self.status(name) is None:
                os.kill(self.number(name), signal.SIGINT)
        late = {name: Lateness(self.number(name)) for name in chosen}
        killed = []
        for name in chosen:
            process, _ = self._running[name]
            while process.exitcode is None and late[name].seconds() < GRACE_S:
                process.join(LOOK_S)
            if process.exitcode is None:
                process.kill()
                process.join()
                killed.append(name)
        return killed
