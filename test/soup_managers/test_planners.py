"""Joint plans: shortest ones are shortest, all of them keep the rules, and what has no plan is said to have none."""

import random
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from soup_managers.planners.check import BadPlan, check_plan
from soup_managers.planners.known import PLANNERS
from soup_managers.planners.moves import Moves
from soup_managers.planners.plan import DEFAULT, PAPER, Task
from soup_managers.planners.remaining import Remaining
from soup_msgs_py.errors import InputError
from soup_msgs_py.warehouse.cell_world import parse_world, read_world

WORLDS = Path(__file__).resolve().parents[2] / "config/worlds"
# what the paper prints for its medium world; of the second robot's letters an L and a U got lost
PRINTED = "RRDPUULUUURPLLDDDDLLLPUUUPLDRR", "RRDPUULLUURPLDDDDLLPUUURULPL"
MENDED = "RRDPUULLUURPLDDDDLLLPUUURUULPL"


def test_a_robot_that_has_a_box_may_be_the_one_that_comes_for_the_next():
    row = "@" + "_" * 200 + "@" + "*|" * 18
    world = parse_world(row + "\n" + "_" * len(row))
    start = Moves(world, DEFAULT).start
    # the right one has the first box; the left one is far from all others, which have a shelf beside them
    state = start._replace(robots=(0, 202), loads=2, boxes=start.boxes & ~1)
    eight_steps_a_box = 8 * 18
    assert Remaining(world, DEFAULT).of(state)[0] <= eight_steps_a_box


@pytest.mark.parametrize(
    ("name", "default"), [("medium1", 29), ("small1-1r", 32), ("small1-2r", 18), ("small1-3r", 10)]
)
def test_the_papers_worlds_have_plans_of_known_length(name: str, default: int):
    world = read_world(WORLDS / f"{name}.txt")
    for rules, makespan in ((DEFAULT, default), (PAPER, default + 1)):
        answer = PLANNERS["optimal"](Task(world, rules))
        assert answer.proven_optimal and answer.makespan == makespan
        assert answer.plans is not None
        assert check_plan(world, answer.plans, may_wait=rules.may_wait, must_leave=rules.must_leave) == makespan


def test_the_plan_that_the_paper_prints_keeps_its_rules():
    world = read_world(WORLDS / "medium1.txt")
    assert check_plan(world, (PRINTED[0], MENDED), may_wait=False, must_leave=True) == 30
    with pytest.raises(BadPlan, match="no box"):
        check_plan(world, (PRINTED[0], PRINTED[1] + "WW"))


@pytest.mark.parametrize("name", ["multi-action", "single-action"])
@pytest.mark.parametrize("rules", [DEFAULT, PAPER])
def test_the_papers_planners_keep_the_rules(name: str, rules):
    world = read_world(WORLDS / "small1-2r.txt")
    answer = PLANNERS[name](Task(world, rules))
    assert answer.plans is not None and answer.makespan is not None
    length = check_plan(world, answer.plans, may_wait=rules.may_wait or name == "single-action")
    best = PLANNERS["optimal"](Task(world, rules)).makespan
    assert best is not None
    assert answer.makespan >= length
    assert answer.makespan >= best
    assert answer.nodes_generated > answer.nodes_expanded > 0


@settings(max_examples=20, derandomize=True, deadline=None)
@given(seed=st.integers(0, 10**9))
def test_a_plan_for_many_keeps_the_rules(seed: int):
    draw = random.Random(seed)
    width, height, robots, boxes = draw.randint(12, 24), draw.randint(10, 16), draw.randint(2, 12), draw.randint(1, 24)
    rows = [["_"] * width for _ in range(height)]
    block = [
        (x + a, y + b) for y in range(1, height - 2, 4) for x in range(1, width - 2, 4) for a in (0, 1) for b in (0, 1)
    ]
    draw.shuffle(block)
    boxes = min(boxes, len(block))
    for k, (x, y) in enumerate(block):
        rows[y][x] = "|" if k < boxes else draw.choice("|#")
    floor = [(x, y) for y in range(height) for x in range(width) if rows[y][x] == "_"]
    draw.shuffle(floor)
    for k, (x, y) in enumerate(floor[: robots + boxes]):
        rows[y][x] = "@" if k < robots else "*"
    world = parse_world("\n".join(map("".join, rows)))
    answer = PLANNERS["anytime"](Task(world, time_limit_s=0.05))
    assert answer.plans is not None
    assert check_plan(world, answer.plans) == answer.makespan
    assert answer.makespan is not None and answer.makespan >= answer.lower_bound


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "an empty file"),
        ("\n\n", "an empty file"),
        ("_*|\n___", "no robot"),
        ("@**|", "2 boxes and 1 empty shelves"),
        ("@_#*\n|_##", "line 1, column 4: found a box that no robot can reach"),
        ("@_*|\n___", "line 2: found 3 cells"),
        ("@_*|\n\n____", "line 2: found an empty line"),
        ("@x*|", "line 1, column 2: found 'x'"),
    ],
)
def test_what_is_no_world_is_told_in_one_line(text: str, told: str):
    with pytest.raises(InputError) as error:
        parse_world(text, "w.txt")
    assert told in str(error.value) and "\n" not in str(error.value)
    assert str(error.value).startswith("w.txt")


@pytest.mark.parametrize("text", ["@*_#|", "@*_\n###\n|__", "*@*|#|"])
@pytest.mark.parametrize("name", ["optimal", "multi-action", "single-action"])
def test_a_world_without_a_plan_is_proven_to_have_none(text: str, name: str):
    answer = PLANNERS[name](Task(parse_world(text)))
    assert answer.plans is None
    assert answer.lower_bound == float("inf")


@pytest.mark.parametrize(
    ("plans", "told"),
    [
        (("R", "W"), "full shelf"),
        (("D", "W"), "leaves the world"),
        (("P", "W"), "no box"),
        (("W", "X"), "no such action"),
        (("W",), "1 plans for 2 robots"),
        (("W", "WW"), "all robots act"),
    ],
)
def test_the_judge_refuses_what_breaks_a_rule(plans: tuple[str, ...], told: str):
    with pytest.raises(BadPlan, match=told):
        check_plan(parse_world("@#@*|"), plans)


def test_the_judge_keeps_robots_apart():
    world = parse_world("@@*|")
    with pytest.raises(BadPlan, match="change places"):
        check_plan(world, ("R", "L"))
    with pytest.raises(BadPlan, match="in one cell"):
        check_plan(world, ("R", "W"))
