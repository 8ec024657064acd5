"""A bag is not believed: what is damaged is found, left out and told, and what lies about its size is refused."""

from __future__ import annotations

import json
import os
import random
import shutil
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any

import lz4.frame
import pytest
import yaml
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Chunk, DataEnd, Footer, Header
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer
from recorded_run import BEGIN, DEFINITIONS, QOS, Said, recorded, write_bag

from soup_lab.bags import replay_node as bag_replay_node
from soup_lab.bags import summary_program as bag_summary_cli
from soup_lab.bags.mcap import MAGIC, MOST_CHUNK, McapFile
from soup_lab.bags.reader import Bag, open_bag
from soup_lab.bags.writer import METADATA, BagWriter, Topic
from soup_lab.headless import program as headless_cli
from soup_msgs_py import topics
from soup_msgs_py.errors import InputError

MIB = 1 << 20


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The bag of a whole run."""
    found = tmp_path_factory.mktemp("run") / "bag"
    write_bag(found, recorded()).close()
    return found


@pytest.fixture
def folder(whole: Path, tmp_path: Path) -> Path:
    """A copy of it, to be damaged."""
    return Path(shutil.copytree(whole, tmp_path / "bag"))


def file_of(folder: Path) -> Path:
    (file,) = folder.glob("*.mcap")
    return file


def middle_of_chunk(file: Path, number: int) -> int:
    """A place in the middle of a chunk."""
    found = McapFile(file)
    piece = found.pieces[number]
    found.close()
    return (piece.start + piece.end) // 2


def turn(file: Path, at: int, bit: int = 0) -> None:
    """Turn one bit of a file."""
    content = bytearray(file.read_bytes())
    content[at] ^= 1 << bit
    file.write_bytes(content)


def said_in(bag: Bag) -> list[Said]:
    return list(bag.messages())


def summary_of(folder: Path, tmp_path: Path) -> dict[str, Any]:
    file = tmp_path / "summary.json"
    assert bag_summary_cli.main([str(folder), "--summary", str(file)]) == 0
    return json.loads(file.read_text())


# ---- checksums ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("compress", [True, False])
def test_all_that_is_written_has_a_checksum(tmp_path: Path, compress: bool):
    writer = BagWriter.create(tmp_path / "bag", compress=compress)
    number = writer.add(Topic("/clock", "rosgraph_msgs/msg/Clock", *DEFINITIONS.of("rosgraph_msgs/msg/Clock"), QOS))
    for k in range(100):
        writer.write(number, BEGIN + k, bytes(12))
        if k % 10 == 9:
            writer.flush()
    writer.close()
    with file_of(tmp_path / "bag").open("rb") as stream:
        found = list(StreamReader(stream, emit_chunks=True, validate_crcs=True).records)
    chunks = [record for record in found if isinstance(record, Chunk)]
    assert len(chunks) == 10
    assert all(chunk.uncompressed_crc for chunk in chunks)
    assert all(record.data_section_crc for record in found if isinstance(record, DataEnd))
    assert all(record.summary_crc for record in found if isinstance(record, Footer))


def test_whatever_bit_is_wrong_what_is_read_is_what_was_recorded_and_what_is_missing_is_told(folder: Path):
    draw = random.Random(18)
    file = file_of(folder)
    content = file.read_bytes()
    with open_bag(folder) as bag:
        truth = said_in(bag)
        assert bag.damage == []
    for _ in range(150):
        damaged = bytearray(content)
        at = draw.randrange(len(damaged))
        damaged[at] ^= 1 << draw.randrange(8)
        if draw.random() < 0.2:
            damaged[at : at + 4000] = draw.randbytes(len(damaged[at : at + 4000]))
        file.write_bytes(damaged)
        with open_bag(folder) as bag:
            read = said_in(bag)
            assert bag.damage
        assert len(read) == sum(bag.counts.values())
        left = iter(truth)
        assert all(message in left for message in read)  # those that were recorded, in their order
        if len(read) < len(truth):
            assert f"{len(truth) - len(read):,} of {len(truth):,} messages are missing" in bag.damage[0]


def test_a_run_with_a_damaged_chunk_is_summed_up_without_it_and_not_judged(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    before = summary_of(folder, tmp_path)
    turn(file_of(folder), middle_of_chunk(file_of(folder), 4))
    capsys.readouterr()
    after = summary_of(folder, tmp_path)
    told = capsys.readouterr()
    assert after["violations"] is None
    assert before["violations"] == 0
    assert after["letters_in_words"] <= before["letters_in_words"]
    assert "bag_0.mcap: 1 damaged chunk is left out, " in told.err
    assert " messages are missing" in told.err
    assert "events are missing" in " ".join(told.out.split())


def test_of_a_bag_that_was_cut_off_what_lies_behind_a_damaged_chunk_is_kept(
    folder: Path, capsys: pytest.CaptureFixture[str]
):
    file = file_of(folder)
    turn(file, middle_of_chunk(file, 2))
    (folder / METADATA).unlink()
    file.write_bytes(file.read_bytes()[: middle_of_chunk(file, -1)])
    as_it_was = file.read_bytes()
    with open_bag(folder) as bag:
        read = said_in(bag)
    truth = recorded()
    assert read == sorted([*truth[:200], *truth[300 : len(read) + 100]], key=lambda message: message[1])
    assert len(read) > 600
    assert (folder / "bag_0.mcap.damaged").read_bytes() == as_it_was
    assert "; what was damaged is kept as bag_0.mcap.damaged" in capsys.readouterr().err


def test_a_file_of_which_nothing_can_be_read_stays_as_it_is(folder: Path):
    (folder / METADATA).unlink()
    file_of(folder).write_bytes(content := random.Random(18).randbytes(20_000))
    with pytest.raises(InputError, match="no readable message"):
        open_bag(folder)
    assert [file.read_bytes() for file in folder.iterdir()] == [content]


def test_that_a_bag_has_no_checksums_is_told(folder: Path):
    bare(folder, compress=True, crcs=False)
    with open_bag(folder) as bag:
        assert bag.damage == [
            "bag_0.mcap has no checksums: whether its messages are as they were recorded, nobody can tell"
        ]


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("chunks", [True, False])
def test_bags_of_others_are_read(folder: Path, compression: CompressionType, chunks: bool):
    bare(folder, compress=True, crcs=chunks, compression=compression, chunks=chunks)
    with open_bag(folder) as bag:
        assert [cdr for _, _, cdr in bag.messages(["/clock"])] == [bytes([k] * 12) for k in range(50)]
        assert bag.qos["/clock"] is None
        assert bag.damage == [] or not chunks


def bare(
    folder: Path,
    *,
    compress: bool,
    crcs: bool,
    compression: CompressionType = CompressionType.ZSTD,
    chunks: bool = True,
) -> None:
    """Have the file of a bag hold fifty messages, as somebody else would write them."""
    with file_of(folder).open("wb") as stream:
        writer = Writer(stream, compression=compression, enable_crcs=crcs, use_chunking=chunks)
        writer.start("ros2")
        schema = writer.register_schema("rosgraph_msgs/msg/Clock", "ros2msg", b"builtin_interfaces/Time clock")
        channel = writer.register_channel("/clock", "cdr", schema)
        for k in range(50):
            writer.add_message(channel, BEGIN + k, bytes([k] * 12), BEGIN + k)
        writer.finish()
    tell(folder, message_count=50, files=None)


def tell(folder: Path, **values: Any) -> None:
    """Write other metadata."""
    content = yaml.safe_load((folder / METADATA).read_text())
    content["rosbag2_bagfile_information"] |= values
    (folder / METADATA).write_text(yaml.safe_dump(content))


# ---- what lies about its size ---------------------------------------------------------------------------------

BOMB = bytes(64 * MIB)


def unsized(content: bytes) -> bytes:
    """Compressed without a word of how much it is."""
    return zstandard.ZstdCompressor(write_content_size=False).compress(content)


@pytest.mark.parametrize(
    ("compression", "pack", "stated"),
    [
        ("zstd", zstandard.compress, 1000),
        ("zstd", unsized, 1000),
        ("zstd", unsized, 0),
        ("lz4", lz4.frame.compress, 1000),
        ("zstd", zstandard.compress, MOST_CHUNK + 1),
        ("zstd", unsized, 2**63),
        ("", lambda _: b"", 2**40),
    ],
)
def test_a_chunk_that_lies_about_its_size_is_refused_by_what_it_states(
    folder: Path, compression: str, pack: Callable[[bytes], bytes], stated: int, capsys: pytest.CaptureFixture[str]
):
    packed = pack(BOMB)
    build = RecordBuilder()
    Header("ros2", "").write(build)
    Chunk(compression, packed, BEGIN, BEGIN, 0, stated).write(build)
    DataEnd(0).write(build)
    Footer(0, 0, 0).write(build)
    file_of(folder).write_bytes(MAGIC + build.end() + MAGIC)
    tracemalloc.start()
    try:
        assert bag_summary_cli.main([str(folder)]) == 2
        assert tracemalloc.get_traced_memory()[1] < 8 * MIB
    finally:
        tracemalloc.stop()
    err = capsys.readouterr().err
    assert "found a damaged bag, no message of which can be read" in err
    assert err.count("\n") == 1


@pytest.mark.parametrize("length", [2**63, 2**31, 10_000_000])
def test_a_record_that_is_longer_than_its_file_ends_nothing(folder: Path, length: int):
    file = file_of(folder)
    content = bytearray(file.read_bytes())
    at = content.index(bytes([Opcode.CHUNK]), len(MAGIC) + 20)
    content[at + 1 : at + 9] = length.to_bytes(8, "little")
    file.write_bytes(content)
    with open_bag(folder) as bag:
        assert sum(bag.counts.values()) == len(recorded()) - 100
        assert "100 of" in bag.damage[0]


# ---- metadata -------------------------------------------------------------------------------------------------


def mutated(text: str, draw: random.Random) -> bytes:
    """Metadata with something wrong in them."""
    lines = text.splitlines()
    at = draw.randrange(min(20, len(lines))) if draw.random() < 0.5 else draw.randrange(len(lines))
    way = draw.randrange(5)
    if way == 0:
        content = bytearray(text.encode())
        content[draw.randrange(len(content))] ^= 1 << draw.randrange(8)
        return bytes(content)
    if way == 1:
        del lines[at]
    elif way == 2:
        wrong = ["-1", "1e400", "null", "[]", "{}", "'x'", "9" * 30, "true", ".nan", "'-1'", "'{\"a\": -1}'"]
        lines[at] = lines[at].split(":")[0] + ": " + draw.choice(wrong)
    elif way == 3:
        lines = lines[:at]
    else:
        lines[at] += draw.choice(["\0", "\t", "&a", "*a", "{", "!!python/object:x", "\ud800", "é"])
    return "\n".join(lines).encode("utf-8", "surrogatepass")


def test_whatever_is_wrong_in_the_metadata_is_told_in_one_line_or_does_no_harm(folder: Path):
    draw = random.Random(18)
    text = (folder / METADATA).read_text()
    outcomes = set()
    for _ in range(40):
        (folder / METADATA).write_bytes(mutated(text, draw))
        try:
            with open_bag(folder) as bag:
                assert bag.dropped == {}
                assert said_in(bag) == sorted(recorded(), key=lambda message: message[1])
            outcomes.add("read")
        except InputError as error:
            assert str(folder) in str(error)
            assert "\n" not in str(error)
            outcomes.add("refused")
    assert outcomes == {"read", "refused"}


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ({"storage_identifier": "sqlite3"}, "metadata.yaml: storage_identifier: found 'sqlite3'; allowed: mcap"),
        ({"compression_mode": "FILE"}, "metadata.yaml: compression_mode: found 'FILE'; allowed: none"),
        ({"version": 10}, "metadata.yaml: version: found 10; allowed: less than or equal to 9"),
        ({"relative_file_paths": ["other.mcap"]}, "metadata.yaml: relative_file_paths: found other.mcap; allowed:"),
        ({"custom_data": {"dropped": "many"}}, "metadata.yaml: custom_data.dropped: found 'many'; allowed:"),
    ],
)
def test_wrong_metadata_are_told_with_key_and_what_is_allowed(
    folder: Path, values: dict[str, Any], told: str, capsys: pytest.CaptureFixture[str]
):
    tell(folder, **values)
    assert bag_summary_cli.main([str(folder)]) == 2
    err = capsys.readouterr().err
    assert told in err
    assert err.count("\n") == 1


def test_files_that_are_missing_and_files_that_nobody_names_are_told(folder: Path):
    shutil.copy(file_of(folder), folder / "other.mcap")
    name = next(path.name for path in folder.glob("bag*.mcap"))
    tell(folder, relative_file_paths=[name, "bag_1.mcap"], files=[{"path": "bag_1.mcap", "message_count": 5000}])
    with open_bag(folder) as bag:
        assert bag.damage == [
            "bag_1.mcap is missing, and its 5,000 messages",
            "other.mcap is left out, metadata.yaml does not name it",
        ]


def test_metadata_that_count_otherwise_than_the_files_are_not_believed(folder: Path):
    tell(folder, message_count=7)
    with open_bag(folder) as bag:
        assert bag.damage == [f"metadata.yaml tells of 7 messages, there are {len(recorded()):,}"]


# ---- what else is not what it seems ---------------------------------------------------------------------------


def test_what_a_repair_that_was_killed_left_behind_is_removed(folder: Path):
    (folder / METADATA).unlink()
    (folder / ".repair.4711").mkdir()
    (folder / ".repair.4711" / "half.mcap").write_bytes(b"half")
    (folder / f".{METADATA}.4711").write_text("half")
    with open_bag(folder) as bag:
        assert sum(bag.counts.values()) == len(recorded())
    assert sorted(path.name for path in folder.iterdir()) == ["bag_0.mcap", METADATA]


@pytest.mark.parametrize("has_metadata", [True, False])
def test_what_is_no_ordinary_file_is_not_opened(folder: Path, has_metadata: bool):
    file_of(folder).unlink()
    os.mkfifo(folder / "bag_0.mcap")
    if not has_metadata:
        (folder / METADATA).unlink()
    with pytest.raises(InputError, match="; allowed: "):
        open_bag(folder)


@pytest.mark.parametrize(("name", "is_needed"), [(topics.EVENTS, True), (topics.STATISTICS, False)])
def test_messages_of_another_version_are_not_read_as_if_they_were_of_this_one(
    tmp_path: Path, name: str, is_needed: bool, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    of, said = type(DEFINITIONS).of, recorded()

    def changed(self: Any, kind: str) -> tuple[str, str]:
        definition, hashed = of(self, kind)
        other = kind == {topics.EVENTS: "soup_msgs/msg/Event", topics.STATISTICS: "soup_msgs/msg/Statistics"}[name]
        return ("int32 more\n" + definition, "RIHS01_" + "0" * 64) if other else (definition, hashed)

    monkeypatch.setattr(type(DEFINITIONS), "of", changed)
    write_bag(tmp_path / "bag", said).close()
    monkeypatch.undo()
    assert bag_replay_node.main([str(tmp_path / "bag")]) == 2
    assert f"{name}: found soup_msgs/msg/" in capsys.readouterr().err
    status = bag_summary_cli.main([str(tmp_path / "bag")])
    told = capsys.readouterr()
    if is_needed:
        assert status == 2
        assert f"{name}: found soup_msgs/msg/Event of another version than what is installed" in told.err
    else:
        assert status == 0
        assert f"{name} is of another version and left out" in " ".join(told.out.split())


@pytest.mark.parametrize("name", [topics.SCENARIO, topics.STATE, topics.SNAPSHOT])
def test_what_if_needs_what_a_world_says_and_tells_what_is_not_there(
    tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]
):
    for k, keep in enumerate((lambda message: message[0] != name, lambda _: True)):
        said = [m if m[0] != name or not k else (name, m[1], m[2][:40]) for m in recorded() if keep(m)]
        write_bag(tmp_path / f"bag{k}", said).close()
        assert headless_cli.main(["--from-bag", str(tmp_path / f"bag{k}"), "--at", "50"]) == 2
        err = capsys.readouterr().err
        assert str(tmp_path) in err
        assert err.count("\n") == 1
