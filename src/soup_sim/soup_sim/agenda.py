"""The agenda of the world: what is due when, and what has been said so far."""

from __future__ import annotations

import heapq
from collections.abc import Callable
from typing import Any

import numpy as np

from soup_msgs_py.codes import BotState, Code, EventType
from soup_msgs_py.messages import BotReply, Event, Reply
from soup_sim.bodies import Bodies
from soup_sim.statistics import Statistics

# looked up once: an enumeration's members are slow to reach
_FREE, _MOVING, _PENALISED = BotState.FREE, BotState.MOVING, BotState.PENALISED
_MOVING_STATE = int(_MOVING)  # and slow to compare with arrays
Action = Callable[..., None]
Entry = tuple[float, int, str, tuple[Any, ...]]
Said = Event | BotReply | Reply


def _nothing() -> None:
    """What there is to do at the end of an instant, if nobody wants anything."""


class Agenda:
    """Simulated time, things that are due, and the outbox. The parts of the world share one.

    Things due at the same instant happen in the order in which they were put down. Actions go by names, so that the
    agenda can be written down in a checkpoint.

    Attributes:
        now: Simulated time in seconds.
        sequence: Number of the last event.
        at_end_of_instant: Called when nothing more happens now, before time goes on; it may put down more.
    """

    def __init__(self) -> None:
        self.now = 0.0
        self.sequence = 0
        self._actions: dict[str, Action] = {}
        self._due: list[Entry] = []
        self._entries = 0
        self._outbox: list[Said] = []
        self.at_end_of_instant: Callable[[], None] = _nothing

    def can(self, **actions: Action) -> None:
        """Make actions known by their names."""
        self._actions.update(actions)

    def at(self, time: float, action: str, *arguments: Any) -> None:
        """Put down an action for a time; for now at the earliest. Arguments are numbers."""
        self._entries += 1
        heapq.heappush(self._due, (max(time, self.now), self._entries, action, arguments))

    @property
    def next_time(self) -> float:
        """When the next thing is due; infinity for never."""
        self.at_end_of_instant()
        return self._due[0][0] if self._due else float("inf")

    def run(self, until: float, pause: bool = False) -> None:
        """Do everything that is due up to a time, and make it now.

        With `pause`, stop at the first instant at which something was said.
        """
        due = self._due
        while True:
            if not due or due[0][0] > self.now:
                self.at_end_of_instant()
            if not due or due[0][0] > until or (pause and self._outbox and due[0][0] > self.now):
                break
            self.now, _, action, arguments = heapq.heappop(due)
            self._actions[action](*arguments)
        if not (pause and self._outbox):
            self.now = until

    def capture(self) -> dict[str, Any]:
        """Everything but the outbox, for a checkpoint."""
        return {"now": self.now, "sequence": self.sequence, "entries": self._entries, "due": sorted(self._due)}

    def restore(self, state: dict[str, Any]) -> None:
        """The opposite of `capture`."""
        self.now, self.sequence, self._entries = state["now"], state["sequence"], state["entries"]
        self._due = [(time, entry, action, tuple(arguments)) for time, entry, action, arguments in state["due"]]

    def say(self, message: Said) -> None:
        """Put a message into the outbox."""
        self._outbox.append(message)

    def empty_outbox(self) -> list[Said]:
        """Everything said since the last time."""
        said, self._outbox = self._outbox, []
        return said


class Common:
    """What the parts of the world have in common: time, bodies, statistics, and a way to speak."""

    def __init__(self, agenda: Agenda, bodies: Bodies, statistics: Statistics) -> None:
        self.agenda = agenda
        self.bodies = bodies
        self.statistics = statistics
        self.penalised_until = [0.0] * len(bodies.bucket)
        self.operation: list[BotState | None] = [None] * len(bodies.bucket)
        self._noted = [_FREE] * len(bodies.bucket)
        self.states = np.zeros(len(bodies.bucket), dtype=np.uint8)  # the same as an array, for many bots at once

    def emit(self, kind: EventType, **fields: Any) -> None:
        """Tell everybody that something happened now."""
        agenda = self.agenda
        agenda.sequence += 1
        event = Event(agenda.now, agenda.sequence, kind, **fields)
        self.statistics.count(event)
        agenda.say(event)

    def answer(self, bot: int, request: int, code: Code, message: str) -> None:
        """Answer a bot's request."""
        x, y = self.bodies.place(bot, self.agenda.now)
        self.agenda.say(BotReply(bot, request, code, message, self.agenda.now, x, y))

    def state_of(self, bot: int) -> BotState:
        """What a bot's body does now."""
        operation = self.operation[bot]
        if operation is not None:
            return operation
        if self.agenda.now < self.penalised_until[bot]:
            return _PENALISED
        return _MOVING if self.bodies.moving[bot] else _FREE

    def note_state(self, bot: int) -> None:
        """Tell the statistics what a bot's body does from now on."""
        state = self.state_of(bot)
        if state is not self._noted[bot]:
            self._noted[bot] = state
            self.states[bot] = state
            self.statistics.bot_state(bot, state, self.agenda.now)

    def hindered(self, bots: np.ndarray) -> np.ndarray:
        """Which of many bots are busy or penalised."""
        return self.states[bots] > _MOVING_STATE

    def note_moving(self, bots: np.ndarray) -> None:
        """The same for bots that have got a velocity, and are neither busy nor penalised."""
        changed = (self.states[bots] == _MOVING_STATE) != self.bodies.moving[bots]
        for bot in bots[changed].tolist():
            self.note_state(bot)

    def hindrance(self, bot: int) -> tuple[Code, str] | None:
        """Why a bot can't begin anything now, or None."""
        if self.agenda.now < self.penalised_until[bot]:
            return Code.PENALISED, f"bot {bot} stands until {self.penalised_until[bot]:.3f} s after a collision"
        operation = self.operation[bot]
        if operation is not None:
            return Code.BUSY, f"bot {bot} is {operation.name.lower()}; wait for that to end"
        return None

    def stands_ready(self, bot: int) -> tuple[Code, str] | None:
        """Why a bot can't begin what it has to stand for, or None."""
        problem = self.hindrance(bot)
        if problem is None and self.bodies.moving[bot]:
            return Code.MOVING, f"bot {bot} is moving; stop it first"
        return problem

    def begin(self, bot: int, operation: BotState) -> None:
        """A bot begins something that takes time."""
        self.operation[bot] = operation
        self.note_state(bot)

    def end(self, bot: int) -> None:
        """It has done it."""
        self.operation[bot] = None
        self.note_state(bot)
