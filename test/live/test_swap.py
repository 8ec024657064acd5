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
        self.alike: dict[str, int] = {}  # how often in a row each has said the same
        person.node.create_subscription(DiagnosticArray, "/diagnostics", self._note, 10)

    def _note(self, report: Any) -> None:
        for status in report.status:
            again = status.message == self.value(status.name, "says")
            self.alike[status.name] = self.alike.get(status.name, 0) + 1 if again else 0
            self.newest[status.name] = {pair.key: pair.value for pair in status.values} | {"says": status.message}

    def value(self, name: str, key: str) -> str:
        """A detail of a process; empty where nothing was heard of it."""
        return self.newest.get(name, {}).get(key, "")


STANDS_BY = "fleet manager (stands by)"


def test_who_is_swapped_out_stands_by_says_so_and_is_in_charge_again(parts: Parts):
    world = parts.start("run_world.py")
    first = parts.start("run_fleet_manager.py")
    with Person() as person:
        reports = Reports(person)
        person.wait(lambda: reports.value("fleet manager", "policy") == "coordinated", "the first is in charge")
        second = parts.start("swap_manager.py", "fleet", "--policy", "minimal")
        person.wait(lambda: reports.value("fleet manager", "policy") == "minimal", "the second has taken over")
        person.wait(lambda: "follows minimal" in reports.value(STANDS_BY, "says"), "the first stands by")
        out, _ = ended(second)
        assert out.splitlines()[0] == "fleet manager: in charge (minimal); Ctrl-C hands back"
        person.wait(lambda: reports.value("fleet manager", "policy") == "coordinated", "the first is in charge again")
        person.wait(lambda: reports.value("fleet manager", "says") == "at work", "the first is at work")
        third = parts.start("swap_manager.py", "fleet", "--policy", "minimal")
        person.wait(lambda: reports.value("fleet manager", "policy") == "minimal", "the third has taken over")
        reports.newest.pop(STANDS_BY)
        person.wait(lambda: "follows minimal" in reports.value(STANDS_BY, "says"), "the first stands by again")
        third.kill()
        person.wait(lambda: reports.value("fleet manager", "policy") == "coordinated", "the first takes over again")
        assert first.poll() is None
    out, err = ended(first)
    assert out.splitlines()[0] == "fleet manager: in charge (coordinated)"
    assert "fleet manager: another one takes over, this one stands by" in err
    assert "fleet manager: stands by for the fleet manager that follows minimal" in err
    end(world)


def test_a_world_without_managers_says_who_starts_them_and_a_part_says_that_it_works(parts: Parts):
    world = parts.start("run_world.py", "--set", "bots=2")
    bots = parts.start("run_bots.py", "0")
    with Person() as person:
        reports = Reports(person)
        person.wait(lambda: reports.value("bots 0", "says") == "at work", "a bot is at work")
        person.wait(lambda: "no word manager" in reports.value("world", "says"), "the world misses somebody")
        person.wait(
            lambda: reports.alike["world"] >= 4, "the world has said so for some seconds, and then in its terminal"
        )
        assert "nobody drives bots 1 (python3 scripts/run_bots.py 1 starts them)" in reports.value("world", "says")
    out, _ = ended(bots)
    assert "bots 0: at work: policy straight" in out
    _, err = ended(world)
    for role in ("word", "letter", "fleet"):
        assert f"no {role} manager (python3 scripts/run_{role}_manager.py starts one)" in err


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


def ended(process: subprocess.Popen[str]) -> tuple[str, str]:
    """End a program as Ctrl-C does: what it has written to stdout and stderr."""
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0, err
    return out, err


def test_what_nobody_can_swap_is_told_in_one_line(parts: Parts):
    status, _, err = parts.run("swap_manager.py", "soup")
    assert status == 2
    assert "word, letter, fleet" in err
    assert err.count("\n") == 1
