"""The coordinated fleet keeps its bots apart and at work, also where messages are slow and things go wrong."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from soup_lab.headless.simulation import Headless
from soup_managers.fleets.coordinated.fleet import CoordinatedFleet
from soup_msgs_py import messages as m
from soup_msgs_py.codes import Code, EventType
from soup_msgs_py.policies import load_policies
from soup_sim.scenario_loader import load_warehouse

CONFIG = Path(__file__).resolve().parents[2] / "config"
STEP_S = 0.05
LATE = 0.2  # of all drives


class SlowWires(Headless):
    """A run in which drives take their time from the fleet to their bots.

    Args:
        slowest_s: One in five takes up to this, simulated, as where the world goes on without the fleet.
    """

    def __init__(self, slowest_s: float, bots: int) -> None:
        warehouse = load_warehouse(CONFIG / "scenarios/demo.yaml", [f"bots={bots}"])
        self.late = 0
        self._under_way: list[tuple[float, m.DriveGoal]] = []
        self._slowest_s = slowest_s
        self._delays = np.random.default_rng(5)
        self.events: list[m.Event] = []
        super().__init__(
            warehouse.world(5, 0.0), load_policies(CONFIG / "policies/best.yaml", {}), 5, self.events.append
        )

    def _say(self, speaker, messages):
        slow = [message for message in messages if self._slowest_s and isinstance(message, m.DriveGoal)]
        slow = [goal for goal in slow if self._delays.random() < LATE]
        for goal in slow:
            self._under_way.append((self.world.now + self._delays.uniform(0.0, self._slowest_s), goal))
        self.late += sum(isinstance(message, m.DriveResult) and message.code is Code.LATE for message in messages)
        super()._say(speaker, [message for message in messages if message not in slow])

    def run(self, until):
        while self.world.now < until:
            super().run(min(until, self.world.now + STEP_S))
            due = [goal for time, goal in self._under_way if time <= self.world.now]
            self._under_way = [(time, goal) for time, goal in self._under_way if time > self.world.now]
            for goal in due:
                super()._say(self.crew, self.crew.handle(goal, self.world.now))
            self._carry()

    def count(self, *kinds: EventType) -> int:
        return sum(event.type in kinds for event in self.events)

    @property
    def collisions(self) -> int:
        return self.count(EventType.BOT_COLLISION, EventType.BUCKET_COLLISION)


def test_a_drive_that_comes_too_late_is_refused_and_planned_anew():
    run = SlowWires(0.3, 1)
    run.run(600.0)
    assert run.late > 0
    assert run.collisions == 0
    assert sum(event.type is EventType.WORD_COMPLETED for event in run.events if event.time > 300.0) > 5


def test_no_bucket_is_set_down_where_a_storage_spot_was_taken_away():
    run = SlowWires(0.0, 8)
    run.run(60.0)
    rng = np.random.default_rng(3)
    spots = run.world.layout.storage_spots.tolist()
    for spot in rng.permutation(spots).tolist():
        run.tell(run.world, m.SetStorageSpot(spot, False))
    removed = {event.waypoint for event in run.events if event.type is EventType.SPOT_REMOVED}
    assert len(removed) > 3
    run.run(600.0)
    places = {tuple(np.round(run.world.layout.waypoints[spot], 3)) for spot in removed}
    set_down = [event for event in run.events if event.type is EventType.RELEASED and event.time > 90.0]
    assert run.collisions == 0
    assert len(set_down) > 10
    assert not places & {(round(event.x, 3), round(event.y, 3)) for event in set_down}
    assert sum(event.type is EventType.WORD_COMPLETED for event in run.events if event.time > 300.0) > 20
    # and one that is made again is used again
    for spot in removed:
        run.tell(run.world, m.SetStorageSpot(spot, True))
    run.run(1200.0)
    assert places & {
        (round(e.x, 3), round(e.y, 3)) for e in run.events if e.type is EventType.RELEASED and e.time > 600
    }


def test_a_task_tells_whenever_it_waits_for_something_else_or_has_come_further():
    run = SlowWires(0.0, 4)
    told: dict[tuple[str, int], list[m.TaskFeedback]] = {}
    assert isinstance(run.fleet, CoordinatedFleet)
    handle = run.word.handle

    def hear(message, now):
        if isinstance(message, m.TaskFeedback):
            told.setdefault((message.kind, message.task), []).append(message)
        return handle(message, now)

    run.word.handle = hear
    for _ in range(120):
        run.run(run.world.now + 1.0)
        for task in run.fleet.tasks():
            heard = told.get((task.kind, task.task))
            if task.kind == m.DELIVER and heard:
                assert len(heard[-1].missing) >= len(task.tiles)
    reasons = {feedback.message for heard in told.values() for feedback in heard}
    assert {"", "all bots are busy"} <= reasons
    for heard in told.values():
        told_of = [(feedback.message, feedback.missing) for feedback in heard]
        assert all(before != after for before, after in pairwise(told_of))
    assert any(len(heard[-1].missing) < len(heard[0].missing) for heard in told.values())


def test_the_newest_reason_of_every_task_has_been_told_a_second_later():
    run = SlowWires(0.0, 4)
    assert isinstance(run.fleet, CoordinatedFleet)
    newest: dict[int, str] = {}
    handle = run.word.handle

    def hear(message, now):
        if isinstance(message, m.TaskFeedback):
            newest[message.task] = message.message
        return handle(message, now)

    run.word.handle = hear
    late: dict[int, float] = {}  # tasks whose newest reason is not told, and since when
    for _ in range(240):
        run.run(run.world.now + 0.25)
        now = run.world.now
        tasks = {task.task: task.message for task in run.fleet.tasks() if task.kind == m.DELIVER}
        late = {task: late.get(task, now) for task, why in tasks.items() if newest.get(task) != why}
        assert all(now - since <= 1.5 for since in late.values())


def test_a_goal_that_comes_before_its_word_is_opened_is_told_and_can_be_taken_back_or_replaced():
    run = SlowWires(0.0, 4)
    run.run(5.0)
    word = next(iter(run.fleet.view.waiting_words.values()))
    goal = m.DeliverGoal(70_001, 0, word.word, word.tiles)
    assert [type(said) for said in run.fleet.handle(goal, run.world.now)] == [m.TaskFeedback]
    said = run.fleet.handle(replace(goal, task=70_002), run.world.now)
    assert [(type(s), s.task) for s in said] == [(m.TaskFeedback, 70_002), (m.TaskResult, 70_001)]
    assert said[1].code is Code.REPLACED
    (result,) = run.fleet.handle(m.CancelTask(m.DELIVER, 70_002), run.world.now)
    assert result.code is Code.CANCELLED
