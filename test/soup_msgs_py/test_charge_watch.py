"""Whoever asks a manager notices that another one is in charge, whatever terms they claim."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from soup_msgs_py.live import charge
from soup_msgs_py.live.charge import FORGOTTEN_S, HEARD_S, SAY_AGAIN_S, ChargeWatch
from soup_msgs_py.messages import Charge


class Wires:
    """Stands in for the process, its node and DDS, whose count of who is alive may be wrong by `error`."""

    def __init__(self) -> None:
        self.error = 0
        self.now = 100.0

    def follow(self, _node: Any, _kind: type, _topic: str, take: Any, _profile: Any, *, event_callbacks: Any) -> None:
        self.take, self.events = take, event_callbacks

    def guard(self, function: Any) -> Any:
        return function

    def count(self, alive: int, dead: int = 0) -> None:
        """Tell how many are alive, and how many more are not forgotten yet."""
        self.events.matched(SimpleNamespace(current_count=alive + dead))
        self.events.liveliness(SimpleNamespace(alive_count=alive + self.error))

    def go_on(self, seconds: float, *speaking: Charge) -> None:
        """Time goes by, in which these say that they are in charge."""
        end = self.now + seconds
        while self.now < end:
            for each in speaking:
                self.take(each)
            self.now += SAY_AGAIN_S


@pytest.fixture
def wires(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A process with a clock of its own."""
    wires = Wires()
    monkeypatch.setattr(charge, "time", SimpleNamespace(monotonic=lambda: wires.now))
    return wires


def claim(term: int, rank: int) -> Charge:
    """Of the fleet manager."""
    return Charge("fleet manager", term, rank, "coordinated")


def test_everybody_in_charge_is_told_from_the_one_before(wires: Any):
    watch = ChargeWatch(wires, wires, "fleet_manager")
    seen = [watch.claim]
    # one that was handed over to, one that knew of nobody when the former was killed, and one it hands over to
    for term, rank in ((1, 5), (2, 3), (1, 9), (2, 1)):
        wires.count(1)
        wires.go_on(2.0, claim(term, rank))
        seen.append(watch.claim)
    assert len(set(seen)) == len(seen)
    wires.count(0)
    wires.go_on(2.0 * HEARD_S)
    assert watch.claim == 0


def test_who_is_dead_is_noticed_though_it_is_not_forgotten_yet(wires: Any):
    watch = ChargeWatch(wires, wires, "fleet_manager")
    wires.count(1)
    wires.go_on(10.0, claim(1, 5))
    wires.count(0, dead=1)
    wires.go_on(HEARD_S)
    assert watch.alive() == 0


def test_a_process_that_thinks_for_long_is_alive(wires: Any):
    watch = ChargeWatch(wires, wires, "fleet_manager")
    wires.count(1)
    wires.go_on(10.0, claim(1, 5))
    number = watch.claim
    wires.go_on(10.0)
    assert (watch.alive(), watch.claim) == (1, number)


def test_who_speaks_is_alive_though_dds_has_counted_wrong(wires: Any):
    watch = ChargeWatch(wires, wires, "fleet_manager")
    wires.error = -1
    wires.count(1)
    wires.go_on(10.0, claim(1, 5))
    assert watch.alive() == 1
    assert watch.alive(5, speaks=True) == 0


@pytest.mark.parametrize("error", [-1, 1])
@pytest.mark.parametrize("there", [0, 1])
def test_a_wrong_count_is_noticed_where_nothing_changes_for_long(wires: Any, there: int, error: int):
    watch = ChargeWatch(wires, wires, "fleet_manager")
    wires.error = error
    wires.count(there)
    wires.go_on(FORGOTTEN_S + 1.0)
    assert watch.alive() == there
    wires.count(1 - there)
    assert watch.alive() == 1 - there


def test_claims_are_forgotten(wires: Any):
    watch = ChargeWatch(wires, wires, "fleet_manager")
    for rank in range(1000):
        wires.go_on(SAY_AGAIN_S, claim(1, rank))
    assert len(watch._spoke) <= FORGOTTEN_S / SAY_AGAIN_S + 1
