"""The record of a run: its event log, its judge, its summary."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from soup_msgs_py.command_line.output_files import GrowingFile, Tell, tell_on_stderr
from soup_msgs_py.messages import Bots, Buckets, Event
from soup_msgs_py.policies import Policies
from soup_sim.checkpoint_state import Books
from soup_sim.event_log import EventLog
from soup_sim.summary import make_summary, write_summary
from soup_sim.validate import Judge
from soup_sim.world import World


class RunRecorder:
    """Watches a run from its start.

    Attributes:
        violations: Broken conservation laws so far.
        is_written: Whether the summary is where it was asked for.
    """

    def __init__(
        self,
        world: World,
        seed: int,
        summary: Path | None,
        event_log: Path | None,
        resumed: Books | None = None,
        tell: Tell = tell_on_stderr,
    ) -> None:
        """Begin; the event log gets its name when the run is over.

        A run that goes on from a checkpoint goes on with its log, without what happened after the checkpoint. The
        checkpoint tells how much of it counts, and its checksum, but no file: that is the one of the command line.

        Args:
            world: The world, before its first event.
            seed: Its seed, for the summary.
            summary: Where to write the summary, if anywhere.
            event_log: Where to write the events, if anywhere.
            resumed: The books of a run that goes on from a checkpoint.
            tell: Says something to a person.

        Raises:
            InputError: The event log cannot be written, or another run writes it.
        """
        resumed = resumed or Books()
        self.is_written = True
        self._world, self._seed, self._tell = world, seed, tell
        self._summary = summary
        self._judge = Judge(world.scenario, world.layout, world.snapshot())
        self._before = resumed.violations
        if event_log is not None and world.now > 0.0 and resumed.log is None:
            tell(f"{event_log}: begins at {world.now:g} s; the run had no event log before")
        self._file = GrowingFile(event_log, tell, resumed.log) if event_log is not None else None
        self._log = EventLog(self._file) if self._file is not None else None

    @property
    def violations(self) -> int:
        """Broken conservation laws so far."""
        return self._before + self._judge.count

    def capture(self) -> Books:
        """What a record that goes on from here needs."""
        return Books(violations=self.violations, log=self._file.flush() if self._file is not None else None)

    def flush(self) -> None:
        """Hand the event log over to the system, so that whoever listens still hears if it fails."""
        if self._file is not None:
            self._file.flush()

    def event(self, event: Event) -> None:
        """Take in the next event."""
        self._judge.event(event)
        if self._log is not None:
            self._log(event)

    def poses(self, bots: Bots, buckets: Buckets) -> None:
        """Take in where everything is now."""
        self._judge.poses(bots, buckets)

    def finish(self, wall_seconds: float, policies: Policies, latency_s: float = 0.0) -> dict[str, Any]:
        """The run is over: judge its end, write the files, as far as that can be; the summary."""
        self._judge.finish(self._world.snapshot())
        summary = make_summary(
            {**self._world.statistics(wall_seconds), "latency_s": latency_s},
            self._world.scenario,
            policies,
            self._seed,
            self.violations,
        )
        self.is_written = write_summary(self._summary, summary, self._tell)
        if self._file is not None:
            self._file.finish()
        return summary

    def why(self) -> list[str]:
        """The first broken laws, one line each."""
        return [str(violation) for violation in self._judge.violations[:10]]

    def close(self) -> None:
        """End; an event log that was not finished stays incomplete. Can be called twice."""
        if self._file is not None:
            self._file.close()
