"""The whole warehouse live: from one command, and from parts that are started by hand in any order."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from soup_msgs import msg

from .conftest import PATIENCE_S, Parts, wait_until
from .person import Person

pytestmark = [pytest.mark.live, pytest.mark.timeout(600)]
NODES = {f"/bot_{bot}/bot_{bot}" for bot in range(20)} | {
    "/world", "/word_manager", "/letter_manager", "/fleet_manager",
}  # fmt: skip
BY_HAND = (
    ("run_fleet_manager.py",),
    ("run_bots.py", "6-19"),
    ("run_word_manager.py",),
    ("run_world.py", "--speed", "5", "--set", "words=PROSE", "--event-log", "events.jsonl", "--summary", "out.json"),
    ("run_bots.py", "0-3,5"),
    ("run_letter_manager.py",),
    ("run_bots.py", "4"),
)


def test_one_command_runs_twenty_four_nodes_that_assemble_words(parts: Parts):
    warehouse = parts.start(
        "run_warehouse.py", "--duration", "200", "--speed", "10", "--no-dashboard", "--summary", "out.json",
        "--event-log", "events.jsonl",
    )  # fmt: skip
    with Person() as person:
        person.wait(lambda: person.nodes() >= NODES, "24 nodes are in the graph")
    out, err = warehouse.communicate(timeout=400)
    assert warehouse.returncode == 0, err
    assert "words completed" in out
    summary = json.loads((parts.folder / "out.json").read_text())
    assert summary["sim_seconds"] == 200.0
    assert summary["words_completed"] > 0
    assert summary["violations"] == 0
    assert summary["policies"] == {"word": "served", "letter": "ahead", "fleet": "coordinated", "bot": "straight"}
    log = [json.loads(line) for line in (parts.folder / "events.jsonl").read_text().splitlines()]
    assert [event["sequence"] for event in log] == list(range(1, len(log) + 1))
    assert sum(event["type"] == "word_completed" for event in log) == summary["words_completed"]
    assert sorted(file.name for file in parts.folder.iterdir()) == ["events.jsonl", "out.json"]


def test_parts_started_by_hand_in_any_order_assemble_words_and_each_ends_at_once(parts: Parts, prose: str):
    started: dict[str, subprocess.Popen[str]] = {}
    for script, *arguments in BY_HAND:
        filled = [argument.replace("PROSE", prose) for argument in arguments]
        started[" ".join([script, *arguments])] = parts.start(script, *filled)
    with Person() as person:
        person.listen(msg.Statistics, "/world/statistics")
        person.wait(lambda: person.nodes() >= NODES, "24 nodes are in the graph")
        newest = person.heard
        person.wait(
            lambda: "/world/statistics" in newest and newest["/world/statistics"].words_completed > 0,
            "a word is completed",
        )
        assert newest["/world/statistics"].violations == 0
    assert parts.shared_memory() == set()
    for name, process in started.items():
        parts.interrupt(process)
        assert process.returncode == 0, name
    assert json.loads((parts.folder / "out.json").read_text())["violations"] == 0
    assert sorted(file.name for file in parts.folder.iterdir()) == ["events.jsonl", "out.json"]


def test_a_part_without_a_world_says_once_what_it_waits_for(parts: Parts):
    managers = [f"run_{role}_manager.py" for role in ("word", "letter", "fleet")]
    waiting = [parts.start("run_bots.py", "0-2"), *map(parts.start, managers)]
    with Person() as person:
        seen: dict[str, str] = {}

        def note(report: Any) -> None:
            seen.update({status.name: status.message for status in report.status})

        person.node.create_subscription(DiagnosticArray, "/diagnostics", note, 10)
        person.wait(lambda: len(seen) == len(waiting), "every part reports")
        person.wait(lambda: all("waits for the world" in message for message in seen.values()), "what it waits for")
        for _ in range(3):
            seen.clear()
            person.wait(lambda: len(seen) == len(waiting), "every part reports again")
    for process in waiting:
        process.send_signal(signal.SIGTERM)
    for process in waiting:
        _, err = process.communicate(timeout=PATIENCE_S)
        assert process.returncode == 0
        assert err.count("waits for the world") == 1, err


def test_the_warehouse_ends_with_ctrl_c_and_leaves_nothing(parts: Parts, prose: str):
    warehouse = parts.start(
        "run_warehouse.py", "--no-dashboard", "--set", f"words={prose}", "--summary", "out.json",
        "--event-log", "events.jsonl",
    )  # fmt: skip
    wait_for_time(parts)
    assert parts.shared_memory() == set()
    parts.interrupt(warehouse)
    assert warehouse.returncode == 0
    assert parts.all_gone()  # the process that the parts are forked from ends after the starter
    assert json.loads((parts.folder / "out.json").read_text())["sim_seconds"] > 0
    assert sorted(file.name for file in parts.folder.iterdir()) == ["events.jsonl", "out.json"]


def test_ctrl_c_before_the_warehouse_is_ready_ends_it_with_one_line(parts: Parts):
    warehouse = parts.start("run_warehouse.py", "--no-dashboard")
    assert warehouse.stdout is not None
    assert warehouse.stdout.readline().startswith("words: ")
    os.killpg(warehouse.pid, signal.SIGINT)  # as a terminal does: the starter and whoever it has not let go of yet
    out, err = warehouse.communicate(timeout=PATIENCE_S)
    assert (warehouse.returncode, err) == (130, "")
    assert out.splitlines()[-1] == "stopped before the warehouse was ready; no summary"
    assert parts.all_gone()


def test_parts_that_are_killed_are_started_again_and_letters_move_on(parts: Parts, prose: str):
    warehouse = parts.start(
        "run_warehouse.py", "--no-dashboard", "--speed", "5", "--set", f"words={prose}", "--summary", "out.json",
        "--event-log", "events.jsonl",
    )  # fmt: skip
    with Person() as person:
        person.listen(msg.Statistics, "/world/statistics")
        pids: dict[str, int] = {}

        def note(report: Any) -> None:
            for status in report.status:
                if status.message == "at work":
                    pids[status.name] = next(int(pair.value) for pair in status.values if pair.key == "pid")

        def letters() -> int:
            return person.heard["/world/statistics"].letters_in_words if "/world/statistics" in person.heard else 0

        person.node.create_subscription(DiagnosticArray, "/diagnostics", note, 10)
        person.wait(lambda: letters() > 0, "letters move")
        for name in ("fleet manager", "bots 0-19", "world"):
            before = pids.pop(name)
            os.kill(before, signal.SIGKILL)
            person.wait(lambda name=name, before=before: pids.get(name, before) != before, f"{name} is back")
            person.heard.pop("/world/statistics")
            person.wait(lambda: letters() > 0, "the world speaks")
            moved = letters()
            person.wait(lambda moved=moved: letters() > moved, f"letters move after {name} was killed")
    warehouse.send_signal(signal.SIGINT)
    out, err = warehouse.communicate(timeout=PATIENCE_S)
    assert warehouse.returncode == 0, err
    for name in ("fleet manager", "bots 0-19", "world"):
        assert f"{name} was killed by SIGKILL" in out
        assert f"{name} is started again" in out
    assert json.loads((parts.folder / "out.json").read_text())["violations"] == 0
    log = [json.loads(line) for line in (parts.folder / "events.jsonl").read_text().splitlines()]
    assert [event["sequence"] for event in log] == list(range(1, len(log) + 1))


def test_no_part_outlives_a_starter_that_was_killed(parts: Parts):
    warehouse = parts.start("run_warehouse.py", "--no-dashboard")
    wait_for_time(parts)
    warehouse.kill()
    warehouse.communicate()
    wait_until(lambda: not parts.alive(), "all parts have ended")


def wait_for_time(parts: Parts) -> None:
    """Wait until the simulated time of the warehouse goes by."""
    with Person() as person:
        person.listen(msg.Statistics, "/world/statistics")
        newest = person.heard
        person.wait(
            lambda: "/world/statistics" in newest and newest["/world/statistics"].sim_seconds > 0.5, "time goes by"
        )
