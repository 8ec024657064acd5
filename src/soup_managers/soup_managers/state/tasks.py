"""The task book of a fleet: the words and bundles that the other managers ask it to serve."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Generic, TypeVar

from soup_msgs_py.messages import DELIVER, STORE, DeliverGoal, StoreGoal

Key = tuple[str, int]  # DELIVER and a word, or STORE and a bundle


@dataclass(slots=True, eq=False)
class Task:
    """A task that a word or letter manager asked for.

    Attributes:
        kind: DELIVER or STORE.
        number: As its manager numbered it.
        station: Where the word or bundle is.
        job: The word or bundle.
        missing: Tiles that are still to be moved.
        seen: The event up to which `missing` is true.
        told: What its manager was last told: how many tiles are missing, and the reason.
    """

    kind: str
    number: int
    station: int
    job: int
    missing: list[int]
    seen: int
    told: tuple[int, str] | None = None

    @property
    def key(self) -> Key:
        """What its tiles are for."""
        return self.kind, self.job


AnyTask = TypeVar("AnyTask", bound=Task)


class TaskBook(Generic[AnyTask]):
    """All tasks; fleets add to it what they look up by.

    Attributes:
        tasks: In the order of their arrival.
    """

    def __init__(self, kind: type[AnyTask]) -> None:
        """Begin with none; `kind` makes them."""
        self.kind = kind
        self.tasks: dict[Key, AnyTask] = {}

    def accept(self, task: AnyTask) -> None:
        """Take a task on."""
        self.tasks[task.key] = task

    def remove(self, task: AnyTask) -> None:
        """Forget a task."""
        del self.tasks[task.key]

    def set_missing(self, task: AnyTask, missing: Iterable[int], seen: int) -> None:
        """Take over what a task really lacks after the event with number `seen`."""
        task.missing, task.seen = list(missing), seen

    def numbered(self, kind: str, number: int) -> AnyTask | None:
        """The task of a manager."""
        # managers give a task the number of its job, but anyone may ask the fleet
        task = self.tasks.get((kind, number))
        if task is not None and task.number == number:
            return task
        return next((task for task in self.tasks.values() if task.kind == kind and task.number == number), None)


def goal_key(goal: DeliverGoal | StoreGoal) -> Key:
    """What a goal asks to have served."""
    return (DELIVER, goal.word) if isinstance(goal, DeliverGoal) else (STORE, goal.bundle)


def goal_tiles(goal: DeliverGoal | StoreGoal) -> tuple[int, ...]:
    """The tiles that a goal asks to have moved."""
    return goal.tiles if isinstance(goal, DeliverGoal) else (goal.tile,) * goal.count


def common_tiles(asked: Iterable[int], left: Iterable[int]) -> list[int]:
    """The tiles that were asked for and are still missing, each as often as in both."""
    rest = list(left)
    common = []
    for tile in asked:
        if tile in rest:
            rest.remove(tile)
            common.append(tile)
    return common
