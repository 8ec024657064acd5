"""What killed processes leave in shared memory is removed, and what living ones use is not."""

from __future__ import annotations

import fcntl
import mmap
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from soup_msgs_py.live.shared_memory import FOLDER, ports_here, ports_of, remove_unused, used_by

HOLD = """
import fcntl, mmap, sys
what, path = sys.argv[1:]
if what == "lock":
    lock = open(path + "_el", "w")
    fcntl.flock(lock, fcntl.LOCK_EX)
else:
    file = open(path, "r+b")
    memory = mmap.mmap(file.fileno(), 0)
print("ready", flush=True)
sys.stdin.read()
"""


@pytest.fixture
def port() -> Iterator[Path]:
    """A port with its lock and its semaphore, as DDS makes them; nobody has one of that number."""
    file = FOLDER / f"fastrtps_port9{os.getpid()}"
    rest = [file, FOLDER / f"{file.name}_el", FOLDER / f"sem.{file.name}_mutex"]
    for made in rest:
        made.write_bytes(b"\0" * mmap.PAGESIZE)
    yield file
    for made in rest:
        made.unlink(missing_ok=True)


def test_what_nobody_uses_goes_with_all_that_belongs_to_it(port: Path):
    remove_unused({port})
    assert not list(FOLDER.glob(f"*{port.name}*"))


@pytest.mark.parametrize("what", ["lock", "use"])
def test_what_another_process_owns_or_uses_stays(port: Path, what: str):
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLD, what, str(port)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert holder.stdout is not None
    holder.stdout.readline()
    remove_unused({port})
    assert len(list(FOLDER.glob(f"*{port.name}*"))) == 3
    assert (port in used_by(holder.pid)) == (what == "use")
    holder.communicate()
    remove_unused({port})
    assert not list(FOLDER.glob(f"*{port.name}*"))


def test_what_this_process_alone_still_has_goes(port: Path):
    with open(f"{port}_el", "r+b") as lock, open(port, "r+b") as file, mmap.mmap(file.fileno(), 0):
        fcntl.flock(lock, fcntl.LOCK_EX)
        assert port in used_by("self")
        remove_unused({port})
    assert not port.exists()


def test_ports_of_the_own_domain_are_found(monkeypatch: pytest.MonkeyPatch):
    file = FOLDER / f"fastrtps_port{ports_of(230)[-1]}"  # no test uses so high a domain
    file.touch()
    try:
        monkeypatch.setenv("ROS_DOMAIN_ID", "230")
        assert file in ports_here()
        monkeypatch.setenv("ROS_DOMAIN_ID", "231")
        assert file not in ports_here()
    finally:
        file.unlink()
