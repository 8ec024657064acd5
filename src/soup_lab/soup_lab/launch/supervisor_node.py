"""Keeps the parts of a live warehouse running: notices who died, says so, and starts them again."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from soup_msgs import msg

from soup_lab.launch.processes import Part, Processes
from soup_lab.launch.restarts import Restarts
from soup_live.process import Live
from soup_live.qos import CHARGES, EVERY_ONE
from soup_msgs_py import topics
from soup_msgs_py.errors import RunError
from soup_msgs_py.messages import Charge, Heard
from soup_msgs_py.mind import NEVER
from soup_msgs_py.wire import to_ros

WORLD = "world"
LOOK_S = 0.1
WRONG_INPUT = 2  # exit status of a part that would end in the same way again


class Supervisor:
    """Starts parts, and starts those again that die.

    Attributes:
        over: Whether the world has come to its end.
        settled: Whether all parts have been at work. Before, a part that ends by itself ends the run.
    """

    def __init__(
        self, live: Live, node: Any, processes: Processes, parts: Sequence[Part], tell: Callable[[str], None]
    ) -> None:
        """Start the parts.

        Args:
            live: This process.
            node: A node of it.
            processes: Where the parts run.
            parts: What to run.
            tell: Says something to the person who started the warehouse.
        """
        self.over = self.settled = False
        self._processes, self._tell = processes, tell
        self._parts = {part.name: part for part in parts}
        self._restarts = Restarts()
        self._heard = node.create_publisher(msg.Heard, topics.HEARD, EVERY_ONE)
        self._charges = node.create_publisher(msg.Charge, topics.BOTS_CHARGE, CHARGES)
        for part in parts:
            self._start(part)
        live.every(LOOK_S, self._look)

    def obituary(self) -> str:
        """Which parts are dead, and why."""
        return "; ".join(f"{name} {self._processes.last_words(name)}" for name in self._processes.dead())

    def _start(self, part: Part) -> None:
        self._restarts.started(part.name, time.monotonic())
        self._processes.start(part)

    def _look(self) -> None:
        if self.over:
            return
        for name in self._processes.dead():
            if name in self._parts and not self._restarts.waits(name):
                self._on_death(name)
        for name in self._restarts.due(time.monotonic()):
            part = self._parts[name]
            kept = tuple(argument for argument in part.arguments if argument != "--paused" or not self.settled)
            part = replace(part, arguments=(*kept, *part.again))
            if not self._restarts.stands_by(name):
                self._tell(f"{name} is started again")
            self._start(part)

    def _on_death(self, name: str) -> None:
        status = self._processes.status(name)
        if name == WORLD and status == 0:
            self.over = True
            return
        by_itself = status is not None and status >= 0
        if by_itself and self.settled and not self._parts[name].needed:
            self._tell(f"{name} {self._processes.last_words(name)}; the run goes on without it")
            del self._parts[name]
            return
        if status == WRONG_INPUT or (by_itself and not self.settled):
            raise RunError(self.obituary())
        wall = time.monotonic()
        pause = self._restarts.handed_over(name, wall) if status == 0 else self._restarts.died(name, wall)
        if pause is None:
            raise RunError(f"{name} does not stay alive: {self._processes.last_words(name)}")
        if status == 0:
            self._tell(f"{name}: another one has taken over; the one of this warehouse stands by until that is gone")
        else:
            self._tell(f"{name} {self._processes.last_words(name)}; starts again in {pause:g} s")
        # the world is not to wait for somebody who is gone
        self._heard.publish(to_ros(Heard(name, 0, NEVER, leaves=True)))
        # and the fleet is not to count on bots that it may have had
        self._charges.publish(to_ros(Charge(name, 0, time.time_ns(), "")))
