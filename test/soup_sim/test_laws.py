"""Laws that hold whatever bots and managers ask for: judged by the independent judge, at every event."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from soup_msgs_py import messages as m
from soup_sim.checkpoint import restore_checkpoint, write_checkpoint
from soup_sim.scenario_loader import Warehouse, load_warehouse
from soup_sim.validate import Judge
from soup_sim.world import World

ROOT = Path(__file__).parents[2]
SMALL = [
    "floor={width_m: 24.0, height_m: 18.0}", "bots=4", "buckets=16", "word_stations=2", "letter_stations=2",
    "layout.block_rows=4", "layout.margin_columns=2", "orders.visible=20",
    "bucket.radius_m=0.3", "bot.radius_m=0.25", "word_station.transfer_s=0.5",
    "letter_station.transfer_s=0.5", "bot.collision_penalty_s=1.0",
]  # fmt: skip
SEEDS = st.integers(0, 2**32)


def small(*overrides: str) -> Warehouse:
    """A crowded little warehouse in which much happens soon."""
    return load_warehouse(ROOT / "config/scenarios/demo.yaml", [*SMALL, *overrides])


def commands(world: World, rng: np.random.Generator) -> list[object]:
    """What a crew and managers without any sense might ask for; often near something, so that it works."""
    scenario, layout = world.scenario, world.layout
    asked: list[object] = []
    buckets, carried = world.buckets(), world.bots().bucket
    snapshot = world.snapshot()
    for bot in range(scenario.bots):
        request = int(rng.integers(1, 2**31))
        # asked first and mostly refused; where the bot happens to be at the right place, it works
        if carried[bot] < 0:
            asked.append(m.Grab(bot, request))
        elif rng.random() < 0.7:
            asked.append(m.Transfer(bot, request, -1, (m.TileMove(),) * int(rng.integers(1, 4))))
        else:
            asked.append(m.Release(bot, request))
        choice = rng.integers(10)
        if choice == 0:
            asked.append(m.SetVelocity(bot, *rng.uniform(-6.0, 6.0, 2).tolist()))
        elif choice <= 3:
            if choice == 1:
                x, y = rng.uniform((0.0, 0.0), (scenario.floor.width_m, scenario.floor.height_m))
            elif carried[bot] < 0:
                bucket = int(rng.integers(scenario.buckets))
                x, y = buckets.x[bucket], buckets.y[bucket]
            else:
                x, y = layout.waypoints[rng.choice(layout.stations if choice == 2 else snapshot.storage_spots)]
            asked.append(m.FollowPath(bot, request, ((float(x), float(y)),)))
    if snapshot.waiting_words:
        word = snapshot.waiting_words[0].word
        asked.append(m.AssignWord(word, int(rng.integers(scenario.word_station_count))))
    station = scenario.word_station_count + int(rng.integers(scenario.letter_station_count))
    asked.append(m.AssignBundle(station, tile=int(rng.integers(26))))
    for storage in (False, True):
        asked.append(m.SetStorageSpot(int(rng.integers(len(layout.waypoints))), storage))
    return asked


def run(world: World, seed: int, steps: int, judge: Judge | None = None) -> list[object]:
    """Let random commands loose; everything that the world said."""
    said: list[object] = []
    for step in range(steps):
        rng = np.random.default_rng([seed, step])
        for command in commands(world, rng):
            said += _listen(world, world.handle(command), judge)
        until = world.now + float(rng.uniform(0.0, 8.0))
        while world.now < until:
            said += _listen(world, world.advance(until, pause=True), judge)
    return said


def _listen(world: World, said: list, judge: Judge | None) -> list:
    if judge is not None:
        for message in said:
            if isinstance(message, m.Event):
                judge.event(message)
        judge.poses(world.bots(), world.buckets())
    return said


@given(SEEDS, st.sampled_from(["null", "3.0"]), st.sampled_from([0.0, 2.5]))
@settings(max_examples=25)
def test_no_law_is_broken_under_random_commands(seed: int, turn_rate: str, clear_s: float) -> None:
    warehouse = small(f"bot.turn_rate_radps={turn_rate}", f"word_station.clear_s={clear_s}")
    world = warehouse.world(seed)
    judge = Judge(warehouse.scenario, warehouse.layout, world.snapshot())
    run(world, seed, 60, judge)
    judge.finish(world.snapshot())
    assert judge.violations == []


@given(SEEDS, st.integers(0, 20), st.floats(0.0, 3.0))
@settings(max_examples=15)
def test_a_checkpoint_at_any_time_changes_nothing_that_follows(tmp_path_factory, seed, steps, pause) -> None:
    warehouse = small(
        "orders={kind: poisson, per_hour: 2000}", "bundles={kind: poisson, per_hour: 2000}",
        "word_station.policy=nearly_done", "letter_station.policy=nearly_empty",
    )  # fmt: skip
    path = tmp_path_factory.mktemp("checkpoint") / "world"
    world = warehouse.world(seed)
    run(world, seed, steps)
    world.advance(world.now + pause)
    write_checkpoint(path, world)
    restored = warehouse.world(seed + 1)
    restore_checkpoint(path, restored)
    assert run(restored, seed, 20) == run(world, seed, 20)
    assert restored.statistics() == world.statistics()


@given(SEEDS)
@settings(max_examples=5)
def test_the_same_seed_and_commands_give_the_same_history(seed: int) -> None:
    assert run(small().world(seed), seed, 15) == run(small().world(seed), seed, 15)
