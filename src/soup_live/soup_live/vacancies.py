"""Which roles of a warehouse nobody fills, and what starts somebody who does."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

from soup_live.diagnostics import PartsWatch
from soup_msgs_py.command_line.arguments import bots, written_bots
from soup_msgs_py.policies import MANAGERS

VACANT_S = 10.0  # wall time; a part that is started again, or takes over, needs less
STARTS = "python3 scripts/run_{}.py"


class Vacancies:
    """Says whom a warehouse lacks, by what its parts report.

    Without a word manager, say, bots park and nothing else tells why.
    """

    def __init__(self, parts: PartsWatch, count: int, clock: Callable[[], float] = time.monotonic) -> None:
        """Begin: nobody is missed yet.

        Args:
            parts: Who reports.
            count: How many bots the warehouse has.
            clock: Wall time (s).
        """
        self._parts, self._clock = parts, clock
        began = clock()
        self._seen = dict.fromkeys((f"{role} manager" for role in MANAGERS), began)
        self._bots_seen = dict.fromkeys(range(count), began)

    def look(self) -> str:
        """Who is missing, and the commands that start them; empty where nobody is."""
        now = self._clock()
        for name, (heard, values) in self._parts.heard.items():
            if name in self._seen:
                self._seen[name] = max(self._seen[name], heard)
            elif name.startswith("bots "):
                for bot in _numbers(values.get("bots", "")):
                    if bot in self._bots_seen:
                        self._bots_seen[bot] = max(self._bots_seen[bot], heard)
        missing = [
            f"no {name} ({STARTS.format(name.replace(' ', '_'))} starts one)"
            for name, seen in self._seen.items()
            if now - seen > VACANT_S
        ]
        lost = tuple(bot for bot, seen in self._bots_seen.items() if now - seen > VACANT_S)
        if lost:
            numbers = written_bots(lost)
            missing.append(f"nobody drives bots {numbers} ({STARTS.format('bots')} {numbers} starts them)")
        return "; ".join(missing)


def _numbers(text: str) -> tuple[int, ...]:
    """The bots that a process says it drives; none where that makes no sense."""
    try:
        return bots(text)
    except argparse.ArgumentTypeError:
        return ()
