"""What programs write: whole or not at all, line by line as far as the disk goes, and one line says what is missing."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from soup_msgs_py.command_line.output_files import GrowingFile, OutputError, SharedFile, whole, write_whole
from soup_msgs_py.errors import InputError

LINES = [f"line {number}\n" for number in range(100)]


@pytest.fixture
def small_disk(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """A disk with room for so many more bytes as the list's one number says."""
    room = [0]
    write = os.write

    def write_what_fits(file: int, data: bytes) -> int:
        fits = data[: room[0]]
        if not fits:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        room[0] -= len(fits)
        return write(file, fits)

    monkeypatch.setattr(os, "write", write_what_fits)
    return room


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_file_that_cannot_be_written_leaves_the_one_before_as_it_was(tmp_path: Path):
    file = tmp_path / "summary.json"
    write_whole(file, "before")
    with (
        pytest.raises(OutputError, match=r"summary\.json: could not be written: No space left on device"),
        whole(file) as half,
    ):
        half.write_text("af")
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert file.read_text() == "before"
    assert names(tmp_path) == ["summary.json"]


def test_a_device_is_written_not_replaced():
    with pytest.raises(OutputError, match="/dev/full: could not be written: No space left on device"):
        write_whole("/dev/full", "text")
    write_whole("/dev/null", "text")
    assert Path("/dev/null").is_char_device() and Path("/dev/full").is_char_device()


def test_a_link_stays_one_and_a_pipe_without_a_reader_is_no_wait(tmp_path: Path):
    (tmp_path / "link").symlink_to(tmp_path / "file")
    write_whole(tmp_path / "link", "text")
    assert (tmp_path / "link").is_symlink() and (tmp_path / "file").read_text() == "text"
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(OutputError):
        write_whole(tmp_path / "pipe", "text")


@pytest.mark.parametrize("name", ["n" * 255, "n" * 240 + ".suffix", "é" * 127])
def test_the_longest_names_are_written(tmp_path: Path, name: str):
    write_whole(tmp_path / name, "text")
    log = GrowingFile(tmp_path / name)
    log.write("line\n")
    log.finish()
    assert names(tmp_path) == [name]
    assert (tmp_path / name).read_text() == "line\n"


def test_a_log_gets_its_name_when_it_is_whole(tmp_path: Path):
    told: list[str] = []
    log = GrowingFile(tmp_path / "events.jsonl", told.append)
    for line in LINES:
        log.write(line)
    assert names(tmp_path) == ["events.jsonl.incomplete"]
    log.finish()
    log.close()
    assert (tmp_path / "events.jsonl").read_text() == "".join(LINES)
    assert names(tmp_path) == ["events.jsonl"] and not told


def test_a_log_that_the_disk_has_no_room_for_keeps_its_whole_lines_and_says_so_once(tmp_path: Path, small_disk):
    told: list[str] = []
    log = GrowingFile(tmp_path / "events.jsonl", told.append)
    small_disk[0] = len("".join(LINES[:30])) + 3
    for line in LINES:
        log.write(line)
    written = log.flush()
    small_disk[0] = 10**6
    log.write("a line after a gap\n")
    log.finish()
    half = tmp_path / "events.jsonl.incomplete"
    assert names(tmp_path) == [half.name]
    assert half.read_text() == "".join(LINES[:30])
    assert told == [f"{tmp_path}/events.jsonl: No space left on device; what came before is in {half}"]
    assert written.size == half.stat().st_size and not written.is_whole


def test_a_log_of_a_run_that_ended_early_stays_and_is_told(tmp_path: Path):
    told: list[str] = []
    log = GrowingFile(tmp_path / "events.jsonl", told.append)
    log.write(LINES[0])
    log.close()
    assert (tmp_path / "events.jsonl.incomplete").read_text() == LINES[0]
    assert len(told) == 1 and "ended early" in told[0]


def test_a_log_that_another_run_writes_is_refused(tmp_path: Path):
    log = GrowingFile(tmp_path / "events.jsonl")
    with pytest.raises(InputError, match="another run writes"):
        GrowingFile(tmp_path / "events.jsonl")
    log.write(LINES[0])
    log.finish()
    assert (tmp_path / "events.jsonl").read_text() == LINES[0]


def test_a_log_goes_on_from_where_it_was_known_without_what_came_after(tmp_path: Path):
    told: list[str] = []
    first = GrowingFile(tmp_path / "log", told.append)
    first.write(LINES[0])
    known = first.flush()
    first.write(LINES[1])
    first.close()
    second = GrowingFile(tmp_path / "log", goes_on=known)
    second.write(LINES[2])
    second.finish()
    assert (tmp_path / "log").read_text() == LINES[0] + LINES[2]


def test_another_log_than_the_known_one_is_kept_as_it_is(tmp_path: Path):
    told: list[str] = []
    first = GrowingFile(tmp_path / "log", told.append)
    first.write(LINES[0])
    known = first.flush()
    first.close()
    mine = "somebody's letter, which is longer than the log"
    (tmp_path / "log.incomplete").write_text(mine)
    second = GrowingFile(tmp_path / "log", told.append, known)
    second.write(LINES[2])
    second.finish()
    assert (tmp_path / "log.incomplete").read_text() == mine
    assert "checksum" in told[-1]
    third = GrowingFile(tmp_path / "other", told.append, known)
    third.write(LINES[3])
    third.finish()
    assert (tmp_path / "other").read_text() == LINES[3] and "begins anew" in told[-1]


def test_lines_in_a_file_that_others_share_are_whole_or_not_there(tmp_path: Path, small_disk):
    told: list[str] = []
    file, other = SharedFile(tmp_path / "choices", told.append), SharedFile(tmp_path / "choices")
    small_disk[0] = 2 * len(LINES[0]) + 2
    for shared in (file, other, file, file):
        shared.write(LINES[0])
    small_disk[0] = 1000
    other.write(LINES[0])
    file.close()
    other.close()
    assert (tmp_path / "choices").read_text() == 3 * LINES[0]
    assert len(told) == 1 and "No space left on device" in told[0]
