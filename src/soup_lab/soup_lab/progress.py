"""The line that tells how something goes: rewritten on a terminal, now and then a new one elsewhere."""

from __future__ import annotations

import time

from rich.console import Console
from rich.text import Text

SPINNER_CELLS = 2  # before the line on a terminal
PLAIN_S = 10.0  # wall time between two lines where no terminal is


class ProgressLine:
    """One line on a console."""

    def __init__(self, console: Console, first: str, pause_s: float = 0.0) -> None:
        """Begin.

        Args:
            console: Where to show it.
            first: What a terminal shows until there is something to tell.
            pause_s: Wall time before the first line where no terminal is (s).
        """
        self._console = console
        self._status = console.status(first) if console.is_terminal else None
        self._due = time.monotonic() + pause_s
        if self._status is not None:
            self._status.start()

    @property
    def due(self) -> bool:
        """Whether a line that is told now is shown."""
        return self._status is not None or time.monotonic() >= self._due

    def tell(self, line: str) -> None:
        """Show a line, if one is due."""
        if self._status is not None:
            shown = Text(line)  # a line that wraps cannot be rewritten
            shown.truncate(self._console.width - SPINNER_CELLS, overflow="ellipsis")
            self._status.update(shown)
        elif self.due:
            self._due = time.monotonic() + PLAIN_S
            self._console.print(line, highlight=False)

    def close(self) -> None:
        """Take the line away. Can be called twice."""
        if self._status is not None:
            self._status.stop()
