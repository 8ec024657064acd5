"""A run that stands still for good says since when, and what stands in its way."""

from pathlib import Path

import pytest

from soup_lab.headless.simulation import Headless
from soup_msgs_py.policies import load_policies
from soup_sim.scenario_loader import load_warehouse
from soup_sim.standstill import patience_s
from soup_sim.world import World

CONFIG = Path(__file__).resolve().parents[2] / "config"


def world_of(*overrides: str) -> World:
    return load_warehouse(CONFIG / "scenarios/demo.yaml", overrides).world(1)


def run_on(world: World, seconds: float) -> Headless:
    run = Headless(world, load_policies(CONFIG / "policies/best.yaml", {}), 1)
    run.run(seconds)
    return run


def test_where_nothing_comes_in_it_says_which_station_starves_for_what():
    world = world_of("initial_inventory=0.0", "bundles={kind: none}")
    patience = patience_s(world.scenario)
    run = run_on(world, patience)
    assert run.stalled() == ""
    assert world.statistics()["stalled_since_s"] is None
    run.run(patience + 1.0)
    assert world.statistics()["stalled_since_s"] == 0.0
    assert run.stalled().startswith("nothing has been moved since 0 s: word station 0 starves for ")
    assert "(nowhere)" in run.stalled()
    assert "of its tasks: no bucket holds " in run.stalled()


def test_where_all_buckets_are_full_of_what_no_word_asks_for_it_says_so(tmp_path):
    (tmp_path / "words.txt").write_text("at")
    (tmp_path / "orders.csv").write_text("0,ZEBRA\n")
    orders = f"orders={{kind: file, path: {tmp_path / 'orders.csv'}}}"
    run = run_on(world_of(f"words={tmp_path / 'words.txt'}", orders, "initial_inventory=1.0"), 200.0)
    assert "the buckets have room for 0 letters: they are full of what no word asks for" in run.stalled()


def test_whoever_waits_for_nothing_has_not_stalled(tmp_path):
    (tmp_path / "orders.csv").write_text("0,AT\n1000,IT\n")
    world = world_of(f"orders={{kind: file, path: {tmp_path / 'orders.csv'}}}")
    run = run_on(world, 1000.0)
    assert world.statistics()["words_completed"] == 1
    assert run.stalled() == ""
    run.run(1010.0)
    assert run.stalled() == ""


def test_without_managers_it_says_that_no_word_is_opened():
    world = world_of()
    world.advance(patience_s(world.scenario) + 1.0)
    assert "no word is open, 200 wait: the word manager opens none" in world.stalled()
    assert "of 20 bots 20 do nothing" in world.stalled()


@pytest.mark.parametrize("bots", [1, 12])
def test_how_long_nothing_may_happen_is_a_matter_of_the_floor_and_of_how_fast_bots_are(bots):
    slow = world_of(f"bots={bots}", "bot.max_speed_mps=0.1").scenario
    assert patience_s(slow) > 4 * (40.0 + 30.0) / 0.1
    assert patience_s(world_of(f"bots={bots}").scenario) < 200.0


def test_a_checkpoint_keeps_since_when_nothing_is_moved():
    world = world_of("initial_inventory=0.0", "bundles={kind: none}")
    run_on(world, 100.0)
    again = world_of("initial_inventory=0.0", "bundles={kind: none}")
    again.restore(world.capture())
    again.advance(200.0)
    assert again.statistics()["stalled_since_s"] == 0.0
