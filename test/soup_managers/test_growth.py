"""A fleet that has served ten thousand tasks is no larger than one that has served a hundred."""

from __future__ import annotations

from collections import deque
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from soup_managers.fleets.make import load_fleet, make_fleet
from soup_managers.view import WarehouseView
from soup_msgs_py.codes import EventType, Phase
from soup_msgs_py.messages import (
    DELIVER,
    BotStatus,
    CancelTask,
    DeliverGoal,
    Event,
    TaskResult,
)
from soup_msgs_py.policies import PolicyChoice
from soup_sim.scenario_loader import load_warehouse

CONFIG = Path(__file__).resolve().parents[2] / "config"
SHORT = 25  # letters that a word of the jargon has at most


def elements(thing: Any) -> int:
    """How many elements all containers hold that are reachable from an object of the managers'."""
    seen: set[int] = set()
    count = 0
    waiting = deque([thing])
    while waiting:
        part = waiting.popleft()
        if id(part) in seen:
            continue
        seen.add(id(part))
        if isinstance(part, np.ndarray):
            count += part.size
        elif isinstance(part, dict):
            count += len(part)
            waiting.extend(part.values())
        elif isinstance(part, list | tuple | set | frozenset | deque):
            count += len(part)
            waiting.extend(part)
        elif type(part).__module__.startswith("soup_managers"):
            waiting.extend(vars(part).values() if hasattr(part, "__dict__") else ())
            names = [name for kind in type(part).__mro__ for name in getattr(kind, "__slots__", ())]
            waiting.extend(getattr(part, name) for name in names if hasattr(part, name))
        elif is_dataclass(part) and not isinstance(part, type):
            waiting.extend(getattr(part, field.name) for field in fields(part))
    return count


class Served:
    """A fleet to whose stations one word after another comes, whose letters somebody else brings."""

    def __init__(self, policy: str) -> None:
        warehouse = load_warehouse(CONFIG / "scenarios/demo.yaml", [])
        self.world = warehouse.world(1)
        scenario, layout = self.world.scenario, self.world.layout
        self.view = WarehouseView(scenario, layout)
        choice = PolicyChoice(name=policy)
        self.fleet = make_fleet(scenario, layout, load_fleet(choice), self.view, np.random.default_rng(1))
        self.fleet.handle(self.world.snapshot(), 0.0)
        for bot in range(scenario.bots):
            self.fleet.handle(BotStatus(0.0, bot, Phase.BY_HAND, -1, None, 0, "is driven by hand"), 0.0)
        self.sequence = self.world.sequence
        self.ended = 0

    def tell(self, message: Any) -> None:
        """Tell the fleet something, and count the tasks that it says have ended."""
        self.ended += sum(isinstance(said, TaskResult) for said in self.fleet.handle(message, self.now))

    def event(self, kind: EventType, **about: Any) -> None:
        """The world says something."""
        self.sequence += 1
        self.tell(Event(self.now, self.sequence, kind, **about))

    def serve(self, words: range) -> None:
        """Words come, are opened, get their letters or are taken back, and go."""
        for number in words:
            self.now = float(number)
            word, station, tile = 1_000_000 + number, number % self.world.scenario.word_station_count, number % 26
            self.event(EventType.WORD_ARRIVED, job=word, tiles=(tile,), text="A")
            goal = DeliverGoal(word, station, word, (tile,))
            if number % 3 == 0:
                self.tell(goal)  # before the word is opened
            self.event(EventType.WORD_ASSIGNED, job=word, station=station)
            self.tell(goal)
            if number % 5 == 0:
                self.tell(DeliverGoal(word + 500_000, station, word, (tile,)))  # another asks for the same
            if number % 7 == 0:
                self.tell(CancelTask(DELIVER, word))
            bucket = next(b for b, contents in enumerate(self.view.contents) if contents.get(tile, 0) > 0)
            self.event(EventType.TRANSFERRED, bot=0, bucket=bucket, station=station, tile=tile, job=word, x=9.0, y=9.0)
            self.event(EventType.WORD_COMPLETED, job=word, station=station, count=1)
            self.event(EventType.WORD_CLEARED, job=word, station=station)
            self._refill(bucket, tile)
            if self.fleet.next_wake <= self.now:
                self.fleet.wake(self.now)

    def _refill(self, bucket: int, tile: int) -> None:
        """A tile of the kind goes back into the bucket, at a letter station."""
        letters = self.world.scenario.word_station_count
        self.event(EventType.TRANSFERRED, bot=0, bucket=bucket, station=letters, tile=tile, job=-1, x=9.0, y=9.0)
        self.view.stock[tile] += 1

    now = 0.0


@pytest.mark.parametrize("policy", ["minimal", "coordinated"])
def test_a_fleet_that_served_ten_thousand_tasks_is_no_larger_than_one_that_served_a_hundred(policy: str) -> None:
    served = Served(policy)
    served.serve(range(100))
    after_a_hundred = elements(served.fleet)
    served.serve(range(100, 10_000))
    assert served.ended >= 10_000
    assert elements(served.fleet) <= 1.02 * after_a_hundred
