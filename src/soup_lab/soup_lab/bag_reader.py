"""Reads rosbag2 bags: messages in the order in which they came, and where simulated time is in them."""

from __future__ import annotations

import bisect
import sys
from collections.abc import Collection, Iterator
from pathlib import Path
from types import TracebackType

from rosbags.interfaces import Connection, ConnectionExtRosbag2, Qos
from rosbags.rosbag2 import Reader

from soup_lab.bag_repair import UNREADABLE, is_cut_off, repair
from soup_msgs_py import topics
from soup_msgs_py.errors import InputError

ALLOWED = "a rosbag2 bag"
WINDOW_NS = 1_000_000_000  # first step of a search backwards; each further one is twice as long
CLOCK = "rosgraph_msgs/msg/Clock"
Recorded = tuple[str, int, bytes]  # topic, time (ns since 1970), serialized message


def open_bag(folder: Path) -> Bag:
    """Open a bag; one that was cut off is repaired first, and a line on stderr says what is missing.

    Raises:
        InputError: It is no bag, is empty, or somebody writes it.
    """
    if not folder.is_dir():
        found = "a file" if folder.exists() else "no such folder"
        raise InputError(folder, "", found, f"{ALLOWED} (a folder)")
    if is_cut_off(folder):
        print(f"{folder}: {repair(folder)}", file=sys.stderr, flush=True)
    try:
        reader = Reader(folder)
        reader.open()
    except FileNotFoundError as error:
        raise InputError(folder, "", "no metadata.yaml", ALLOWED) from error
    except (OSError, *UNREADABLE, AssertionError, AttributeError, TypeError) as error:
        raise InputError(folder, "", f"a damaged bag ({error})", ALLOWED) from error
    if reader.message_count == 0:
        reader.close()
        raise InputError(folder, "", "a bag without messages", "a bag that holds some")
    return Bag(folder, reader)


class Bag:
    """An open bag; use it as a context manager. Times are ns since 1970 on the recorder's clock.

    Attributes:
        folder: Where it stands.
        kinds: Message type of each topic.
        qos: What the publishers of each topic offered; None where the bag does not say.
        counts: Messages on each topic.
        first: Time of the first message.
        last: Time of the last one.
        notes: What its recorder wrote into the metadata besides.
    """

    def __init__(self, folder: Path, reader: Reader) -> None:
        """Take over an open reader."""
        self.folder, self._reader = folder, reader
        self._connections: dict[str, list[Connection]] = {}
        self.kinds: dict[str, str] = {}
        self.qos: dict[str, Qos | None] = {}
        self.counts: dict[str, int] = {}
        for connection in reader.connections:
            name = connection.topic
            self._connections.setdefault(name, []).append(connection)
            self.kinds[name] = connection.msgtype
            profiles = connection.ext.offered_qos_profiles if isinstance(connection.ext, ConnectionExtRosbag2) else []
            self.qos[name] = profiles[0] if profiles else None
            self.counts[name] = self.counts.get(name, 0) + connection.msgcount
        self.first, self.last = reader.start_time, reader.end_time - 1
        self.notes: dict[str, str] = dict(reader.storage.metadata.custom or {})
        self._instants: list[tuple[float, int]] | None = None

    def __enter__(self) -> Bag:
        """Nothing more than the constructor did."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the bag."""
        self._reader.close()

    def messages(
        self, names: Collection[str] | None = None, start: int | None = None, stop: int | None = None
    ) -> Iterator[Recorded]:
        """Messages in the order of their times.

        Args:
            names: Topics; without: all.
            start: The earliest time.
            stop: The time before which to end.

        Raises:
            InputError: The bag is damaged.
        """
        chosen = [
            c for name in (self._connections if names is None else names) for c in self._connections.get(name, [])
        ]
        if not chosen:
            return
        try:
            for connection, time, data in self._reader.messages(chosen, start, stop):
                yield connection.topic, time, data
        except (OSError, *UNREADABLE, AssertionError) as error:
            raise InputError(self.folder, "", f"a damaged bag ({error})", ALLOWED) from error

    def newest(self, names: Collection[str], until: int) -> dict[str, Recorded]:
        """The newest message of each topic at a time or before; topics without one are left out."""
        found: dict[str, Recorded] = {}
        stop, width = until + 1, WINDOW_NS
        while stop > self.first and (missing := [name for name in names if name not in found]):
            start = max(self.first, stop - width)
            found |= {message[0]: message for message in self.messages(missing, start, stop)}
            stop, width = start, 2 * width
        return found

    # ---- simulated time -----------------------------------------------------------------------------------

    @property
    def has_clock(self) -> bool:
        """Whether the bag says what simulated time it was; without, times count from its first message."""
        return self.kinds.get(topics.CLOCK) == CLOCK and self.counts[topics.CLOCK] > 0

    def instant(self, simulated: float) -> int:
        """When (ns) a simulated time (s) was reached last; the first or last message for times outside of the bag."""
        if not self.has_clock:
            return min(max(self.first + round(simulated * 1e9), self.first), self.last)
        ticks = self._ticks()
        for (before, since), (after, until) in zip(reversed(ticks[:-1]), reversed(ticks[1:]), strict=True):
            if before <= simulated <= after:
                share = (simulated - before) / (after - before) if after > before else 0.0
                return since + round(share * (until - since))
        return self.first if simulated < ticks[0][0] else self.last

    def simulated(self, instant: int) -> float:
        """Simulated time (s) at a time (ns)."""
        if not self.has_clock:
            return (instant - self.first) * 1e-9
        ticks = self._ticks()
        k = bisect.bisect_right(ticks, instant, key=lambda tick: tick[1])
        return ticks[max(0, k - 1)][0]

    def _ticks(self) -> list[tuple[float, int]]:
        if self._instants is None:
            self._instants = [(_read_clock(cdr), time) for _, time, cdr in self.messages([topics.CLOCK])]
        return self._instants


def _read_clock(cdr: bytes) -> float:
    order = "little" if cdr[1] & 1 else "big"
    seconds = int.from_bytes(cdr[4:8], order, signed=True)
    return seconds + int.from_bytes(cdr[8:12], order) * 1e-9
