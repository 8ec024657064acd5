"""What the stations want: the fleet's tasks by station, and the tiles that words lack."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from soup_managers.state.contents import Counts
from soup_managers.state.tasks import Key, Task, TaskBook
from soup_msgs_py.messages import DELIVER, TileMove


class StationBook(TaskBook[Task]):
    """All tasks, by station.

    Attributes:
        at: The tasks of each station, in the order of their arrival.
        need: Tiles that the words of each word station lack, shape (word stations, kinds).
    """

    def __init__(self, word_stations: int, stations: int, kinds: int, changed: Callable[[int], None]) -> None:
        """Begin with none.

        Args:
            word_stations: Their number.
            stations: Number of all stations.
            kinds: Number of tile kinds.
            changed: Is told of a station that wants something else than before.
        """
        super().__init__(Task)
        self.at: list[dict[Key, Task]] = [{} for _ in range(stations)]
        self.need = np.zeros((word_stations, kinds), np.int32)
        self._changed = changed

    def accept(self, task: Task) -> None:
        """Take a task on."""
        super().accept(task)
        self.at[task.station][task.key] = task
        self._count(task, 1)

    def remove(self, task: Task) -> None:
        """Forget a task."""
        self._count(task, -1)
        super().remove(task)
        del self.at[task.station][task.key]

    def set_missing(self, task: Task, missing: Iterable[int], seen: int) -> None:
        """Take over what a task really lacks after the event with number `seen`."""
        self._count(task, -1)
        super().set_missing(task, missing, seen)
        self._count(task, 1)

    def moved(self, key: Key, tile: int) -> None:
        """A tile was moved for a word or bundle."""
        task = self.tasks.get(key)
        if task is not None and tile in task.missing:
            task.missing.remove(tile)
            if task.kind == DELIVER:
                self.need[task.station, tile] -= 1

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

    def _count(self, task: Task, sign: int) -> None:
        if task.kind == DELIVER:
            for tile in task.missing:
                self.need[task.station, tile] += sign
        self._changed(task.station)
