"""A warehouse that lacks somebody says whom, and which command starts them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from soup_live.vacancies import VACANT_S, Vacancies

ALL = ("word manager", "letter manager", "fleet manager")


class Warehouse:
    """Four bots; everybody reports until told otherwise."""

    def __init__(self) -> None:
        self.now = 0.0
        self.parts: Any = SimpleNamespace(heard={})
        self.vacancies = Vacancies(self.parts, 4, lambda: self.now)
        for name in ALL:
            self.report(name)
        self.report("bots 0-3", bots="0-3")

    def report(self, name: str, **values: str) -> None:
        """A process says that it is there."""
        self.parts.heard[name] = (self.now, values)

    def later(self, *but: str, bots: str = "0-3") -> str:
        """All but some go on to report for a long while; what is said then."""
        self.now += 2.0 * VACANT_S
        for name in ALL:
            if name not in but:
                self.report(name)
        self.report("bots 0-3", bots=bots)
        return self.vacancies.look()


@pytest.fixture
def warehouse() -> Warehouse:
    return Warehouse()


def test_a_warehouse_that_is_just_started_misses_nobody():
    now = 0.0
    vacancies = Vacancies(SimpleNamespace(heard={}), 4, lambda: now)  # type: ignore[arg-type]
    now = 0.9 * VACANT_S
    assert vacancies.look() == ""
    now = 1.1 * VACANT_S
    assert vacancies.look().count("python3 scripts/") == 4


def test_nobody_is_missed_while_all_report(warehouse: Warehouse):
    assert warehouse.later() == ""


@pytest.mark.parametrize("role", ["word", "letter", "fleet"])
def test_a_manager_that_has_gone_is_named_with_what_starts_another(warehouse: Warehouse, role: str):
    assert warehouse.later(f"{role} manager") == (
        f"no {role} manager (python3 scripts/run_{role}_manager.py starts one)"
    )
    assert warehouse.later() == ""


def test_one_that_stands_by_for_nobody_does_not_count(warehouse: Warehouse):
    warehouse.report("word manager (stands by)")
    assert "no word manager" in warehouse.later("word manager")


def test_bots_that_nobody_drives_are_named(warehouse: Warehouse):
    assert warehouse.later(bots="0,2") == "nobody drives bots 1,3 (python3 scripts/run_bots.py 1,3 starts them)"


@pytest.mark.parametrize("bots", ["", "many", "7-2", "0-99999999999"])
def test_a_report_that_makes_no_sense_drives_no_bot(warehouse: Warehouse, bots: str):
    assert "nobody drives bots 0-3" in warehouse.later(bots=bots)
