"""When each recorded moment is due in a replay: the pace, pauses, steps, jumps."""

from __future__ import annotations

SLIP_S = 0.5  # wall time that a replay may be late before it gives the lost time up


class ReplayPace:
    """Relates wall time (s) and recorded time (ns).

    Attributes:
        speed: Recorded seconds a wall second.
        paused: Whether recorded time stands.
        given_up_s: Wall time by which the replay took longer than asked.
    """

    def __init__(self, speed: float, wall: float, at: int, *, paused: bool = False) -> None:
        """Begin.

        Args:
            speed: Recorded seconds a wall second; infinity: as fast as it goes.
            wall: What time it is (s).
            at: The recorded time that it begins with (ns).
            paused: Whether to stand there.
        """
        self.speed, self.paused, self.given_up_s = speed, paused, 0.0
        self._wall, self._at = wall, at
        self._until: int | None = None  # of a step

    def now(self, wall: float) -> int | None:
        """Recorded time (ns) up to which everything is due; None for no limit."""
        if self.paused:
            return self._at
        if self.speed == float("inf"):
            return self._until
        at = self._at + round((wall - self._wall) * self.speed * 1e9)
        return at if self._until is None else min(at, self._until)

    def due(self, at: int) -> float:
        """Wall time (s) at which a recorded time (ns) is due; infinity while it stands before that."""
        if self.paused or (self._until is not None and at > self._until):
            return float("inf")
        return self._wall + (at - self._at) * 1e-9 / self.speed

    def set_speed(self, wall: float, speed: float) -> None:
        """Go on at another speed."""
        self._set_here(wall)
        self.speed = speed

    def pause(self, wall: float, paused: bool) -> None:
        """Stand, or go on."""
        self._set_here(wall)
        self.paused, self._until = paused, None

    def step(self, wall: float, until: int) -> None:
        """Of a paused replay: go on to a recorded time (ns), and stand there."""
        self._wall, self.paused, self._until = wall, False, until

    def reached(self, at: int | None) -> bool:
        """Whether a step has come to its end, when all before a recorded time (ns; None: all) has been said."""
        if self._until is None or (at is not None and at <= self._until):
            return False
        self._at, self.paused, self._until = self._until, True, None
        return True

    def jump(self, wall: float, at: int) -> None:
        """Go on from another recorded time (ns)."""
        self._wall, self._at, self._until = wall, at, None

    def late(self, wall: float, at: int) -> None:
        """What was due at a recorded time (ns) is being said now: give up what cannot be made up for."""
        late = wall - self.due(at)
        if SLIP_S < late < float("inf") and self.speed < float("inf"):
            self._wall += late
            self.given_up_s += late

    def _set_here(self, wall: float) -> None:
        if not self.paused and self.speed < float("inf"):
            self._at = self.now(wall) or self._at
        self._wall = wall
