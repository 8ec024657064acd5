"""The checkpoints of a live world: when it is time, and whenever somebody asks for one."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from soup_msgs import srv

from soup_live.process import Live
from soup_live.services import Answer, serve
from soup_msgs_py import topics
from soup_msgs_py.codes import Code
from soup_msgs_py.command_line.output_files import OutputError
from soup_msgs_py.errors import InputError
from soup_msgs_py.wire import fill_result
from soup_sim.checkpoint import place_for, write_checkpoint
from soup_sim.lockstep import Lockstep
from soup_sim.pacing import Pacer
from soup_sim.run_recorder import RunRecorder
from soup_sim.world import World

CHECKPOINT_S = 10.0  # wall time between two, where nobody says how much simulated time
FASTEST = 10.0  # the real-time factor that is expected of a world without a limit


class CheckpointKeeper:
    """Writes the state of a world, and the books of its run, to files.

    Args:
        live: The process.
        node: The node `world`.
        world: The world itself.
        pacer: How fast it runs.
        lockstep: Who follows it.
        record: The run's books.
    """

    def __init__(
        self, live: Live, node: Any, world: World, pacer: Pacer, lockstep: Lockstep, record: RunRecorder
    ) -> None:
        """Begin to serve; nothing is written before `keep` or a request."""
        self._live, self._world, self._pacer = live, world, pacer
        self._lockstep, self._record = lockstep, record
        self._file: Path | None = None
        self._problem = ""
        self._every_s = self._due = 0.0
        serve(live, node, srv.Checkpoint, topics.CHECKPOINT, self._on_checkpoint)

    def keep(self, file: Path, every_s: float | None) -> None:
        """Write the state of the world to a file from now on.

        Args:
            file: Where the newest checkpoint stands.
            every_s: Simulated time between two (s); without: ten seconds of wall time.
        """
        speed = self._pacer.speed if math.isfinite(self._pacer.speed) else FASTEST
        self._file, self._every_s = file, every_s or CHECKPOINT_S * speed

    def look(self) -> None:
        """Write the newest one if it is due; one that cannot be written is tried again when the next one is."""
        if self._file is None or self._world.now < self._due:
            return
        self._due = self._world.now + self._every_s
        before = self._problem
        try:
            self._write(self._file)
            self._problem = ""
        except OutputError as error:
            self._problem = str(error)
        if self._problem and not before:
            self._live.tell(f"{self._problem}; tried again every {self._every_s:g} s, the run goes on")
        elif before and not self._problem:
            self._live.tell(f"{self._file}: written again")

    def _on_checkpoint(self, request: srv.Checkpoint.Request, answer: Answer) -> None:
        try:
            path = place_for(self._file.parent if self._file is not None else None, request.path)
            self._write(path)
            code, message = Code.DONE, f"written to {path}"
        except (InputError, OutputError) as error:
            code, message = Code.INVALID, str(error)
        answer.give(fill_result(srv.Checkpoint.Response(), code, message))

    def _write(self, path: Path) -> None:
        books = self._record.capture()
        more = {"wall_seconds": self._pacer.wall_seconds, "parts": tuple(self._lockstep.names)}
        write_checkpoint(path, self._world, books.model_copy(update=more))
