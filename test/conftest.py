"""What all tests share: how they are drawn, and that they touch nothing but folders of their own."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

import _environment

# compilation and a noisy machine make single examples slow; time is never what a test asserts
settings.register_profile("warehouse", deadline=None)
settings.load_profile("warehouse")

PROJECT = str(_environment.ROOT)
CACHES = ("__pycache__", ".venv", ".git", ".pytest_cache", ".hypothesis", ".ruff_cache")  # what tools keep there
WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
# events of Python's audit, how many paths come first, and after them, where there is one, a folder they are relative to
CHANGES = {
    "os.remove": (1, 1), "os.rmdir": (1, 1), "os.mkdir": (1, 2), "os.rename": (2, 2), "os.link": (2, 2),
    "os.symlink": (2, 2), "os.truncate": (1, 1), "shutil.rmtree": (1, 1),
}  # fmt: skip


class ReadersFileError(BaseException):
    """A test was about to change the project's folder, where the files of whoever runs the tests are, too."""


class ReadersFiles:
    """Refuses whatever would change a file in the project's folder.

    Attributes:
        guarded: Whether a test runs.
    """

    def __init__(self) -> None:
        self.guarded = False

    def audit(self, event: str, arguments: tuple[Any, ...]) -> None:
        """Look at what is about to be done; an audit hook."""
        if not self.guarded:
            return
        if event == "open":
            path, _, flags = arguments
            self._refuse(event, [path] if isinstance(flags, int) and flags & WRITES else [])
        elif event in CHANGES:
            paths, folder = CHANGES[event]
            # what is relative to an open folder is part of a tree whose removal was looked at as a whole
            if not any(isinstance(number, int) and number >= 0 for number in arguments[folder:]):
                self._refuse(event, arguments[:paths])

    def _refuse(self, event: str, paths: Iterable[Any]) -> None:
        for path in paths:
            if isinstance(path, str | bytes | os.PathLike):
                place = os.path.abspath(os.fsdecode(path))
                if place.startswith(PROJECT + os.sep) and not any(cache in Path(place).parts for cache in CACHES):
                    raise ReadersFileError(f"{event}: {place}")


READERS_FILES = ReadersFiles()
sys.addaudithook(READERS_FILES.audit)


@pytest.fixture(autouse=True)
def folder_of_its_own(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    """Each test, and what it starts, works in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(READERS_FILES, "guarded", True)
    yield
    READERS_FILES.guarded = False
