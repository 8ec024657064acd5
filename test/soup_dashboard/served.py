"""A dashboard in a process of its own, as a person starts it."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from pathlib import Path

import httpx

import _environment

DOMAIN = "10"  # below those that the other live tests take
START_S = 60.0
SCRIPT = _environment.ROOT / "scripts" / "run_dashboard.py"


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def start_dashboard(port: int, folder: Path) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, SCRIPT, "--port", str(port)],
        cwd=folder,
        env={**os.environ, "ROS_DOMAIN_ID": DOMAIN},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def get(port: int, path: str = "/", **headers: str) -> httpx.Response:
    """What the page answers, as soon as the server is there; `_` in a header's name stands for `-`."""
    deadline = time.monotonic() + START_S
    named = {name.replace("_", "-"): value for name, value in headers.items()}
    while True:
        try:
            return httpx.get(f"http://127.0.0.1:{port}{path}", headers=named, trust_env=False)
        except httpx.TransportError:
            if time.monotonic() > deadline:
                raise
            time.sleep(0.1)
