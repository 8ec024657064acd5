"""Reads rosbag2 bags: messages in the order in which they came, and where simulated time is in them."""

from __future__ import annotations

import bisect
import json
import sys
from collections import Counter
from collections.abc import Collection, Iterator
from operator import itemgetter
from pathlib import Path

from rosbags.interfaces import Qos

from soup_lab.bags.mcap import Broken, McapFile
from soup_lab.bags.metadata import ALLOWED, BagMetadata, read_metadata
from soup_lab.bags.repair import is_cut_off, qos_of, repair
from soup_lab.bags.writer import METADATA
from soup_msgs_py import topics
from soup_msgs_py.closes import Closes
from soup_msgs_py.errors import InputError

WINDOW_NS = 1_000_000_000  # first step of a search backwards; each further one is twice as long
CLOCK = "rosgraph_msgs/msg/Clock"
Recorded = tuple[str, int, bytes]  # topic, time (ns since 1970), serialized message


def open_bag(folder: Path) -> Bag:
    """Open a bag, and check all that is in it; what is damaged is left out.

    A bag that was cut off is repaired first. Lines on stderr say what is missing.

    Raises:
        InputError: It is no bag, is empty, or somebody writes it.
    """
    try:
        is_folder, exists = folder.is_dir(), folder.exists()
    except OSError as error:  # a name that no file can have
        raise InputError(folder, "", error.strerror, f"{ALLOWED} (a folder)") from error
    if not is_folder:
        found = "a file" if exists else "no such folder"
        raise InputError(folder, "", found, f"{ALLOWED} (a folder)")
    try:
        if is_cut_off(folder):
            print(f"{folder}: {repair(folder)}", file=sys.stderr, flush=True)
        bag = Bag(folder, read_metadata(folder))
    except OSError as error:
        raise InputError(folder, "", error.strerror or error, f"{ALLOWED} that can be read") from error
    if not bag.counts:
        bag.close()
        found = "a damaged bag, no message of which can be read" if bag.damage else "a bag without messages"
        raise InputError(folder, "", found, "a bag that holds some")
    for sentence in bag.damage:
        print(f"{folder}: {sentence}", file=sys.stderr, flush=True)
    return bag


