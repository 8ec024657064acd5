"""Makes a bag whole whose recorder was killed, or ran out of disk: everything that can be read stays.

A file that is more than cut short, damaged before its end, is kept beside the new one: others may read more of it.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path

from mcap.records import Channel
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2.errors import ReaderError
from rosbags.rosbag2.metadata import parse_qos

from soup_lab.bags.interfaces import type_hash
from soup_lab.bags.mcap import McapFile
from soup_lab.bags.writer import METADATA, QOS_KEY, SUFFIX, BagFile, BagWriter, Topic, lock
from soup_msgs_py.errors import InputError

HALF = ".repair"  # where a file is written anew
DAMAGED = ".damaged"  # what the name of a file that is kept ends with
_NO_TIME = QosTime(0, 0)
_UNKNOWN_QOS = Qos(
    QosHistory.UNKNOWN, 0, QosReliability.RELIABLE, QosDurability.VOLATILE, _NO_TIME, _NO_TIME,
    QosLiveliness.AUTOMATIC, _NO_TIME, False,
)  # fmt: skip


@dataclass(frozen=True)
class Repair:
    """What a repair found: messages kept, bytes that could not be read, names under which damaged files are kept."""

    messages: int
    bytes_lost: int
    damaged: tuple[str, ...] = ()

    def __str__(self) -> str:
        """One sentence for a person."""
        lost = f"{self.bytes_lost:,} bytes could not be read" if self.bytes_lost else "nothing was unreadable"
        kept = f"; what was damaged is kept as {', '.join(self.damaged)}" if self.damaged else ""
        return f"was cut off and is repaired: {self.messages:,} messages; {lost}{kept}"


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
    held = lock(folder)  # a bag that is being written only looks cut off
    try:
        topics, kept, found = _mend(folder)
    except BaseException:
        os.close(held)
        raise
    return BagWriter.after(folder, topics, kept, held, compress=compress), found


def _mend(folder: Path) -> tuple[list[Topic], list[BagFile], Repair]:
    """Write all files of a bag anew."""
    files = _files_of(folder)
    if not files:
        raise InputError(folder, "", f"no {SUFFIX} file", "a rosbag2 bag (MCAP)")
    if not any(map(_holds_messages, files)):
        raise InputError(folder, "", "no readable message", "a rosbag2 bag (MCAP)")
    topics: list[Topic] = []
    kept: list[BagFile] = []
    damaged: list[str] = []
    lost = 0
    half = folder / HALF
    _remove_left_over(folder)
    for file in files:
        mended = BagWriter.create(half)
        try:
            bytes_lost, is_damaged = _salvage(file, mended, topics)
            lost += bytes_lost
            mended.close()
            written = mended.files[0]
            if is_damaged:
                damaged.append(file.name + DAMAGED)
                file.replace(folder / damaged[-1])
            (half / written.path).replace(file)
        finally:
            mended.abandon()
            _remove_left_over(folder)
        kept.append(BagFile(file.name, written.first, written.last, written.count))
    (folder / METADATA).unlink(missing_ok=True)  # it knows nothing of what is to come
    return topics, kept, Repair(sum(file.count for file in kept), lost, tuple(damaged))


def _remove_left_over(folder: Path) -> None:
    """Remove what a repair, or a recorder, that was killed had not made whole."""
    for half in folder.glob(f"{HALF}*/"):
        for left in half.iterdir():
            left.unlink()
        half.rmdir()
    for left in folder.glob(f".{METADATA}.*"):
        left.unlink()


def _files_of(folder: Path) -> list[Path]:
    """The files of a bag in the order in which they were written."""

    def number(file: Path) -> int:
        digits = re.search(r"(\d+)$", file.stem)
        return int(digits[1]) if digits else 0

    found = [file for file in folder.glob(f"*{SUFFIX}") if file.is_file() and not file.name.startswith(".")]
    return sorted(found, key=number)


def _holds_messages(path: Path) -> bool:
    file = McapFile(path)
    file.close()
    return bool(file.counts)


def _salvage(path: Path, writer: BagWriter, topics: list[Topic]) -> tuple[int, bool]:
    """Copy all that is sound in a file. `topics` counts over all files.

    Returns:
        How many bytes of it are not sound, and whether it is worth keeping: not only its end is missing.
    """
    numbers: dict[int, int] = {}
    known = {topic.name: topic for topic in topics}
    file = McapFile(path)
    try:
        for channel in sorted(file.counts):
            topic = _topic_of(file, file.channels[channel])
            if topic is None:
                continue
            numbers[channel] = writer.add(topic)
            if topic.name not in known:
                known[topic.name] = Topic(topic.name, topic.kind, topic.definition, topic.hash, topic.qos)
                topics.append(known[topic.name])
        for piece in file.pieces:
            for channel, time, data in file.messages(piece):
                if channel in numbers:
                    writer.write(numbers[channel], time, data)
                    known[writer.topics[numbers[channel]].name].count += 1
    finally:
        file.close()
    return file.bytes_lost, file.broken > 0


def qos_of(channel: Channel) -> Qos | None:
    """What the publishers of a channel offered; None where it does not say."""
    try:
        found = parse_qos(channel.metadata.get(QOS_KEY, ""))
    except (ReaderError, KeyError, TypeError, AttributeError, ValueError):
        return None
    return found[0] if found else None


def _topic_of(file: McapFile, channel: Channel) -> Topic | None:
    schema = file.schemas.get(channel.schema_id)
    if schema is None or channel.message_encoding != "cdr":
        return None
    definition = schema.data.decode(errors="replace")
    hashed = type_hash(schema.name, definition)
    return Topic(channel.topic, schema.name, definition, hashed, qos_of(channel) or _UNKNOWN_QOS)
