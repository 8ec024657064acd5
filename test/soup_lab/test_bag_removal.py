"""A bag may make room for another one of its name; nothing else is ever removed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from soup_lab.bags.removal import remove_bag
from soup_msgs_py.errors import InputError


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    folder = tmp_path / "my_bag"
    folder.mkdir()
    for name in ("metadata.yaml", "my_bag_0.mcap", "my_bag_1.mcap"):
        (folder / name).write_text("")
    return folder


def test_a_bag_is_removed_as_a_whole(bag: Path):
    remove_bag(bag)
    assert not bag.exists()


KEPT: dict[str, Callable[[Path], object]] = {
    "a note": lambda bag: (bag / "notes.txt").write_text("what I saw"),
    "a folder": lambda bag: (bag / "plots.mcap").mkdir(),
    "a link to another bag": lambda bag: (bag / "other.mcap").symlink_to(bag / "my_bag_0.mcap"),
}


@pytest.mark.parametrize("add", KEPT.values(), ids=list(KEPT))
def test_a_folder_that_holds_anything_else_stays_as_it_is(bag: Path, add: Callable[[Path], object]):
    add(bag)
    before = sorted(bag.iterdir())
    with pytest.raises(InputError, match="allowed: a folder that holds a bag alone"):
        remove_bag(bag)
    assert sorted(bag.iterdir()) == before


def test_an_empty_folder_is_no_bag(tmp_path: Path):
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="is empty; allowed: a folder that holds a bag alone"):
        remove_bag(tmp_path / "empty")
    assert (tmp_path / "empty").is_dir()


def test_what_is_no_folder_stays(tmp_path: Path, bag: Path):
    (tmp_path / "file").write_text("")
    (tmp_path / "link").symlink_to(bag)
    for name in ("file", "link"):
        with pytest.raises(InputError, match="allowed: the folder of a bag"):
            remove_bag(tmp_path / name)
    assert len(list(bag.iterdir())) == 3
