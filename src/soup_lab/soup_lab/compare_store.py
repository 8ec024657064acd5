"""The results of a sweep on disk, one JSON line a run as it ends: an interrupted sweep goes on where it was."""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Iterable
from pathlib import Path
from types import TracebackType
from typing import Any

from soup_lab.runs import Summary
from soup_msgs_py.errors import InputError

FILE = "results.jsonl"


class Store:
    """Results by the fingerprint of their run; closed by `with`.

    Args:
        folder: Where the results are; made if there is none.

    Raises:
        InputError: Nothing can be written there, or another sweep writes there now.
    """

    def __init__(self, folder: Path) -> None:
        self.path = folder / FILE
        self._lines: dict[str, dict[str, Any]] = {}
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._file = self.path.open("a+", encoding="utf-8", errors="replace")
        except OSError as error:
            raise InputError("--out", "", f"{folder}: {error.strerror}", "a folder that can be written") from error
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            self._file.close()
            raise InputError("--out", "", f"another sweep at work in {folder}", "a folder of its own") from error
        self._file.seek(0)
        text = self._file.read()
        for line in text.splitlines():
            result = _parsed(line)
            if result is not None:
                self._lines[result["run"]] = result
        if text and not text.endswith("\n"):  # the last one was interrupted while it wrote
            self._file.write("\n")

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
        """Keep the summary of a run; it is on disk afterwards."""
        line = {"run": run, "variant": label, "seed": summary["seed"], "summary": summary}
        self._lines[run] = line
        self._file.write(json.dumps(line) + "\n")
        self._file.flush()
        os.fsync(self._file.fileno())

    def sort(self, runs: Iterable[str]) -> None:
        """Put the lines of these runs in their order; others stay behind them."""
        order = [run for run in runs if run in self._lines]
        lines = {run: self._lines[run] for run in [*order, *sorted(set(self._lines) - set(order))]}
        write_whole(self.path, "".join(json.dumps(line) + "\n" for line in lines.values()))
        self._lines = lines


def write_whole(path: Path, text: str) -> None:
    """Write a file whole or not at all."""
    half = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        half.write_text(text, encoding="utf-8")
        half.replace(path)
    finally:
        half.unlink(missing_ok=True)


def _parsed(line: str) -> dict[str, Any] | None:
    """A line as it was written, None for what an interrupted write has left."""
    try:
        result = json.loads(line)
    except ValueError:
        return None
    whole = isinstance(result, dict) and isinstance(result.get("run"), str) and isinstance(result.get("summary"), dict)
    return result if whole else None
