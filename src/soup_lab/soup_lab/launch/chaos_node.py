"""Chaos: does to a live warehouse what can happen to it, at random, and tells what that cost."""

from __future__ import annotations

import argparse
import json
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table
from soup_msgs import msg

from soup_lab.lab_arguments import parse_chaos
from soup_lab.launch.bound_program import bound
from soup_live.diagnostics import PartsWatch
from soup_live.domain import stay_on_this_machine
from soup_live.process import Live, exit_status
from soup_live.qos import DISPLAY, EVERY_ONE, LATCHED
from soup_msgs_py import topics
from soup_msgs_py.codes import EventType
from soup_msgs_py.errors import RunError
from soup_msgs_py.figures import known, told
from soup_msgs_py.messages import Event
from soup_msgs_py.policies import MANAGERS
from soup_msgs_py.wire import from_ros, from_statistics

QUARTERS = 4  # bot processes: one of them holds a quarter of the bots
STOPPED_S = 20.0  # wall time for which a process is stopped
CALM_S = 5.0  # wall time between two blows
IN_SWING = 0.5  # of the most words that there could be; before, long pauses between words are the rule
FLOWS_S = 10.0  # wall time within which words have to flow again
PATIENCE_S = 60.0  # wall time after which they are given up
READY_S = 400.0
LOST_S = 1800.0  # simulated: a task that has been there for so long is lost
# what managers are swapped for; a fleet without reserved traffic would need other bots, too
OTHER_POLICIES = """\
word: in_stock
letter: minimal
fleet: {name: coordinated, options: {buckets: nearest, storage: nearest, onward: store}}
"""
FAILED = re.compile(r"ended with status [1-9]")  # what the warehouse says of a part that was not killed
WIDE = "1000"  # columns of what it says, so that each part that ended has one line


@dataclass(frozen=True)
class Blow:
    """One thing that was done, and what it cost.

    Attributes:
        what: What was done.
        pause_s: The longest wall time without a word since then, until it was over and words flowed again (s).
    """

    what: str
    pause_s: float


