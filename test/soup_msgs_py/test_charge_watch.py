"""Whoever asks a manager notices that another one is in charge, whatever terms they claim."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from soup_msgs_py.live import charge
from soup_msgs_py.live.charge import COUNTED_S, DOUBTED_S, ChargeWatch
from soup_msgs_py.messages import Charge


class Wires:
    """Stands in for the process, its node and DDS, whose count of who is alive may be wrong by `error`."""

    def __init__(self) -> None:
        self.there: list[Charge] = []  # claims of publishers
        self.dead: list[Charge] = []  # those of them that DDS has not forgotten yet
        self.error = 0
        self.now = 0.0
        self._speak_at = math.inf  # when those who are alive say so to a new subscription
        self._looks: list[Any] = []

    def follow(self, _node: Any, _kind: type, _topic: str, take: Any, _profile: Any, *, event_callbacks: Any) -> object:
        self.take, self.events, self.error = take, event_callbacks, 0
        self._speak_at = self.now + 1.0
        for each in self.there:
            take(each)
        return self

    def destroy_subscription(self, _subscription: object) -> None:
        del self.events

    def guard(self, function: Any) -> Any:
        return function

    def every(self, _period_s: float, function: Any) -> None:
        self._looks.append(function)

    def count(self) -> None:
        """Tell how many are there, and how many alive."""
        self.events.matched(SimpleNamespace(current_count=len(self.there)))
        alive = len(self.there) - len(self.dead) + self.error
        self.events.liveliness(SimpleNamespace(alive_count=alive))

    def claims(self, *claims: Charge) -> None:
        """These are in charge, or claim to be, from now on."""
        new = [each for each in claims if each not in self.there]
        self.there, self.dead = list(claims), []
        self.count()
        for each in new:
            self.take(each)

    def go_on(self, seconds: float) -> None:
        """Time goes by."""
        end = self.now + seconds
        while self.now < end:
            self.now += 0.1
            if self.now >= self._speak_at:
                self._speak_at = math.inf
                self.count()
            for look in self._looks:
                look()


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
        wires.claims(claim(term, rank))
        seen.append(watch.claim)
    assert len(set(seen)) == len(seen)
    wires.claims()
    assert watch.claim == 0


@pytest.mark.parametrize("error", [-1, 1])
@pytest.mark.parametrize("there", [0, 1])
def test_a_wrong_count_of_who_is_alive_is_made_anew(wires: Any, there: int, error: int):
    watch = ChargeWatch(wires, wires, "fleet_manager")
    wires.error = error
    wires.claims(*[claim(1, 5)][:there])
    wires.go_on(2.0 * (DOUBTED_S + COUNTED_S))
    assert watch.alive == there


def test_who_is_in_charge_stays_so_while_the_dead_are_not_forgotten_yet(wires: Any):
    watch = ChargeWatch(wires, wires, "fleet_manager")
    killed, new = claim(1, 5), claim(2, 3)
    wires.claims(killed, new)
    wires.dead = [killed]
    wires.count()
    assert watch.alive == 1
    number = watch.claim
    for _ in range(200):
        wires.go_on(0.1)
        assert (watch.alive, watch.claim) == (1, number)
    wires.dead = [killed, new]
    wires.count()
    assert watch.alive == 0
