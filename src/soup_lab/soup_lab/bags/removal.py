"""Removes a bag to make room for another one of its name, and never anything that is no bag."""

from __future__ import annotations

from pathlib import Path

from soup_lab.bags.writer import METADATA, SUFFIX
from soup_msgs_py.errors import InputError


def remove_bag(folder: Path) -> None:
    """Remove a bag.

    Raises:
        InputError: It is not, or not only, a bag; nothing was removed.
    """
    for entry in files_of_bag(folder):
        entry.unlink()
    folder.rmdir()


def files_of_bag(folder: Path) -> list[Path]:
    """All that a folder holds, which is a bag.

    Raises:
        InputError: It is no folder, or one that holds anything but a bag.
    """
    found = f"{folder}, which is there already"
    if folder.is_symlink() or not folder.is_dir():
        raise InputError("--overwrite", "", found, "the folder of a bag")
    entries = list(folder.iterdir())
    if not entries:
        raise InputError("--overwrite", "", f"{found} and is empty", "a folder that holds a bag alone")
    others = [entry.name for entry in entries if not _of_a_bag(entry)]
    if others:
        raise InputError("--overwrite", "", f"{found} and holds {others[0]}", "a folder that holds a bag alone")
    return entries


def _of_a_bag(entry: Path) -> bool:
    return entry.is_file() and not entry.is_symlink() and (entry.name == METADATA or entry.suffix == SUFFIX)
