"""What the word and the letter manager ask for: words and bundles on stations, and the tiles still to be moved."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from soup_managers.fleets.coordinated.stock import Counts
from soup_msgs_py.messages import DELIVER, DeliverGoal, StoreGoal, TileMove

Key = tuple[str, int]


@dataclass(slots=True, eq=False)
class Job:
    """One task: a word or bundle on a station.

    Attributes:
        kind: DELIVER or STORE.
        number: Of the task, as its manager numbered it.
        station: Where it is.
        job: The word or bundle.
        missing: Tiles that are still to be moved.
        told: What its manager was told last.
    """

    kind: str
    number: int
    station: int
    job: int
    missing: list[int]
    told: tuple[int, str] | None = None


class Jobs:
    """All tasks, by station.

    Attributes:
        all: In the order of their arrival.
        at: The same, for each station.
        need: Tiles that the words of each word station lack, shape (word stations, kinds).
    """

    def __init__(self, word_stations: int, stations: int, kinds: int) -> None:
        self.all: dict[Key, Job] = {}
        self.at: list[dict[Key, Job]] = [{} for _ in range(stations)]
        self.need = np.zeros((word_stations, kinds), np.int32)

    def accept(self, goal: DeliverGoal | StoreGoal) -> Job | None:
        """Take a task on; the one for the same word or bundle that it takes the place of, if there is one."""
        if isinstance(goal, DeliverGoal):
            job = Job(DELIVER, goal.task, goal.station, goal.word, list(goal.tiles))
        else:
            job = Job("store", goal.task, goal.station, goal.bundle, [goal.tile] * goal.count)
        key = job.kind, job.job
        old = self.all.get(key)
        if old is not None:
            self.remove(old)
        self.all[key] = self.at[job.station][key] = job
        self._count(job, 1)
        return old

    def remove(self, job: Job) -> None:
        """Forget a task."""
        key = job.kind, job.job
        self._count(job, -1)
        del self.all[key], self.at[job.station][key]

    def moved(self, key: Key, tile: int) -> None:
        """A tile was moved for a word or bundle."""
        job = self.all.get(key)
        if job is not None and tile in job.missing:
            job.missing.remove(tile)
            if job.kind == DELIVER:
                self.need[job.station, tile] -= 1

    def correct(self, job: Job, missing: list[int]) -> None:
        """Take over what a task really lacks."""
        self._count(job, -1)
        job.missing = missing
        self._count(job, 1)

    def numbered(self, kind: str, number: int) -> Job | None:
        """The task of a manager."""
        return next((job for job in self.all.values() if job.kind == kind and job.number == number), None)

    def deliveries(self, station: int, contents: Counts) -> tuple[TileMove, ...]:
        """The moves by which a bucket serves a word station, the oldest word first.

        Args:
            station: A word station.
            contents: Tiles of each kind in the bucket, shape (kinds,).
        """
        moves: list[TileMove] = []
        left: dict[int, int] = {}
        for job in self.at[station].values():
            for tile in job.missing:
                there = left[tile] if tile in left else int(contents[tile])
                if there > 0:
                    moves.append(TileMove(tile, job.job))
                left[tile] = there - 1
        return tuple(moves)

    def fillings(self, station: int, room: int) -> tuple[TileMove, ...]:
        """The moves by which a letter station fills a bucket, the oldest bundle first."""
        tiles = [TileMove(tile, job.job) for job in self.at[station].values() for tile in job.missing]
        return tuple(tiles[: max(0, room)])

    def _count(self, job: Job, sign: int) -> None:
        if job.kind == DELIVER:
            for tile in job.missing:
                self.need[job.station, tile] += sign
