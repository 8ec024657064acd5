"""The letters of the fleet's tasks: which wait, and which trips have promised to move."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from soup_managers.fleets.minimal.letter_queue import LetterQueue
from soup_managers.fleets.minimal.plans import Letter, Place
from soup_managers.state.tasks import Key, Task, TaskBook
from soup_msgs_py.messages import DELIVER


@dataclass(slots=True, eq=False)
class LetterTask(Task):
    """A task letter by letter; `missing` includes promised ones.

    Attributes:
        waiting: Its letters that no trip has promised to move, by tile kind.
    """

    waiting: dict[int, list[Letter]] = field(default_factory=dict)


class LetterBook(TaskBook[LetterTask]):
    """All tasks, their waiting letters in one queue, and how many letters trips have promised to move.

    For each task and tile kind, letters waiting and letters promised together are never more than are
    missing: so no letter is moved twice.

    Attributes:
        queue: The waiting letters.
        changed: Tasks whose managers may have to be told something, as an ordered set.
    """

    def __init__(self) -> None:
        """Begin with none."""
        super().__init__(LetterTask)
        self.queue = LetterQueue()
        self.changed: dict[Key, LetterTask] = {}
        self._promised: dict[Key, dict[int, int]] = {}
        self._arrivals = 0

    def accept(self, task: LetterTask) -> None:
        """Take a task on. Letters that trips have promised already are not asked for again."""
        super().accept(task)
        self._arrivals += 1
        self.changed[task.key] = task
        promised = dict(self._promised.get(task.key, {}))
        for number, tile in enumerate(task.missing):
            if promised.get(tile, 0) > 0:
                promised[tile] -= 1
            else:
                self._wait(task, Letter((self._arrivals, number), task.key, task.station, tile))

    def remove(self, task: LetterTask) -> None:
        """Forget a task; what trips have promised stays in the books until they end."""
        super().remove(task)
        self.changed.pop(task.key, None)
        for letters in task.waiting.values():
            for letter in letters:
                self._drop(letter)

    def promise(self, letter: Letter) -> None:
        """A trip is to move a letter."""
        letter.place = Place.PROMISED
        promised = self._promised.setdefault(letter.key, {})
        promised[letter.tile] = promised.get(letter.tile, 0) + 1
        task = self.tasks.get(letter.key)
        if task is not None:
            self.changed[task.key] = task
            letters = task.waiting.get(letter.tile, [])
            if letter in letters:
                letters.remove(letter)

    def take_back(self, letter: Letter) -> None:
        """A trip did not move a letter: it waits again at its old place in the order, if still missing."""
        self._fulfil(letter)
        task = self.tasks.get(letter.key)
        if task is None:
            return
        self.changed[task.key] = task
        if self._accounted(task, letter.tile) < task.missing.count(letter.tile):
            self._wait(task, letter)

    def moved(self, key: Key, tile: int, sequence: int, promised: Letter | None) -> None:
        """A tile was moved, as an event told: by the trip that had promised that letter, or by another."""
        if promised is not None:
            self._fulfil(promised)
        task = self.tasks.get(key)
        if task is None:
            return
        self.changed[key] = task
        if sequence > task.seen and tile in task.missing:
            task.missing.remove(tile)
        waiting = task.waiting.get(tile)
        while waiting and self._accounted(task, tile) > task.missing.count(tile):
            self._drop(waiting.pop())
        if promised is not None and self._accounted(task, tile) < task.missing.count(tile):
            # the task was counted when this move was known already, but still promised: another letter is lacking
            self._wait(task, Letter(promised.order, key, task.station, tile))

    def set_missing(self, task: LetterTask, missing: Iterable[int], seen: int) -> None:
        """Take over from the world what a task lacks, where the transfers do not tell."""
        self.remove(task)
        super().set_missing(task, missing, seen)
        task.waiting = {}
        self.accept(task)

    def reason(self, task: LetterTask) -> str:
        """Why a task waits; empty where all its letters are on their way."""
        reason = ""
        for letters in task.waiting.values():
            for letter in letters:
                if letter.place is Place.DEFERRED:
                    return letter.reason
                reason = "all bots are busy"
        return reason

    def _accounted(self, task: LetterTask, tile: int) -> int:
        return len(task.waiting.get(tile, ())) + self._promised.get(task.key, {}).get(tile, 0)

    def _wait(self, task: LetterTask, letter: Letter) -> None:
        task.waiting.setdefault(letter.tile, []).append(letter)
        self.queue.add(letter)

    def _drop(self, letter: Letter) -> None:
        queued = letter.place is Place.QUEUED
        self.queue.drop(letter)
        if queued:
            # it may be the one that a free bucket, or the end of a trip, brought back: another may have its chance
            self.queue.bring_back(letter.tile if letter.key[0] == DELIVER else LetterQueue.ROOM)
            self.queue.bring_back(letter.key)

    def _fulfil(self, letter: Letter) -> None:
        letter.place = Place.GONE
        promised = self._promised[letter.key]
        promised[letter.tile] -= 1
        if not promised[letter.tile]:
            del promised[letter.tile]
            if not promised:
                del self._promised[letter.key]
