"""What parts say that they follow is read from a topic on which anybody may speak."""

from __future__ import annotations

from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from soup_live.diagnostics import MOST_PARTS, PartsWatch
from soup_msgs_py.policies import NONE, policies_of

OURS = {"word manager": {"policy": "urgent"}, "bots 0-5,8": {"policy": "evade"}}
FOREIGN = {
    "": {"policy": "nameless"}, "  ": {"policy": "blank"}, "word": {"policy": "no manager"},
    "bots": {"policy": "no bots"}, "word salad": {"policy": "no part"}, "letter manager": {"policy": ""},
    "fleet manager": {"policy": "x" * 1_000_000}, "camera driver": {},
}  # fmt: skip


class Wires:
    """Stands in for the process: keeps who listens."""

    take: Any

    def subscribe(self, _node: Any, _kind: type, _topic: str, take: Any, _profile: Any) -> None:
        self.take = take


def watch() -> tuple[PartsWatch, Wires]:
    """A watch, and how it is told."""
    wires: Any = Wires()
    return PartsWatch(wires, wires), wires


def report(name: str, level: bytes = DiagnosticStatus.OK, **values: str) -> DiagnosticArray:
    """A report of one process."""
    pairs = [KeyValue(key=key, value=value) for key, value in values.items()]
    return DiagnosticArray(status=[DiagnosticStatus(name=name, level=level, values=pairs)])


def test_the_policies_are_those_of_the_parts_of_a_warehouse_whatever_else_has_a_name() -> None:
    policies = policies_of({**FOREIGN, **OURS})
    assert (policies.word.name, policies.bot.name) == ("urgent", "evade")
    assert (policies.letter.name, policies.fleet.name) == (NONE, NONE)


def test_ten_thousand_foreign_names_take_no_more_room_than_some_hundred() -> None:
    parts, wires = watch()
    for number in range(10_000):
        if number % 100 == 0:
            wires.take(report("word manager", policy="urgent"))
        wires.take(report(f"stranger {number}", DiagnosticStatus.WARN if number % 2 else DiagnosticStatus.OK))
    assert len(parts.at_work) <= MOST_PARTS
    assert len(parts.waiting) <= MOST_PARTS
    assert policies_of(parts.at_work).word.name == "urgent"


def test_a_nameless_report_and_a_process_that_is_no_number_are_nobodys() -> None:
    parts, wires = watch()
    wires.take(report("", policy="nameless"))
    wires.take(report("word manager", pid="everything"))
    assert list(parts.at_work) == ["word manager"]
    assert parts.pid("word manager") == 0
