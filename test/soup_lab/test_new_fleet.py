"""A fleet manager dies in the middle of a run, and another one takes over what bots and buckets are left as."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bare_floor import Nobody
from successor import takes_over

import _environment
from soup_lab.headless.simulation import Headless, make_minds
from soup_managers.fleets.make import make_fleet
from soup_managers.fleets.planned.fleet import PlannedFleet
from soup_managers.state.robots import Activity
from soup_managers.view import WarehouseView
from soup_msgs_py import messages as m
from soup_msgs_py.codes import Code, EventType, Phase
from soup_msgs_py.mind import Message
from soup_msgs_py.policies import Policies, load_policies
from soup_sim.scenario_loader import load_warehouse

CONFIG: Path = _environment.ROOT / "config"
COLLISIONS = frozenset({EventType.BOT_COLLISION, EventType.BUCKET_COLLISION})
BEHIND_S = 0.5  # who drives so close behind cannot brake any more
POLICIES = load_policies(CONFIG / "policies" / "best.yaml")


def take_over(run: Headless, pause_s: float, policies: Policies = POLICIES) -> None:
    """Kill the fleet manager; after a while, during which bots do what they were asked for, there is another one."""
    world = run.world
    tasks = run.fleet.tasks()
    run.replace("fleet", Nobody())
    run.run(world.now + pause_s)
    policy = make_minds(policies).fleet
    view = WarehouseView(world.scenario, world.layout)
    fleet = make_fleet(world.scenario, world.layout, policy, view, np.random.default_rng(1))
    takes_over(run, "fleet", fleet, tasks)


def demo(bots: int, seed: int, on_event: Callable[[m.Event], None] | None = None) -> Headless:
    """The demonstration with another number of bots, about to begin."""
    warehouse = load_warehouse(CONFIG / "scenarios" / "demo.yaml", [f"bots={bots}"])
    return Headless(warehouse.world(seed), POLICIES, seed, on_event=on_event)


def all_is_well(run: Headless) -> None:
    """Nobody has collided, nobody is left alone, and words were completed."""
    figures = run.world.statistics()
    assert figures["bot_collisions"] == figures["bucket_collisions"] == 0
    assert figures["words_completed"] > 0
    assert not run.fleet.stalled


@pytest.mark.parametrize("pause_s", [0.0, 4.0, 30.0])
@pytest.mark.parametrize("seed", [1])
def test_nobody_collides_and_words_go_on(seed: int, pause_s: float):
    run = demo(24, seed)
    before = 0
    for k in range(1, 5):
        run.run(150.0 * k)
        words = run.world.statistics()["words_completed"]
        assert words > before
        before = words
        take_over(run, pause_s)
    run.run(750.0)
    figures = run.world.statistics()
    assert figures["words_completed"] > before
    assert figures["bot_collisions"] == figures["bucket_collisions"] == 0


@pytest.mark.parametrize("seed", [1, 2])
def test_nobody_runs_into_those_whom_somebody_else_has_stopped_on_their_way(seed: int):
    run = demo(40, seed)
    for k in range(1, 13):
        run.run(20.0 * k)
        for bot, mind in run.crew.minds.items():
            run.tell(run.crew, m.CancelDrive(bot, mind._drive))
    run.run(400.0)
    all_is_well(run)


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("noticed", [True, False])
@pytest.mark.parametrize("fleet_too", [True, False])
def test_bots_that_are_started_again_on_their_way_are_where_the_fleet_expects_them(
    seed: int, noticed: bool, fleet_too: bool
):
    run = demo(40, seed)
    for k in range(1, 9):
        run.run(40.0 * k)
        some = range(k % 4, 40, 4)
        run.kill(some, noticed=noticed)
        run.run(run.world.now + 1.0)
        run.revive(some)
        if fleet_too:
            take_over(run, 2.0)
    run.run(400.0)
    all_is_well(run)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_new_fleet_knows_at_once_where_everybody_is_though_all_minds_are_new(seed: int):
    run = demo(24, seed)
    for k in range(1, 7):
        run.run(40.0 * k)
        run.kill(range(24), noticed=False)
        run.revive(range(24))
        assert any(mind.phase is Phase.FINISHING for mind in run.crew.minds.values())
        take_over(run, 0.0)
        run.run(run.world.now + 2.0)
        fleet: Any = run.fleet
        assert not any(robot.activity is Activity.UNKNOWN for robot in fleet.state.robots)
    run.run(400.0)
    all_is_well(run)


@pytest.mark.parametrize("seed", [2, 4, 5])
def test_who_does_not_hear_that_it_is_to_stop_still_has_its_way(seed: int, monkeypatch: pytest.MonkeyPatch):
    run = demo(40, seed)
    fleet: Any = run.fleet
    for k in range(1, 9):
        run.run(60.0 * k)
        run.kill(range(k % 4, 40, 4), noticed=False)
        now = run.world.now
        on_its_way = [robot for robot in fleet.state.robots if robot.arrives > now + 5.0]
        deaf = [robot.number for robot in on_its_way if robot.number not in run.crew.minds]
        with monkeypatch.context() as patch:
            patch.setattr(fleet._traffic, "conflicts", lambda bot, _now, deaf=deaf: deaf if bot not in deaf else [])
            fleet._recovery._stop_others(fleet.state.robots[(k + 1) % 4], now)
        run._say(fleet, fleet.step(now))
        assert fleet._recovery.halted.issuperset(deaf)
        run.run(now + 30.0)
        halted = [fleet.state.robots[bot] for bot in fleet._recovery.halted]
        assert not any(robot.activity is Activity.DRIVES for robot in halted)
        run.revive(range(k % 4, 40, 4))
    run.run(700.0)
    all_is_well(run)


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("noticed", [True, False])
def test_nobody_runs_into_dead_bots_that_were_struck_on_their_way(seed: int, noticed: bool):
    collided: list[float] = []
    run = demo(40, seed, lambda event: collided.append(event.time) if event.type in COLLISIONS else None)
    for k in range(1, 17):
        run.run(60.0 * k)
        some, resting = range(k % 4, 40, 4), int((run.world.buckets().bot < 0).nonzero()[0][0])
        run.kill(some, noticed=noticed)
        run.run(run.world.now + 1.0)
        for bot in some:
            if run.world._bodies.moving[bot]:
                run.world._driving._contact(bot, -1 - resting, sys.maxsize)
        run.run(run.world.now + 40.0)
        run.revive(some)
    run.run(1200.0)
    assert len(collided) > 5
    assert all(time % 60.0 < 1.0 + BEHIND_S for time in collided)
    assert not run.fleet.stalled


@pytest.mark.parametrize("pause_s", [0.0, 5.0])
def test_a_plan_is_carried_out_whoever_does_it(pause_s: float):
    warehouse = load_warehouse(CONFIG / "worlds" / "medium1.txt")
    policies = load_policies(CONFIG / "policies" / "planned.yaml")
    run = Headless(warehouse.world(1), policies, 1)
    for k in range(1, 12):
        run.run(max(3.0 * k, run.world.now))
        take_over(run, pause_s, policies)
    run.run(120.0)
    figures = run.world.statistics()
    assert figures["releases"] == figures["grabs"] == 4
    assert figures["bot_collisions"] == figures["bucket_collisions"] == 0
    assert isinstance(run.fleet, PlannedFleet) and run.fleet.is_done


def test_a_bot_that_an_order_never_came_to_is_used_again():
    run = demo(12, 1)
    run.run(60.0)
    handle, lost = run.crew.handle, set()

    def forgetful(message: Message, now: float) -> list[Message]:
        if isinstance(message, m.DriveGoal) and message.bot not in lost:
            lost.add(message.bot)
            return []
        return handle(message, now)

    run.crew.handle = forgetful
    run.run(180.0)
    assert lost
    del run.crew.handle
    run.run(200.0)
    assert not run.fleet.stalled
    figures = run.world.statistics()
    assert figures["bot_collisions"] == figures["bucket_collisions"] == 0


def test_a_goal_that_came_before_its_word_was_opened_is_served_though_the_event_was_lost():
    world = load_warehouse(CONFIG / "scenarios" / "demo.yaml").world(1)
    view = WarehouseView(world.scenario, world.layout)
    fleet = make_fleet(world.scenario, world.layout, make_minds(POLICIES).fleet, view, np.random.default_rng(1))
    fleet.handle(world.snapshot(), 0.0)
    word = world.snapshot().waiting_words[0]
    fleet.handle(m.DeliverGoal(7, 0, word.word, word.tiles), 0.0)
    assert not fleet.tasks()
    world.handle(m.AssignWord(word.word, 0))
    fleet.handle(world.snapshot(), 1.0)
    assert [task.job for task in fleet.tasks()] == [word.word]


def test_bots_that_drive_for_an_earlier_fleet_may_die_once_more():
    run = demo(24, 3)
    for k in range(1, 7):
        run.run(40.0 * k)
        take_over(run, 0.0)
        fleet: Any = run.fleet
        adopted = [robot for robot in fleet.state.robots if robot.adopted]
        assert adopted
        for robot in adopted:
            gone = m.DriveResult(robot.number, robot.order, Code.STOPPED, "who was asked is gone")
            run.tell(run.fleet, gone)
    run.run(400.0)
    figures = run.world.statistics()
    assert figures["bot_collisions"] == figures["bucket_collisions"] == 0
    assert not run.fleet.stalled


@pytest.mark.parametrize("seed", [1, 2])
def test_no_station_is_cut_off_for_good_by_bots_that_did_not_answer_for_a_while(seed: int):
    served: dict[int, float] = {}

    def note(event: m.Event) -> None:
        if event.type is EventType.TRANSFERRED:
            served[event.station] = event.time

    run = demo(36, seed, note)
    for k in range(1, 9):
        run.run(100.0 * k)
        some = range(k % 4, 36, 4)
        run.kill(some, noticed=False)
        run.run(run.world.now + 60.0)
        run.revive(some)
    run.run(1000.0)
    figures = run.world.statistics()
    assert figures["bot_collisions"] == figures["bucket_collisions"] == 0
    assert sorted(station for station, time in served.items() if time > 900.0) == list(range(6))
