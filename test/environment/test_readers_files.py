"""Tests work in folders of their own: whoever runs them loses no file, and has none in their way."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

import _environment

ROOT = _environment.ROOT
# what a test might do in the project's folder, with a name that nobody has there
TOUCHES: dict[str, Callable[[Path], object]] = {
    "deletes a file": lambda file: file.unlink(missing_ok=True),
    "deletes a folder": lambda file: shutil.rmtree(file, ignore_errors=True),
    "writes a file": lambda file: file.write_text(""),
    "appends to a file": lambda file: file.open("a"),
    "makes a folder": lambda file: file.mkdir(),
    "puts a file in another one's place": lambda file: Path("mine").rename(file),
    "takes a file away": lambda file: file.rename("mine"),
}


@pytest.mark.parametrize("touch", TOUCHES.values(), ids=list(TOUCHES))
def test_a_test_that_would_touch_the_readers_files_fails(touch: Callable[[Path], object]):
    file = ROOT / "of_the_reader"
    assert not file.exists()
    with pytest.raises(BaseException, match="of_the_reader") as told:
        touch(file)
    assert type(told.value).__name__ == "ReadersFileError"
    assert not file.exists()


def test_a_test_begins_in_an_empty_folder(tmp_path: Path):
    assert Path.cwd() == tmp_path
    assert not list(Path.cwd().iterdir())
    Path("mine").write_text("")
    assert not (ROOT / "mine").exists()


def test_reading_the_project_and_keeping_caches_is_nobodys_loss():
    assert (ROOT / "README.md").read_text(encoding="utf-8")
    (ROOT / "test/__pycache__/nothing").unlink(missing_ok=True)
