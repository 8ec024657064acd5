"""Kills the parts of a warehouse that are still there a while after their starter has gone.

Parts are told when their starter ends, however that is, and end by themselves. One that is caught in native code
cannot: so a small process knows them all, and goes last.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys

from soup_live.ending import Lateness

GRACE_S = 2.8  # for a part to end in order; then it is killed. Parts give up by themselves before
LOOK_S = 0.05
NUMBER_BYTES = 4

_to_guardian: int | None = None  # where parts say who they are


def stand_guard() -> None:
    """Fork the guardian; called by the process from which parts are forked, before there are any."""
    global _to_guardian
    numbers, _to_guardian = os.pipe()
    if os.fork() == 0:
        os.setsid()  # a Ctrl-C is not for the guardian
        os.closerange(0, numbers)  # whoever waits for the end of the starter's output is not to wait for the guardian
        os.closerange(numbers + 1, os.sysconf("SC_OPEN_MAX"))
        try:
            _kill_late(_parts_left(numbers))
        finally:
            os._exit(0)
    os.close(numbers)


def be_guarded() -> None:
    """Called by a part: be killed if it is late."""
    if _to_guardian is not None:
        os.write(_to_guardian, os.getpid().to_bytes(NUMBER_BYTES, sys.byteorder))
        os.close(_to_guardian)


def _parts_left(numbers: int) -> dict[int, int]:
    """Wait until the process from which parts are forked has ended; the parts that run then, by their descriptors."""
    parts: dict[int, int] = {}
    while True:
        for ready in select.select([numbers, *parts], [], [])[0]:
            if ready != numbers:
                os.close(ready)  # that one has ended
                del parts[ready]
                continue
            told = os.read(numbers, NUMBER_BYTES)
            if not told:
                return parts
            number = int.from_bytes(told, sys.byteorder)
            with contextlib.suppress(ProcessLookupError):
                parts[os.pidfd_open(number)] = number


def _kill_late(parts: dict[int, int]) -> None:
    """Give parts time to end, kill who takes longer."""
    late = {part: Lateness(number) for part, number in parts.items()}
    while late:
        ended = select.select(list(late), [], [], LOOK_S)[0]
        over = [part for part in late if part not in ended and late[part].seconds() > GRACE_S]
        for part in over:
            signal.pidfd_send_signal(part, signal.SIGKILL)
        for part in (*ended, *over):
            del late[part]