class Chaos:
    """A warehouse and what is done to it."""

    def __init__(self, live: Live, rng: random.Random, scripts: Path, policies: Path, console: Console) -> None:
        """Watch a warehouse that is starting.

        Args:
            live: This process.
            rng: Decides what is done.
            scripts: The folder of the programs.
            policies: A file with what managers are swapped for.
            console: Where it is told.
        """
        self._live, self._rng, self._scripts, self._console = live, rng, scripts, console
        self._policies = policies
        node = live.node("chaos")
        self._parts = PartsWatch(live, node)
        self._figures: dict[str, Any] = {}
        self._last_word = time.monotonic()  # wall time at which the newest word was heard of
        self._pause = 0.0  # the longest one since the last blow
        self._words_at: list[tuple[float, int, float]] = []  # wall time, words, simulated time; of the last seconds
        self._since: dict[tuple[str, int], float] = {}  # tasks: when they were seen first (simulated s)
        self.blows: list[Blow] = []
        live.subscribe(node, msg.Statistics, topics.STATISTICS, self._on_figures, DISPLAY)
        live.follow(node, msg.Event, topics.EVENTS, self._on_event, EVERY_ONE)
        live.subscribe(node, msg.Tasks, topics.TASKS, self._on_tasks, LATCHED)

    @property
    def words(self) -> int:
        """Words that are completed."""
        return self._figures.get("words_completed", 0)

    @property
    def flows(self) -> bool:
        """Whether work is in full swing: words come at half of the rate that the stations could keep."""
        wall = time.monotonic()
        self._words_at = [entry for entry in self._words_at if wall - entry[0] <= FLOWS_S]
        if not self._words_at:
            return False
        _, words, since = self._words_at[0]
        possible = self._figures["word_rate_bound"] * (self._figures["sim_seconds"] - since)
        return self.words - words >= max(2.0, IN_SWING * possible)

    @property
    def oldest_task_s(self) -> float:
        """How long the oldest task has been there (simulated s)."""
        now = self._figures.get("sim_seconds", 0.0)
        return max((now - since for since in self._since.values()), default=0.0)

    def wait(self, condition: Callable[[], bool], patience_s: float) -> bool:
        """Wait until something is so."""
        return self._live.spin(condition, patience_s)

    def strike(self) -> None:
        """Do something, and wait until words flow again."""
        what, blow = self._rng.choice(self._choices())
        self._console.print(f"{self._figures.get('sim_seconds', 0.0):8,.0f} s: {what}", highlight=False)
        try:
            costs = blow()
        except ProcessLookupError:
            self._console.print("            it had already ended by itself", highlight=False)
            return
        for then, pause in costs:
            self.blows.append(Blow(f"{what}{then}", pause))
            self._console.print(f"            {pause:.1f} s without a word{then}", highlight=False)

    def _choices(self) -> list[tuple[str, Callable[[], list[tuple[str, float]]]]]:
        choices: list[tuple[str, Callable[[], list[tuple[str, float]]]]] = [
            ("kill the world", lambda: self._kill("world")),
            ("kill a quarter of the bots", lambda: self._kill(self._some_bots())),
            (f"stop a quarter of the bots for {STOPPED_S:g} s", self._stop),
        ]
        for role in MANAGERS:
            choices.append((f"kill the {role} manager", lambda role=role: self._kill(f"{role} manager")))
            choices.append((f"swap the {role} manager and back", lambda role=role: self._swap(role)))
        return choices

    # ---- blows --------------------------------------------------------------------------------------------

    def _some_bots(self) -> str:
        return self._rng.choice(sorted(name for name in self._parts.at_work if name.startswith("bots ")))

    def _pid(self, name: str) -> int:
        return self._parts.pid(name) if name in self._parts.at_work else 0

    def _kill(self, name: str) -> list[tuple[str, float]]:
        before = self._pid(name)
        self._begin()
        os.kill(before, signal.SIGKILL)
        self._parts.at_work.pop(name, None)
        self.wait(lambda: self._pid(name) not in (0, before), PATIENCE_S)
        return [("", self._until_words_flow())]

    def _stop(self) -> list[tuple[str, float]]:
        number = self._pid(self._some_bots())
        self._begin()
        os.kill(number, signal.SIGSTOP)
        try:
            self.wait(lambda: False, STOPPED_S)
        finally:
            os.kill(number, signal.SIGCONT)
        meanwhile = self._longest_pause()
        self._begin()
        return [("", meanwhile), (", which go on", self._until_words_flow())]

    def _swap(self, role: str) -> list[tuple[str, float]]:
        name = f"{role} manager"
        before = self._pid(name)
        self._begin()
        command = [sys.executable, str(self._scripts / "swap_manager.py"), role, "--policies", str(self._policies)]
        other = subprocess.Popen(bound(command, signal.SIGINT), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            self.wait(lambda: self._pid(name) == other.pid, PATIENCE_S)
            there = self._until_words_flow()
            # the one before stands by again, to be in charge afterwards
            standby = f"{name} (stands by)"
            self.wait(lambda: self._parts.pid(standby) not in (0, before, other.pid), PATIENCE_S)
        finally:
            other.send_signal(signal.SIGINT)
            other.wait()
        self._begin()
        self.wait(lambda: self._pid(name) not in (0, before, other.pid), PATIENCE_S)
        return [("", there), (", back with the policy before", self._until_words_flow())]

    def _begin(self) -> None:
        """A blow comes now."""
        self._last_word, self._pause = time.monotonic(), 0.0

    def _until_words_flow(self) -> float:
        """Wait for the next word; the longest time without one since the blow."""
        began = time.monotonic()
        self.wait(lambda: self._last_word > began, PATIENCE_S)
        return self._longest_pause()

    def _longest_pause(self) -> float:
        return max(self._pause, time.monotonic() - self._last_word)

    # ---- what is heard ------------------------------------------------------------------------------------

    def _on_figures(self, message: msg.Statistics) -> None:
        self._figures = from_statistics(message)
        self._words_at.append((time.monotonic(), self.words, self._figures["sim_seconds"]))

    def _on_event(self, event: Event) -> None:
        if event.type is EventType.WORD_COMPLETED:
            self._pause, self._last_word = self._longest_pause(), time.monotonic()

    def _on_tasks(self, message: msg.Tasks) -> None:
        tasks = from_ros(message)
        keys = {(task.kind, task.job) for task in tasks.tasks}
        self._since = {key: min(self._since.get(key, tasks.time), tasks.time) for key in keys}


def main(argv: Sequence[str] | None = None, *, scripts: Path) -> int:
    """Run a warehouse, and strike it again and again; the exit status."""
    options = parse_chaos(argv, scripts)
    return exit_status(lambda: run(options))


def run(options: argparse.Namespace) -> int:
    """Run the warehouse and strike it.

    Raises:
        RunError: No word came for too long, a law was broken, or a task was lost.
    """
    console = Console()
    command = [sys.executable, str(options.scripts / "run_warehouse.py"), "--no-dashboard", "--seed", str(options.seed)]
    command += ["--bot-processes", str(QUARTERS), "--speed", str(options.speed).replace("inf", "max")]
    command += [f"--set={override}" for override in options.set]
    for name in ("scenario", "policies", "event_log", "record"):
        if getattr(options, name) is not None:
            command += [f"--{name.replace('_', '-')}", str(getattr(options, name))]
    stay_on_this_machine(QUARTERS + 8)
    with tempfile.TemporaryDirectory() as folder, Live("chaos", ends_soon=False) as live:
        summary = Path(folder) / "summary.json"
        policies = Path(folder) / "others.yaml"
        policies.write_text(OTHER_POLICIES, encoding="utf-8")
        with open(Path(folder) / "said", "w+", encoding="utf-8") as said:
            command += ["--summary", str(summary)]
            warehouse = subprocess.Popen(
                bound(command, signal.SIGINT), stdout=said, stderr=said, env={**os.environ, "COLUMNS": WIDE}
            )
            chaos = Chaos(live, random.Random(options.seed), options.scripts, policies, console)
            try:
                _strike_on(chaos, live, warehouse, 60.0 * options.minutes)
            finally:
                warehouse.send_signal(signal.SIGINT)
                status = warehouse.wait()
            said.seek(0)
            lines = said.read().strip().splitlines()
            if not summary.exists():
                raise RunError(f"the warehouse ended with status {status}: {lines[-1:]}")
            for line in lines:
                if FAILED.search(line):
                    console.print(f"not killed: {line.strip()}", highlight=False)
        figures = json.loads(summary.read_text(encoding="utf-8"))
    return _verdict(console, chaos, figures)


def _strike_on(chaos: Chaos, live: Live, warehouse: subprocess.Popen[bytes], seconds: float) -> None:
    chaos.wait(lambda: chaos.flows or warehouse.poll() is not None, READY_S)
    if not chaos.words or warehouse.poll() is not None:
        return
    end = time.monotonic() + seconds
    while time.monotonic() < end and not live.stopping and warehouse.poll() is None:
        chaos.wait(lambda: warehouse.poll() is not None, CALM_S)
        if not live.stopping and warehouse.poll() is None:
            chaos.strike()


def _verdict(console: Console, chaos: Chaos, figures: dict[str, Any]) -> int:
    table = Table("what was done", "times", "seconds without a word, mean", "longest")
    for what in dict.fromkeys(blow.what for blow in chaos.blows):
        times = [blow.pause_s for blow in chaos.blows if blow.what == what]
        table.add_row(what, str(len(times)), f"{sum(times) / len(times):.1f}", f"{max(times):.1f}")
    console.print(table)
    keys = ("sim_seconds", "words_completed", "bot_collisions", "bucket_collisions", "violations")
    console.print(" · ".join(f"{known(key).words} {told(key, figures[key])}" for key in keys), highlight=False)
    console.print(f"oldest task: {chaos.oldest_task_s:,.0f} simulated seconds", highlight=False)
    late = [blow for blow in chaos.blows if blow.pause_s > FLOWS_S]
    if figures["violations"] or late or chaos.oldest_task_s > LOST_S:
        raise RunError(
            f"{figures['violations']} violations, {len(late)} of {len(chaos.blows)} times without a word for more "
            f"than {FLOWS_S:g} s, oldest task {chaos.oldest_task_s:,.0f} s"
        )
    return 0
