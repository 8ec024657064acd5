"""A script is a guest in a live warehouse: it is told what it cannot have, and leaves nothing under way."""

from __future__ import annotations

import math
import signal
from pathlib import Path

import pytest
from soup_msgs import msg

from soup_live.handle import Refused
from soup_live.leader_election import SILENT_S
from soup_live.warehouse import INTERRUPTED, Warehouse
from soup_msgs_py.codes import Code, EventType
from soup_msgs_py.errors import InputError, RunError
from soup_msgs_py.mail import goals, results
from soup_msgs_py.messages import DELIVER

from .conftest import Parts
from .person import PATIENCE_S, Person

pytestmark = [pytest.mark.live, pytest.mark.timeout(600)]
SOON_S = 1.0
SCRIPT = """
import sys
from soup_live.warehouse import Warehouse, run

def main():
    with Warehouse(timeout_s=float(sys.argv[1])) as warehouse:
        drive = warehouse.drive(0, (2.0, 2.0), (38.0, 28.0), (2.0, 2.0), (38.0, 28.0))
        next(warehouse.follow(drive))
        print("on its way", flush=True)
        warehouse.wait(drive)

sys.exit(run(main))
"""


@pytest.fixture
def script(tmp_path: Path) -> Path:
    """A script that sends bot 0 on a long way; its argument is for how long it looks for the warehouse (s)."""
    file = tmp_path / "script.py"
    file.write_text(SCRIPT)
    return file


def test_without_a_warehouse_a_script_ends_with_one_line(parts: Parts, domain: str, script: Path):
    process = parts.run_file(script, str(SOON_S))
    out, err = process.communicate(timeout=PATIENCE_S)
    assert (process.returncode, out) == (1, "")
    line = f"no warehouse in domain {domain} (nothing on /world/scenario) within 1 s; "
    assert err == f"{line}python3 scripts/run_warehouse.py starts one\n"


def test_what_cannot_be_is_told_in_one_line_and_what_is_left_is_cancelled(parts: Parts):
    world = parts.start("run_world.py", "--set", "bots=2", "--set", "buckets=1")
    bot = parts.start("run_bots.py", "0")
    with Warehouse(timeout_s=PATIENCE_S) as warehouse:
        with pytest.raises(InputError, match=r"^bot: found 2; allowed: 0 to 1, which the warehouse has$"):
            warehouse.drive(2, (1.0, 1.0))
        with pytest.raises(InputError, match=r"^points: found none; allowed: one or more \(x, y\) in metres$"):
            warehouse.drive(0)
        with pytest.raises(
            InputError, match=r"^word: found 999999; allowed: the number of a word that waits or is open$"
        ):
            warehouse.deliver(999_999)
        with pytest.raises(Refused, match=r"^bot 0 releases its bucket: not_carrying: ") as refused:
            warehouse.wait(warehouse.release(0))
        assert refused.value.code is Code.NOT_CARRYING
        with pytest.raises(Refused, match=r"^bot 0 drives to \(-5\.0, 5\.0\): off_floor: "):
            warehouse.wait(warehouse.drive(0, (-5.0, 5.0)))

        warehouse.timeout_s = SOON_S
        with pytest.raises(RunError, match=r"^nobody serves /bot_1/drive within 1 s; python3 scripts/run_bots\.py 1 "):
            warehouse.drive(1, (1.0, 1.0))
        with pytest.raises(RunError, match=r"^nobody serves /fleet/deliver_letters within 1 s; "):
            warehouse.deliver(warehouse.snapshot().waiting_words[0].word)
        warehouse.timeout_s = PATIENCE_S

        far = [(2.0, 2.0), (38.0, 28.0), (2.0, 2.0)]
        drive = warehouse.drive(0, *far)
        with pytest.raises(RunError, match=r"^bot 0 drives to \(2\.0, 2\.0\): takes longer than 0 s"):
            warehouse.wait(drive, timeout_s=0.0)
        drive.cancel()
        assert warehouse.first(drive) is drive
        assert drive.code is Code.CANCELLED
        with pytest.raises(Refused, match=r"cancelled"):
            warehouse.wait(drive)

        x, y, _ = warehouse.pose(0)
        warehouse.wait(warehouse.drive(0, (x + 1.0, y)))
        assert math.dist(warehouse.pose(0)[:2], (x + 1.0, y)) < 0.1
        left = warehouse.drive(0, *far)
    assert left.code is Code.CANCELLED
    with pytest.raises(RuntimeError, match="left"):
        warehouse.bots()
    with Warehouse(timeout_s=PATIENCE_S) as again:
        assert again.scenario.bots == 2
    for process in (bot, world):
        parts.interrupt(process)
        assert process.returncode == 0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_script_that_is_ended_calls_its_bot_back(parts: Parts, script: Path, number: int):
    world = parts.start("run_world.py", "--set", "bots=1", "--set", "buckets=1")
    bot = parts.start("run_bots.py", "0")
    with Person() as person:
        person.listen(msg.Bots, "/world/bots")
        person.listen(msg.BotStatus, "/bot_0/status", latched=True)
        person.wait(lambda: "/bot_0/status" in person.heard, "the bot is there")
        process = parts.run_file(script, str(PATIENCE_S))
        assert process.stdout is not None
        assert process.stdout.readline() == "on its way\n"
        person.wait(lambda: person.heard["/bot_0/status"].phase == "driving", "the bot drives")
        err = parts.interrupt(process, number)
        assert (process.returncode, err) == (INTERRUPTED, "")
        person.wait(lambda: person.heard["/bot_0/status"].phase == "idle", "the bot stands idle")
        assert math.dist(person.place(0), (38.0, 28.0)) > 1.0
    for other in (bot, world):
        parts.interrupt(other)


