"""What the word and letter managers ask of the fleet."""

from __future__ import annotations

from soup_msgs_py.codes import Code
from soup_msgs_py.messages.base import message

DELIVER = "deliver"
STORE = "store"


@message
class DeliverGoal:
    """Bring the letters that an open word lacks to its station.

    Tasks are known by their kind (DELIVER or STORE) and the number that their manager gives them.
    """

    task: int
    station: int
    word: int
    tiles: tuple[int, ...]


@message
class StoreGoal:
    """Bring buckets to a letter station until a staged bundle is stored."""

    task: int
    station: int
    bundle: int
    tile: int
    count: int


@message
class TaskFeedback:
    """How far a task has come: the tiles still to be moved, and why it waits, if it does."""

    kind: str
    task: int
    missing: tuple[int, ...]
    message: str


@message
class TaskResult:
    """How a task ended."""

    kind: str
    task: int
    code: Code
    message: str


@message
class CancelTask:
    """Take a task back."""

    kind: str
    task: int


@message
class TaskState:
    """One line of the fleet's list of tasks. `kind` is `deliver` or `store`."""

    task: int
    kind: str
    station: int
    job: int
    tiles: tuple[int, ...]
    bots: tuple[int, ...]
    message: str


@message
class Tasks:
    """All tasks of the fleet."""

    time: float
    tasks: tuple[TaskState, ...]


@message
class Bound:
    """Which buckets the fleet has bound for which stations now, in the order of their binding; -1 for no bucket."""

    time: float
    buckets: tuple[int, ...]
    stations: tuple[int, ...]
