"""Which run of the world a part follows: the one it has, until nothing has been heard of it for a while."""

from __future__ import annotations

import math
from typing import Generic, Protocol, TypeVar

SILENT_S = 2.0  # wall time; a world sends a snapshot every second, also while it is paused


class Announced(Protocol):
    """What a world says about its run."""

    @property
    def run(self) -> int:
        """Its number."""
        ...


Announcement = TypeVar("Announcement", bound=Announced)


class Allegiance(Generic[Announcement]):
    """Keeps a part with its world while another run is announced, as by a bag that is played beside it.

    A world that is started again draws another number, and its part changes over: the one before is silent by then. Who
    has changed over to what was no world returns, once that is silent and the world still speaks.
    """

    def __init__(self) -> None:
        """Nothing has been heard of yet."""
        self._here: Announcement | None = None
        self._rival: Announcement | None = None
        self._heard = self._rival_heard = -math.inf  # wall time

    def hear(self, run: int, wall: float) -> None:
        """A run has said something at wall time `wall` (s)."""
        if self._here is not None and run == self._here.run:
            self._heard = wall
        elif self._rival is not None and run == self._rival.run:
            self._rival_heard = wall

    def announce(self, announcement: Announcement, wall: float) -> None:
        """A run is announced."""
        if self._here is None or announcement.run != self._here.run:
            self._rival, self._rival_heard = announcement, wall

    def change(self, wall: float) -> Announcement | None:
        """The announcement of the run to follow from now on, where it is time to change."""
        speaks = self._here is not None and wall - self._heard < SILENT_S
        if self._rival is None or speaks or self._rival_heard <= self._heard:
            return None
        self._here, self._rival = self._rival, self._here
        self._heard, self._rival_heard = wall, self._heard
        return self._here
