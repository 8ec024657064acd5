"""Which run of the world a part follows: the one it has, until nothing has been heard of it for a while."""

from __future__ import annotations

from typing import Generic, Protocol, TypeVar

SILENT_S = 3.0  # wall time; a world sends a snapshot every second, also while it is paused


class Announced(Protocol):
    """What a world says about its run."""

    @property
    def run(self) -> int:
        """Its number."""
        ...


Announcement = TypeVar("Announcement", bound=Announced)


class Allegiance(Generic[Announcement]):
    """Keeps a part with its world while another run is announced, as by a bag that is played beside it.

    A world that is started again draws another number, and its part changes over: the one before is silent by then.
    """

    def __init__(self) -> None:
        """Nothing has been heard of yet."""
        self._run = 0
        self._heard = -SILENT_S
        self._rival: Announcement | None = None

    def hear(self, run: int, wall: float) -> None:
        """A run has said something at wall time `wall` (s)."""
        if run == self._run:
            self._heard = wall

    def announce(self, announcement: Announcement) -> None:
        """A run is announced."""
        self._rival = announcement if announcement.run != self._run else None

    def change(self, wall: float) -> Announcement | None:
        """The announcement of the run to follow from now on, where it is time to change."""
        rival = self._rival
        if rival is None or (self._run and wall - self._heard < SILENT_S):
            return None
        self._run, self._heard, self._rival = rival.run, wall, None
        return rival
