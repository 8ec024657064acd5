"""One place opens the files that a person names: regular ones only, up to a stated size, however they are marked."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from soup_msgs_py.errors import LONGEST, InputError
from soup_msgs_py.policies import load_policies
from soup_msgs_py.reading.files import folder_of, read_bytes, read_text, whole_path
from soup_msgs_py.scenario import load_scenario
from soup_msgs_py.warehouse.cell_world import read_world
from soup_sim.scenario_loader import load_warehouse

DEMO = Path(__file__).parents[2] / "config/scenarios/demo.yaml"


def set_to(value: str) -> Callable[[Path], object]:
    return lambda path: load_warehouse(DEMO, [value.format(path=path)])


# whatever reads a file that a person names, by the file's ending
READERS: dict[str, tuple[str, Callable[[Path], object]]] = {
    "a scenario": (".yaml", load_scenario),
    "policies": (".yaml", load_policies),
    "a world of cells": (".txt", read_world),
    "a world as a scenario": (".txt", load_scenario),
    "words": (".txt", set_to("words={path}")),
    "orders": (".csv", set_to("orders={{kind: file, path: {path}}}")),
    "bundles": (".csv", set_to("bundles={{kind: file, path: {path}}}")),
    "a map": (".txt", set_to("layout={{kind: map, path: {path}}}")),
    "a station's policy": (".py", set_to("word_station.policy={path}:Own")),
}


def line_of(read: Callable[[Path], object], path: Path) -> str:
    with pytest.raises(InputError) as caught:
        read(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize("kind", READERS)
def test_no_path_makes_a_reader_hang_or_fail(kind: str, tmp_path: Path):
    ending, read = READERS[kind]
    loop, pipe, device = (tmp_path / f"{name}{ending}" for name in ("loop", "pipe", "device"))
    loop.symlink_to(loop)
    os.mkfifo(pipe)
    device.symlink_to("/dev/zero")
    (tmp_path / f"folder{ending}").mkdir()
    assert "Too many levels of symbolic links" in line_of(read, loop)
    assert "a device, pipe or socket" in line_of(read, pipe)
    assert "a device, pipe or socket" in line_of(read, device)
    assert "directory" in line_of(read, tmp_path / f"folder{ending}")
    assert "directory" in line_of(read, pipe / f"below{ending}")
    assert "File name too long" in line_of(read, tmp_path / ("x" * 5000 + ending))


@pytest.mark.parametrize(
    "override", ['words="a\\0b"', 'orders={kind: file, path: "a\\0b"}', 'layout={kind: map, path: "\\0"}']
)
def test_a_zero_byte_in_a_path_is_told(override: str):
    with pytest.raises(InputError, match="a zero byte in its name"):
        load_warehouse(DEMO, [override])


def test_what_a_person_wrote_is_never_echoed_whole():
    for override in ("x" * 5000 + "=1", "words=" + "y" * 5000, "name=" + "z" * 5000):
        with pytest.raises(InputError) as caught:
            load_warehouse(DEMO, [override])
        assert max(len(part) for part in (caught.value.source, caught.value.key, caught.value.found)) <= LONGEST


def test_control_characters_are_told_as_what_they_are():
    assert str(InputError("a\x1b[31m", "k\n", "\0", "b")) == "a\\x1b[31m: k : found \\x00; allowed: b"


def test_a_file_is_read_up_to_its_stated_size(tmp_path: Path):
    (tmp_path / "file").write_bytes(b"12345")
    assert read_bytes(tmp_path / "file", 5) == b"12345"
    with pytest.raises(InputError, match="found more than 4 bytes; allowed: a list, at most 4 bytes"):
        read_text(tmp_path / "file", 4, "a list")


def test_a_byte_order_mark_changes_nothing(tmp_path: Path):
    world = tmp_path / "world.txt"
    world.write_text("@*|_\n", "utf-8-sig")
    assert (read_world(world).robots, load_scenario(world).bots) == ((0,), 1)
    (tmp_path / "map.txt").write_text("L.S.W\n", "utf-8-sig")
    layout = f"layout={{kind: map, path: {tmp_path / 'map.txt'}, pitch_m: 3.0}}"
    few = ["bots=1", "buckets=1", "word_stations=1", "letter_stations=1", "layout.x=1"]
    with pytest.raises(InputError, match=r"layout\.x"):  # the last thing that is wrong: the map itself is read
        load_warehouse(DEMO, [layout, *few])
    (tmp_path / "orders.csv").write_text("5,SOUP\n", "utf-8-sig")
    (tmp_path / "demo.yaml").write_text(DEMO.read_text("utf-8"), "utf-8-sig")
    changes = [
        f"orders={{kind: file, path: {tmp_path / 'orders.csv'}}}",
        f"words={DEMO.parents[1] / 'words/jargon.txt'}",
    ]
    assert load_warehouse(tmp_path / "demo.yaml", changes).timed_words[0].letters == "SOUP"


def test_a_path_that_leads_nowhere_is_still_a_path(tmp_path: Path):
    (tmp_path / "loop").symlink_to("loop")
    assert whole_path("loop", tmp_path) == str(tmp_path / "loop")
    assert whole_path("a\0b", tmp_path) == str(tmp_path / "a\0b")
    assert whole_path("../b", tmp_path / "a") == str(tmp_path / "b")
    (tmp_path / "a").mkdir()
    (tmp_path / "link.py").symlink_to(tmp_path / "a" / "real")
    assert whole_path("a/../link.py", tmp_path) == str(tmp_path / "link.py")
    assert folder_of(tmp_path / "link.py") == tmp_path / "a"
