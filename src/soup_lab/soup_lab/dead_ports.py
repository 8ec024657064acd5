"""Ports of dead processes, kept from those that start next.

Who is killed leaves its place in DDS's shared memory, which goes by the number of its port. Now and then a process that
takes that port is written to where nobody reads: it would hear nothing, and nobody would hear of it. One that finds the
port taken uses another.
"""

from __future__ import annotations

import contextlib
import os
import re
import socket
from pathlib import Path

HOLD_S = 30.0  # wall time after which DDS has forgotten a process that was killed


def udp_ports(process: int) -> set[int]:
    """The UDP ports that a process listens on; none where it is gone or another person's."""
    sockets = set()
    with contextlib.suppress(OSError):
        for entry in Path(f"/proc/{process}/fd").iterdir():
            with contextlib.suppress(OSError):
                found = re.fullmatch(r"socket:\[(\d+)\]", os.readlink(entry))
                if found is not None:
                    sockets.add(found[1])
    ports = set()
    with contextlib.suppress(OSError):
        for line in Path(f"/proc/{process}/net/udp").read_text().splitlines()[1:]:
            fields = line.split()
            if fields[9] in sockets:
                ports.add(int(fields[1].rpartition(":")[2], 16))
    return ports


class DeadPorts:
    """Notes the ports of processes while they live, and holds them for a while when they are dead."""

    def __init__(self) -> None:
        """Begin with none."""
        self._ports: dict[int, set[int]] = {}
        self._held: list[tuple[float, socket.socket]] = []

    def note(self, process: int) -> None:
        """A process lives."""
        self._ports[process] = udp_ports(process)

    def hold(self, process: int, wall: float) -> None:
        """A process is dead at wall time `wall` (s). Ports that others have, too, are theirs."""
        for port in sorted(self._ports.pop(process, ())):
            held = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            try:
                held.bind(("", port))
            except OSError:
                held.close()
            else:
                self._held.append((wall, held))

    def look(self, wall: float) -> None:
        """Let go of what was held for long enough."""
        while self._held and wall - self._held[0][0] > HOLD_S:
            self._held.pop(0)[1].close()

    def close(self) -> None:
        """Let go of everything."""
        for _, held in self._held:
            held.close()
        self._held.clear()
