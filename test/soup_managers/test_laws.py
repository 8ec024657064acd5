"""Laws of the minimal coordination in random small warehouses; the tiny world watches over every trip."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from managers_world import TinyWorld, Warehouse, layout_of, scenario_of

KINDS = 6


def random_warehouse(
    seed: int, *, fewest_buckets: int = 2, failures: float = 0.0, instant: bool = False, **options
) -> Warehouse:
    """Words of random letters, buckets a third full, more bots than free buckets or the other way round."""
    rng = np.random.default_rng(seed)
    bots, buckets = int(rng.integers(1, 8)), int(rng.integers(fewest_buckets, 13))
    scenario = scenario_of(bots=bots, buckets=buckets, initial_inventory=0.3)
    layout = layout_of(3, 5, 2, 2)
    words = [tuple(rng.integers(0, KINDS, rng.integers(2, 7)).tolist()) for _ in range(8)]
    world = TinyWorld(scenario, layout, words, rng, failures=failures, instant=instant)
    world.fill(rng.integers(0, KINDS, int(0.3 * 8 * buckets)).tolist())
    return Warehouse(world, seed=seed, **options)


seeds = st.integers(0, 2**32 - 1)
fewer = settings(max_examples=40)


@fewer
@given(seeds, st.booleans(), st.booleans())
def test_all_words_get_done_and_nothing_is_promised_twice(seed, instant, shared_view):
    warehouse = random_warehouse(seed, instant=instant, shared_view=shared_view)
    warehouse.run()
    assert sorted(warehouse.world.completed) == list(range(8))


@fewer
@given(seeds, st.floats(0.1, 0.6))
def test_failed_trips_are_tried_again_until_all_words_are_done(seed, failures):
    warehouse = random_warehouse(seed, failures=failures)
    warehouse.run()
    assert sorted(warehouse.world.completed) == list(range(8))


@fewer
@given(seeds, st.floats(0.1, 0.9), st.sampled_from([0.0, 0.3]))
def test_messages_that_lag_behind_delay_words_but_lose_none(seed, lag, failures):
    # late news make the letter manager bring in more than it wants: that must not fill all buckets
    warehouse = random_warehouse(seed, fewest_buckets=6, failures=failures, shared_view=False, lag=lag)
    warehouse.run()
    assert sorted(warehouse.world.completed) == list(range(8))


@fewer
@given(seeds, st.lists(st.sampled_from(["word", "letter", "fleet"]), min_size=1, max_size=6), st.booleans())
@example(24, ["word"], True)
def test_managers_that_are_started_anew_at_any_time_go_on(seed, roles, shared_view):
    warehouse = random_warehouse(seed, failures=0.2, shared_view=shared_view)
    rng = np.random.default_rng(seed)
    for role in roles:
        target = warehouse.world.now + float(rng.uniform(1.0, 60.0))
        warehouse.run(until=lambda target=target: warehouse.world.now >= target or is_done(warehouse))
        warehouse.restart(role)
    warehouse.run()
    assert sorted(warehouse.world.completed) == list(range(8))


def is_done(warehouse: Warehouse) -> bool:
    return not warehouse.world.waiting and not warehouse.world.open


@fewer
@given(seeds)
def test_without_failures_no_trip_is_in_vain(seed):
    warehouse = random_warehouse(seed)
    world = warehouse.world
    warehouse.run()
    warehouse.run(until=lambda: not world.doing and not world.agenda)
    assert world.trips == sum(world.delivered.values()) + stored(world)


def stored(world: TinyWorld) -> int:
    """Tiles that bots brought from letter stations into buckets."""
    return world.bundles * world.scenario.bundle_size - sum(b.count for _, b in world.staged.values())


@pytest.mark.parametrize("seed", range(3))
def test_the_same_seed_gives_the_same_messages(seed):
    first, second = (random_warehouse(seed, failures=0.2) for _ in range(2))
    first.run()
    second.run()
    assert first.log == second.log


@fewer
@given(seeds, st.floats(1.0, 400.0))
def test_a_view_kept_by_events_is_the_view_of_a_new_snapshot(seed, moment):
    warehouse = random_warehouse(seed, failures=0.2)
    world = warehouse.world
    warehouse.run(until=lambda: world.now >= moment or is_done(warehouse))
    kept = warehouse.shared
    assert kept is not None
    fresh = type(kept)(world.scenario, world.layout)
    fresh.reset(world.snapshot())
    for name, value in vars(fresh).items():
        if isinstance(value, (int, list, dict)) and name not in ("_heard", "resets", "waiting_words"):
            assert comparable(name, getattr(kept, name), world) == comparable(name, value, world), name
        elif isinstance(value, np.ndarray):
            told, true = comparable(name, getattr(kept, name), world), comparable(name, value, world)
            np.testing.assert_array_equal(told, true, name)
    np.testing.assert_array_equal(kept.contents.tiles, fresh.contents.tiles)
    np.testing.assert_array_equal(kept.contents.total, fresh.contents.total)
    assert list(kept.waiting_words) == list(fresh.waiting_words)


def comparable(name: str, value, world: TinyWorld):
    """What both views must agree in: not in sets that have become empty, nor where carried buckets rested."""
    if name == "spot_of":
        return [spot for spot, bot in zip(value, world.bucket_bot, strict=True) if bot < 0]
    return {k: v for k, v in value.items() if v != 0} if isinstance(value, dict) else value
