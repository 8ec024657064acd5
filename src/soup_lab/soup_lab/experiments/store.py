"""The results of a sweep on disk, one JSON line a run as it ends: an interrupted sweep goes on where it was."""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any

from soup_lab.headless.runs import Summary
from soup_msgs_py.command_line.output_files import OutputError, Tell, tell_on_stderr, why, write_whole
from soup_msgs_py.errors import InputError

FILE = "results.jsonl"


class Store:
    """Results by the fingerprint of their run; closed by `with`.

    What the disk has no room for stays in memory, is said once, and is written with the next result.

    Args:
        folder: Where the results are; made if there is none.
        tell: Says something to a person.

    Raises:
        InputError: Nothing can be written there, or another sweep writes there now.
    """

    def __init__(self, folder: Path, tell: Tell = tell_on_stderr) -> None:
        self.path = folder / FILE
        self._tell = tell
        self._lines: dict[str, dict[str, Any]] = {}
        self._unsaved: list[str] = []
        self._problem = ""
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._file = self.path.open("a+b", buffering=0)
        except OSError as error:
            raise InputError("--out", "", f"{folder}: {why(error)}", "a folder that can be written") from error
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            self._file.close()
            raise InputError("--out", "", f"another sweep at work in {folder}", "a folder of its own") from error
        self._file.seek(0)
        text = self._file.read().decode(errors="replace")
        for line in text.splitlines():
            result = _parsed(line)
            if result is not None:
                self._lines[result["run"]] = result
        if text and not text.endswith("\n"):  # the last one was interrupted while it wrote
            self._unsaved.append("\n")

    def __enter__(self) -> Store:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._file.close()

    def __len__(self) -> int:
        return len(self._lines)

    def get(self, run: str) -> Summary | None:
        """The summary of a run, if it is there."""
        line = self._lines.get(run)
        return line["summary"] if line is not None else None

    def add(self, run: str, label: str, summary: Summary) -> None:
        """Keep the summary of a run; it is on disk afterwards, if there is room."""
        line = {"run": run, "variant": label, "seed": summary["seed"], "summary": summary}
        self._lines[run] = line
        self._unsaved.append(json.dumps(line) + "\n")
        size = os.fstat(self._file.fileno()).st_size
        try:
            data = "".join(self._unsaved).encode()
            while data:
                data = data[self._file.write(data) :]
            os.fsync(self._file.fileno())
        except OSError as error:
            with suppress(OSError):
                self._file.truncate(size)
            self._note(f"{self.path}: {why(error)}; tried again with the next result")
        else:
            self._unsaved.clear()
            self._note("")

    def sort(self, runs: Iterable[str]) -> None:
        """Put the lines of these runs in their order; others stay behind them."""
        order = [run for run in runs if run in self._lines]
        lines = {run: self._lines[run] for run in [*order, *sorted(set(self._lines) - set(order))]}
        self._lines = lines
        try:
            write_whole(self.path, "".join(json.dumps(line) + "\n" for line in lines.values()))
            self._unsaved.clear()
        except OutputError as error:
            self._tell(f"{error}; it lacks {len(self._unsaved)} results" if self._unsaved else str(error))

    def _note(self, problem: str) -> None:
        """Tell a problem, but not again with each result."""
        if problem and not self._problem:
            self._tell(problem)
        self._problem = problem


def _parsed(line: str) -> dict[str, Any] | None:
    """A line as it was written, None for what an interrupted write has left."""
    try:
        result = json.loads(line)
    except ValueError:
        return None
    whole = isinstance(result, dict) and isinstance(result.get("run"), str) and isinstance(result.get("summary"), dict)
    return result if whole else None
