"""What a process says about itself on /diagnostics: whether it is at work, or what it waits for."""

from __future__ import annotations

import os
import sys
import time
from dataclasses import dataclass

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from soup_live.process import Live
from soup_live.qos import EVERY_ONE
from soup_msgs_py import topics
from soup_msgs_py.wire import to_stamp

PERIOD_S = 1.0
SILENT_S = 3.0  # a process that has said nothing for so long does not wait
PATIENCE_S = 1.0  # a wait that takes longer is told on stderr, once
MOST_PARTS, MOST_VALUES, LONGEST_TEXT = 500, 50, 4096  # that are kept: anybody may speak on the topic
LONGEST_PID = 10  # digits
AT_WORK = "at work"
TOLD = "told"  # the value that says what the process has told a person
WAITS = "waits"  # the value that says how much the world waits for the others


class Report:
    """Publishes one line about a process, once a second and whenever it changes.

    Attributes:
        name: Of the process.
        values: Details, by name.
        time: Simulated time to stamp it with (s).
    """

    def __init__(self, live: Live, node: Node) -> None:
        """Report, through a node of the process, that it starts."""
        self.name = live.name
        self.values: dict[str, str] = {}
        self.time = 0.0
        self._live = live
        self._publisher = node.create_publisher(DiagnosticArray, topics.DIAGNOSTICS, EVERY_ONE)
        self._message = ""
        self._waits = True
        self._since = time.monotonic()
        self._told = self._at_work = ""
        live.every(PERIOD_S, self._repeat)

    def waits(self, message: str) -> None:
        """The process waits for something."""
        self._set(message, waits=True)

    def works(self) -> None:
        """The process does what it is there for."""
        self._set(AT_WORK, waits=False)

    def mistake(self, text: str) -> None:
        """A policy of the process has chosen what cannot be: say it to the person, and from now on in the report."""
        self.values["mistake"] = text
        self._live.tell(text)
        self.publish()

    def _set(self, message: str, *, waits: bool) -> None:
        if (message, waits) != (self._message, self._waits):
            self._message, self._waits = message, waits
            self._since = time.monotonic()
            self.publish()

    def _repeat(self) -> None:
        self.publish()
        late = time.monotonic() - self._since > PATIENCE_S
        if self._waits and self._message and late and self._message != self._told:
            self._told = self._message
            print(f"{self._live.name}: {self._message}", file=sys.stderr, flush=True)
        elif not self._waits:
            self._tell_work()

    def _tell_work(self) -> None:
        """Say that the process is at work, and how, once that has not changed since the last look."""
        bots, policy = self.values.get("bots", ""), self.values.get("policy")
        # a process of bots has their numbers in its name
        parts = [f"{bots} bots"] if bots.isdecimal() and not self._live.name.startswith("bots") else []
        parts += [f"policy {policy.rpartition(':')[2]}"] if policy is not None else []
        work = f"{AT_WORK}: {', '.join(parts)}" if parts else AT_WORK
        if work == self._at_work and work != self._told:
            self._told = work
            print(f"{self._live.name}: {work}", flush=True)
        self._at_work = work

    def publish(self) -> None:
        """Say it now."""
        dropped = {"malformed_messages": str(self._live.malformed), "foreign_messages": str(self._live.foreign)}
        if self._live.malformed:
            dropped["last_malformed"] = self._live.last_malformed
        values = {**self.values, TOLD: self._live.told, **dropped, "pid": str(os.getpid())}
        status = DiagnosticStatus(
            level=DiagnosticStatus.WARN if self._waits else DiagnosticStatus.OK,
            name=self.name,
            message=self._message,
            values=[KeyValue(key=key, value=value) for key, value in values.items()],
        )
        message = DiagnosticArray(status=[status])
        message.header.stamp = to_stamp(self.time)
        self._publisher.publish(message)


class PartsWatch:
    """Knows which processes are at work, from their reports.

    Attributes:
        at_work: Details of each process that is, by its name.
        heard: When each process reported last (wall time, s), and its details, by its name.
    """

    def __init__(self, live: Live, node: Node) -> None:
        """Watch from now on."""
        self.at_work: dict[str, dict[str, str]] = {}
        self.heard: dict[str, tuple[float, dict[str, str]]] = {}
        self._waiting: dict[str, _Waiting] = {}
        live.subscribe(node, DiagnosticArray, topics.DIAGNOSTICS, self._take, EVERY_ONE)

    @property
    def waiting(self) -> dict[str, str]:
        """What each other process waits for, by its name.

        Who is silent is left out: that one has gone, or is in charge now, under another name.
        """
        since = time.monotonic() - SILENT_S
        return {name: part.message for name, part in self._waiting.items() if part.heard >= since}

    def pid(self, name: str) -> int:
        """The process of a name that was heard last; 0 for none."""
        values = self._waiting[name].values if name in self._waiting else self.at_work.get(name, {})
        pid = values.get("pid", "")
        return int(pid) if pid.isdecimal() and len(pid) <= LONGEST_PID else 0

    def _take(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self._waiting.pop(status.name, None)
            self.at_work.pop(status.name, None)
            self.heard.pop(status.name, None)
            if not 0 < len(status.name) <= LONGEST_TEXT:
                continue
            values = {pair.key[:LONGEST_TEXT]: pair.value[:LONGEST_TEXT] for pair in status.values[:MOST_VALUES]}
            self.heard[status.name] = time.monotonic(), values
            if status.level == DiagnosticStatus.OK:
                self.at_work[status.name] = values
            else:
                text = status.message[:LONGEST_TEXT]
                self._waiting[status.name] = _Waiting(text, values, time.monotonic())
            for heard in (self.at_work, self._waiting, self.heard):
                if len(heard) > MOST_PARTS:
                    del heard[next(iter(heard))]  # who was heard least lately


@dataclass(frozen=True)
class _Waiting:
    message: str
    values: dict[str, str]
    heard: float  # wall time (s)
