"""When a part that died is started again. It knows no clock and no process; wall time comes in."""

from __future__ import annotations

from dataclasses import dataclass

FIRST_S, LONGEST_S = 0.2, 5.0  # pauses before a part is started again: each twice as long as the one before
STEADY_S = 30.0  # a part that has run for so long dies for the first time again
MOST = 5  # deaths in a row after which a part is given up


@dataclass(slots=True)
class _History:
    started: float
    deaths: int = 0
    stands_by: bool = False  # whether it ended only to stand by for another one
    due: float | None = None


class Restarts:
    """The deaths of each part, and when it may try again."""

    def __init__(self) -> None:
        """Begin with parts that have never died."""
        self._parts: dict[str, _History] = {}

    def started(self, name: str, wall: float) -> None:
        """A part begins to run."""
        history = self._parts.setdefault(name, _History(wall))
        history.started, history.due, history.stands_by = wall, None, False

    def died(self, name: str, wall: float) -> float | None:
        """A part has ended though nobody asked it to: the pause until it is to be started again, None to give it up."""
        history = self._parts[name]
        if wall - history.started >= STEADY_S:
            history.deaths = 0
        history.deaths += 1
        if history.deaths > MOST:
            return None
        pause = min(FIRST_S * 2.0 ** (history.deaths - 1), LONGEST_S)
        history.due = wall + pause
        return pause

    def handed_over(self, name: str, wall: float) -> float:
        """A part has ended because another one has taken over: the pause until it may stand by for that (s)."""
        self._parts[name].due, self._parts[name].stands_by = wall + FIRST_S, True
        return FIRST_S

    def stands_by(self, name: str) -> bool:
        """Whether a part is to be started again only to stand by for another one."""
        return self._parts[name].stands_by

    def waits(self, name: str) -> bool:
        """Whether a part is dead and has a time to be started again."""
        return self._parts[name].due is not None

    def due(self, wall: float) -> list[str]:
        """The parts to start now."""
        return [name for name, history in self._parts.items() if history.due is not None and history.due <= wall]
