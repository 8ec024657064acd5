"""What a program shows: a screen that fails (a closed pipe, a full disk) ends the showing, not the run."""

from __future__ import annotations

import functools
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, ParamSpec, TextIO, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


class Screen:
    """A stream that stays silent once it has failed; for the rest it is the stream that it stands for."""

    def __init__(self, stream: TextIO, failed: Callable[[OSError], None]) -> None:
        """Stand for a stream.

        Args:
            stream: It.
            failed: Called once, when it has failed.
        """
        self._stream, self._failed = stream, failed

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Show a text, as far as the stream's alphabet goes."""
        try:
            self._stream.write(text)
        except UnicodeEncodeError:
            alphabet = self._stream.encoding
            self._stream.write(text.encode(alphabet, "replace").decode(alphabet))
        except OSError as error:
            self._end(error)
        return len(text)

    def flush(self) -> None:
        """Show what waits."""
        try:
            self._stream.flush()
        except OSError as error:
            self._end(error)

    def _end(self, error: OSError) -> None:
        """Let all that comes go nowhere, what waits in the stream included."""
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, self._stream.fileno())
        os.close(nothing)
        self._failed(error)


@contextmanager
def display() -> Iterator[None]:
    """Have stdout and stderr end by themselves, for as long as a program runs."""
    before = sys.stdout, sys.stderr

    def failed(error: OSError) -> None:
        if not isinstance(error, BrokenPipeError):  # whoever reads no more knows
            print(f"stdout: {error.strerror}; the run goes on without it", file=sys.stderr, flush=True)

    # None: a program that was started without
    out = Screen(before[0], failed) if before[0] is not None else None
    errors = Screen(before[1], _ignore) if before[1] is not None else None
    sys.stdout, sys.stderr = out, errors  # type: ignore[assignment]
    try:
        yield
    finally:
        for screen in (out, errors):
            if screen is not None:
                screen.flush()
        sys.stdout, sys.stderr = before


def on_display(main: Callable[P, R]) -> Callable[P, R]:
    """A program whose screen may fail."""

    @functools.wraps(main)
    def shown(*arguments: P.args, **options: P.kwargs) -> R:
        with display():
            return main(*arguments, **options)

    return shown


def _ignore(_error: OSError) -> None:
    """There is nowhere left to say it."""
