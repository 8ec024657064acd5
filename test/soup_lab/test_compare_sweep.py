"""A sweep from its file to its report; stopped, and gone on with."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import psutil
import pytest
import yaml
from distributed import LocalCluster

from soup_lab.experiments.experiment import load_experiment
from soup_lab.experiments.program import main
from soup_lab.experiments.runs import OtherCodeError, attempt, jobs, run_local
from soup_lab.experiments.store import Store
from soup_lab.headless import pool
from soup_msgs_py.errors import InputError
from soup_msgs_py.figures import told, with_interval

pytestmark = pytest.mark.timeout(400)  # each sweep starts processes, which a busy machine is slow at

ROOT = Path(__file__).parents[2]
PATIENCE_S = 120.0
WALL = ("wall_seconds", "real_time_factor")  # all that may differ between two runs
TINY: dict[str, Any] = {
    "name": "tiny <sweep>",
    "about": "Of [seconds] & no more.",
    "scenario": str(ROOT / "config/scenarios/demo.yaml"),
    "policies": str(ROOT / "config/policies/minimal.yaml"),
    "warmup_s": 60,
    "duration_s": 300,
    "seeds": [1, 2],
    "variants": [
        {
            "group": "bots",
            "variants": [{"name": f"{n} bots", "scenario": {"bots": n}} for n in (3, 6, 20)],
        },
        {"group": "words", "variants": [{"name": "served", "policies": {"word": "served"}}]},
    ],
}
RUNS = 8  # base (which is also 20 bots), 3 bots, 6 bots, served; each with two seeds


def written(folder: Path, **changes: Any) -> Path:
    path = folder / "tiny.yaml"
    path.write_text(yaml.safe_dump({**TINY, **changes}, sort_keys=False))
    return path


def results(out: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (out / "results.jsonl").read_text().splitlines()]


def timeless(out: Path) -> list[dict[str, Any]]:
    """All results without wall times."""
    lines = results(out)
    for line in lines:
        line["summary"] = {key: value for key, value in line["summary"].items() if key not in WALL}
    return lines


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A sweep that has been run: its file and its results. Not to be changed."""
    folder = tmp_path_factory.mktemp("sweep")
    assert main([str(written(folder)), "--out", str(folder / "out"), "--processes", "2"]) == 0
    return folder / "tiny.yaml", folder / "out"


@pytest.fixture
def copy(done: tuple[Path, Path], tmp_path: Path) -> tuple[Path, Path]:
    """The same, to be changed."""
    out = tmp_path / "out"
    out.mkdir()
    (out / "results.jsonl").write_bytes((done[1] / "results.jsonl").read_bytes())
    return written(tmp_path), out


