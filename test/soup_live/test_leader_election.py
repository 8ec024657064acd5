"""Whoever asks a manager notices that another one is in charge, whatever terms they claim."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from soup_live import leader_election as election
from soup_live.leader_election import FORGOTTEN_S, SAY_AGAIN_S, SILENT_S, ChargeWatch
from soup_msgs_py.messages import Charge


class Wires:
    """Stands in for the process and its subscription."""

    def __init__(self) -> None:
        self.publishers = 0
        self.now = 100.0

    def follow(self, _node: Any, _kind: type, _topic: str, take: Any, _profile: Any) -> Any:
        self.take = take
        return self

    def get_publisher_count(self) -> int:
        return self.publishers

    def go_on(self, seconds: float, watch: ChargeWatch, *speaking: Charge) -> None:
        """Time goes by, in which these say that they are in charge, and somebody looks."""
        end = self.now + seconds
        while self.now < end:
            for each in speaking:
                self.take(each)
            self.now += SAY_AGAIN_S
            watch.alive()


@pytest.fixture
def wires(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A process with a clock of its own."""
    wires = Wires()
    monkeypatch.setattr(election, "time", SimpleNamespace(monotonic=lambda: wires.now))
    return wires


def claim(term: int, rank: int) -> Charge:
    """Of the fleet manager."""
    return Charge("fleet manager", term, rank, "coordinated")


def test_everybody_in_charge_is_told_from_the_one_before(wires: Any):
    watch = ChargeWatch(wires, wires, "fleet_manager")
    seen = [watch.claim]
    # one that was handed over to, one that knew of nobody when the former was killed, and one it hands over to
    for term, rank in ((1, 5), (2, 3), (1, 9), (2, 1)):
        wires.publishers = 1
        wires.go_on(2.0, watch, claim(term, rank))
        seen.append(watch.claim)
    assert len(set(seen)) == len(seen)
    wires.publishers = 0
    assert watch.claim == 0


def test_who_was_killed_is_noticed_though_dds_has_not_forgotten_it(wires: Any):
    watch = ChargeWatch(wires, wires, "fleet_manager")
    wires.publishers = 1
    wires.go_on(10.0, watch, claim(1, 5))
    assert watch.alive() == 1
    wires.go_on(SILENT_S, watch)
    assert watch.alive() == 0


def test_a_process_that_thinks_for_a_while_is_alive(wires: Any):
    watch = ChargeWatch(wires, wires, "fleet_manager")
    wires.publishers = 1
    wires.go_on(10.0, watch, claim(1, 5))
    number = watch.claim
    wires.go_on(SILENT_S - 2.0 * SAY_AGAIN_S, watch)
    assert (watch.alive(), watch.claim) == (1, number)


def test_who_was_stopped_itself_takes_nobody_for_gone(wires: Any):
    watch = ChargeWatch(wires, wires, "fleet_manager")
    wires.publishers = 1
    wires.go_on(10.0, watch, claim(1, 5))
    wires.now += 20.0
    assert watch.alive() == 1


def test_the_own_claim_does_not_count(wires: Any):
    watch = ChargeWatch(wires, wires, "fleet_manager")
    wires.publishers = 1
    wires.go_on(2.0, watch, claim(1, 5))
    assert watch.alive(5, speaks=True) == 0
    wires.publishers = 2
    wires.go_on(2.0, watch, claim(1, 5), claim(1, 6))
    assert watch.alive(5, speaks=True) == 1


def test_claims_are_forgotten(wires: Any):
    watch = ChargeWatch(wires, wires, "fleet_manager")
    for rank in range(1000):
        wires.go_on(SAY_AGAIN_S, watch, claim(1, rank))
    assert len(watch._spoke) <= FORGOTTEN_S / SAY_AGAIN_S + 1
