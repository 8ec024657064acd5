"""The dashboard as a process: it answers browsers, refuses a taken port, ends when asked."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from served import SCRIPT, START_S, free_port, get, start_dashboard

END_S = 3.0


@pytest.fixture
def port() -> int:
    return free_port()


@pytest.fixture
def dashboard(port: int, tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    process = start_dashboard(port, tmp_path)
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


@pytest.mark.live
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_the_page_is_served_and_ends_in_order_within_three_seconds(
    dashboard: subprocess.Popen[str], port: int, tmp_path: Path, number: signal.Signals
):
    answer = get(port)
    assert answer.status_code == 200
    assert "const warehouse = " in answer.text
    assert not re.findall(r"(?:src|href)=\"(?:https?:)?//", answer.text), "everything comes from this machine"
    dashboard.send_signal(number)
    _, errors = dashboard.communicate(timeout=END_S)
    assert dashboard.returncode == 0
    assert "Traceback" not in errors
    assert list(tmp_path.iterdir()) == []


@pytest.mark.live
def test_a_port_in_use_is_told_in_one_line(port: int):
    with socket.socket() as other:
        other.bind(("127.0.0.1", port))
        other.listen()
        done = subprocess.run(
            [sys.executable, SCRIPT, "--port", str(port)], capture_output=True, text=True, timeout=START_S
        )
    assert done.returncode == 2
    assert done.stdout == ""
    assert re.fullmatch(rf"--port: found (port )?{port} in use; allowed: [^\n]+\n", done.stderr)
