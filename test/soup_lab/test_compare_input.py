"""What is wrong with an experiment file is told in one line before anything runs."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from soup_lab.experiments.experiment import load_experiment
from soup_lab.experiments.program import main
from soup_msgs_py.errors import InputError

ROOT = Path(__file__).parents[2]
EXPERIMENTS = sorted((ROOT / "config/experiments").glob("*.yaml"))
GOOD: dict[str, Any] = {
    "name": "tiny",
    "scenario": str(ROOT / "config/scenarios/demo.yaml"),
    "policies": str(ROOT / "config/policies/best.yaml"),
    "duration_s": 60,
    "seeds": [1, 2],
    "variants": [{"group": "words", "variants": [{"name": "oldest", "policies": {"word": "minimal"}}]}],
}
NOTHING = object()


def written(folder: Path, **changes: Any) -> Path:
    """An experiment file like the good one but for some keys."""
    path = folder / "experiment.yaml"
    data = {key: value for key, value in {**GOOD, **changes}.items() if value is not NOTHING}
    path.write_text(yaml.safe_dump(data))
    return path


def variant(**keys: Any) -> dict[str, Any]:
    """The keys of an experiment with one variant."""
    return {"variants": [{"group": "g", "variants": [{"name": "v", **keys}]}]}


# what is changed in the file, the key that the line names, what it says was found, what it says is allowed
WRONG = [
    ({"name": NOTHING}, "name", "nothing", "required"),
    ({"name": 7}, "name", "7", "string"),
    ({"duration": 60}, "duration", "an unknown key", "duration_s (did you mean it?)"),
    ({"duration_s": 0}, "duration_s", "0", "greater than 0"),
    ({"duration_s": "1 h"}, "duration_s", "'1 h'", "number"),
    ({"warmup_s": -1}, "warmup_s", "-1", "greater than or equal to 0"),
    ({"warmup_s": 60}, "warmup_s", "60", "less than duration_s, 60"),
    ({"seeds": NOTHING}, "seeds", "neither seeds nor replications", "one of them"),
    ({"replications": 3}, "seeds", "seeds and replications", "one of them"),
    ({"seeds": [1, 2, 1]}, "seeds", "1 twice", "each seed once"),
    ({"seeds": []}, "seeds", "[]", "at least 1"),
    ({"seeds": [-1]}, "seeds.0", "-1", "greater than or equal to 0"),
    ({"seeds": NOTHING, "replications": 0}, "replications", "0", "greater than or equal to 1"),
    ({"set": 3}, "set", "3", "dotted keys with values"),
    ({"set": {"robots": 3}}, "set.robots", "an unknown key", "bots"),
    ({"variants": []}, "variants", "[]", "at least 1"),
    ({"variants": {"words": []}}, "variants", "{'words': []}", "list"),
    ({"variants": [{"variants": []}]}, "variants.0.group", "nothing", "required"),
    ({"variants": [{"group": "g", "variants": []}]}, "variants.g.variants", "[]", "at least 1"),
    ({"variants": [{**GOOD["variants"][0], "abuot": ""}]}, "variants.words.abuot", "an unknown key", "about (did you"),
    ({"variants": GOOD["variants"] * 2}, "variants.words", "the group twice", "each group once"),
    (
        {"variants": [{"group": "g", "variants": [{"name": "v"}, {"name": "v"}]}]},
        "variants.g.v",
        "the variant twice",
        "each name once",
    ),
    (variant(policy="minimal"), "variants.g.v.policy", "an unknown key", "policies (did you mean it?)"),
    (variant(policies=3), "variants.g.v.policies", "3", "{word: minimal}, or the name of a file"),
    (variant(scenario=["bots"]), "variants.g.v.scenario", "['bots']", "{bots: 150}, or the name of a file"),
    (variant(scenario={"bot..radius_m": 1}), "variants.g.v.scenario", "the key 'bot..radius_m'", "dotted keys"),
    (variant(scenario={4: 1}), "variants.g.v.scenario", "the key 4", "dotted keys"),
    (variant(policies={"wrd": "minimal"}), "variants.g.v.policies.wrd", "an unknown key", "word (did you mean it?)"),
    (variant(policies={"word": "psychic"}), "variants.g.v.policies", "'psychic'", "minimal, served"),
    (variant(policies={"word": 5}), "variants.g.v.policies.word", "5", ""),
    (
        variant(policies={"fleet.options.bukets": "first"}),
        "variants.g.v.policies.coordinated.options.bukets",
        "an unknown key",
        "buckets",
    ),
    (variant(policies={"fleet.options.buckets": "worst"}), "variants.g.v.policies", "'worst'", "first"),
    (
        variant(policies={"fleet.options.buckets.options.speed": 1}),
        "variants.g.v.policies.most_tiles_per_second.options.speed",
        "an unknown key",
        "travel_weight",
    ),
    (variant(policies={"word": "mine.py:Mine"}), "variants.g.v.policies", "no file", "a Python file"),
    (variant(scenario={"bots": 0}), "variants.g.v.scenario.bots", "0", "greater than or equal to 1"),
    (variant(scenario={"bots": 3.5}), "variants.g.v.scenario.bots", "3.5", "integer"),
    (variant(scenario={"robots": 3}), "variants.g.v.scenario.robots", "an unknown key", "bots"),
    (variant(scenario={"bots.many": 3}), "variants.g.v.scenario.bots.many", "a value at 'bots'", "mappings"),
    (variant(scenario={"buckets": 5000}), "variants.g.v.scenario.buckets", "5000 buckets", "at most"),
    (variant(scenario={"words": "no.txt"}), "variants.g.v.scenario.words", "no.txt", ""),
]


@pytest.mark.parametrize(("changes", "key", "found", "allowed"), WRONG, ids=lambda part: str(part)[:40])
def test_a_mistake_names_the_file_the_key_what_was_found_and_what_is_allowed(
    tmp_path: Path, changes: dict[str, Any], key: str, found: str, allowed: str
):
    path = written(tmp_path, **changes)
    with pytest.raises(InputError) as told:
        load_experiment(path)
    error = told.value
    assert error.source == str(path)
    assert error.key.startswith(key)
    assert found in error.found
    assert allowed in f"{error.found} {error.allowed}"
    assert "\n" not in str(error)


@pytest.mark.parametrize("key", ["scenario", "policies"])
@pytest.mark.parametrize("of", ["the base", "a variant"])
def test_a_file_that_is_not_there_is_named(tmp_path: Path, key: str, of: str):
    changes = {key: "no.yaml"} if of == "the base" else variant(**{key: "no.yaml"})
    with pytest.raises(InputError) as told:
        load_experiment(written(tmp_path, **changes))
    assert str(told.value) == (
        f"{tmp_path / 'no.yaml'}: found No such file or directory; allowed: a YAML file of `key: value` lines"
    )


def test_the_same_mistake_on_the_command_line_ends_with_status_2_and_nothing_is_written(tmp_path: Path):
    path = written(tmp_path, duration_s=-5)
    program = [sys.executable, str(ROOT / "scripts/compare_policies.py"), str(path), "--out", str(tmp_path / "out")]
    ended = subprocess.run(program, capture_output=True, text=True, check=False)
    line = f"{path}: duration_s: found -5; allowed: greater than 0\n"
    assert (ended.returncode, ended.stdout, ended.stderr) == (2, "", line)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--replications", "0"], "--replications: found '0'"),
        (["--processes", "many"], "--processes: found 'many'"),
        (["--processes", "2", "--scheduler", "tcp://here:8786"], "--processes: found --scheduler too"),
        (["--fast"], "--fast"),
    ],
)
def test_a_wrong_option_is_told_in_one_line(arguments: list[str], told: str, capsys: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit) as ended:
        main(["experiment.yaml", *arguments])
    assert ended.value.code == 2
    err = capsys.readouterr().err
    assert told in err
    assert err.count("\n") == 1


def test_results_cannot_go_where_a_file_is(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    path = written(tmp_path)
    assert main([str(path), "--out", str(path)]) == 2
    assert capsys.readouterr().err == (f"--out: found {path}: File exists; allowed: a folder that can be written\n")


def test_a_cluster_that_does_not_answer_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("soup_lab.experiments.runs.CONNECT_S", 0.5)
    assert main([str(written(tmp_path)), "--out", str(tmp_path / "out"), "--scheduler", "tcp://127.0.0.1:9"]) == 2
    assert "--scheduler: found no scheduler at tcp://127.0.0.1:9; allowed:" in capsys.readouterr().err


@pytest.mark.parametrize("path", EXPERIMENTS, ids=lambda path: path.stem)
def test_the_experiments_that_come_with_the_warehouse_are_right(path: Path):
    experiment = load_experiment(path)
    assert experiment.base.name == "best"
    assert all(experiment.base.digest in {case.digest for case in experiment.shown(g)} for g in experiment.groups)


def test_a_variant_that_says_what_the_base_does_is_the_base(tmp_path: Path):
    groups = [
        {"group": "a", "variants": [{"name": "same", "policies": {"word": "served"}}, {"name": "all", "scenario": {}}]},
        {"group": "b", "variants": [{"name": "other", "policies": {"word": "minimal"}}]},
        {"group": "c", "variants": [{"name": "it again", "policies": {"word": {"name": "minimal"}}}]},
    ]
    experiment = load_experiment(written(tmp_path, variants=groups))
    assert [case.name for case in experiment.cases()] == ["best", "other"]
    assert [[c.name for c in experiment.shown(g)] for g in experiment.groups] == [
        ["same", "all"],
        ["best", "other"],
        ["best", "it again"],
    ]


def test_dotted_keys_go_through_policies_that_are_only_named(tmp_path: Path):
    change = {"fleet.options.storage.options.weight": 2.0, "fleet.options.bots": "first"}
    experiment = load_experiment(written(tmp_path, **variant(policies=change)))
    fleet = experiment.groups[0].cases[0].plan.policies.fleet
    assert fleet.name == "coordinated"
    assert fleet.options["storage"] == {"name": "near_words", "options": {"weight": 2.0}}
    assert fleet.options["bots"] == "first"
    assert fleet.options["buckets"] == experiment.base.plan.policies.fleet.options["buckets"]


def test_files_that_a_variant_names_are_relative_to_the_experiment(tmp_path: Path):
    (tmp_path / "mine.txt").write_text("soup\nladle\n")
    (tmp_path / "mine.py").write_text(
        "from soup_managers.policies.word import Minimal\nclass Mine(Minimal):\n    '''Mine.'''\n"
    )
    change = variant(scenario={"words": "mine.txt"}, policies={"word": "mine.py:Mine"})
    case = load_experiment(written(tmp_path, **change)).groups[0].cases[0]
    assert case.plan.warehouse.scenario.words == str(tmp_path / "mine.txt")
    assert case.plan.policies.word.name == f"{tmp_path / 'mine.py'}:Mine"


def test_runs_are_other_runs_when_a_file_that_they_read_has_changed(tmp_path: Path):
    words, path = tmp_path / "mine.txt", written(tmp_path, **variant(scenario={"words": "mine.txt"}))
    digests = []
    for text in ("soup\n", "soup\n", "stew\n"):
        words.write_text(text)
        digests.append(load_experiment(path).groups[0].cases[0].digest)
    assert digests[0] == digests[1] != digests[2]


@pytest.mark.parametrize(
    ("seeds", "wanted", "run"),
    [([4, 9], None, (4, 9)), ([4, 9], 1, (4,)), ([9, 4], 4, (9, 4, 10, 11)), (None, None, (1, 2, 3))],
)
def test_replications_take_the_seeds_of_the_file_first(
    tmp_path: Path, seeds: list[int] | None, wanted: int | None, run: tuple[int, ...]
):
    changes = {"seeds": seeds} if seeds else {"seeds": NOTHING, "replications": 3}
    assert load_experiment(written(tmp_path, **changes), wanted).seeds == run
