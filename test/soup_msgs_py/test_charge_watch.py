"""Whoever asks a manager notices that another one is in charge, whatever terms they claim."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from soup_msgs_py.live.charge import ChargeWatch
from soup_msgs_py.messages import Charge


class Wires:
    """Stands in for the process: keeps who listens."""

    def follow(self, _node: Any, _kind: type, _topic: str, take: Any, _profile: Any, *, event_callbacks: Any) -> None:
        self.take, self.events = take, event_callbacks

    def guard(self, function: Any) -> Any:
        return function

    def lives(self, count: int) -> None:
        """So many claim to be in charge now."""
        self.events.liveliness(SimpleNamespace(alive_count=count))


def claim(term: int, rank: int) -> Charge:
    """Of the fleet manager."""
    return Charge("fleet manager", term, rank, "coordinated")


def test_everybody_in_charge_is_told_from_the_one_before():
    wires: Any = Wires()
    watch = ChargeWatch(wires, wires, "fleet_manager")
    seen = [watch.claim]
    # one that was handed over to, one that knew of nobody when the former was killed, and one it hands over to
    for term, rank in ((1, 5), (2, 3), (1, 9), (2, 1)):
        wires.lives(1)
        wires.take(claim(term, rank))
        seen.append(watch.claim)
    assert len(set(seen)) == len(seen)
    wires.lives(0)
    assert watch.claim == 0
