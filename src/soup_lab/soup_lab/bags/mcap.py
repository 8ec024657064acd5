"""What is sound in an MCAP file: its chunks, each checked against its checksum and its own limits.

Nothing that a file says of itself is believed unless it holds: a chunk whose checksum differs, that states another size
than it has, or that holds more than `MOST_CHUNK` bytes is left out, and the search goes on for the next one. So a file
is read as far as it is sound, whether its index is there or not.
"""

from __future__ import annotations

import mmap
import struct
import zlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any

import lz4.frame
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Footer, Schema, Statistics

MOST_CHUNK = 128 << 20  # bytes that a chunk may hold, unpacked
MAGIC = b"\x89MCAP0\r\n"
UNREADABLE = (McapError, zstandard.ZstdError, RuntimeError, ValueError, MemoryError, OverflowError, struct.error)
_HEAD = struct.Struct("<BQ")  # of a record: opcode, length
_CHUNK = struct.Struct("<QQQII")  # of a chunk: first and last time, bytes unpacked, checksum, length of a name
_LENGTH = struct.Struct("<Q")
_SUM = struct.Struct("<I")
_MESSAGE = struct.Struct("<HIQQ")  # of a message: channel, number, time of its record, time of its publication
_FOOTER_BYTES = _HEAD.size + 20
# bytes of records that have but one size
_SIZES: dict[int, int] = {Opcode.FOOTER: 20, Opcode.SUMMARY_OFFSET: 17, Opcode.DATA_END: 4}
_NAMES = {b"": "", b"zstd": "zstd", b"lz4": "lz4"}
_BARE = frozenset({Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE})


class Broken(ValueError):
    """Bytes that are not what they say."""


@dataclass(frozen=True)
class Piece:
    """A stretch of a file that holds messages: a chunk, or messages that are in none.

    Attributes:
        start: Where its content begins in the file.
        end: Where it ends.
        compression: Of its content: `zstd`, `lz4` or nothing.
        size: Bytes of the content, unpacked.
        crc: Its checksum; 0 without one.
        first: Time of its first message (ns).
        last: Time of its last one.
        counts: Messages in each channel.
    """

    start: int
    end: int
    compression: str
    size: int
    crc: int
    first: int = 2**64 - 1
    last: int = 0
    counts: Counter[int] = field(default_factory=Counter)


