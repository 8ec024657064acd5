"""Files that programs write: whole or not at all, or line by line. A disk that is full is one line, and never more.

A file that is not whole never has its final name. What is no regular file (a pipe, /dev/stdout) is written as it is.
"""

from __future__ import annotations

import fcntl
import os
import stat
import sys
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple, Protocol

from soup_msgs_py.errors import InputError, RunError

INCOMPLETE = ".incomplete"
LONGEST_NAME = 255  # bytes, on all file systems that are common
LONGEST_SUFFIX = 20  # characters that say what kind of file it is
BUFFER = 1 << 20  # characters that wait to be written
COPIED = 1 << 20  # bytes read at once
Tell = Callable[[str], None]


class OutputError(RunError):
    """A file could not be written; its text is one line.

    Args:
        path: The file.
        error: What the system said.
    """

    def __init__(self, path: Path, error: OSError) -> None:
        super().__init__(f"{path}: could not be written: {why(error)}")


class Written(NamedTuple):
    """How much of a growing file there is.

    Attributes:
        size: Bytes.
        checksum: CRC-32 of them.
        is_whole: Whether nothing is missing among them; to a file that the disk had no room for, nothing is added.
    """

    size: int
    checksum: int
    is_whole: bool = True


class Lines(Protocol):
    """What takes lines of text, for instance an open file."""

    def write(self, line: str, /) -> object:
        """Take one line, with its end."""


def why(error: OSError) -> str:
    """What the system said, without numbers and paths."""
    return error.strerror or str(error)


def tell_on_stderr(line: str) -> None:
    """Say something to the person who started this program."""
    print(line, file=sys.stderr, flush=True)


def write_whole(path: str | Path, data: str | bytes, *, durable: bool = False) -> None:
    """Write a file whole or not at all.

    Args:
        path: The file.
        data: All that it is to hold; text becomes UTF-8.
        durable: Whether it is to outlive a machine that is switched off.

    Raises:
        OutputError: It cannot be written.
    """
    with whole(path) as half, open(half, "wb", opener=_not_waiting) as file:
        file.write(data.encode() if isinstance(data, str) else data)
        if durable and half != Path(path):
            file.flush()
            os.fsync(file.fileno())


@contextmanager
def whole(path: str | Path) -> Iterator[Path]:
    """A place to write to, with the suffix of the file; it becomes the file if all goes well, and is gone otherwise.

    Raises:
        OutputError: It cannot be written; of whatever raises `OSError` inside.
    """
    path = Path(path)
    try:
        if _is_special(path):
            yield path
            return
        target = Path(os.path.realpath(path))  # what a link stands for, not the link
        half = target.with_name(_fitting(f".{target.stem}", f".{os.getpid()}{target.suffix[-LONGEST_SUFFIX:]}"))
        try:
            yield half
            half.replace(target)
        finally:
            with suppress(OSError):
                half.unlink(missing_ok=True)
    except OSError as error:
        raise OutputError(path, error) from error


