"""Writes a rosbag2 bag (version 9, MCAP) whose content stays readable whatever ends the writing.

Checksums cover all of it: one each chunk, one all that lies before the index, one the index.
"""

from __future__ import annotations

import fcntl
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml
from mcap.writer import CompressionType, Writer
from rosbags.interfaces import Qos
from rosbags.rosbag2.metadata import dump_qos_v9

from soup_msgs_py.errors import InputError

METADATA = "metadata.yaml"
SUFFIX = ".mcap"
VERSION = 9
QOS_KEY = "offered_qos_profiles"  # of a channel
NEVER = 2**63 - 1


@dataclass
class BagFile:
    """One file of a bag. Times in ns of the recorder's clock."""

    path: str
    first: int = NEVER
    last: int = 0
    count: int = 0

    def entry(self) -> dict[str, Any]:
        """What stands of it in the bag's metadata."""
        return {
            "path": self.path,
            "starting_time": {"nanoseconds_since_epoch": self.first},
            "duration": {"nanoseconds": max(0, self.last - self.first)},
            "message_count": self.count,
        }


@dataclass
class Topic:
    """A topic of a bag."""

    name: str
    kind: str
    definition: str
    hash: str
    qos: Qos
    count: int = 0


class _Storage:
    """The file that is being written: topic k of the bag is its channel k + 1."""

    def __init__(self, path: Path, *, compress: bool) -> None:
        self.stream: Any = path.open("xb")
        compression = CompressionType.ZSTD if compress else CompressionType.NONE
        self.writer = Writer(self.stream, compression=compression, enable_data_crcs=True)
        self.writer.start("ros2")
        self._schemas: dict[str, int] = {}

    def connect(self, topic: Topic) -> None:
        """Make a channel for a topic."""
        if topic.kind not in self._schemas:
            encoding = "ros2idl" if topic.definition.startswith("=" * 80) else "ros2msg"
            self._schemas[topic.kind] = self.writer.register_schema(topic.kind, encoding, topic.definition.encode())
        self.writer.register_channel(topic.name, "cdr", self._schemas[topic.kind], {QOS_KEY: _written_qos(topic.qos)})