class McapFile:
    """An open file; close it in the end.

    Attributes:
        path: Where it stands.
        pieces: All that is sound in it, in its order.
        channels: Its channels, by number.
        schemas: Its schemas, by number.
        stated: How many messages its index states; None where there is no sound index.
        broken: Chunks that are left out.
        bytes_lost: Bytes that could not be read.
        is_checked: Whether all pieces have a checksum.
        is_whole: Whether it has its end, and every byte of it is as it was written.
    """

    def __init__(self, path: Path) -> None:
        """Read a file through.

        Raises:
            OSError: It cannot be read.
        """
        self.path = path
        self.pieces: list[Piece] = []
        self.channels: dict[int, Channel] = {}
        self.schemas: dict[int, Schema] = {}
        self.stated: int | None = None
        self.broken = self.bytes_lost = 0
        self._data: mmap.mmap | bytes = b""
        with path.open("rb") as stream:
            if path.stat().st_size:
                self._data = mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ)
        end = self._read_index()
        self._read_pieces(len(MAGIC), len(self._data) if end is None else end)
        self.is_checked = all(piece.crc for piece in self.pieces)
        self.is_whole = end is not None and not self.bytes_lost and self._sum_is_right(end)

    def close(self) -> None:
        """Let go of the file."""
        if isinstance(self._data, mmap.mmap):
            self._data.close()

    @property
    def counts(self) -> Counter[int]:
        """Messages in each channel that is known."""
        found: Counter[int] = Counter()
        for piece in self.pieces:
            found.update({channel: n for channel, n in piece.counts.items() if channel in self.channels})
        return found

    def messages(self, piece: Piece) -> Iterator[tuple[int, int, bytes]]:
        """Channel, time (ns) and content of the messages of a piece.

        Raises:
            Broken: The file has changed since it was opened.
        """
        content = self._unpack(piece)
        for opcode, start, end in _records(content):
            if opcode == Opcode.MESSAGE:
                channel, _, time, _ = _MESSAGE.unpack_from(content, start)
                yield channel, time, content[start + _MESSAGE.size : end]

    # ---- the index ----------------------------------------------------------------------------------------

    def _read_index(self) -> int | None:
        """Take in what the index says, if it is sound; where it begins."""
        data = self._data
        at = len(data) - len(MAGIC) - _FOOTER_BYTES
        if at < len(MAGIC) or data[-len(MAGIC) :] != MAGIC or _HEAD.unpack_from(data, at) != (Opcode.FOOTER, 20):
            return None
        footer = Footer.read(_stream(data[at + _HEAD.size :]))
        begin = footer.summary_start or at
        if not len(MAGIC) <= begin <= at:
            return None
        if footer.summary_crc and zlib.crc32(data[begin : at + _HEAD.size + 16]) != footer.summary_crc:
            return None
        try:
            for opcode, start, end in _records(data[begin:at]):
                body = data[begin + start : begin + end]
                self._define(opcode, body)
                if opcode == Opcode.STATISTICS:
                    self.stated = Statistics.read(_stream(body)).message_count
        except UNREADABLE:
            return None
        return begin

    def _sum_is_right(self, end: int) -> bool:
        """Whether all that lies before the index has the checksum that it should."""
        at = end - _HEAD.size - _SUM.size
        if at < 0 or _HEAD.unpack_from(self._data, at) != (Opcode.DATA_END, _SUM.size):
            return False
        (expected,) = _SUM.unpack_from(self._data, at + _HEAD.size)
        with memoryview(self._data) as view:
            return expected == 0 or zlib.crc32(view[:at]) == expected

    def _define(self, opcode: int, body: bytes) -> None:
        """Take in a schema or a channel."""
        if opcode == Opcode.SCHEMA:
            schema = Schema.read(_stream(body))
            self.schemas.setdefault(schema.id, schema)
        elif opcode == Opcode.CHANNEL:
            channel = Channel.read(_stream(body))
            self.channels.setdefault(channel.id, channel)

    # ---- the content --------------------------------------------------------------------------------------

    def _read_pieces(self, at: int, end: int) -> None:
        """Find all that is sound between two places."""
        while at < end:
            after = self._record_end(at, end)
            opcode = self._data[at]
            if after is None or not self._is_likely(opcode, at + _HEAD.size, after):
                after = self._next_chunk(at + 1, end)
                self.bytes_lost += after - at
            elif opcode == Opcode.CHUNK:
                if not self._take(self._chunk_at(at, after)):
                    self.broken += 1
                    if self._record_end(after, end) is None:  # its length is wrong, too
                        after = self._next_chunk(at + 1, end)
                    self.bytes_lost += after - at
            elif opcode in _BARE:
                after = self._bare_end(at, end)
                if not self._take(Piece(at, after, "", after - at, 0)):
                    self.bytes_lost += after - at
            at = after

    def _record_end(self, at: int, end: int) -> int | None:
        """Where a record ends; None where there cannot be one."""
        if at == end:
            return end
        if at + _HEAD.size > end:
            return None
        opcode, length = _HEAD.unpack_from(self._data, at)
        after = at + _HEAD.size + length
        return after if Opcode.HEADER <= opcode <= Opcode.DATA_END and after <= end else None

    def _is_likely(self, opcode: int, start: int, after: int) -> bool:
        """Whether the content of a record has a size that its opcode allows: one wrong bit makes a chunk another."""
        size = after - start
        if opcode == Opcode.MESSAGE_INDEX:
            return size >= 6 and _SUM.unpack_from(self._data, start + 2)[0] == size - 6
        return size == _SIZES.get(opcode, size)

    def _bare_end(self, at: int, end: int) -> int:
        """Where messages that are in no chunk end."""
        while at < end and self._data[at] in _BARE and (after := self._record_end(at, end)) is not None:
            at = after
        return at

    def _next_chunk(self, at: int, end: int) -> int:
        """Where the next chunk begins that looks like one."""
        while (at := self._data.find(bytes([Opcode.CHUNK]), at, end)) >= 0:
            after = self._record_end(at, end)
            if after is not None and self._chunk_at(at, after) is not None:
                return at
            at += 1
        return end

    def _chunk_at(self, at: int, after: int) -> Piece | None:
        """The chunk that a record says it is; None where its sizes cannot be."""
        data, at = self._data, at + _HEAD.size
        if after - at < _CHUNK.size + _LENGTH.size:
            return None
        _, _, size, crc, name_length = _CHUNK.unpack_from(data, at)
        begin = at + _CHUNK.size + name_length + _LENGTH.size
        name = data[at + _CHUNK.size : at + _CHUNK.size + min(name_length, 8)]
        if begin > after or name not in _NAMES or size > MOST_CHUNK:
            return None
        (length,) = _LENGTH.unpack_from(data, begin - _LENGTH.size)
        return Piece(begin, after, _NAMES[name], size, crc) if begin + length == after else None

    def _take(self, piece: Piece | None) -> bool:
        """Take in a piece if it is sound."""
        if piece is None:
            return False
        first, last, counts = piece.first, piece.last, piece.counts
        definitions = []
        try:
            content = self._unpack(piece)
            for opcode, start, end in _records(content):
                if opcode == Opcode.MESSAGE:
                    if end - start < _MESSAGE.size:
                        return False
                    channel, _, time, _ = _MESSAGE.unpack_from(content, start)
                    counts[channel] += 1
                    first, last = time if time < first else first, time if time > last else last
                elif opcode in _BARE:
                    definitions.append((opcode, content[start:end]))
            for opcode, body in definitions:
                self._define(opcode, body)
        except UNREADABLE:
            return False
        if counts:
            whole = Piece(piece.start, piece.end, piece.compression, piece.size, piece.crc, first, last, counts)
            self.pieces.append(whole)
        return True

    def _unpack(self, piece: Piece) -> bytes:
        """The content of a piece; no more of it is unpacked than it states.

        Raises:
            Broken: It is not what it says.
        """
        packed = self._data[piece.start : piece.end]
        try:
            content = _UNPACK[piece.compression](packed, piece.size)
        except UNREADABLE as error:
            raise Broken(str(error)) from error
        if len(content) != piece.size:
            raise Broken(f"a chunk that holds other than the {piece.size} bytes it states")
        if piece.crc and zlib.crc32(content) != piece.crc:
            raise Broken("a chunk with another checksum")
        return content


def _unpack_zstd(packed: bytes, size: int) -> bytes:
    # what a frame states is allocated at once
    if zstandard.frame_content_size(packed) not in (size, -1):
        raise Broken("a frame that states another size than its chunk")
    return zstandard.decompress(packed, max_output_size=size)


def _unpack_lz4(packed: bytes, size: int) -> bytes:
    return lz4.frame.LZ4FrameDecompressor().decompress(packed, max_length=size + 1)


_UNPACK: dict[str, Any] = {"": lambda packed, _: packed, "zstd": _unpack_zstd, "lz4": _unpack_lz4}


def _records(content: bytes) -> Iterator[tuple[int, int, int]]:
    """Opcode, begin and end of the content of all records.

    Raises:
        Broken: They do not fill it.
    """
    at, size = 0, len(content)
    while at < size:
        opcode, length = _HEAD.unpack_from(content, at)
        at += _HEAD.size
        if at + length > size:
            raise Broken("a record that is longer than what holds it")
        yield opcode, at, at + length
        at += length


def _stream(body: bytes) -> ReadDataStream:
    return ReadDataStream(BytesIO(body))
