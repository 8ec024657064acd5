"""The planning program: its summary, its pictures, and what it says of bad input."""

import json
import re
from pathlib import Path

import pytest
from matplotlib.text import Annotation

from soup_lab.benchmarks.program import main as measure
from soup_lab.planning.picture import draw_paths
from soup_lab.planning.program import main
from soup_managers.planners.check import play
from soup_managers.planners.optimal import optimal
from soup_managers.planners.plan import Task
from soup_msgs_py.figures import told as figure
from soup_msgs_py.warehouse.cell_world import read_world

WORLD = str(Path(__file__).resolve().parents[2] / "config/worlds/small1-2r.txt")
KEYS = {
    "planner", "rules", "makespan", "proven_optimal", "lower_bound", "gap", "nodes_generated", "nodes_expanded",
    "search_seconds", "robots", "boxes", "plans",
}  # fmt: skip


@pytest.mark.parametrize("planner", ["optimal", "multi-action"])
def test_a_plan_is_told_shown_and_drawn(planner: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    summary, picture = tmp_path / "plan.json", tmp_path / "plan.png"
    assert main([WORLD, "--planner", planner, "--summary", str(summary), "--picture", str(picture), "--show"]) == 0
    told = json.loads(summary.read_text())
    assert set(told) >= KEYS
    assert told["makespan"] == len(told["plans"][0]) == len(told["plans"][1])
    assert picture.stat().st_size > 1000
    out = capsys.readouterr().out
    assert f"step {told['makespan']}" in out and "robot 2: " in out
    assert out.count("@ robot, $ robot with a box, * box, | empty shelf") == 1
    assert "P pick up or put down" in out
    assert f"wrote {picture}\n" in out


def test_the_figures_of_a_plan_have_words(capsys: pytest.CaptureFixture[str]):
    assert main([WORLD]) == 0
    out = capsys.readouterr().out
    assert re.search(r"proven shortest +│ +yes", out) and re.search(r"search time +│ +[\d.e-]+ │ s", out)
    assert "_optimal" not in out


def test_a_picture_says_what_its_signs_are_and_which_way_the_robots_go():
    world = read_world(Path(WORLD))
    plans = optimal(Task(world)).plans
    assert plans is not None
    figure = draw_paths(world, list(play(world, plans, may_wait=True)))
    told = [text.get_text() for text in figure.legends[0].get_texts()]
    assert told == ["wall or full shelf", "empty shelf", "box", "robot, where it begins", "path, in its direction"]
    heads = [(head.xy, head.xyann) for head in figure.axes[0].texts if isinstance(head, Annotation)]
    assert len(heads) >= 2 * len(world.robots)
    assert all(abs(x - u) + abs(y - v) == pytest.approx(0.3) for (x, y), (u, v) in heads)


def test_a_world_without_a_plan_ends_with_status_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    world = tmp_path / "w.txt"
    world.write_text("@*_#|\n")
    assert main([str(world), "--summary", str(tmp_path / "s.json")]) == 1
    assert "proven" in capsys.readouterr().err
    assert json.loads((tmp_path / "s.json").read_text())["plans"] is None


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["no.txt"], "no.txt: found No such file"),
        ([WORLD, "--planner", "best"], "best"),
        ([WORLD, "--weight", "-1"], "a number from 0"),
        ([WORLD, "--weight", "2"], "multi-action"),
        ([WORLD, "--time-limit", "0"], "a number above 0"),
        ([WORLD, "--summary", "nowhere/plan.json"], "a folder that exists"),
        ([WORLD, "--picture", "plan.jpg"], ".png or .gif"),
        ([WORLD, "--planner", "anytime", "--rules", "paper"], "--rules default"),
    ],
)
def test_bad_input_ends_with_status_2(arguments: list[str], told: str, capsys: pytest.CaptureFixture[str]):
    try:
        status = main(arguments)
    except SystemExit as stop:
        status = stop.code
    assert status == 2
    assert told in capsys.readouterr().err


def test_the_planners_are_measured_on_the_papers_worlds(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    picture, summary = tmp_path / "plots.png", tmp_path / "figures.json"
    more = ["--picture", str(picture), "--summary", str(summary)]
    assert measure(["planner", "--time-limit", "0.3", *more]) == 0
    shown = capsys.readouterr().out
    assert "given up" in shown
    assert picture.stat().st_size > 1000
    rows = json.loads(summary.read_text())["planner"]
    assert [row["makespan"] for row in rows if row["planner"] == "optimal"] == [30, 33, 19, 11, 9, 9, 16, 19]
    assert all(f" {figure('search_seconds', row['search_seconds'])} " in shown for row in rows)
