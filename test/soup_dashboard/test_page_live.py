"""The dashboard as a process: it answers browsers, refuses a taken port, ends when asked."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest

import _environment

DOMAIN = "10"  # below those that the other live tests take
START_S = 60.0
END_S = 3.0
SCRIPT = _environment.ROOT / "scripts" / "run_dashboard.py"


@pytest.fixture
def port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@pytest.fixture
def dashboard(port: int, tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen(
        [sys.executable, SCRIPT, "--port", str(port)],
        cwd=tmp_path,
        env={**os.environ, "ROS_DOMAIN_ID": DOMAIN},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def get(port: int, **headers: str) -> httpx.Response:
    """The page, as soon as the server is there."""
    deadline = time.monotonic() + START_S
    while True:
        try:
            return httpx.get(f"http://127.0.0.1:{port}/", headers=headers, trust_env=False)
        except httpx.TransportError:
            if time.monotonic() > deadline:
                raise
            time.sleep(0.1)


@pytest.mark.live
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_the_page_is_served_and_ends_in_order_within_three_seconds(
    dashboard: subprocess.Popen[str], port: int, tmp_path: Path, number: signal.Signals
):
    answer = get(port)
    assert answer.status_code == 200
    assert "const warehouse = " in answer.text
    assert not re.findall(r"(?:src|href)=\"(?:https?:)?//", answer.text), "everything comes from this machine"
    assert get(port, host="elsewhere.example").status_code == 400
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
