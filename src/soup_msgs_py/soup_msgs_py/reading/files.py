"""Files that a person names: one place opens them all, regular files only, and only up to a stated size."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

from soup_msgs_py.errors import InputError

AnyPath = str | os.PathLike[str]
DEVICE = "a device, pipe or socket"
ZERO_BYTE = "a zero byte in its name"


def read_bytes(path: AnyPath, most_bytes: int) -> bytes:
    """The content of a regular file of at most so many bytes.

    Raises:
        OSError: There is none, or it is another thing, or larger; `strerror` says which.
    """
    check_regular(path)
    # what was looked at may have been replaced by a pipe since, which nobody may wait for
    with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
        data = file.read(min(most_bytes, os.fstat(file.fileno()).st_size) + 1)  # as much is set aside as is asked for
    if len(data) > most_bytes:
        raise OSError(errno.EFBIG, f"more than {most_bytes} bytes", str(path))
    return data


def check_regular(path: AnyPath) -> None:
    """Make sure that a path leads to a regular file.

    Raises:
        OSError: It does not; `strerror` says why.
    """
    try:
        mode = os.stat(path).st_mode
    except ValueError:
        raise OSError(errno.EINVAL, ZERO_BYTE, str(path)) from None
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, DEVICE, str(path))


def read_text(path: AnyPath, most_bytes: int, allowed: str, named_at: tuple[object, str] | None = None) -> str:
    """The text of a file in UTF-8; a byte order mark before it is left out.

    Args:
        path: The file.
        most_bytes: Larger ones are refused.
        allowed: What kind of file it should be, for messages.
        named_at: The file and key that named it, where a person has to mend it there.

    Raises:
        InputError: It cannot be read, or is no such text.
    """
    try:
        return read_bytes(path, most_bytes).decode("utf-8-sig")
    except OSError as error:
        found = error.strerror or str(error)
        if error.errno == errno.EFBIG:
            allowed = f"{allowed}, at most {most_bytes} bytes"
        if named_at is None:
            raise InputError(path, "", found, allowed) from error
        raise InputError(*named_at, f"{path}: {found}", allowed) from error
    except UnicodeDecodeError as error:
        raise InputError(path, "", "bytes that are not UTF-8 text", allowed) from error


def whole_path(place: AnyPath, base: AnyPath) -> str:
    """A path as an absolute one, a link kept under its own name; what leads nowhere is told by who opens it."""
    folder, name = os.path.split(os.path.join(base, place))
    return _real(os.path.join(folder, name)) if name in ("", ".", "..") else os.path.join(_real(folder), name)


def folder_of(file: AnyPath) -> Path:
    """The folder that a file, not a link to it, is in: what the file names is relative to that."""
    return Path(_real(file)).parent


def _real(path: AnyPath) -> str:
    try:
        return os.path.realpath(path)
    except ValueError:  # no file can have that name
        return os.path.abspath(path)
