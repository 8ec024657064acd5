"""Nobody gets a port that a process had which died a moment ago."""

from __future__ import annotations

import os
import socket
import subprocess
import sys

import pytest

from soup_lab.dead_ports import HOLD_S, DeadPorts, udp_ports

LISTEN = """
import socket, sys
server = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
server.bind(("", 0))
print(server.getsockname()[1], flush=True)
sys.stdin.read()
"""


def bind(port: int) -> None:
    """Take a port, and give it back."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("", port))


def test_a_dead_process_keeps_its_ports_for_a_while():
    process = subprocess.Popen([sys.executable, "-c", LISTEN], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert process.stdout is not None
    port = int(process.stdout.readline())
    assert udp_ports(process.pid) == {port}
    assert port not in udp_ports(os.getpid())
    ports = DeadPorts()
    ports.note(process.pid)
    process.kill()
    process.communicate()
    assert udp_ports(process.pid) == set()
    ports.hold(process.pid, 100.0)
    ports.look(100.0 + HOLD_S)
    with pytest.raises(OSError, match="in use"):
        bind(port)
    ports.look(100.1 + HOLD_S)
    bind(port)
    ports.hold(process.pid, 200.0)  # it is known no more
    bind(port)
    ports.close()
