"""What all fleets have in common: they take tasks on, say why they wait and how they end, and start anew."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Generic

from soup_managers.manager import Manager
from soup_managers.state.tasks import AnyTask, TaskBook, common_tiles, goal_key, goal_tiles
from soup_managers.view import WarehouseView
from soup_msgs_py.codes import Code, EventType
from soup_msgs_py.messages import (
    DELIVER,
    STORE,
    BotStatus,
    CancelTask,
    DeliverGoal,
    Event,
    StoreGoal,
    TaskFeedback,
    TaskResult,
    TaskState,
)
from soup_msgs_py.mind import Message


class Fleet(Manager, Generic[AnyTask]):
    """The fleet manager (the paper's bucketbot manager): has the bots do what the other managers ask for.

    It owns nothing durable: a new one finds the world in the snapshot, what bots do in their statuses, and its tasks
    in the goals that their managers send again. A fleet says why a task waits (`reason`), who works for it (`bots_of`),
    and what it does about the tasks (`step`).

    Attributes:
        book: The tasks.
        wants_places: Whether it has to see where bots stand.
        stalled: Bots that do not do what they were asked for, and why.
    """

    wants_places = False

    def __init__(self, view: WarehouseView, book: TaskBook[AnyTask]) -> None:
        """Begin with a world that is not heard of yet."""
        super().__init__(view)
        self.book = book
        self._early: list[DeliverGoal | StoreGoal | BotStatus] = []  # what came before the first snapshot
        self._ahead: dict[int, DeliverGoal] = {}  # by word: goals that came before it was opened
        self._handlers |= {
            DeliverGoal: self._handle_goal,
            StoreGoal: self._handle_goal,
            CancelTask: self._handle_cancel,
            BotStatus: self._handle_status,
        }

    # ---- what a fleet gives --------------------------------------------------------------------------------

    @property
    def stalled(self) -> dict[int, str]:
        """Bots that do not do what they were asked for, and why."""
        raise NotImplementedError

    def reason(self, task: AnyTask) -> str:
        """Why a task waits; empty where all that it lacks is on its way."""
        raise NotImplementedError

    def bots_of(self) -> dict[tuple[str, int], tuple[int, ...]]:
        """The bots that work for each task, by its key; tasks without any may be left out."""
        raise NotImplementedError

    def on_status(self, status: BotStatus, now: float) -> list[Message]:
        """A bot says what it does; the world is known by now."""
        raise NotImplementedError

    def take_over(self, now: float) -> None:
        """Make the own books about the world anew from the view."""
        raise NotImplementedError

    def on_goal(self, task: AnyTask) -> None:
        """A task was taken on."""

    def on_cancel(self, task: AnyTask) -> list[Message]:
        """A task was taken back, and is in the book no more."""
        return []

    def step(self, now: float) -> list[Message]:
        """Do what can be done now."""
        raise NotImplementedError

    # ---- what is the same for all --------------------------------------------------------------------------

    def tasks(self) -> tuple[TaskState, ...]:
        """The fleet's list of tasks, in the order of their arrival."""
        bots = self.bots_of()
        return tuple(
            [
                TaskState(
                    task.number, task.kind, task.station, task.job, tuple(task.missing),
                    bots.get(task.key, ()), self.reason(task),
                )
                for task in self.book.tasks.values()
            ]
        )  # fmt: skip

    def on_world(self, now: float) -> list[Message]:
        """Take over what came before the snapshot; after a gap, correct all tasks by what is there."""
        self.take_over(now)
        # what bots do comes first: it may be what the goals ask for
        early = sorted(self._early, key=lambda message: not isinstance(message, BotStatus))
        early += self._ahead.values()  # words may have been opened without an event that was heard
        self._early, self._ahead = [], {}
        said = [answer for message in early for answer in self.handle(message, now)]
        for task in list(self.book.tasks.values()):
            left = self._lacking(task.kind, task.job, task.station) or ()
            self.book.set_missing(task, common_tiles(task.missing, left), self.view.sequence)
        return said + self.step(now)

    def tell_tasks(self, tasks: Iterable[AnyTask]) -> list[Message]:
        """How tasks have ended that lack nothing, and what is new about the others."""
        said: list[Message] = []
        for task in tasks:
            if not task.missing:
                said.append(self.end(task))
                continue
            told = len(task.missing), self.reason(task)
            if told != task.told:
                task.told = told
                said.append(TaskFeedback(task.kind, task.number, tuple(task.missing), told[1]))
        return said

    def completed(self, event: Event) -> AnyTask | None:
        """The task whose word is complete, or whose bundle is empty, by this event."""
        kind = DELIVER if event.type is EventType.WORD_COMPLETED else STORE
        return self.book.tasks.get((kind, event.job))

    def opened(self, event: Event, now: float) -> list[Message]:
        """A word is open now: its goal may have come before."""
        goal = self._ahead.pop(event.job, None)
        return self._handle_goal(goal, now) if goal is not None else []

    def end(self, task: AnyTask) -> TaskResult:
        """A task is done."""
        self.book.remove(task)
        return TaskResult(task.kind, task.number, Code.DONE, "all letters are in place")

    def _handle_status(self, status: BotStatus, now: float) -> list[Message]:
        if not self.view.ready:
            self._early.append(status)
            return []
        return self.on_status(status, now)

    def _handle_goal(self, goal: DeliverGoal | StoreGoal, now: float) -> list[Message]:
        kind, job = key = goal_key(goal)
        if not self.view.ready:
            self._early.append(goal)
            return [TaskFeedback(kind, goal.task, goal_tiles(goal), "the fleet waits for a snapshot of the world")]
        said: list[Message] = []
        if isinstance(goal, DeliverGoal) and job in self.view.waiting_words:
            before = self._ahead.get(job)
            self._ahead[job] = goal
            said.append(TaskFeedback(kind, goal.task, goal_tiles(goal), f"word {job} is not open yet"))
            if before is not None and before.task != goal.task:
                said.append(_replaced(kind, before.task, goal.task))
            return said
        left = self._lacking(kind, job, goal.station)
        if left is None:
            what = f"word {job} is not open" if kind == DELIVER else f"bundle {job} is not staged"
            return [TaskResult(kind, goal.task, Code.UNKNOWN, f"{what} on station {goal.station}")]
        known, other = self.book.numbered(kind, goal.task), self.book.tasks.get(key)
        if other is not None and other is not known:
            said.append(_replaced(kind, other.number, goal.task))
            self.book.remove(other)
        if known is not None:
            self.book.remove(known)
        missing = common_tiles(goal_tiles(goal), left)
        task = self.book.kind(kind, goal.task, goal.station, job, missing, self.view.sequence)
        self.book.accept(task)
        self.on_goal(task)
        return said + self.step(now)

    def _handle_cancel(self, cancel: CancelTask, now: float) -> list[Message]:
        taken_back = TaskResult(cancel.kind, cancel.task, Code.CANCELLED, "taken back")
        if cancel.kind == DELIVER:
            for word in [word for word, goal in self._ahead.items() if goal.task == cancel.task]:
                del self._ahead[word]
                return [taken_back]
        task = self.book.numbered(cancel.kind, cancel.task)
        if task is None:
            text = f"the fleet has no {cancel.kind} task {cancel.task}"
            return [TaskResult(cancel.kind, cancel.task, Code.UNKNOWN, text)]
        self.book.remove(task)
        return [taken_back, *self.on_cancel(task), *self.step(now)]

    def _lacking(self, kind: str, job: int, station: int) -> tuple[int, ...] | None:
        """The tiles that a word or bundle on a station still needs moved; None where there is no such one."""
        if kind == DELIVER:
            word = self.view.open_words.get(job)
            return word.missing if word is not None and word.station == station else None
        bundle = self.view.staged_bundles.get(job)
        return (bundle.tile,) * bundle.count if bundle is not None and bundle.station == station else None


def _replaced(kind: str, before: int, task: int) -> TaskResult:
    return TaskResult(kind, before, Code.REPLACED, f"task {task} asks for the same")
