"""What DDS leaves in shared memory when a process was killed.

Everybody counts who uses a port; who is killed does not take itself off. So the last ones to use it leave the file,
though they end in order, and the next process to get that port is given one in which a dead one may hold a lock.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
from pathlib import Path

from soup_msgs_py.live.domain_id import domain_id

FOLDER = Path("/dev/shm")
_MAPPED = re.compile(r"\s(/dev/shm/fastrtps_(?:port\d+|[0-9a-f]{16}))$", re.MULTILINE)


def used_by(process: int | str) -> set[Path]:
    """The files of DDS in shared memory that a process uses; none where it is gone or another person's."""
    with contextlib.suppress(OSError):
        return {Path(place) for place in _MAPPED.findall(Path(f"/proc/{process}/maps").read_text())}
    return set()


def ports_of(domain: int) -> range:
    """Numbers of the ports that DDS gives to the processes of a domain."""
    first = 7400 + 250 * domain
    return range(first, first + 250)


def ports_here() -> set[Path]:
    """The ports of this process's domain that are in shared memory now."""
    numbers = ports_of(domain_id())
    return {FOLDER / f"fastrtps_port{number}" for number in numbers}.intersection(FOLDER.iterdir())


def remove_unused(files: set[Path]) -> None:
    """Remove those of some files that no other process owns or uses, with what belongs to them."""
    mine = _open_files()
    left = {file for file in files if file.exists() and (_lock_of(file) in mine or not _is_owned(file))}
    if not left:
        return
    for entry in Path("/proc").iterdir():
        if entry.name.isdecimal() and int(entry.name) != os.getpid():
            left -= used_by(entry.name)
    for file in left:
        for rest in (file, _lock_of(file), file.with_name(f"sem.{file.name}_mutex")):
            with contextlib.suppress(OSError):
                rest.unlink()


def _lock_of(file: Path) -> Path:
    return file.with_name(f"{file.name}_el")


def _open_files() -> set[Path]:
    """The files that this process has open; DDS closes some only when the process ends."""
    found = set()
    for entry in Path("/proc/self/fd").iterdir():
        with contextlib.suppress(OSError):
            found.add(Path(os.readlink(entry)))
    return found


def _is_owned(file: Path) -> bool:
    """Whether a process that lives holds the lock of a file's owner."""
    try:
        lock = os.open(_lock_of(file), os.O_RDWR)
    except FileNotFoundError:
        return False
    except OSError:
        return True
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    finally:
        os.close(lock)
    return False
