"""What the stations want: the fleet's tasks by station, and the tiles that words lack."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from soup_managers.contents import Counts
from soup_managers.state.tasks import Key, Task, TaskBook
from soup_msgs_py.messages import TileMove


class StationBook(TaskBook[Task]):
    """All tasks, by station.

    Attributes:
        at: The tasks of each station, in the order of their arrival.
    """

    def __init__(self, stations: int, kinds: int, changed: Callable[[int], None]) -> None:
        """Begin with none.

        Args:
            stations: Their number.
            kinds: Number of tile kinds.
            changed: Is told of a station that wants something else than before.
        """
        super().__init__(Task)
        self.at: list[dict[Key, Task]] = [{} for _ in range(stations)]
        self._kinds, self._changed = kinds, changed

    def accept(self, task: Task) -> None:
        """Take a task on."""
        super().accept(task)
        self.at[task.station][task.key] = task
        self._changed(task.station)

    def remove(self, task: Task) -> None:
        """Forget a task."""
        super().remove(task)
        del self.at[task.station][task.key]
        self._changed(task.station)

    def set_missing(self, task: Task, missing: Iterable[int], seen: int) -> None:
        """Take over what a task really lacks after the event with number `seen`."""
        super().set_missing(task, missing, seen)
        self._changed(task.station)

    def moved(self, key: Key, tile: int) -> None:
        """A tile was moved for a word or bundle."""
        task = self.tasks.get(key)
        if task is not None and tile in task.missing:
            task.missing.remove(tile)

    def need(self, station: int) -> Counts:
        """Tiles that the words of a word station lack, shape (kinds,)."""
        missing = [tile for task in self.at[station].values() for tile in task.missing]
        return np.bincount(missing, minlength=self._kinds).astype(np.int16)

    def deliveries(self, station: int, contents: Counts) -> tuple[TileMove, ...]:
        """The moves by which a bucket serves a word station, the oldest word first.

        Args:
            station: A word station.
            contents: Tiles of each kind in the bucket, shape (kinds,).
        """
        moves: list[TileMove] = []
        left: dict[int, int] = {}
        for task in self.at[station].values():
            for tile in task.missing:
                there = left[tile] if tile in left else int(contents[tile])
                if there > 0:
                    moves.append(TileMove(tile, task.job))
                left[tile] = there - 1
        return tuple(moves)

    def fillings(self, station: int, room: int) -> tuple[TileMove, ...]:
        """The moves by which a letter station fills a bucket, the oldest bundle first."""
        tiles = [TileMove(tile, task.job) for task in self.at[station].values() for tile in task.missing]
        return tuple(tiles[: max(0, room)])