def test_a_word_is_delivered_without_a_word_manager_and_time_waits_for_no_goal_of_a_script(parts: Parts, prose: str):
    world = parts.start("run_world.py", "--speed", "10", "--set", "bots=4", "--set", f"words={prose}")
    others = [parts.start("run_bots.py", "0-3"), parts.start("run_fleet_manager.py")]
    counted: set[str] = set()
    heard: set[str] = set()
    with Person() as person:

        def hear(message: msg.Heard) -> None:
            heard.add(message.part)
            counted.update((*message.sent_on, *message.got_on))

        person.node.create_subscription(msg.Heard, "/world/heard", hear, 1000)
        with Warehouse(timeout_s=PATIENCE_S) as warehouse:
            completed = warehouse.watch(EventType.WORD_COMPLETED)
            word = min(warehouse.snapshot().waiting_words, key=lambda word: len(word.tiles))
            delivery = warehouse.deliver(word.word)
            lacked = [len(feedback.missing) for feedback in warehouse.follow(delivery)]
            warehouse.wait(delivery)
            assert next(completed).job == word.word
            assert lacked == sorted(lacked, reverse=True)
        person.wait(lambda: "fleet manager" in heard, "the fleet manager has said how far it is")
    assert not counted & {goals(DELIVER), results(DELIVER)}
    for process in [*others, world]:
        parts.interrupt(process)


def test_a_script_is_patient_with_a_fleet_manager_that_is_busy(parts: Parts, prose: str):
    world = parts.start("run_world.py", "--speed", "10", "--set", "bots=4", "--set", f"words={prose}")
    bots, fleet = parts.start("run_bots.py", "0-3"), parts.start("run_fleet_manager.py")
    with Warehouse(timeout_s=PATIENCE_S) as warehouse:
        word = min(warehouse.snapshot().waiting_words, key=lambda word: len(word.tiles))
        delivery = warehouse.deliver(word.word)
        fleet.send_signal(signal.SIGSTOP)  # as silent as one that compiles
        with pytest.raises(RunError, match="takes longer than"):
            warehouse.wait(delivery, timeout_s=SILENT_S + 1.0)
        fleet.send_signal(signal.SIGCONT)
        warehouse.wait(delivery)
    for process in (fleet, bots, world):
        parts.interrupt(process)
