"""The start-up barrier: how long a fleet that has just begun waits for what others asked for to be done."""

from __future__ import annotations

from collections.abc import Callable

LONGEST_S = 60.0  # simulated: then it begins, whoever still drives
TASKS_S = 10.0  # simulated: tasks that there are have come by then


class StartupBarrier:
    """The beginning of a fleet.

    Of bots that have not told where they stand or drive, nobody could keep clear; and a fleet that knows not all tasks
    yet would put buckets away that stand at their stations.
    """

    def __init__(self) -> None:
        """The fleet knows nothing."""
        self.over = False
        self._began: float | None = None

    def begin(self, now: float) -> None:
        """The fleet has heard of the world, maybe once more."""
        if self._began is None:
            self._began = now

    def look(self, unplaced: bool, has_all_tasks: Callable[[], bool], now: float) -> bool:
        """Whether it is over now, and was not before.

        Args:
            unplaced: Whether bots have not told yet where they stand or drive.
            has_all_tasks: Tells whether all that is on stations is in a task.
            now: Simulated time (s).
        """
        if self.over or self._began is None:
            return False
        waited = now - self._began
        self.over = waited >= LONGEST_S or (not unplaced and (waited >= TASKS_S or has_all_tasks()))
        return self.over
