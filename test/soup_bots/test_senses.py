"""A bot is told everything within its sensing radius, and less where the scenario blinds it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from soup_bots.senses import NOWHERE
from soup_bots.steering import KNOWN, Evade, Me, Neighbour, Steer, Steering, SteerView
from soup_lab.headless.simulation import Headless
from soup_msgs_py.policies import Policies, PolicyChoice
from soup_sim.scenario_loader import load_warehouse
from soup_sim.world import World

ROOT = Path(__file__).parents[2]
DEMO = ROOT / "config/scenarios/demo.yaml"
LASTS_S = 30.0
RADIUS_M = 8.0


class Spy(Steering):
    """Drives like the default one; keeps what each bot is told, and has it checked at once."""

    views: ClassVar[list[SteerView]] = []  # one list for the copies of all bots
    check: ClassVar[list[Callable[[Me, list[Neighbour]], None]]] = []

    def __init__(self) -> None:
        self._evade = Evade()

    def steer(self, view: SteerView) -> Steer:
        super().steer(view)
        self.views.append(view)
        return self._evade.steer(view)

    def steer_one(self, me: Me, neighbours: list[Neighbour], limits) -> None:
        for check in self.check:
            check(me, neighbours)


@pytest.fixture(autouse=True)
def spy(monkeypatch) -> Iterator[None]:
    monkeypatch.setitem(KNOWN, "spy", Spy)
    Spy.views.clear()
    yield
    Spy.check.clear()
    Spy.views.clear()


def run(*overrides: str, check=None) -> Headless:
    """Run a warehouse and have each look of each bot checked: `check(world, me, neighbours)`."""
    warehouse = load_warehouse(DEMO, [f"bot.sensing_radius_m={RADIUS_M}", *overrides])
    world = warehouse.world(1)
    if check is not None:
        Spy.check.append(lambda me, neighbours: check(world, me, neighbours))
    headless = Headless(world, Policies(bot=PolicyChoice(name="spy")), 1)
    headless.run(LASTS_S)
    return headless


def away(me: Me, other: Neighbour) -> float:
    return math.hypot(other.x - me.x, other.y - me.y)


def test_unblinded_a_bot_is_told_all_about_everything_within_its_radius_and_nothing_beyond() -> None:
    told = {"moving": 0, "contents": 0, "heading": 0}

    def check(world: World, me: Me, neighbours: list[Neighbour]) -> None:
        bots, buckets, contents = world.bots(), world.buckets(), world.snapshot().contents
        distance = np.hypot(bots.x - me.x, bots.y - me.y)
        distance[me.bot] = np.inf
        seen = {other.bot: other for other in neighbours if other.bot >= 0}
        assert set(seen) == set(np.flatnonzero(distance <= RADIUS_M).tolist())
        for bot, other in seen.items():
            assert (other.vx, other.vy, other.heading) == (bots.vx[bot], bots.vy[bot], bots.heading[bot])
            carried = int(bots.bucket[bot])
            assert other.contents == (contents[carried] if carried >= 0 else None)
            told["moving"] += other.vx != 0.0
            told["heading"] += other.heading != 0.0
        distance = np.hypot(buckets.x - me.x, buckets.y - me.y)
        resting = np.flatnonzero((distance <= RADIUS_M) & (buckets.bot < 0))
        there = [other.contents for other in neighbours if other.bot < 0]
        assert there == [contents[bucket] for bucket in resting.tolist()]
        told["contents"] += len(there)

    headless = run(check=check)
    assert all(told.values())
    assert headless.world.statistics()["grabs"] > 0


def test_contents_follow_the_transfers() -> None:
    headless = run("word_station.transfer_s=0.1", "letter_station.transfer_s=0.1")
    assert headless.world.statistics()["letters_dispensed"] > 0
    contents = headless.world.snapshot().contents
    view = Spy.views[-1]
    assert view.contents_of is not None
    assert tuple(dict(view.contents_of(bucket)) for bucket in range(len(contents))) == contents


def test_a_bot_may_be_kept_from_knowing_contents() -> None:
    def check(world: World, me: Me, neighbours: list[Neighbour]) -> None:
        assert all(other.contents is None for other in neighbours)

    run("bot.sensing.contents=false", check=check)
    assert Spy.views[-1].contents_of is None


def test_a_bot_may_be_kept_from_knowing_velocities_of_others_but_it_knows_its_own() -> None:
    moved = []

    def check(world: World, me: Me, neighbours: list[Neighbour]) -> None:
        assert all(other.vx == other.vy == 0.0 for other in neighbours)
        assert (me.vx, me.vy) == (world.bots().vx[me.bot], world.bots().vy[me.bot])
        moved.append(math.hypot(me.vx, me.vy))

    run("bot.sensing.velocities=false", check=check)
    assert max(moved) > 1.0


@pytest.mark.parametrize("angle", [1.0, math.pi])
def test_a_bot_may_be_made_to_see_ahead_only(angle: float) -> None:
    count = {"seen": 0, "hidden": 0}

    def check(world: World, me: Me, neighbours: list[Neighbour]) -> None:
        for other in neighbours:
            dx, dy = other.x - me.x, other.y - me.y
            turn = math.atan2(dy, dx) - me.heading
            off = abs(math.atan2(math.sin(turn), math.cos(turn)))
            assert off <= angle / 2.0 + 1e-6 or away(me, other) < 1e-9
        bots = world.bots()
        within = int(np.count_nonzero(np.hypot(bots.x - me.x, bots.y - me.y) <= RADIUS_M)) - 1
        seen = sum(other.bot >= 0 for other in neighbours)
        count["seen"] += seen
        count["hidden"] += within - seen

    run(f"bot.sensing.view_angle_rad={angle}", check=check)
    assert count["seen"] > 0 and count["hidden"] > 0


def test_a_bot_may_be_made_to_see_only_the_nearest() -> None:
    def check(world: World, me: Me, neighbours: list[Neighbour]) -> None:
        bots, buckets = world.bots(), world.buckets()
        for is_bot, x, y in ((True, bots.x, bots.y), (False, buckets.x[buckets.bot < 0], buckets.y[buckets.bot < 0])):
            distance = np.hypot(x - me.x, y - me.y)
            if is_bot:
                distance[me.bot] = np.inf
            expected = np.sort(distance[distance <= RADIUS_M])[:2]
            seen = sorted(away(me, other) for other in neighbours if (other.bot >= 0) == is_bot)
            assert seen == pytest.approx(expected.tolist())

    run("bot.sensing.nearest=2", check=check)


def test_what_a_blinded_bot_does_not_see_is_not_in_its_arrays_either() -> None:
    run("bot.sensing.nearest=1")
    for view in Spy.views:
        (me,) = view.bot.tolist()
        hidden = np.flatnonzero(view.x == NOWHERE)
        assert len(view.x) - len(hidden) <= 2 and me not in hidden
        assert not view.vx[hidden].any() and not view.state[hidden].any() and (view.bucket[hidden] == -1).all()
        unseen = np.flatnonzero(view.bucket_x == NOWHERE)
        assert len(view.bucket_x) - len(unseen) <= 1 + 2  # a resting one, its own, the one on the other bot
        assert view.contents_of is not None and not any(view.contents_of(bucket) for bucket in unseen.tolist())


def test_bots_that_do_not_hear_of_intentions_think_for_themselves() -> None:
    run("bot.sensing.intentions=false")
    assert {len(view.bot) for view in Spy.views} == {1}
    Spy.views.clear()
    run()
    assert max(len(view.bot) for view in Spy.views) > 1


def test_blinded_bots_drive_worse() -> None:
    def collisions(*overrides: str) -> float:
        world = load_warehouse(DEMO, overrides).world(1)
        Headless(world, Policies(), 1).run(150.0)
        return world.statistics()["bot_collisions"]

    assert collisions() == collisions("bot.sensing.contents=false") == 0
    assert collisions("bot.sensing.velocities=false") > 3
    assert collisions("bot.sensing.view_angle_rad=1.0") > 10
    assert collisions("bot.sensing.nearest=1") > 10
    assert collisions("bot.sensing_radius_m=1.0") > 3


def test_blinded_runs_can_be_repeated() -> None:
    def places() -> list[float]:
        return run("bot.sensing.nearest=3").world.bots().x.tolist()

    assert places() == places()
