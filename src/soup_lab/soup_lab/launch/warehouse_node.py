"""A live warehouse from one command: all nodes as processes, a line of progress, the table at the end."""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import ExitStack
from itertools import pairwise
from pathlib import Path
from typing import Any

from rich.console import Console
from soup_msgs import msg
from std_srvs.srv import SetBool

from soup_lab.bags.arguments import LEAST_FREE_MIB
from soup_lab.bags.record_node import COMPLETE, MIB, check_room
from soup_lab.bags.record_node import NAME as RECORDER
from soup_lab.bags.removal import files_of_bag, remove_bag
from soup_lab.headless.simulation import make_minds
from soup_lab.launch.processes import Part, Processes
from soup_lab.launch.supervisor_node import WORLD, Supervisor
from soup_lab.launch.warehouse_arguments import parse
from soup_lab.progress import ProgressLine
from soup_live.diagnostics import TOLD, WAITS, PartsWatch
from soup_live.domain import refuse_second_world, stay_on_this_machine
from soup_live.leader_election import called
from soup_live.process import Live, exit_status
from soup_live.qos import DISPLAY
from soup_msgs_py import topics
from soup_msgs_py.command_line import arguments as args
from soup_msgs_py.command_line.output_files import why, write_whole
from soup_msgs_py.errors import InputError, RunError
from soup_msgs_py.policies import MANAGERS, ROLES, Policies, load_policies
from soup_msgs_py.wire import from_statistics
from soup_sim.scenario_loader import load_warehouse
from soup_sim.standstill import STALLED
from soup_sim.summary import lateness, table, write_summary

FLEET = "fleet manager"
OTHERS = 5  # processes besides the bots'
BOTS_A_PROCESS = 64  # where the machine has that many cores
READY_S, READY_A_BOT_S = 400.0, 0.5  # the longest start: code is compiled in the first one
SETTLED_S = 0.5  # wall time for all to have found each other
INTERRUPTED = 130  # exit status
SLOW = 0.9  # share of the speed that was asked for below which a run is slow


def main(argv: Sequence[str] | None = None, *, scenario: Path | None = None, policies: Path | None = None) -> int:
    """Run a live warehouse; the exit status."""
    options = parse(argv, scenario, policies)
    return exit_status(lambda: run(options))


def run(options: argparse.Namespace) -> int:
    """Check everything, then start, watch and end the processes.

    Raises:
        InputError: Anything is wrong; nothing was started.
        RunError: A part died, or did not get ready.
    """
    policies = load_policies(options.policies, {role: getattr(options, f"{role}_policy") for role in ROLES})
    warehouse = load_warehouse(options.scenario, options.set)
    make_minds(policies, warehouse.scenario)
    if options.record is not None:
        if options.record.exists() and options.overwrite:
            files_of_bag(options.record)
        elif options.record.exists():
            raise InputError(
                "--record",
                "",
                f"{options.record}, which is there already",
                "a folder that is not there yet, or --overwrite",
            )
        check_room(options.record, LEAST_FREE_MIB * MIB)
    if not options.no_dashboard:
        args.refuse_port_in_use(options.port)
    bots = warehouse.scenario.bots
    groups = bot_groups(bots, options.bot_processes)
    stay_on_this_machine(len(groups) + OTHERS)
    console = Console()
    with Live("warehouse", ends_soon=False) as live, ExitStack() as files:
        node = live.node("warehouse")
        refuse_second_world(live, node)
        if live.stopping:
            return INTERRUPTED
        if options.record is not None and options.record.exists():
            remove_bag(options.record)
        console.print(f"words: {warehouse.words.describe()}", highlight=False)
        folder = temporary_folder(files)
        summary_file = folder / "summary.json"
        os.mkfifo(summary_file)  # it needs no room on the disk
        figures = files.enter_context(open(summary_file, opener=_not_waiting, encoding="utf-8"))
        if options.explain is not None:
            write_whole(options.explain, "")  # the managers append to it
        parts = make_parts(options, groups, folder, summary_file)
        processes = Processes(folder)
        watch = PartsWatch(live, node)
        show = Progress(console, options.duration, options.speed)
        try:

            def show_figures(message: msg.Statistics) -> None:
                show(from_statistics(message), watch.at_work.get(WORLD, {}).get(WAITS, ""))
                show.tell_new(watch.at_work)
                show.stalled(watch.waiting.get(WORLD, ""))

            live.subscribe(node, msg.Statistics, topics.STATISTICS, show_figures, DISPLAY)
            supervisor = Supervisor(live, node, processes, parts, show.tell)
            get_ready(live, node, watch, [part.name for part in parts], bots)
            supervisor.settled = True
            if not live.stopping:
                show.tell(at_work(bots, policies, None if options.no_dashboard else options.port))
            live.spin(lambda: supervisor.over)
        finally:
            show.close()
            # the recorder last: it hears what the others say at their end
            processes.end([part.name for part in parts if part.name != RECORDER])
            processes.end()
            show.tell_new(watch.at_work)
        text = figures.read()
        if not text and live.ended_by:
            console.print("stopped before the warehouse was ready; no summary", highlight=False)
            return INTERRUPTED
        if not text:
            raise RunError(f"{WORLD} {processes.last_words(WORLD)}")
    summary = json.loads(text)
    written = write_summary(options.summary, summary)
    console.print(table(summary))
    if late := lateness(summary):
        console.print(late, style="yellow", highlight=False)
    if summary["violations"]:
        raise RunError(f"{summary['violations']} conservation laws were broken")
    if not written:
        return 1
    return INTERRUPTED if live.ended_by and options.duration is not None else 0


