"""The program behind `scripts/run_world.py`: a world as the command line says, in a process of its own."""

from __future__ import annotations

import os
import secrets
import sys
from collections.abc import Sequence
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

from rich.console import Console

from soup_live.domain import only_world, stay_on_this_machine
from soup_live.process import Live, exit_status
from soup_msgs_py import topics
from soup_msgs_py.command_line.part_arguments import parse_world
from soup_msgs_py.messages import Event
from soup_sim.checkpoint import SUFFIX, come_to_rest, hold_folder, restore_checkpoint
from soup_sim.checkpoint_state import Books
from soup_sim.pacing import Pacer
from soup_sim.run_recorder import RunRecorder
from soup_sim.scenario_loader import load_warehouse
from soup_sim.summary import lateness, table
from soup_sim.warm_up import rehearse
from soup_sim.world_node import WorldNode

RUN_BITS = 62  # of the number of a run; 0 is for worlds that nobody follows over a network
NEWEST = f"world{SUFFIX}"


def main(argv: Sequence[str] | None = None, *, scenario: Path | None = None) -> int:
    """Run the world in this process; its exit status."""
    options = parse_world(argv, scenario)
    return exit_status(lambda: run_world(options))


def run_world(options: Any) -> int:
    """Run a world as the command line says; the exit status.

    Raises:
        InputError: Scenario, words or layout are wrong, or there is another world.
    """
    warehouse = load_warehouse(options.scenario, options.set)
    rehearse(warehouse.world(options.seed))
    stay_on_this_machine()
    with Live("world") as live:
        node = live.node(topics.WORLD_NODE)
        with only_world(live, node, look=not options.restore), ExitStack() as files:
            if live.stopping:
                return 0
            console = Console()
            console.print(warehouse.words.describe(), style="dim", highlight=False)
            world = warehouse.world(options.seed, options.warmup, run=secrets.randbits(RUN_BITS))
            pacer = Pacer(options.speed, options.duration or float("inf"), paused=options.paused)
            books = Books()
            file = options.checkpoint / NEWEST if options.checkpoint is not None else None
            if file is not None:
                files.callback(os.close, hold_folder(file.parent))
            if options.restore and file is not None and file.exists():
                books = restore_checkpoint(file, world)
                pacer.wall_seconds = books.wall_seconds
            record = RunRecorder(world, options.seed, options.summary, options.event_log, books, live.tell)
            files.enter_context(closing(record))
            if world.now > 0.0:
                for said in come_to_rest(world):
                    if isinstance(said, Event):
                        record.event(said)
            shell = WorldNode(live, node, world, pacer, record, books.parts)
            if file is not None:
                shell.checkpoints.keep(file, options.every)
            live.spin()
            summary = record.finish(pacer.wall_seconds, shell.policies(), shell.latency_s)
    console.print(table(summary))
    if late := lateness(summary):
        console.print(late, style="yellow", highlight=False)
    for line in record.why():
        console.print(line, style="red", highlight=False)
    return 0 if record.is_written else 1


if __name__ == "__main__":
    sys.exit(main())
