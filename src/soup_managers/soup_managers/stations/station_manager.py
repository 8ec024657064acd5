"""What the word and the letter manager have in common: stations to fill with jobs, jobs to have done."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from soup_managers.explain import Explain
from soup_managers.manager import Manager
from soup_managers.stations.request import ASK_AGAIN_S, Request
from soup_managers.view import WarehouseView
from soup_msgs_py.codes import Code
from soup_msgs_py.messages import AssignBundle, AssignWord, DeliverGoal, Reply, StoreGoal, TaskResult
from soup_msgs_py.mind import NEVER, Message


class StationManager(Manager):
    """Fills free places on its stations, and has the fleet do what each job there (a word, a bundle) needs.

    A task of the fleet carries the number of its job. The manager keeps nothing that a new one could not find
    in a snapshot. A subclass says which task a job needs and which job comes next.

    Attributes:
        kind: Of the tasks of the fleet.
        role: What the policy decides.
        policy: What decides.
    """

    kind: str
    role: str
    policy: Any

    def __init__(self, view: WarehouseView, stations: range, explain: Explain | None) -> None:
        super().__init__(view)
        self._explain = explain or Explain()
        self._stations = stations
        self._request = Request()
        self._goal_due: dict[int, float] = {}  # jobs whose task ended too early, and when to ask again
        self._handlers |= {Reply: self._handle_reply, TaskResult: self._handle_result}

    def jobs(self) -> Iterable[int]:
        """Numbers of the jobs on the stations."""
        raise NotImplementedError

    def goal(self, job: int) -> DeliverGoal | StoreGoal | None:
        """The task that a job still needs, if it does."""
        raise NotImplementedError

    def choose(self, free: list[int]) -> AssignWord | AssignBundle | None:
        """The next job and one of the stations with a free place for it, or None for no job now."""
        raise NotImplementedError

    def problem(self, choice: AssignWord | AssignBundle) -> str:
        """What is wrong with the job of a choice; empty for nothing."""
        raise NotImplementedError

    def on_world(self, now: float) -> list[Message]:
        """Have all jobs done, and fill the free places."""
        self._request.drop()
        self._goal_due.clear()
        return self.ask_fleet(self.jobs()) + self.fill_places(now)

    def wake(self, now: float) -> list[Message]:
        """Ask again for what was refused or ended too early."""
        due = [job for job, time in self._goal_due.items() if time <= now]
        for job in due:
            del self._goal_due[job]
        self._request.expire(now)
        return self.ask_fleet(due) + self.fill_places(now)

    def ask_fleet(self, jobs: Iterable[int]) -> list[Message]:
        """The goals of those jobs that need one."""
        goals = [self.goal(job) for job in jobs]
        return [goal for goal in goals if goal is not None]

    def fill_places(self, now: float) -> list[Message]:
        """Ask the world for one more job, if there is a place for it and nothing else is asked."""
        asked: list[Message] = []
        if self.view.ready and not self.view.lost and self._request.is_allowed(now):
            places = self.view.free_places
            free = [station for station in self._stations if places[station] > 0]
            self._explain.now = now
            choice = self._checked(self.choose(free), free) if free else None
            if choice is not None:
                self._request.send(choice, now)
                asked.append(choice)
            elif free:
                self._request.rest(now)
        self._set_alarm()
        return asked

    def _checked(self, choice: AssignWord | AssignBundle | None, free: list[int]) -> AssignWord | AssignBundle | None:
        """A choice that the world can carry out; None for one that it cannot, which is noted."""
        if choice is None:
            return None
        if not isinstance(choice, AssignWord | AssignBundle):
            problem = "what is no request to the world"
        elif choice.station not in free:
            problem = "a station without a free place"
        else:
            problem = self.problem(choice)
        if problem:
            self.mistakes.add(self.role, self.policy, problem, choice)
            return None
        return choice

    def assigned(self, event_job: int, station: int, tile: int, now: float) -> list[Message]:
        """A job came onto a station, by whomever: have it done, and go on."""
        self._request.happened(event_job, station, tile)
        return self.ask_fleet([event_job]) + self.fill_places(now)

    def _handle_reply(self, reply: Reply, now: float) -> list[Message]:
        self._request.answered(reply, now)
        return self.fill_places(now)

    def _handle_result(self, result: TaskResult, now: float) -> list[Message]:
        if result.kind == self.kind and result.code is not Code.REPLACED and self.goal(result.task) is not None:
            self._goal_due[result.task] = now + ASK_AGAIN_S
            self._set_alarm()
        return []

    def _set_alarm(self) -> None:
        self.next_wake = min([self._request.next_wake, *self._goal_due.values(), NEVER])
