"""Plans of the 2023 paper on a floor where nobody is ever in step: boxes are shelved, nobody collides, all go home."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import _environment
from soup_lab.headless import program as headless_cli
from soup_lab.headless.simulation import Headless
from soup_managers.fleets.planned.fleet import PlannedFleet
from soup_managers.fleets.planned.policies import Planned
from soup_managers.planners.check import check_plan, play
from soup_managers.planners.homing import go_home
from soup_managers.planners.known import PLANNERS
from soup_managers.planners.plan import FLEET, Task
from soup_managers.planners.precedence import actions_of
from soup_msgs_py.errors import InputError
from soup_msgs_py.policies import load_policies
from soup_msgs_py.scenario.floor_plan import CellsLayout
from soup_msgs_py.warehouse.cell_world import World, parse_world
from soup_sim.scenario_loader import load_warehouse
from soup_sim.validate import Judge

CONFIG: Path = _environment.ROOT / "config"
POLICIES = load_policies(CONFIG / "policies" / "planned.yaml")
LONGEST_S = 600.0


def drawn(seed: int) -> str:
    """A small world; it need not have a plan."""
    draw = random.Random(seed)
    robots, boxes = draw.randint(1, 4), draw.randint(1, 4)
    width, height = draw.randint(3, 7), draw.randint(3, 7)
    kinds = "@" * robots + "*" * boxes + "|" * (boxes + draw.randint(0, 2)) + "#" * draw.randint(0, 4)
    cells = list(kinds[: width * height].ljust(width * height, "_"))
    draw.shuffle(cells)
    return "\n".join("".join(cells[row * width : (row + 1) * width]) for row in range(height))


def world_of(text: str) -> World | None:
    """The world of a text; None where it is none."""
    try:
        return parse_world(text)
    except InputError:
        return None


def carry_out(text: str, folder: Path, until: float = LONGEST_S) -> Headless:
    """Run a world's plan; its fleet has done all that it says, and nobody has broken a law."""
    file = folder / "world.txt"
    file.write_text(text)
    run = start(file)
    judge = Judge(run.world.scenario, run.world.layout, run.world.snapshot())
    run._on_event = judge.event
    finish(run, until)
    judge.finish(run.world.snapshot())
    assert judge.violations == []
    return run


def start(file: Path) -> Headless:
    return Headless(load_warehouse(file).world(0), POLICIES, 0)


def finish(run: Headless, until: float = LONGEST_S) -> None:
    fleet: Any = run.fleet
    while not fleet.is_done and run.world.now < until:
        run.run(run.world.now + 5.0)
    assert fleet.is_done, (fleet._done, [len(actions) for actions in fleet._actions])


def at_home(run: Headless) -> list[bool]:
    """Which bots stand where they began."""
    bots, layout = run.world.bots(), run.world.scenario.layout
    assert isinstance(layout, CellsLayout)
    homes = run.world.layout.waypoints[np.searchsorted(layout.world.open_cells, layout.world.robots)]
    return (np.hypot(bots.x - homes[:, 0], bots.y - homes[:, 1]) < 0.1).tolist()


def all_shelved(run: Headless) -> bool:
    """Whether each bucket rests on a shelf of its own."""
    snapshot, layout = run.world.snapshot(), run.world.scenario.layout
    assert isinstance(layout, CellsLayout)
    shelves = run.world.layout.waypoints[np.searchsorted(layout.world.open_cells, layout.world.shelves)]
    places = np.stack([snapshot.buckets.x, snapshot.buckets.y], axis=1)
    away = np.hypot(*(places[:, None] - shelves[None]).transpose(2, 0, 1))
    used = away.argmin(axis=1).tolist()
    return bool((away.min(axis=1) < 0.2).all()) and len(set(used)) == len(used) and max(snapshot.buckets.bot) < 0


