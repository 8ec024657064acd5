"""A warehouse on three hosts, which are network namespaces of this machine; one drops off and comes back."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from .conftest import PATIENCE_S, Parts, wait_until

NETWORK = "10.77.23"
DISCOVERY = f"{NETWORK}.1:11811"
OFF_S = 12.0  # wall time; longer than the world waits for anybody


def ip(*arguments: str) -> None:
    """Run `ip`."""
    subprocess.run(["ip", *arguments], check=True, capture_output=True)


def can_make_hosts() -> bool:
    """Whether this machine lets a test make network namespaces."""
    probe = f"soup-probe-{os.getpid()}"  # two test runs at once may ask at the same moment
    try:
        ip("netns", "add", probe)
        ip("netns", "del", probe)
    except (OSError, subprocess.CalledProcessError):
        return False
    return True


pytestmark = [
    pytest.mark.live,
    pytest.mark.timeout(600),
    pytest.mark.skipif(not can_make_hosts(), reason="needs iproute2, and the right to make network namespaces"),
]


class Hosts:
    """Two hosts besides this one, on a network of their own."""

    names = ("soup-b", "soup-c")

    def __enter__(self) -> Hosts:
        """Make them."""
        ip("link", "add", "soup-bridge", "type", "bridge")
        ip("addr", "add", f"{NETWORK}.1/24", "dev", "soup-bridge")
        ip("link", "set", "soup-bridge", "up")
        for number, name in enumerate(self.names, 2):
            ip("netns", "add", name)
            ip("link", "add", f"{name}-out", "type", "veth", "peer", "name", "eth0", "netns", name)
            ip("link", "set", f"{name}-out", "master", "soup-bridge", "up")
            ip("-n", name, "addr", "add", f"{NETWORK}.{number}/24", "dev", "eth0")
            ip("-n", name, "link", "set", "lo", "up")
            ip("-n", name, "link", "set", "eth0", "up")
        return self

    def __exit__(self, *_: object) -> None:
        """Take them away."""
        for name in self.names:
            subprocess.run(["ip", "netns", "del", name], capture_output=True, check=False)
        subprocess.run(["ip", "link", "del", "soup-bridge"], capture_output=True, check=False)

    def plug(self, name: str, state: str) -> None:
        """Take a host off the network (`down`), or put it on again (`up`)."""
        ip("link", "set", f"{name}-out", state)


@pytest.fixture
def hosts() -> Iterator[Hosts]:
    """Three hosts."""
    with Hosts() as hosts:
        yield hosts


def test_bots_on_two_other_hosts_move_letters_also_after_one_was_cut_off(
    hosts: Hosts, parts: Parts, prose: str, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("ROS_DISCOVERY_SERVER", DISCOVERY)
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")
    discovery = parts.start("run_discovery.py")
    world = parts.start("run_world.py", "--speed", "5", "--set", f"words={prose}")
    started = [world, *(parts.start(f"run_{role}_manager.py") for role in ("word", "letter", "fleet"))]
    for name, bots in zip(hosts.names, ("0-9", "10-19"), strict=True):
        started.append(parts.start_in(name, "run_bots.py", bots))
    seen = parts.folder / "transfers"
    seen.touch()
    watcher = parts.run_file(Path(__file__).with_name("transfers.py"), str(seen))

    def moved(host: str) -> int:
        """How many letters the bots of a host have moved."""
        bots = [int(line) for line in seen.read_text().split()]
        return sum(hosts.names[bot // 10] == host for bot in bots)

    away, there = hosts.names
    wait_until(lambda: moved(away) and moved(there), "bots of both hosts move letters")
    hosts.plug(away, "down")
    time.sleep(OFF_S)
    before = moved(there)
    wait_until(lambda: moved(there) > before, "the bots that are left move letters")
    hosts.plug(away, "up")
    before = moved(away)
    wait_until(lambda: moved(away) > before, "the bots that are back move letters")
    for process in (watcher, *started, discovery):
        process.send_signal(signal.SIGINT)
    watcher.communicate(timeout=PATIENCE_S)
    for process in started:
        _, err = process.communicate(timeout=PATIENCE_S)
        assert process.returncode == 0, err
