"""Pacing: how far simulated time may go as wall time goes on. It knows no clock; wall time comes in."""

from __future__ import annotations

import math

LONGEST_STRIDE_S = 0.1  # wall time; a machine that is later than this runs the world slower instead of jumping

LONGEST_STRIDE_SIMULATED_S = 10.0  # for a world without a limit to its speed

FASTEST_WITHOUT = 10.0  # real-time factor; a part that was only busy for some seconds has not missed the whole run


class Pacer:
    """Lets simulated time follow wall time at a real-time factor.

    Attributes:
        speed: Simulated seconds a wall second.
        paused: Whether time stands.
        end: Simulated time at which the run is over (s).
        wall_seconds: Wall time that has gone by while time did not stand.
    """

    def __init__(self, speed: float, end: float, *, paused: bool = False) -> None:
        """Start at the first call of `until`.

        Args:
            speed: Simulated seconds a wall second; infinity: as fast as the parts can.
            end: Simulated time at which the run is over (s).
            paused: Whether time stands at first.
        """
        self.speed = speed
        self.end = end
        self.paused = paused
        self.wall_seconds = 0.0
        self._wall: float | None = None
        self._allowed = -float("inf")  # simulated time that wall time allows
        self._pause_at = float("inf")

    def pause(self, paused: bool) -> None:
        """Make time stand, or go on."""
        self.paused = paused
        self._pause_at = float("inf")

    def step(self, now: float, seconds: float) -> None:
        """Go on from `now` for some simulated seconds, then pause."""
        self.paused = False
        self._pause_at = now + seconds

    def until(self, wall: float, now: float, *, without: bool = False) -> float:
        """How far the world may go.

        A world that has not gone as far as it might, because it waited, may catch up a little later.

        Args:
            wall: Any clock of wall time (s).
            now: The simulated time that the world has reached (s).
            without: Whether it goes on without somebody for whom it has waited in vain; it does not race then.

        Returns:
            The simulated time to go on to, at least `now`.
        """
        elapsed = 0.0 if self._wall is None else wall - self._wall
        self._wall = wall
        if now >= self._pause_at:
            self.pause(True)
        if self.paused or now >= self.end:
            self._allowed = now
            return now
        self.wall_seconds += elapsed
        speed = min(self.speed, FASTEST_WITHOUT) if without else self.speed
        if math.isinf(speed):
            self._allowed = now + LONGEST_STRIDE_SIMULATED_S
        else:
            stride = LONGEST_STRIDE_S * speed
            self._allowed = min(max(self._allowed, now) + elapsed * speed, now + stride)
        return max(now, min(self._allowed, self._pause_at, self.end))
