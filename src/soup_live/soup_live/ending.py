"""A process that is to end does so, whatever its own code or a library does meanwhile.

A thread of Python watches first: it can say what happened and chooses the exit status. Native code that never lets
go of the interpreter stops that thread, and so does the end of the interpreter, after which the static destructors of
DDS have been seen to spin for ever. Timers of the kernel last to the last instruction.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

LONGEST_END_S = 2.5  # for a process to end; a busy machine gives it more
LONGEST_WALL = 4.0  # times as long, whatever the machine does meanwhile
SPINS_S = 2.8  # processor time after which the kernel ends it
LOOK_S = 0.1


class Ending:
    """Sees to it that a process ends in time.

    Args:
        name: Of the process, for messages to a person.
        status: Exit status of a process that has done its work and could not leave.
        to_the_last: Whether to watch the very end of the process, too, after which nobody can.
    """

    def __init__(self, name: str, status: Callable[[], int], to_the_last: bool) -> None:
        """Begin with no hurry."""
        self._name, self._status = name, status
        self._called_off = threading.Event()
        self._watched = False
        self._told = False
        self._leaves = False
        if to_the_last:
            atexit.unregister(arm)
            atexit.register(arm)

    def told(self) -> None:
        """The process was told to end, and has to be gone soon."""
        self._told = True
        self._watch()

    def leaves(self) -> None:
        """What the process had to do is done; it has to leave soon."""
        self._leaves = True
        self._watch()

    def left(self) -> None:
        """It has left. Who was told to end is watched on; others may go on with something else."""
        if not self._told:
            self._called_off.set()
            disarm()

    def _watch(self) -> None:
        if not self._watched:
            self._watched = True
            arm()
            threading.Thread(target=self._end_at_last, daemon=True).start()

    def _end_at_last(self) -> None:
        late = Lateness()
        while late.seconds() < LONGEST_END_S:
            if self._called_off.wait(LOOK_S):
                return
        with contextlib.suppress(OSError, ValueError):  # nobody may be there to read
            if self._leaves:
                sys.stdout.flush()
            else:
                print(f"{self._name}: did not end within {LONGEST_END_S:g} s, was ended", file=sys.stderr, flush=True)
        os._exit(self._status() if self._leaves else 1)


def arm() -> None:
    """Have the kernel end this process soon, by a signal."""
    for number in (signal.SIGPROF, signal.SIGALRM):
        signal.signal(number, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_PROF, SPINS_S)
    signal.setitimer(signal.ITIMER_REAL, LONGEST_WALL * SPINS_S)


def disarm() -> None:
    """The process goes on. What it becomes by `exec` would inherit the timers, what it forks would not."""
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    signal.setitimer(signal.ITIMER_REAL, 0.0)


class Lateness:
    """How long ago something began, without the time that the machine took from a process.

    Args:
        process: Its number; without: this process.
    """

    def __init__(self, process: int | None = None) -> None:
        """Begin now."""
        self._file = Path(f"/proc/{'self' if process is None else process}/schedstat")
        self._began = time.monotonic()
        self._queued_s = self._queued()

    def seconds(self) -> float:
        """Wall time since then in which the process ran or slept, not those in which it waited for a processor."""
        wall = time.monotonic() - self._began
        return max(wall / LONGEST_WALL, wall - (self._queued() - self._queued_s))

    def _queued(self) -> float:
        try:
            return int(self._file.read_text().split()[1]) * 1e-9
        except (OSError, ValueError, IndexError):  # a machine that does not tell, or the process has ended
            return 0.0