class Bag(Closes):
    """An open bag; use it as a context manager. Times are ns since 1970 on the recorder's clock.

    Attributes:
        folder: Where it stands.
        kinds: Message type of each topic.
        definitions: How that type was defined when it was recorded.
        qos: What the publishers of each topic offered; None where the bag does not say.
        counts: Messages on each topic that can be read.
        first: Time of the first message.
        last: Time of the last one.
        notes: What its recorder wrote into the metadata besides.
        damage: What is missing or damaged, a sentence each.
    """

    def __init__(self, folder: Path, metadata: BagMetadata) -> None:
        """Open the files of a bag.

        Raises:
            OSError: One of them cannot be read.
            InputError: None of them is there.
        """
        self.folder, self.notes = folder, dict(metadata.custom_data or {})
        self.kinds: dict[str, str] = {}
        self.definitions: dict[str, str] = {}
        self.qos: dict[str, Qos | None] = {}
        self.counts: Counter[str] = Counter()
        self.damage: list[str] = []
        self._files: list[McapFile] = []
        self._names: list[dict[int, str]] = []  # of each file: channel -> topic
        names = metadata.names
        if not any((folder / name).is_file() for name in names):
            raise InputError(
                folder / METADATA, "relative_file_paths", ", ".join(names)[:80], "the names of files beside it"
            )
        for name, stated in names.items():
            if (folder / name).is_file():
                self._add(McapFile(folder / name), stated)
            else:
                self.damage.append(f"{name} is missing{_all_of(stated)}")
        strangers = sorted(file.name for file in folder.glob("*.mcap") if file.name not in names)
        self.damage += [f"{name} is left out, {METADATA} does not name it" for name in strangers]
        found = sum(self.counts.values())
        if not self.damage and metadata.message_count not in (None, found):
            self.damage.append(f"{METADATA} tells of {metadata.message_count:,} messages, there are {found:,}")
        self._pieces = sorted(
            ((k, piece) for k, file in enumerate(self._files) for piece in file.pieces),
            key=lambda entry: entry[1].first,
        )
        self.first = min((piece.first for _, piece in self._pieces), default=0)
        self.last = max((piece.last for _, piece in self._pieces), default=0)
        self._instants: list[tuple[float, int]] | None = None

    def close(self) -> None:
        """Close its files."""
        for file in self._files:
            file.close()

    @property
    def dropped(self) -> dict[str, int]:
        """Messages that the recorder knows it missed, by topic.

        Raises:
            InputError: The metadata say something else.
        """
        text = self.notes.get("dropped", "{}")
        try:
            found = json.loads(text)
        except ValueError:
            found = None
        if not isinstance(found, dict) or not all(type(n) is int and n >= 0 for n in found.values()):
            where = self.folder / METADATA
            raise InputError(where, "custom_data.dropped", repr(text[:40]), "how many messages of which topic, as JSON")
        return found

    def messages(
        self, names: Collection[str] | None = None, start: int | None = None, stop: int | None = None
    ) -> Iterator[Recorded]:
        """Messages in the order of their times.

        Args:
            names: Topics; without: all.
            start: The earliest time.
            stop: The time before which to end.

        Raises:
            InputError: The bag has changed since it was opened.
        """
        begin, end = self.first if start is None else start, self.last + 1 if stop is None else stop
        chosen = [
            {channel: name for channel, name in known.items() if names is None or name in names}
            for known in self._names
        ]
        waiting: list[Recorded] = []
        for k, piece in self._pieces:
            if piece.last < begin or piece.first >= end or chosen[k].keys().isdisjoint(piece.counts):
                continue
            ready = bisect.bisect_left(waiting, piece.first, key=itemgetter(1))
            yield from waiting[:ready]
            try:
                found = [
                    (chosen[k][channel], time, data)
                    for channel, time, data in self._files[k].messages(piece)
                    if channel in chosen[k] and begin <= time < end
                ]
            except Broken as error:
                raise InputError(self.folder, "", f"a bag that has changed meanwhile ({error})", ALLOWED) from error
            waiting = sorted(waiting[ready:] + found, key=itemgetter(1))
        yield from waiting

    def _add(self, file: McapFile, stated: int | None) -> None:
        """One more file, of which the metadata state how many messages it holds."""
        self._files.append(file)
        known: dict[int, str] = {}
        for channel, count in file.counts.items():
            found = file.channels[channel]
            schema = file.schemas.get(found.schema_id)
            if found.message_encoding == "cdr" and schema is not None:
                known[channel] = found.topic
                self.kinds.setdefault(found.topic, schema.name)
                self.definitions.setdefault(found.topic, schema.data.decode(errors="replace"))
                self.qos.setdefault(found.topic, qos_of(found))
                self.counts[found.topic] += count
        self._names.append(known)
        self.damage += _damage_of(file, sum(file.counts[channel] for channel in known), stated)

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


def _damage_of(file: McapFile, read: int, stated: int | None) -> list[str]:
    """What a person should know of a file of which so many messages are read."""
    stated = stated if file.stated is None else file.stated
    missing = 0 if stated is None else stated - read
    name = file.path.name
    if file.broken or file.bytes_lost or missing:
        chunks = "chunk is" if file.broken == 1 else "chunks are"
        parts = [f"{file.broken} damaged {chunks} left out"] if file.broken else []
        if file.bytes_lost:
            parts.append(f"{file.bytes_lost:,} bytes could not be read")
        parts.append("how many messages are missing is not known" if stated is None else _missing(missing, stated))
        return [f"{name}: {', '.join(parts)}"]
    if not file.is_whole:
        return [f"{name} is damaged beside its messages, none of which is missing"]
    if not file.is_checked:
        return [f"{name} has no checksums: whether its messages are as they were recorded, nobody can tell"]
    return []


def _missing(count: int, stated: int) -> str:
    return f"{count:,} of {stated:,} messages are missing" if count >= 0 else f"{-count:,} messages are too many"


def _all_of(stated: int | None) -> str:
    return f", and its {stated:,} messages" if stated else ""


def _read_clock(cdr: bytes) -> float:
    order = "little" if cdr[1] & 1 else "big"
    seconds = int.from_bytes(cdr[4:8], order, signed=True)
    return seconds + int.from_bytes(cdr[8:12], order) * 1e-9
