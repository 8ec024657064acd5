"""A live warehouse is recorded, replayed and measured again; recorders end whole, or leave what can be repaired."""

from __future__ import annotations

import json
import signal
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import deserialize_message
from soup_msgs import msg, srv
from std_msgs.msg import Int64
from std_srvs.srv import SetBool

from soup_lab.bags.course import read_course
from soup_lab.bags.reader import Bag, open_bag
from soup_lab.bags.record_node import NODE, OF_ALL
from soup_lab.bags.summary import differences, summarize
from soup_lab.headless import program as headless_cli
from soup_msgs_py import topics

from .conftest import Parts
from .person import Person

pytestmark = [pytest.mark.live, pytest.mark.timeout(600)]

MOST_LOST_S = 2.0
PERIOD_S = 0.02


def figures(folder: Path) -> dict[str, Any]:
    with open_bag(folder) as bag:
        assert json.loads(bag.notes["dropped"]) == {}
        course = read_course(bag)
        assert course.missing == 0
        return summarize(course)


def said_on(name: str, bag: Bag) -> list[bytes]:
    # what a process says to itself comes without the bytes that fill up its last word
    return [cdr.ljust((len(cdr) + 3) // 4 * 4, b"\0") for _, _, cdr in bag.messages([name])]


def counted(ours: dict[str, Any], theirs: dict[str, Any]) -> list[tuple[str, Any, Any]]:
    return [(key, a, b) for key, a, b, is_counted in differences(ours, theirs) if is_counted]


def test_a_recorded_run_is_measured_replayed_and_run_on(parts: Parts, tmp_path: Path):
    folder, summary = tmp_path / "bag", tmp_path / "live.json"
    process = parts.start(
        "run_warehouse.py", "--no-dashboard", "--speed", "10", "--duration", "150", "--warmup", "30",
        "--record", str(folder), "--summary", str(summary),
    )  # fmt: skip
    _, err = process.communicate(timeout=400)
    assert process.returncode == 0, err
    live = json.loads(summary.read_text())
    assert live["words_completed"] > 0
    ours = figures(folder)
    assert counted(ours, live) == []
    assert ours["distance_total_m"] == pytest.approx(live["distance_total_m"], rel=0.02)

    decoded = 0
    (file,) = folder.glob("*.mcap")
    with file.open("rb") as stream:
        for schema, _, _, _ in make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
            decoded += schema is not None and bool(schema.data)
    with open_bag(folder) as bag:
        assert decoded == sum(bag.counts.values())
        seeking_restores_what_was_latched(parts, bag)

    again = tmp_path / "again"
    recorder = parts.start("record_bag.py", str(again))
    with Person() as person:
        person.wait(lambda: NODE in person.node.get_node_names(), "the recorder")
    replay = parts.start("replay_bag.py", str(folder), "--speed", "5")
    _, err = replay.communicate(timeout=200)
    assert replay.returncode == 0, err
    parts.interrupt(recorder)
    assert recorder.returncode == 0
    assert differences(figures(again), ours) == []
    with open_bag(folder) as recorded, open_bag(again) as replayed:
        for name in recorded.counts:
            once, twice = said_on(name, recorded), said_on(name, replayed)
            if name in OF_ALL:  # there the recorder and the replay speak, too
                known = set(once)
                twice = [cdr for cdr in twice if cdr in known]
            assert twice == once, name

    what_if = tmp_path / "what_if.json"
    arguments = ["--from-bag", str(folder), "--at", "75", "--word-policy", "minimal", "--summary", str(what_if)]
    assert headless_cli.main(arguments) == 0
    assert json.loads(what_if.read_text())["violations"] == 0


def seeking_restores_what_was_latched(parts: Parts, bag: Bag) -> None:
    """Wherever a replay jumps, what is latched is what it was in the recording."""
    replay = parts.start("replay_bag.py", str(bag.folder), "--paused")
    chosen = {topics.SNAPSHOT: msg.Snapshot, topics.SCENARIO: msg.Scenario, "/bot_3/status": msg.BotStatus}
    with Person() as person:
        for name, kind in chosen.items():
            person.listen(kind, name, latched=True)
        for time in (100.0, 20.0, 140.0, 60.0):
            answer = person.call(srv.Seek, topics.SEEK, time=time)
            assert answer.success, answer.message
            expected = bag.newest(chosen, bag.instant(time))
            told = {name: deserialize_message(expected[name][2], kind) for name, kind in chosen.items()}
            person.wait(lambda told=told: person.heard == told, f"the state at {time} s")
        assert not person.call(srv.Seek, topics.SEEK, time=1e6).success
        assert person.call(srv.Step, topics.STEP, seconds=5.0).success
        assert person.call(SetBool, topics.PAUSE, data=False).success
    parts.interrupt(replay)
    assert replay.returncode == 0


def test_a_recorder_keeps_every_message_and_what_it_had_when_it_was_killed(parts: Parts, tmp_path: Path):
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    recorders = [parts.start("record_bag.py", str(folder)) for folder in (whole, killed)]
    sent = {"/few": 0, "/many": 0}
    with Person() as person:
        # latched: that a publisher knows of a recorder does not say that the recorder knows of it, too
        deep = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        # several publishers of one topic, and one of the other
        publishers = [(name, person.node.create_publisher(Int64, name, deep)) for name in ("/few", "/many", "/many")]
        person.wait(lambda: all(p.get_subscription_count() == 2 for _, p in publishers), "the recorders")

        def publish() -> None:
            for name, publisher in publishers:
                sent[name] += 1
                publisher.publish(Int64(data=sent[name]))

        timer = person.node.create_timer(PERIOD_S, publish)
        person.wait(lambda: sent["/few"] > 5.0 / PERIOD_S, "messages")
        recorders[1].send_signal(signal.SIGKILL)
        recorders[1].wait()
        at_kill = sent["/few"]
        person.wait(lambda: sent["/few"] > at_kill + 10, "messages")
        timer.cancel()
    parts.interrupt(recorders[0])
    assert recorders[0].returncode == 0
    with open_bag(whole) as bag:
        assert {name: bag.counts[name] for name in sent} == sent
        assert json.loads(bag.notes["dropped"]) == {}
    with open_bag(killed) as bag:
        assert at_kill - bag.counts["/few"] <= MOST_LOST_S / PERIOD_S