class GrowingFile:
    """A file that grows line by line. It gets its name when it is whole; until then it is called `.incomplete`.

    Should the disk be full, it keeps the whole lines that it has, says so once, and takes no more; whoever writes goes
    on. What has been written is known by its length and checksum, so that somebody else can go on with it.

    Attributes:
        problem: Why it takes no more; empty while it does.
    """

    def __init__(self, path: Path, tell: Tell = tell_on_stderr, goes_on: Written | None = None) -> None:
        """Open the file.

        Args:
            path: Its name once it is whole.
            tell: Says something to a person.
            goes_on: How much of what is there counts; where there is something else, it is kept, and nothing is
                written.

        Raises:
            InputError: It cannot be written, or somebody else writes it.
        """
        self.problem = ""
        self._path, self._tell = path, tell
        self._lines: list[str] = []
        self._waiting = self._size = self._checksum = 0
        self._half: Path | None = None
        try:
            if _is_special(path):
                self._file = _not_waiting(path, os.O_WRONLY | os.O_CLOEXEC)
                return
            self._target = Path(os.path.realpath(path))
            self._half = self._target.with_name(_fitting(self._target.name, INCOMPLETE))
            self._file = _open_alone(self._half)
        except BlockingIOError as error:
            raise InputError(path, "", "a file that another run writes now", "a name of its own") from error
        except OSError as error:
            raise InputError(path, "", why(error), "a file that can be written") from error
        if goes_on is not None:
            self._go_on(goes_on)
        else:
            os.ftruncate(self._file, 0)

    def write(self, line: str) -> None:
        """Take one line, with its end."""
        if self._file < 0 or self.problem:
            return
        self._lines.append(line)
        self._waiting += len(line)
        if self._waiting >= BUFFER:
            self.flush()

    def flush(self) -> Written:
        """Hand everything over to the system; how much there is now."""
        data = "".join(self._lines).encode()
        self._lines.clear()
        self._waiting = written = 0
        try:
            while written < len(data):
                written += os.write(self._file, data[written:])
        except OSError as error:
            written = data.rfind(b"\n", 0, written) + 1
            where = f"; what came before is in {self._half}" if self._half is not None else ""
            if self._half is not None:
                with suppress(OSError):
                    os.ftruncate(self._file, self._size + written)
            self._end(f"{why(error)}{where}")
        self._size += written
        self._checksum = zlib.crc32(data[:written], self._checksum)
        return Written(self._size, self._checksum, not self.problem)

    def finish(self) -> None:
        """All is written: it gets its name."""
        if self._file < 0:
            return
        self.flush()
        if self._half is not None and not self.problem:
            try:
                self._half.replace(self._target)
            except OSError as error:
                self._end(f"{why(error)}; all is in {self._half}")
        self.close()

    def close(self) -> None:
        """End; what was not finished stays incomplete, and that is said. Can be called twice."""
        if self._file < 0:
            return
        self.flush()
        if self._half is not None and not self.problem and self._half.exists():
            self._end(f"the run ended early; what came before is in {self._half}")
        with suppress(OSError):
            os.close(self._file)
        self._file = -1

    def _go_on(self, before: Written) -> None:
        """Take what is there, or keep it as it is."""
        found, left = 0, before.size
        while left > 0 and (part := os.read(self._file, min(left, COPIED))):
            found = zlib.crc32(part, found)
            left -= len(part)
        if left == before.size > 0:
            self._tell(f"{self._path}: begins anew; {self._half} is not there any more")
        elif left or found != before.checksum:
            self._end(f"nothing is written; {self._half} is not what the checkpoint goes on from (checksum)")
        elif not before.is_whole:
            self._end(f"nothing more is written; {self._half} has ended before")
        else:
            os.ftruncate(self._file, before.size)
            self._size, self._checksum = before.size, before.checksum

    def _end(self, problem: str) -> None:
        self.problem = problem
        self._tell(f"{self._path}: {problem}")


class SharedFile:
    """The end of a file that others write to as well, line by line.

    Args:
        path: The file; made if there is none.
        tell: Says something to a person: once, when the disk is full; nothing more is written then.

    Raises:
        InputError: It cannot be written.
    """

    def __init__(self, path: Path, tell: Tell = tell_on_stderr) -> None:
        self._path, self._tell = path, tell
        try:
            self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 0o666)
        except OSError as error:
            raise InputError(path, "", why(error), "a file that can be written") from error

    def write(self, line: str) -> None:
        """Append one line, with its end, in one piece."""
        if self._file < 0:
            return
        data = line.encode()
        try:
            written = os.write(self._file, data)
            if written < len(data):
                self._take_back(written)
                os.write(self._file, data)  # says why
        except OSError as error:
            self._tell(f"{self._path}: {why(error)}; it lacks what comes now")
            self.close()

    def close(self) -> None:
        """End. Can be called twice."""
        if self._file >= 0:
            with suppress(OSError):
                os.close(self._file)
            self._file = -1

    def _take_back(self, written: int) -> None:
        """Take a half line away, unless somebody else has written after it."""
        with suppress(OSError):
            end = os.lseek(self._file, 0, os.SEEK_CUR)
            if end == os.fstat(self._file).st_size:
                os.ftruncate(self._file, end - written)


def _not_waiting(path: str | Path, flags: int) -> int:
    """Open a file; a pipe that nobody reads is an error, not a wait."""
    file = os.open(path, flags | os.O_NONBLOCK, 0o666)
    os.set_blocking(file, True)
    return file


def _is_special(path: Path) -> bool:
    """Whether something is there that is neither a regular file nor a folder."""
    try:
        mode = path.stat().st_mode
    except OSError:
        return False
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))


def _fitting(name: str, end: str) -> str:
    """A name with something at its end, shortened to what a file system takes."""
    room = LONGEST_NAME - len(os.fsencode(end))
    return os.fsdecode(os.fsencode(name)[:room]) + end


def _open_alone(path: Path) -> int:
    """Open a file that nobody else writes, and keep others from writing it."""
    while True:
        file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o666)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if _is_at(file, path):
                return file
        except OSError:
            os.close(file)
            raise
        os.close(file)  # whoever had it has just given it its final name


def _is_at(file: int, path: Path) -> bool:
    """Whether an open file is still the one at a path."""
    try:
        return os.path.samestat(os.fstat(file), path.stat())
    except FileNotFoundError:
        return False