class Page(HTMLParser):
    """What the tests want to know of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.sources: list[str] = []
        self.links: list[str] = []
        self.texts: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.sources += [value or "" for key, value in attrs if key == "src"]
        self.links += [value or "" for key, value in attrs if key == "href"]
        if tag not in ("meta", "img"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def test_each_different_run_is_made_once(done: tuple[Path, Path]):
    lines = results(done[1])
    assert [(line["variant"], line["seed"]) for line in lines] == [
        (label, seed) for seed in (1, 2) for label in ("minimal", "bots: 3 bots", "bots: 6 bots", "words: served")
    ]
    assert {line["summary"]["bots"] for line in lines} == {3, 6, 20}


def test_figures_for_other_programs_hold_intervals_and_paired_differences(done: tuple[Path, Path]):
    figures = json.loads((done[1] / "figures.json").read_text())
    rates = {(line["variant"], line["seed"]): line["summary"]["words_per_second"] for line in results(done[1])}
    assert figures["seeds"] == [1, 2]
    assert figures["base"]["is_base"]
    three, _, twenty = figures["groups"]["bots"]
    expected = sum(rates["bots: 3 bots", seed] - rates["minimal", seed] for seed in (1, 2)) / 2
    assert three["words_per_second_to_base"]["mean"] == pytest.approx(expected)
    assert three["totals"] == {"bot_collisions": 0, "bucket_collisions": 0, "violations": 0}
    assert twenty["is_base"]
    assert twenty["figures"] == figures["base"]["figures"]
    assert [row["variant"] for row in figures["groups"]["words"]] == ["minimal", "served"]


def test_the_report_is_one_file_that_can_be_repeated_from(done: tuple[Path, Path]):
    path, out = done
    text = (out / "report.html").read_text()
    page = Page(text)
    said = "".join(page.texts)
    assert page.open == []
    assert page.links == []
    assert len(page.sources) == 3  # the overview, and a chart for each group
    assert all(source.startswith("data:image/svg+xml;base64,") for source in page.sources)
    assert "<sweep>" not in text
    assert "Of [seconds] & no more." in said
    assert path.read_text() in said
    assert (ROOT / "config/scenarios/demo.yaml").read_text() in said
    assert "1, 2, the same for all variants" in said
    for version in json.loads((out / "figures.json").read_text())["versions"].values():
        assert version in said


def test_the_table_for_a_readme_has_a_line_for_each_variant(done: tuple[Path, Path]):
    lines = (done[1] / "table.md").read_text().splitlines()
    assert [line.split("|")[2].strip() for line in lines[2:7]] == [
        "3 bots", "6 bots", "20 bots (base)", "minimal (base)", "served",
    ]  # fmt: skip
    assert len({line.count("|") for line in lines[:7]}) == 1


def test_the_table_is_written_as_other_tables_are(done: tuple[Path, Path]):
    figures = json.loads((done[1] / "figures.json").read_text())
    row = figures["groups"]["bots"][0]["figures"]
    rate, bound = row["words_per_second"], row["fraction_of_bound"]
    cells = [cell.strip() for cell in (done[1] / "table.md").read_text().splitlines()[2].split("|")]
    assert cells[3] == with_interval(rate["mean"], rate["half_width"])
    assert cells[5] == f"{told('fraction_of_bound', bound['mean'])} ({told('fraction_of_bound', bound['lowest'])})"
    assert cells[6] == told("pile_on_word", row["pile_on_word"]["mean"])


def test_the_same_sweep_gives_the_same_results_whatever_the_order_of_the_runs(done: tuple[Path, Path], tmp_path: Path):
    assert main([str(done[0]), "--out", str(tmp_path), "--processes", "1"]) == 0
    assert timeless(tmp_path) == timeless(done[1])


def test_a_sweep_that_is_whole_runs_nothing_and_gives_the_same_report(
    copy: tuple[Path, Path], done: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
):
    before = (copy[1] / "results.jsonl").read_bytes()
    assert main([str(done[0]), "--out", str(copy[1])]) == 0
    assert f"{RUNS} runs, of which {RUNS} are done already\n" in capsys.readouterr().err
    assert (copy[1] / "results.jsonl").read_bytes() == before
    for file in ("report.html", "table.md", "figures.json"):
        assert (copy[1] / file).read_bytes() == (done[1] / file).read_bytes()


def test_an_interrupted_sweep_runs_only_what_is_missing(
    copy: tuple[Path, Path], done: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
):
    path, out = copy
    lines = (out / "results.jsonl").read_text().splitlines(keepends=True)
    torn = lines[6][: len(lines[6]) // 2]
    (out / "results.jsonl").write_text("".join([*lines[:3], *lines[4:6], torn]))
    assert main([str(path), "--out", str(out), "--processes", "1"]) == 0
    told = capsys.readouterr()
    assert f"{RUNS} runs, of which 5 are done already\n" in told.err
    assert told.err.count("words/s") == 3
    assert [line["run"] for line in results(out)] == [line["run"] for line in results(done[1])]
    assert timeless(out) == timeless(done[1])


def test_results_of_other_settings_or_code_are_kept_but_not_used(
    copy: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    path, out = copy
    written(path.parent, duration_s=310)
    monkeypatch.setattr("soup_lab.experiments.program.run_local", lambda todo, processes: (_ for _ in ()))
    main([str(path), "--out", str(out)])
    assert f"{RUNS} runs; {RUNS} others, of other settings, seeds or code, are kept" in capsys.readouterr().err
    written(path.parent)
    monkeypatch.setattr("soup_lab.experiments.runs.code_digest", lambda: "another")
    main([str(path), "--out", str(out)])
    assert f"{RUNS} runs; {RUNS} others, of other settings, seeds or code, are kept" in capsys.readouterr().err
    assert len(results(out)) == RUNS


def test_two_sweeps_do_not_write_into_one_folder(tmp_path: Path):
    with Store(tmp_path), pytest.raises(InputError, match="--out: found another sweep at work in"):
        Store(tmp_path)
    with Store(tmp_path):
        pass


def test_lines_that_are_no_results_are_passed_over(tmp_path: Path):
    whole = '{"run": "a", "variant": "v", "seed": 1, "summary": {"seed": 1}}'
    (tmp_path / "results.jsonl").write_text(f'no JSON\n[1]\n{{"run": 3, "summary": {{}}}}\n{whole}\n{{"run"')
    with Store(tmp_path) as store:
        assert len(store) == 1
        store.add("b", "w", {"seed": 2})
    with Store(tmp_path) as store:
        assert store.get("a") == {"seed": 1}
        assert store.get("b") == {"seed": 2}


def test_a_policy_that_fails_is_told_and_the_others_go_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    (tmp_path / "mine.py").write_text(
        "from soup_managers.policies.word import Minimal\n"
        "class Mine(Minimal):\n"
        "    def choose(self, view, stations, rng):\n"
        "        raise KeyError('my own\\nmistake')\n"
    )
    groups = [{"group": "words", "variants": [{"name": "mine", "policies": {"word": "mine.py:Mine"}}]}]
    path = written(tmp_path, variants=groups, seeds=[1], duration_s=90)
    out = tmp_path / "out"
    assert main([str(path), "--out", str(out), "--processes", "1"]) == 1
    told = capsys.readouterr()
    assert "words: mine, seed 1: failed: a policy failed: KeyError: 'my own\\nmistake' (" in told.err
    assert "mine (1 of 1 runs failed)" in " ".join(told.out.split())
    assert [line["variant"] for line in results(out)] == ["minimal"]
    assert "in choose" in (out / "failures.txt").read_text()
    assert "Runs that failed" in (out / "report.html").read_text()


def test_a_worker_with_other_code_runs_nothing(done: tuple[Path, Path]):
    experiment = load_experiment(done[0])
    with pytest.raises(OtherCodeError):
        attempt(experiment.base.plan, 1, "another")


def test_code_that_changes_while_the_sweep_starts_makes_it_start_again(
    copy: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    real = run_local
    starts: list[int] = []

    def changed_once(todo: Any, processes: Any) -> Any:
        starts.append(len(todo))
        if len(starts) == 1:
            raise OtherCodeError
        yield from real(todo, processes)

    monkeypatch.setattr("soup_lab.experiments.program.run_local", changed_once)
    assert main([str(copy[0]), "--out", str(copy[1])]) == 0
    assert "the code changed while the sweep was starting; it starts again with the new code" in capsys.readouterr().err
    assert len(starts) == 2


def test_a_cluster_of_dask_gives_the_same_results(done: tuple[Path, Path], tmp_path: Path):
    small: Any = {"n_workers": 1, "threads_per_worker": 1, "host": "127.0.0.1", "dashboard_address": None}
    cluster: Any
    with LocalCluster(**small) as cluster:
        status = main([str(done[0]), "--out", str(tmp_path), "--scheduler", cluster.scheduler_address])
    assert status == 0
    assert timeless(tmp_path) == timeless(done[1])


def test_a_process_that_is_killed_is_told_and_what_was_done_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    path = written(tmp_path, duration_s=20_000, seeds=[1])
    real = pool.ProcessPoolExecutor

    def doomed(*arguments: Any, **options: Any) -> Any:
        executor = real(*arguments, **options)
        executor.submit(os._exit, 9)
        return executor

    monkeypatch.setattr(pool, "ProcessPoolExecutor", doomed)
    assert main([str(path), "--out", str(tmp_path / "out")]) == 1
    assert capsys.readouterr().err.endswith(
        f"; run the same command again to continue with what is in {tmp_path / 'out'}\n"
    )


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL], ids=["Ctrl-C", "killed"])
def test_a_sweep_that_is_stopped_leaves_no_process_and_goes_on_later(tmp_path: Path, number: signal.Signals):
    path, out = written(tmp_path, duration_s=50_000, seeds=[1], warmup_s=0), tmp_path / "out"
    program = "import sys; from soup_lab.experiments.program import main; sys.exit(main(sys.argv[1:]))"
    command = [sys.executable, "-c", program, str(path), "--out", str(out), "--processes", "2"]
    workers: list[psutil.Process] = []
    process = subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
    try:
        starter = psutil.Process(process.pid)
        deadline = time.monotonic() + PATIENCE_S
        while process.poll() is None and len(workers := starter.children(recursive=True)) < 2:
            assert time.monotonic() < deadline, "the sweep does not start"
            time.sleep(0.1)
        assert process.poll() is None, process.communicate()[1]
        process.send_signal(number)
        _, err = process.communicate(timeout=PATIENCE_S)
    finally:
        process.kill()
        process.wait()
    _, alive = psutil.wait_procs(workers, timeout=PATIENCE_S)
    assert alive == []
    if number is signal.SIGINT:
        assert process.returncode == 130
        assert (
            err.splitlines()[-1]
            == f"stopped before the end; run the same command again to continue with what is in {out}"
        )
    with Store(out):
        pass  # nobody holds it


def test_the_small_experiment_that_comes_with_the_warehouse_runs(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    path = ROOT / "config/experiments/small.yaml"
    assert main([str(path), "--out", str(tmp_path), "--replications", "1"]) == 0
    said = capsys.readouterr().out
    for name in ("best (base)", "oldest word", "minimal", "6 bots", "20 bots (base)"):
        assert name in said
    rates = {line["variant"]: line["summary"]["words_per_second"] for line in results(tmp_path)}
    assert len(rates) == 7
    assert rates["best"] > 2 * rates["decisions: minimal"]


def test_jobs_are_made_seed_by_seed(done: tuple[Path, Path]):
    assert [job.seed for job in jobs(load_experiment(done[0]))] == [1] * 4 + [2] * 4
