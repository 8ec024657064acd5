"""The record of a run: its event log, its judge, its summary."""

from __future__ import annotations

import os
from pathlib import Path
from typing import IO, Any

from soup_msgs_py.messages import Bots, Buckets, Event
from soup_msgs_py.policies import Policies
from soup_sim.event_log import EventLog
from soup_sim.summary import make_summary, write_summary
from soup_sim.validate import Judge
from soup_sim.world import World


class RunRecord:
    """Watches a run from its start.

    Attributes:
        violations: Broken conservation laws so far.
    """

    def __init__(
        self,
        world: World,
        seed: int,
        summary: Path | None,
        event_log: Path | None,
        resumed: dict[str, Any] | None = None,
    ) -> None:
        """Begin; the event log is written beside its place and gets its name when the run is over.

        Args:
            world: The world, before its first event.
            seed: Its seed, for the summary.
            summary: Where to write the summary, if anywhere.
            event_log: Where to write the events, if anywhere.
            resumed: The books of a run that goes on from a checkpoint, as `capture` told them.
        """
        resumed = resumed or {}
        self._world, self._seed = world, seed
        self._summary, self._log_path = summary, event_log
        self._judge = Judge(world.scenario, world.layout, world.snapshot())
        self._before: int = resumed.get("violations", 0)
        self._half = event_log.with_name(f".{event_log.name}.{os.getpid()}") if event_log is not None else None
        if self._half is not None:
            _take_over(resumed, self._half)
        self._file: IO[str] | None = self._half.open("a", encoding="utf-8") if self._half is not None else None
        self._log = EventLog(self._file) if self._file is not None else None

    @property
    def violations(self) -> int:
        """Broken conservation laws so far."""
        return self._before + self._judge.count

    def capture(self) -> dict[str, Any]:
        """What a record that goes on from here needs: plain JSON values."""
        books: dict[str, Any] = {"violations": self.violations}
        if self._file is not None:
            self._file.flush()
            books |= {"log": str(self._half), "bytes": self._file.tell()}
        return books

    def event(self, event: Event) -> None:
        """Take in the next event."""
        self._judge.event(event)
        if self._log is not None:
            self._log(event)

    def poses(self, bots: Bots, buckets: Buckets) -> None:
        """Take in where everything is now."""
        self._judge.poses(bots, buckets)

    def finish(self, wall_seconds: float, policies: Policies) -> dict[str, Any]:
        """The run is over: judge its end, write the files; the summary."""
        self._judge.finish(self._world.snapshot())
        summary = make_summary(
            self._world.statistics(wall_seconds),
            self._world.scenario,
            policies,
            self._seed,
            self.violations,
        )
        if self._summary is not None:
            write_summary(self._summary, summary)
        self.close(keep=True)
        return summary

    def why(self) -> list[str]:
        """The first broken laws, one line each."""
        return [str(violation) for violation in self._judge.violations[:10]]

    def close(self, *, keep: bool = False) -> None:
        """Close the event log, and give it its name or remove it. Can be called twice."""
        if self._file is None or self._half is None or self._log_path is None:
            return
        self._file.close()
        self._file = self._log = None
        if keep:
            self._half.replace(self._log_path)
        else:
            self._half.unlink(missing_ok=True)


def _take_over(books: dict[str, Any], half: Path) -> None:
    """Go on with the event log of a run that was killed, without what happened after its last checkpoint."""
    before = Path(books.get("log", ""))
    if not before.is_file():
        half.write_bytes(b"")
        return
    before.replace(half)
    os.truncate(half, min(books["bytes"], half.stat().st_size))
