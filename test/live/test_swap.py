"""A manager, or the mind of a bot, is swapped for another while the world runs."""

from __future__ import annotations

import signal
import subprocess
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from soup_msgs import msg, srv

from .conftest import PATIENCE_S, Parts
from .person import Person

pytestmark = [pytest.mark.live, pytest.mark.timeout(600)]


class Reports:
    """What the processes say about themselves, by name."""

    def __init__(self, person: Person) -> None:
        self.newest: dict[str, dict[str, str]] = {}
        person.node.create_subscription(DiagnosticArray, "/diagnostics", self._note, 10)

    def _note(self, report: Any) -> None:
        for status in report.status:
            self.newest[status.name] = {pair.key: pair.value for pair in status.values} | {"says": status.message}

    def value(self, name: str, key: str) -> str:
        """A detail of a process; empty where nothing was heard of it."""
        return self.newest.get(name, {}).get(key, "")


def test_a_manager_takes_over_at_once_and_another_stands_by_until_it_is_killed(parts: Parts):
    world = parts.start("run_world.py")
    first = parts.start("run_fleet_manager.py")
    with Person() as person:
        reports = Reports(person)
        person.wait(lambda: reports.value("fleet manager", "policy") == "coordinated", "the first is in charge")
        second = parts.start("swap_manager.py", "fleet", "--policy", "minimal")
        person.wait(lambda: reports.value("fleet manager", "policy") == "minimal", "the second has taken over")
        _, err = first.communicate(timeout=PATIENCE_S)
        assert first.returncode == 0, err
        third = parts.start("run_fleet_manager.py")
        standby = "fleet manager (stands by)"
        person.wait(lambda: "follows minimal" in reports.value(standby, "says"), "the third stands by")
        second.kill()
        person.wait(lambda: reports.value("fleet manager", "policy") == "coordinated", "the third has taken over")
        person.wait(lambda: reports.value("fleet manager", "says") == "at work", "the third is at work")
        assert third.poll() is None
    end(world, third)


def test_a_bot_gets_another_mind_for_a_while_and_the_others_of_its_process_keep_theirs(parts: Parts):
    world = parts.start("run_world.py")
    host = parts.start("run_bots.py", "0-2")
    with Person() as person:
        reports = Reports(person)
        person.wait(lambda: reports.value("bots 0-2", "says") == "at work", "three bots are at work")
        other = parts.start("swap_manager.py", "1", "--policy", "evade")
        person.wait(lambda: reports.value("bots 1", "says") == "at work", "bot 1 has another mind")
        person.wait(lambda: reports.value("bots 0-2", "bots") == "0,2", "the others have theirs")
        person.listen(msg.BotStatus, "/bot_1/status", latched=True)
        person.wait(lambda: "/bot_1/status" in person.heard, "bot 1 speaks")
        end(other)
        person.wait(lambda: reports.value("bots 0-2", "bots") == "0-2", "the first process has taken bot 1 back")
        answer = person.call(srv.Release, "/bot_1/release")
        assert answer.code == "not_carrying", answer
        assert host.poll() is None
    end(host, world)


def end(*processes: subprocess.Popen[str]) -> None:
    """End programs as Ctrl-C does."""
    for process in processes:
        process.send_signal(signal.SIGINT)
    for process in processes:
        _, err = process.communicate(timeout=PATIENCE_S)
        assert process.returncode == 0, err


def test_what_nobody_can_swap_is_told_in_one_line(parts: Parts):
    status, _, err = parts.run("swap_manager.py", "soup")
    assert status == 2
    assert "word, letter, fleet" in err
    assert err.count("\n") == 1