def at_work(bots: int, policies: Policies, port: int | None) -> str:
    """What the person who started the warehouse is told when it has begun.

    Args:
        bots: How many.
        policies: Of all parts.
        port: Of the page, which answers; None without one.
    """
    chosen = ", ".join(f"{role} {called(getattr(policies, role).name)}" for role in ROLES)
    page = f"; the page: http://127.0.0.1:{port}" if port is not None else ""
    return f"at work: {bots} bots; policies: {chosen}{page}; Ctrl-C ends it"


def temporary_folder(files: ExitStack) -> Path:
    """A folder for what the parts keep during a run; it is gone when the run is over.

    Raises:
        InputError: There is no room for it.
    """
    try:
        return Path(files.enter_context(tempfile.TemporaryDirectory()))
    except OSError as error:
        raise InputError("TMPDIR", "", why(error), "a folder for temporary files with room") from error


def _not_waiting(path: str, flags: int) -> int:
    """Open a pipe to which nobody writes yet."""
    return os.open(path, flags | os.O_NONBLOCK)


def bot_groups(bots: int, processes: int | None) -> list[tuple[int, ...]]:
    """Which bots share a process."""
    count = processes or min(os.cpu_count() or 1, math.ceil(bots / BOTS_A_PROCESS))
    count = min(count, bots)
    edges = [bots * k // count for k in range(count + 1)]
    return [tuple(range(low, high)) for low, high in pairwise(edges)]


def make_parts(options: argparse.Namespace, groups: list[tuple[int, ...]], folder: Path, summary: Path) -> list[Part]:
    """All processes of the warehouse; the world keeps its checkpoints in a folder where nobody names another."""
    world = ["--scenario", str(options.scenario), "--summary", str(summary), "--paused"]
    speed = "max" if math.isinf(options.speed) else repr(options.speed)
    world += ["--speed", speed, "--warmup", repr(options.warmup), "--seed", str(options.seed)]
    world += ["--checkpoint", str(options.checkpoint or folder)]
    if options.every is not None:
        world += ["--every", repr(options.every)]
    if options.restore:
        world += ["--restore"]
    world += [f"--set={override}" for override in options.set]
    if options.duration is not None:
        world += ["--duration", repr(options.duration)]
    if options.event_log is not None:
        world += ["--event-log", str(options.event_log)]
    parts = []
    if options.record is not None:  # the first one, so that it hears all
        arguments = (str(options.record),)
        parts.append(Part(RECORDER, "soup_lab.bags.record_node", arguments, again=("--go-on",), needed=False))
    parts.append(Part(WORLD, "soup_sim.world_program", tuple(world), again=("--restore",)))
    explain = ("--explain", str(options.explain)) if options.explain is not None else ()
    for role in MANAGERS:
        module = f"soup_managers.nodes.{role}_manager_node"
        parts.append(Part(f"{role} manager", module, (*policy_arguments(options, role), *explain)))
    for group in groups:
        numbers = args.written_bots(group)
        arguments = (numbers, *policy_arguments(options, "bot"))
        parts.append(Part(f"bots {numbers}", "soup_bots.bots_program", arguments))
    if not options.no_dashboard:
        parts.append(Part("dashboard", "soup_dashboard.dashboard_node", ("--port", str(options.port))))
    return parts


def policy_arguments(options: argparse.Namespace, role: str) -> tuple[str, ...]:
    """What tells a part its policy."""
    arguments = ["--seed", str(options.seed)]
    if options.policies is not None:
        arguments += ["--policies", str(options.policies)]
    override = getattr(options, f"{role}_policy")
    if override is not None:
        arguments += ["--policy", override]
    return tuple(arguments)


def get_ready(live: Live, node: Any, watch: PartsWatch, names: list[str], bots: int) -> None:
    """Wait until every part is at work, then let time go on, so that all runs begin alike.

    Raises:
        RunError: A part died, or takes too long.
    """
    since = float("inf")

    def ready() -> bool:
        nonlocal since
        fleet = watch.at_work.get(FLEET, {})
        if not all(name in watch.at_work for name in names) or fleet.get("bots") != str(bots):
            return False
        since = min(since, time.time())
        # topics that have just come to be are to be recorded from their first message on
        return RECORDER not in names or float(watch.at_work[RECORDER][COMPLETE]) > since + SETTLED_S

    if not live.spin(ready, READY_S + READY_A_BOT_S * bots):
        if live.stopping:
            return
        late = [f"{name} {watch.waiting.get(name, 'is not heard')}" for name in names if name not in watch.at_work]
        raise RunError(f"not ready after {READY_S + READY_A_BOT_S * bots:g} s: {'; '.join(late) or 'the fleet'}")
    client = node.create_client(SetBool, topics.PAUSE)
    live.spin(client.service_is_ready, READY_S)
    answer = client.call_async(SetBool.Request(data=False))
    if not live.spin(answer.done, READY_S) and not live.stopping:
        raise RunError("the world does not answer")


class Progress:
    """Tells how the run goes."""

    def __init__(self, console: Console, duration: float | None, speed: float) -> None:
        """Begin with nothing shown.

        Args:
            console: Where to show it.
            duration: Simulated seconds of the run, if it has an end.
            speed: Simulated seconds a wall second that were asked for.
        """
        self._console, self._speed = console, speed
        self._of = f" of {duration:,.0f}" if duration is not None else ""
        self._line = ProgressLine(console, "the parts are starting")
        self._told: dict[str, str] = {}
        self._is_stalled = False

    def __call__(self, figures: dict[str, float | int], waits: str) -> None:
        """Show the newest figures; of a run that is slow also how much the world waits, and for whom."""
        if figures["sim_seconds"] <= 0:  # it waits for its parts to start, which is no sign of anything
            return
        slow = f" · waits {waits}" if waits and figures["real_time_factor"] < SLOW * self._speed else ""
        self._line.tell(
            f"{figures['sim_seconds']:,.0f}{self._of} s · {figures['words_completed']:,} words · "
            f"{figures['bot_collisions'] + figures['bucket_collisions']:,} collisions · "
            f"{figures['real_time_factor']:.3g} x real time{slow}"
        )

    def stalled(self, waits: str) -> None:
        """Tell once that the run has come to a standstill, and why, where that is what the world says."""
        stalled = waits.startswith(STALLED)
        if stalled and not self._is_stalled:
            self.tell(waits)
        self._is_stalled = stalled

    def tell(self, line: str) -> None:
        """Show a line of its own: something happened."""
        self._console.print(line, highlight=False)

    def tell_new(self, parts: dict[str, dict[str, str]]) -> None:
        """Show what parts have to tell a person, once."""
        for name, values in parts.items():
            line = values.get(TOLD, "")
            if line and line != self._told.get(name):
                self._told[name] = line
                self.tell(f"{name}: {line}")

    def close(self) -> None:
        """Take the line away. Can be called twice."""
        self._line.close()


if __name__ == "__main__":
    sys.exit(main())
