"""The best policies in other warehouses than the ones that they were tuned on: none comes to a standstill."""

from __future__ import annotations

from pathlib import Path

import pytest
from random_warehouse import draw

from soup_lab.headless.simulation import Headless
from soup_msgs_py import messages as m
from soup_msgs_py.codes import EventType
from soup_msgs_py.policies import Policies, load_policies
from soup_sim.scenario_loader import load_warehouse

CONFIG = Path(__file__).resolve().parents[2] / "config"
BEST = load_policies(CONFIG / "policies/best.yaml", {})


def completed(scenario: str, seconds: float, *overrides: str, policies: Policies = BEST) -> list[float]:
    """When words were completed."""
    events: list[m.Event] = []
    world = load_warehouse(CONFIG / "scenarios" / f"{scenario}.yaml", overrides).world(1)
    Headless(world, policies, 1, events.append).run(seconds)
    return [event.time for event in events if event.type is EventType.WORD_COMPLETED]


@pytest.mark.parametrize(("capacity", "least"), [(4, 25), (8, 40), (12, 50)])
def test_small_buckets_are_filled_too(capacity: int, least: int) -> None:
    """How much room makes a bucket worth filling is a matter of its size."""
    words = completed("demo", 500.0, f"bucket.capacity={capacity}")
    assert len(words) >= least


def test_amounts_in_tiles_do_what_shares_do() -> None:
    options = {
        "horizons": {"least_room": 16},
        "onward": {"name": "serve_on", "options": {"least_tiles": 8, "least_room": 16}},
    }
    fleet = BEST.fleet.model_copy(update={"options": {**BEST.fleet.options, **options}})
    tiles = BEST.model_copy(update={"fleet": fleet})
    assert completed("demo", 200.0, policies=tiles) == completed("demo", 200.0)


def test_few_bots_are_spared() -> None:
    """Too few bots for the stations cross the floor with full buckets, and serve what is near them."""
    fleet = BEST.fleet.model_copy(update={"options": {**BEST.fleet.options, "onward": "serve_on"}})
    lavish = BEST.model_copy(update={"fleet": fleet})
    assert len(completed("paper", 1800.0, "bots=12")) > 1.4 * len(
        completed("paper", 1800.0, "bots=12", policies=lavish)
    )


def test_stations_that_no_bucket_serves_leave_the_bots_to_others() -> None:
    """Nine word stations that lack letters must not keep three bots from the letter stations, where these come in."""
    words = completed("demo", 1800.0, "bots=3", "word_stations=9", "buckets=4", "initial_inventory=0.7")
    assert len([time for time in words if time > 1200.0]) >= 10


@pytest.mark.parametrize("seed", [2, 3, 8])
def test_no_warehouse_that_is_drawn_at_random_comes_to_a_standstill(seed: int, tmp_path: Path) -> None:
    moved: list[float] = []

    def on_event(event: m.Event) -> None:
        if event.type is EventType.TRANSFERRED:
            moved.append(event.time)

    run = Headless(load_warehouse(draw(seed, tmp_path)).world(1), BEST, 1, on_event)
    run.run(900.0)
    assert moved[-1] > 840.0, run.stalled()
    assert run.world.statistics()["words_completed"] >= 5
