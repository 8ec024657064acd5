"""The letters that wait to be moved: first in, first out, those set aside that nothing can be done for."""

from __future__ import annotations

import heapq
from collections.abc import Iterator, KeysView

from soup_managers.fleets.minimal.plans import Key, Letter, Place

_Entry = tuple[tuple[int, int], int, Letter]
Awaited = int | Key  # a tile kind, `LetterQueue.ROOM`, or a task
MOST_GONE = 200  # letters that are kept though nobody waits for them any more


class LetterQueue:
    """Waiting letters in the order of their tasks' arrival.

    A letter is set aside under what it waits for: its tile kind, `ROOM` in a bucket, or the end of the trip that
    its task is on. Each bucket that becomes free brings one such letter back, the oldest, because one is what the
    bucket can serve at once; and so does each trip that ends.
    """

    ROOM = -1

    def __init__(self) -> None:
        self._queue: list[_Entry] = []
        self._aside: dict[Awaited, list[_Entry]] = {}
        self._serial = 0
        self._gone = 0  # letters that were dropped since the last sweep

    def add(self, letter: Letter) -> None:
        """Put a letter at its place in the order."""
        letter.place = Place.QUEUED
        heapq.heappush(self._queue, self._entry(letter))

    def defer(self, letter: Letter, until: Awaited) -> None:
        """Set a queued letter aside until a bucket with that tile kind, or `ROOM`, or its own task becomes free."""
        letter.place = Place.DEFERRED
        heapq.heappush(self._aside.setdefault(until, []), self._entry(letter))

    def drop(self, letter: Letter) -> None:
        """A letter is not to be moved any more; it stays where it is until its turn, or until there are many such."""
        letter.place = Place.GONE
        self._gone += 1
        if self._gone > max(MOST_GONE, len(self._queue) // 2):
            self._sweep()

    def _sweep(self) -> None:
        """Throw away all letters that are gone: those whose turn never comes would be kept for ever."""
        self._gone = 0
        for waiting in (self._queue, *self._aside.values()):
            waiting[:] = [entry for entry in waiting if entry[2].place is not Place.GONE]
            heapq.heapify(waiting)
        self._aside = {until: waiting for until, waiting in self._aside.items() if waiting}

    def bring_back(self, until: Awaited) -> Letter | None:
        """Queue the oldest of the letters that wait for a tile kind, for `ROOM` or for a task."""
        waiting = self._aside.get(until)
        while waiting:
            letter = heapq.heappop(waiting)[2]
            if not waiting:
                del self._aside[until]
            if letter.place is Place.DEFERRED:
                self.add(letter)
                return letter
        return None

    @property
    def awaited(self) -> KeysView[Awaited]:
        """What letters are set aside for: tile kinds, `ROOM` and tasks."""
        return self._aside.keys()

    def __bool__(self) -> bool:
        """Whether letters are queued that are not set aside."""
        queue = self._queue
        while queue and queue[0][2].place is not Place.QUEUED:
            heapq.heappop(queue)
        return bool(queue)

    def in_order(self) -> Iterator[Letter]:
        """The queued letters. While it runs, letters may be promised, set aside or dropped."""
        passed: list[_Entry] = []
        try:
            while self:
                entry = self._queue[0]
                yield entry[2]
                if entry[2].place is Place.QUEUED and self._queue and self._queue[0] is entry:
                    passed.append(heapq.heappop(self._queue))
        finally:
            for entry in passed:
                heapq.heappush(self._queue, entry)

    def _entry(self, letter: Letter) -> _Entry:
        self._serial += 1  # letters themselves have no order
        return letter.order, self._serial, letter
