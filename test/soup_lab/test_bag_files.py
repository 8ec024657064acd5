"""Bags as files: what is written is read, by others too; what is cut off is repaired as far as it goes."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rclpy.serialization import serialize_message
from rosbags.highlevel import AnyReader
from rosgraph_msgs.msg import Clock
from soup_msgs import msg

from soup_lab.bags import record_node as bag_record_node
from soup_lab.bags import replay_node as bag_replay_node
from soup_lab.bags import summary_program as bag_summary_cli
from soup_lab.bags.gaps import Gaps
from soup_lab.bags.interfaces import Definitions, UnknownType
from soup_lab.bags.reader import open_bag
from soup_lab.bags.repair import is_cut_off
from soup_lab.bags.writer import METADATA, BagWriter, Topic
from soup_lab.headless import program as headless_cli
from soup_live.qos import LATCHED
from soup_msgs_py import topics
from soup_msgs_py.errors import InputError
from soup_msgs_py.wire import to_stamp

SECOND = 1_000_000_000
BEGIN = 1_790_000_000 * SECOND
QOS = bag_record_node.offered(LATCHED)
DEFINITIONS = Definitions()


def topic(name: str, kind: str) -> Topic:
    return Topic(name, kind, *DEFINITIONS.of(kind), QOS)


def clock(seconds: float) -> bytes:
    return serialize_message(Clock(clock=to_stamp(seconds)))


def write(folder: Path, seconds: int = 20, *, files: int = 1, compress: bool = True) -> BagWriter:
    """A bag with ten clocks a second, at twice real time, and an event a second; it is not closed."""
    writer = BagWriter.create(folder, compress=compress)
    ticks, events = writer.add(topic(topics.CLOCK, "rosgraph_msgs/msg/Clock")), None
    for k in range(10 * seconds):
        at = BEGIN + k * SECOND // 10
        writer.write(ticks, at, clock(0.2 * k))
        if k % 10 == 0:
            if events is None:
                events = writer.add(topic(topics.EVENTS, "soup_msgs/msg/Event"))
            event = msg.Event(stamp=to_stamp(0.2 * k), sequence=k // 10, type="grabbed", bots=[1, 2], text="soup")
            writer.write(events, at + 1, serialize_message(event))
            writer.flush()
        if files > 1 and k % (10 * seconds // files) == 0 and k:
            writer.split()
    return writer


@pytest.mark.parametrize("compress", [True, False])
@pytest.mark.parametrize("files", [1, 3])
def test_what_is_written_is_read(tmp_path: Path, files: int, compress: bool):
    write(tmp_path / "bag", files=files, compress=compress).close()
    with open_bag(tmp_path / "bag") as bag:
        assert bag.counts == {topics.CLOCK: 200, topics.EVENTS: 20}
        assert (bag.first, bag.last) == (BEGIN, BEGIN + 199 * SECOND // 10)
        read = list(bag.messages())
        assert [time for _, time, _ in read] == sorted(time for _, time, _ in read)
        assert [cdr for name, _, cdr in read if name == topics.CLOCK] == [clock(0.2 * k) for k in range(200)]
        assert bag.qos[topics.CLOCK] == QOS


@pytest.mark.parametrize("files", [1, 3])
def test_other_programs_read_it(tmp_path: Path, files: int):
    write(tmp_path / "bag", files=files).close()
    with AnyReader([tmp_path / "bag"]) as reader:
        found = [reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages()]
        assert len(found) == 220
        assert all(c.digest.startswith("RIHS01_") for c in reader.connections)
    decoded = []
    for file in (tmp_path / "bag").glob("*.mcap"):
        with file.open("rb") as stream:
            decoded += list(make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages())
    assert len(decoded) == 220
    assert {message[3].text for message in decoded if message[1].topic == topics.EVENTS} == {"soup"}


def test_simulated_time_is_found(tmp_path: Path):
    write(tmp_path / "bag").close()
    with open_bag(tmp_path / "bag") as bag:
        assert bag.instant(10.1) == pytest.approx(BEGIN + 5.05 * SECOND)
        assert bag.instant(-5.0) == bag.first
        assert bag.instant(1e6) == bag.last
        assert bag.simulated(BEGIN + 5 * SECOND) == pytest.approx(10.0)


def test_the_newest_message_of_a_topic_is_found_however_long_ago(tmp_path: Path):
    writer = BagWriter.create(tmp_path / "bag")
    rare, often = (writer.add(topic(name, "rosgraph_msgs/msg/Clock")) for name in ("/rare", "/often"))
    writer.write(rare, BEGIN, clock(1.0))
    for k in range(100):
        writer.write(often, BEGIN + k * SECOND, clock(k))
    writer.close()
    with open_bag(tmp_path / "bag") as bag:
        found = bag.newest(["/rare", "/often", "/never"], BEGIN + 50 * SECOND)
        assert found == {
            "/rare": ("/rare", BEGIN, clock(1.0)),
            "/often": ("/often", BEGIN + 50 * SECOND, clock(50)),
        }


# ---- bags that lack their end ---------------------------------------------------------------------------------


@settings(max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(share=st.floats(0.05, 1.0), files=st.sampled_from([1, 3]), compress=st.booleans())
def test_wherever_a_bag_was_cut_off_it_is_whole_up_to_there(
    tmp_path_factory: pytest.TempPathFactory, share: float, files: int, compress: bool
):
    folder = tmp_path_factory.mktemp("cut") / "bag"
    writer = write(folder, files=files, compress=compress)
    writer.flush()
    writer.abandon()
    last = folder / writer.files[-1].path
    size = last.stat().st_size
    os.truncate(last, int(size * share))
    if not (whole := [f for f in folder.glob("*.mcap") if f != last]) and size * share < 3000:
        return  # a file without its first chunk holds nothing
    assert is_cut_off(folder)
    with open_bag(folder) as bag:
        read = list(bag.messages())
        kept = [cdr for name, _, cdr in read if name == topics.CLOCK]
        assert kept == [clock(0.2 * k) for k in range(len(kept))]
        assert sum(bag.counts.values()) == len(read)
        assert bag.last == max(time for _, time, _ in read)
    described = yaml.safe_load((folder / METADATA).read_text())["rosbag2_bagfile_information"]
    for entry in described["topics_with_message_count"]:
        assert entry["topic_metadata"]["type_description_hash"].startswith("RIHS01_")
    assert not whole or len(kept) >= 60
    assert not [f for f in folder.iterdir() if f.name.startswith(".")]


def test_a_bag_that_was_killed_holds_all_that_was_flushed(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    folder = tmp_path / "bag"
    writer = write(folder)
    writer.flush()
    writer.abandon()
    with open_bag(folder) as bag:
        assert bag.counts == {topics.CLOCK: 200, topics.EVENTS: 20}
    assert "repaired: 220 messages; nothing was unreadable" in capsys.readouterr().err
    with open_bag(folder):
        assert capsys.readouterr().err == ""


def test_a_disk_that_is_full_leaves_what_was_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    folder = tmp_path / "bag"
    writer = write(folder)

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    storage: Any = writer._storage
    monkeypatch.setattr(storage.stream, "write", full)
    writer.write(0, BEGIN + 30 * SECOND, clock(60.0))
    with pytest.raises(OSError, match="No space"):
        writer.close()
    writer.abandon()
    with open_bag(folder) as bag:
        assert bag.counts[topics.EVENTS] == 20


# ---- what is no bag -------------------------------------------------------------------------------------------


@pytest.fixture
def wrong(tmp_path: Path) -> dict[str, Path]:
    """Folders and files that are no bag of a warehouse."""
    found = {name: tmp_path / name for name in ("missing", "file", "empty", "silent", "foreign", "damaged", "broken")}
    found["file"].write_text("no bag")
    found["empty"].mkdir()
    BagWriter.create(found["silent"]).close()
    foreign = BagWriter.create(found["foreign"])
    text = "string data\n"
    foreign.add(Topic("/chatter", "elsewhere_msgs/msg/Text", text, "RIHS01_" + "0" * 64, QOS))
    foreign.write(0, BEGIN, b"\x00\x01\x00\x00\x02\x00\x00\x00a\x00")
    foreign.close()
    write(found["damaged"]).close()
    (file,) = found["damaged"].glob("*.mcap")
    content = bytearray(file.read_bytes())
    content[len(content) // 3 : len(content) // 2] = os.urandom(len(content) // 2 - len(content) // 3)
    file.write_bytes(content)
    write(found["broken"]).close()
    (found["broken"] / METADATA).write_text("{")
    return found


PROGRAMS = {
    "replay": lambda path: bag_replay_node.main([str(path)]),
    "summary": lambda path: bag_summary_cli.main([str(path)]),
    "what if": lambda path: headless_cli.main(["--from-bag", str(path), "--at", "5"]),
}


@pytest.mark.parametrize("program", PROGRAMS)
@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("missing", "found no such folder; allowed: a rosbag2 bag"),
        ("file", "found a file; allowed: a rosbag2 bag"),
        ("empty", "found no metadata.yaml; allowed: a rosbag2 bag"),
        ("silent", "found a bag without messages; allowed:"),
        ("broken", "metadata.yaml: line 2: found no node content"),
        ("foreign", "; allowed: "),
    ],
)
def test_what_is_no_bag_is_told_in_one_line(
    wrong: dict[str, Path], program: str, name: str, told: str, capsys: pytest.CaptureFixture[str]
):
    assert PROGRAMS[program](wrong[name]) == 2
    err = capsys.readouterr().err
    assert told in err
    assert err.count("\n") == 1
    assert str(wrong[name]) in err


@pytest.mark.parametrize("program", PROGRAMS)
def test_a_name_that_no_folder_can_have_is_told_in_one_line(program: str, capsys: pytest.CaptureFixture[str]):
    assert PROGRAMS[program](Path("x" * 5000)) == 2
    err = capsys.readouterr().err
    assert "x: found File name too long; allowed: a rosbag2 bag" in err
    assert err.count("\n") == 1
    assert len(err) < 500


def test_of_a_damaged_bag_what_is_missing_is_told_before_why_it_is_no_use(
    wrong: dict[str, Path], capsys: pytest.CaptureFixture[str]
):
    assert bag_summary_cli.main([str(wrong["damaged"])]) == 2
    damage, error = capsys.readouterr().err.splitlines()
    assert "damaged_0.mcap: " in damage
    assert damage.endswith("messages are missing")
    assert "found a bag without /world/scenario; allowed: a bag of a warehouse" in error


def test_a_missing_type_is_told_with_its_topic(wrong: dict[str, Path], capsys: pytest.CaptureFixture[str]):
    assert bag_replay_node.main([str(wrong["foreign"])]) == 2
    assert "/chatter: found elsewhere_msgs/msg/Text, which is not installed; allowed:" in capsys.readouterr().err
    with pytest.raises(UnknownType, match="not installed"):
        DEFINITIONS.of("elsewhere_msgs/msg/Text")


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["."], "File exists; allowed: a folder that is not there yet"),
        (["no/such/bag"], "found No such file or directory; allowed: a new folder in one that exists"),
        (["new", "--topics", "("], "--topics: found '('"),
        (["new", "--leave-free-mib", "1e12"], "MiB of free disk; allowed: at least"),
    ],
)
def test_a_bag_that_cannot_be_made_is_told_in_one_line(
    tmp_path: Path, arguments: list[str], told: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    try:
        status = bag_record_node.main(arguments)
    except SystemExit as error:
        status = error.code
    err = capsys.readouterr().err
    assert status == 2
    assert told in err
    assert err.count("\n") == 1


def test_a_bag_that_is_being_written_is_left_alone(tmp_path: Path):
    writer = write(tmp_path / "bag")
    with pytest.raises(InputError, match="a bag that is being written"):
        open_bag(tmp_path / "bag")
    writer.close()
    open_bag(tmp_path / "bag")


# ---- gaps -----------------------------------------------------------------------------------------------------


@st.composite
def deliveries(draw: st.DrawFn) -> tuple[list[list[int]], list[int]]:
    """The numbers of several publishers, each in order, mixed at random."""
    chains = draw(st.lists(st.tuples(st.integers(1, 5), st.integers(1, 20)), min_size=1, max_size=4))
    numbers = [list(range(first, first + count)) for first, count in chains]
    order = draw(st.permutations([k for k, chain in enumerate(numbers) for _ in chain]))
    waiting: list[Iterator[int]] = [iter(chain) for chain in numbers]
    return numbers, [next(waiting[k]) for k in order]


@given(deliveries())
def test_complete_deliveries_have_no_gap(delivery: tuple[list[list[int]], list[int]]):
    numbers, came = delivery
    gaps = Gaps()
    for number in came:
        gaps.take(number)
    assert gaps.count(len(numbers)) == 0


@given(st.integers(2, 50), st.data())
def test_a_message_that_one_publisher_lost_is_a_gap(count: int, data: st.DataObject):
    lost = data.draw(st.integers(2, count))
    gaps = Gaps()
    for number in range(1, count + 2):
        if number != lost:
            gaps.take(number)
    assert gaps.count(1) == 1