@dataclass
class BagWriter:
    """A bag that is being written. Others see by a lock on its folder that it is.

    Attributes:
        folder: Where it stands.
        compress: Whether to compress, with zstd.
        topics: Its topics, in the order of `add`; the numbers that `write` takes count them from 0.
        files: Its files.
        notes: What else to write into its metadata.
    """

    folder: Path
    compress: bool = True
    topics: list[Topic] = field(default_factory=list)
    files: list[BagFile] = field(default_factory=list)
    notes: dict[str, str] = field(default_factory=dict)
    _storage: _Storage | None = None
    _lock: int = -1

    @classmethod
    def create(cls, folder: Path, *, compress: bool = True) -> BagWriter:
        """Make a bag.

        Raises:
            InputError: There is something already, or the folder cannot be made.
        """
        try:
            folder.mkdir()
        except OSError as error:
            raise InputError(folder, "", error.strerror or error, "a folder that is not there yet") from error
        writer = cls(folder, compress)
        writer._lock = lock(folder)
        writer.split()
        return writer

    @classmethod
    def after(
        cls, folder: Path, topics: Sequence[Topic], files: Sequence[BagFile], held: int, *, compress: bool = True
    ) -> BagWriter:
        """A bag of files that are whole: after `split`, more messages go into a new file.

        Args:
            folder: Where it stands.
            topics: Its topics.
            files: Its files.
            held: What `lock` gave; the writer lets go of it.
            compress: Whether to compress what is still to come.
        """
        writer = cls(folder, compress, list(topics), list(files))
        writer._lock = held
        return writer

    @property
    def messages(self) -> int:
        """How many it holds."""
        return sum(file.count for file in self.files)

    @property
    def size(self) -> int:
        """Bytes on the disk."""
        return sum((self.folder / file.path).stat().st_size for file in self.files)

    @property
    def file_size(self) -> int:
        """Bytes of the present file."""
        return self._storage.stream.tell() if self._storage is not None else 0

    @property
    def file_first(self) -> int:
        """Time of the first message in the present file; `NEVER` without any."""
        return self.files[-1].first

    def add(self, topic: Topic) -> int:
        """Add a topic; its number."""
        self.topics.append(topic)
        assert self._storage is not None
        self._storage.connect(topic)
        return len(self.topics) - 1

    def write(self, topic: int, time: int, cdr: bytes) -> None:
        """Write a serialized message.

        Args:
            topic: Number of its topic.
            time: When it came (ns since 1970).
            cdr: The message, with its header.

        Raises:
            OSError: The disk is full, or broken.
        """
        assert self._storage is not None
        file = self.files[-1]
        self._storage.writer.add_message(topic + 1, time, cdr, time)
        if time < file.first:  # a call of min() takes as long as all else here
            file.first = time
        if time > file.last:
            file.last = time
        file.count += 1
        self.topics[topic].count += 1

    def flush(self) -> None:
        """Hand everything over to the system: it stays, though this process be killed.

        Raises:
            OSError: The disk is full, or broken.
        """
        assert self._storage is not None
        self._storage.writer.flush()

    def split(self) -> None:
        """Go on in a new file."""
        self._close_file()
        name = f"{self.folder.name}_{len(self.files)}{SUFFIX}"
        self._storage = _Storage(self.folder / name, compress=self.compress)
        self.files.append(BagFile(name))
        for topic in self.topics:
            self._storage.connect(topic)

    def close(self) -> None:
        """Write the index and the metadata: the bag is whole. Can be called twice.

        Raises:
            OSError: The disk is full, or broken.
        """
        if self._lock < 0:
            return
        self._close_file()
        half = self.folder / f".{METADATA}.{os.getpid()}"
        try:
            content = metadata(self.topics, self.files, self.notes)
            half.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
            half.replace(self.folder / METADATA)
        finally:
            half.unlink(missing_ok=True)
            self._let_go()

    def abandon(self) -> None:
        """End without an index, as if killed: the bag has to be repaired."""
        if self._storage is not None:
            # what is still in the buffer may not fit on the disk: close without it
            self._storage.stream.raw.close()
            self._storage = None
        self._let_go()

    def _close_file(self) -> None:
        storage, self._storage = self._storage, None
        if storage is None:
            return
        file = self.files[-1]
        content = metadata(self.topics, [file], {})["rosbag2_bagfile_information"]
        storage.writer.add_metadata(
            "rosbag2", {"serialized_metadata": yaml.safe_dump(content, sort_keys=False).strip()}
        )
        storage.writer.finish()
        storage.stream.close()

    def _let_go(self) -> None:
        if self._lock >= 0:
            os.close(self._lock)
            self._lock = -1


def lock(folder: Path) -> int:
    """Lock a bag for writing; the descriptor that holds the lock until it is closed.

    Raises:
        InputError: Somebody else writes it.
    """
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        os.close(descriptor)
        raise InputError(folder, "", "a bag that is being written", "a bag whose recorder has ended") from error
    return descriptor


def metadata(topics: Sequence[Topic], files: Sequence[BagFile], notes: dict[str, str]) -> dict[str, Any]:
    """The metadata of a bag, as rosbag2 wants them."""
    first = min((file.first for file in files), default=NEVER)
    last = max((file.last for file in files), default=0)
    return {
        "rosbag2_bagfile_information": {
            "version": VERSION,
            "storage_identifier": "mcap",
            "relative_file_paths": [file.path for file in files],
            "duration": {"nanoseconds": max(0, last - first)},
            "starting_time": {"nanoseconds_since_epoch": first},
            "message_count": sum(file.count for file in files),
            "topics_with_message_count": [
                {
                    "topic_metadata": {
                        "name": topic.name,
                        "type": topic.kind,
                        "serialization_format": "cdr",
                        "offered_qos_profiles": dump_qos_v9([topic.qos]),
                        "type_description_hash": topic.hash,
                    },
                    "message_count": topic.count,
                }
                for topic in topics
            ],
            "compression_format": "",
            "compression_mode": "",
            "files": [file.entry() for file in files],
            "custom_data": notes or None,
            "ros_distro": "jazzy",
        },
    }


def _written_qos(qos: Qos) -> str:
    return yaml.safe_dump(dump_qos_v9([qos]), sort_keys=False).strip()
