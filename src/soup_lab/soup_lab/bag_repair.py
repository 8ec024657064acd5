"""Makes a bag whole whose recorder was killed, or ran out of disk: everything that can be read stays."""

from __future__ import annotations

import os
import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcap.exceptions import McapError
from mcap.records import Channel, Footer, Message, Schema
from mcap.stream_reader import StreamReader
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2.errors import ReaderError
from rosbags.rosbag2.metadata import parse_qos
from zstandard import ZstdError

from soup_lab.bag_types import type_hash
from soup_lab.bag_writer import METADATA, SUFFIX, BagFile, BagWriter, Topic, lock
from soup_msgs_py.errors import InputError

QOS_KEY = "offered_qos_profiles"
UNREADABLE = (McapError, ReaderError, ZstdError, ValueError, KeyError, EOFError, MemoryError, struct.error)
_NO_TIME = QosTime(0, 0)
_UNKNOWN_QOS = Qos(
    QosHistory.UNKNOWN, 0, QosReliability.RELIABLE, QosDurability.VOLATILE, _NO_TIME, _NO_TIME,
    QosLiveliness.AUTOMATIC, _NO_TIME, False,
)  # fmt: skip


@dataclass(frozen=True)
class Repair:
    """What a repair found: messages kept, bytes that could not be read, when the last message came (ns)."""

    messages: int
    bytes_lost: int
    last: int

    def __str__(self) -> str:
        """One sentence for a person."""
        lost = (
            f"{self.bytes_lost:,} bytes at the end could not be read" if self.bytes_lost else "nothing was unreadable"
        )
        return f"was cut off and is repaired: {self.messages:,} messages; {lost}"


def is_cut_off(folder: Path) -> bool:
    """Whether a folder holds a bag without its end."""
    return not (folder / METADATA).exists() and bool(_files_of(folder))


def repair(folder: Path) -> Repair:
    """Repair a bag in its place.

    Raises:
        InputError: Somebody writes it, or nothing in it is readable.
    """
    writer, found = go_on(folder)
    writer.close()
    return found


def go_on(folder: Path, *, compress: bool = True) -> tuple[BagWriter, Repair]:
    """Repair a bag and open it: after `split`, more messages can be written.

    Raises:
        InputError: Somebody writes it, or nothing in it is readable.
    """
    os.close(lock(folder))  # a bag that is being written only looks cut off
    files = _files_of(folder)
    if not files:
        raise InputError(folder, "", f"no {SUFFIX} file", "a rosbag2 bag (MCAP)")
    topics: list[Topic] = []
    kept: list[BagFile] = []
    lost = 0
    half = folder / f".repair.{os.getpid()}"
    for file in files:
        mended = BagWriter.create(half)
        try:
            lost += _salvage(file, mended, topics)
            mended.close()
            (new,) = half.glob(f"*{SUFFIX}")
            written = mended.files[0]
            new.replace(file)
        finally:
            for left in half.glob("*"):
                left.unlink()
            half.rmdir()
        kept.append(BagFile(file.name, written.first, written.last, written.count))
    if not any(file.count for file in kept):
        raise InputError(folder, "", "no readable message", "a rosbag2 bag (MCAP)")
    (folder / METADATA).unlink(missing_ok=True)  # it knows nothing of what is to come
    found = Repair(sum(file.count for file in kept), lost, max(file.last for file in kept))
    return BagWriter.after(folder, topics, kept, compress=compress), found


def _files_of(folder: Path) -> list[Path]:
    """The files of a bag in the order in which they were written."""

    def number(file: Path) -> int:
        digits = re.search(r"(\d+)$", file.stem)
        return int(digits[1]) if digits else 0

    return sorted((f for f in folder.glob(f"*{SUFFIX}") if not f.name.startswith(".")), key=number)


def _salvage(file: Path, writer: BagWriter, topics: list[Topic]) -> int:
    """Copy all that is readable in a file; how many bytes at its end are not. `topics` counts over all files."""
    numbers: dict[int, int] = {}
    schemas: dict[int, Schema] = {}
    known = {topic.name: topic for topic in topics}
    with file.open("rb") as stream:
        good = 0
        for record in _records(stream):
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel) and record.id not in numbers:
                topic = _topic_of(record, schemas)
                numbers[record.id] = writer.add(topic)
                if topic.name not in known:
                    known[topic.name] = Topic(topic.name, topic.kind, topic.definition, topic.hash, topic.qos)
                    topics.append(known[topic.name])
            elif isinstance(record, Message) and record.channel_id in numbers:
                number = numbers[record.channel_id]
                writer.write(number, record.log_time, record.data)
                known[writer.topics[number].name].count += 1
            elif isinstance(record, Footer):
                return 0
            good = stream.tell()
    return file.stat().st_size - good


def _records(stream: Any) -> Iterator[Any]:
    try:
        yield from StreamReader(stream).records
    except UNREADABLE:
        return


def _topic_of(channel: Channel, schemas: dict[int, Schema]) -> Topic:
    schema = schemas[channel.schema_id]
    definition = schema.data.decode()
    try:
        qos = parse_qos(channel.metadata.get(QOS_KEY, ""))
    except (ReaderError, KeyError, TypeError):
        qos = []
    hashed = type_hash(schema.name, definition)
    return Topic(channel.topic, schema.name, definition, hashed, qos[0] if qos else _UNKNOWN_QOS)