def test_the_papers_world_is_carried_out(tmp_path: Path):
    run = carry_out((CONFIG / "worlds" / "medium1.txt").read_text(), tmp_path)
    figures = run.world.statistics()
    assert figures["grabs"] == figures["releases"] == 4
    assert figures["bot_collisions"] == figures["bucket_collisions"] == 0
    assert all_shelved(run) and all(at_home(run))


@settings(max_examples=60, derandomize=True, deadline=None)
@given(seed=st.integers(0, 10**9))
def test_whatever_the_world_boxes_are_shelved_and_nobody_collides(tmp_path_factory: pytest.TempPathFactory, seed: int):
    text = drawn(seed)
    world = world_of(text)
    assume(world is not None)
    assert world is not None
    assume(PLANNERS["optimal"](Task(world, FLEET)).plans is not None)
    run = carry_out(text, tmp_path_factory.mktemp("world"))
    figures = run.world.statistics()
    assert figures["bot_collisions"] == figures["bucket_collisions"] == 0
    assert all_shelved(run)


@settings(max_examples=60, derandomize=True, deadline=None)
@given(seed=st.integers(0, 10**9))
def test_going_home_changes_no_work(seed: int):
    world = world_of(drawn(seed))
    assume(world is not None)
    assert world is not None
    plans = PLANNERS["optimal"](Task(world, FLEET)).plans
    assume(plans is not None)
    assert plans is not None
    home = go_home(world, plans)
    assert check_plan(world, home, carries_over=False) == check_plan(world, plans, carries_over=False)
    *_, end = play(world, home, may_wait=True)
    stays = [place for place, start in zip(end.robots, world.robots, strict=True) if place != world.place(start)]
    for x, y in stays:  # then it could not get there, or had nothing to do at all
        assert 0 <= x < world.width and 0 <= y < world.height


RING = """\
@@_*_|
@@____
______"""


def test_bots_that_move_into_each_others_cells_do_it_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    plans = ("RWWWWWWW", "DRRUPRRP", "UWWWWWWW", "LWWWWWWW")
    world = parse_world(RING)
    check_plan(world, plans)
    rings = [action.ring for actions in actions_of(world, plans) for action in actions if action.ring]
    assert len(rings) == 4 and all(sorted(ring) == [0, 1, 2, 3] for ring in rings)
    monkeypatch.setattr(Planned, "plan", lambda self, world: plans)
    run = carry_out(RING, tmp_path)
    figures = run.world.statistics()
    assert figures["bot_collisions"] == 0 and all_shelved(run)


def test_a_bot_whose_mind_dies_delays_the_others_and_nothing_else():
    run = start(CONFIG / "worlds" / "medium1.txt")
    for k in range(1, 8):
        run.run(5.0 * k)
        run.kill([k % 2], noticed=k % 3 > 0)
        run.run(run.world.now + 3.0)
        run.revive([k % 2])
    finish(run)
    figures = run.world.statistics()
    assert figures["bot_collisions"] == figures["bucket_collisions"] == 0
    assert all_shelved(run) and all(at_home(run))
    assert isinstance(run.fleet, PlannedFleet)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--fleet-policy", "planned"], "layout of kind rows"),
        (["--scenario", "WORLD", "--set", "bots=3"], "bots: found 3; allowed: 1, as the world of cells has it"),
        (["--scenario", "WORLD"], "there is no plan"),
        (["--scenario", "EMPTY"], "an empty file"),
        (["--scenario", "NOTHING"], "no box"),
    ],
)
def test_a_mistake_is_told_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], told: str
):
    files = {"WORLD": "@_*_#|\n_____#\n", "EMPTY": "", "NOTHING": "@_|\n"}
    for name, text in files.items():
        (tmp_path / f"{name}.txt").write_text(text)
    given = [str(tmp_path / f"{text}.txt") if text in files else text for text in arguments]
    assert headless_cli.main(["--duration", "5", *given]) == 2
    (line,) = [line for line in capsys.readouterr().err.splitlines() if "found" in line]
    assert told in line
