"""What a person wrote wrongly is told in one line: the file, the key, what was found, what is allowed."""

from __future__ import annotations

from pathlib import Path

import pytest

from soup_msgs_py.errors import InputError
from soup_sim.scenario_loader import load_warehouse

ROOT = Path(__file__).parents[2]
DEMO = ROOT / "config/scenarios/demo.yaml"

# what is set, the key that the line names, what it says was found, what it says is allowed
WRONG_VALUES = [
    ("bots=0", "bots", "0", "greater than or equal to 1"),
    ("bots=ten", "bots", "'ten'", "integer"),
    ("bots=1.5", "bots", "1.5", "integer"),
    ("bots=true", "bots", "True", "integer"),
    ("bots=null", "bots", "None", "integer"),
    ("bots=200000", "bots", "200000", "less than or equal"),
    ("bots=2000", "bots", "2000 bots", "at most"),
    ("buckets=97", "buckets", "97 buckets", "at most the 96 storage spots"),
    ("bukets=60", "bukets", "an unknown key", "buckets (did you mean it?)"),
    ("bot.radius_cm=50", "bot.radius_cm", "an unknown key", "radius_m (did you mean it?)"),
    ("bot.radius_m='50 cm'", "bot.radius_m", "'50 cm'", "number"),
    ("bot.radius_m=-1", "bot.radius_m", "-1", "greater than or equal to 0.05"),
    ("bot.radius_m=.nan", "bot.radius_m", "nan", "finite"),
    ("bot.radius_m=.inf", "bot.radius_m", "inf", "finite"),
    ("bot.radius_m=0.75", "layout.pitch_m", "1.5", "more than"),
    ("bot.max_speed_mps=0", "bot.max_speed_mps", "0", "greater than or equal to 0.01"),
    ("bot.max_acceleration_mps2=fast", "bot.max_acceleration_mps2", "'fast'", "number"),
    ("bot.turn_rate_radps=-2", "bot.turn_rate_radps", "-2", "greater than or equal to 0.01"),
    ("bot.grab_s=-0.5", "bot.grab_s", "-0.5", "greater than or equal to 0"),
    ("bot.collision_penalty_s=0", "bot.collision_penalty_s", "0", "greater than or equal to 0.001"),
    ("bot.sensing.view_angle_rad=7", "bot.sensing.view_angle_rad", "7", "less than or equal to 6.28"),
    ("bot.sensing.view_angle_rad=0", "bot.sensing.view_angle_rad", "0", "greater than 0"),
    ("bot.sensing.nearest=0", "bot.sensing.nearest", "0", "greater than or equal to 1"),
    ("bot.sensing.velocities=no!", "bot.sensing.velocities", "'no!'", "boolean"),
    ("bot.sensing.content=false", "bot.sensing.content", "an unknown key", "contents (did you mean it?)"),
    ("bot=12", "bot", "12", "dictionary"),
    ("bucket.capacity=0", "bucket.capacity", "0", "greater than or equal to 1"),
    ("bundle_size=41", "bundle_size", "41 tiles", "at most the capacity of a bucket, 40"),
    ("initial_inventory=70", "initial_inventory", "70", "less than or equal to 1"),
    ("floor.width_m='40 m'", "floor.width_m", "'40 m'", "number"),
    ("floor={width_m: 40.0}", "floor.height_m", "nothing", "required"),
    ("floor={width_m: 6.0, height_m: 6.0}", "floor", "6 by 6 m", ""),
    ("word_stations=[[41.0, 5.0]]", "word_stations.0", "a station at (41, 5)", "a place on the floor"),
    ("word_stations=[[39.9, 5.0]]", "word_stations.0", "a station at (39.9, 5)", "where a bot fits"),
    ("word_stations=[[5.0, 5.0], [5.1, 5.0]]", "word_stations.1", "a station at (5.1, 5)", "or more from"),
    ("word_stations=[[5.0, north]]", "word_stations.0.1", "'north'", "number"),
    ("word_stations=[]", "word_stations", "[]", "at least 1"),
    ("letter_stations=30", "letter_stations", "30 stations", "at most 20"),
    ("word_station.open_words=0", "word_station.open_words", "0", "greater than or equal to 1"),
    ("word_station.transfer_s=-1", "word_station.transfer_s", "-1", "greater than or equal to 0"),
    ("letter_station.staged_bundles=x", "letter_station.staged_bundles", "'x'", "integer"),
    ("colours=[0.8, 0.1]", "colours", "shares that add up to 0.9", "shares that add up to 1"),
    ("colours=[]", "colours", "[]", "at least 1"),
    ("colours={kind: pareto}", "colours.count", "nothing", "required"),
    ("colours={kind: rainbow}", "colours.kind", "'rainbow'", "'pareto'"),
    ("orders={kind: poisson, per_hour: 0}", "orders.per_hour", "0", "greater than or equal to 0.000001"),
    ("orders={kind: poisson, per_hour: 9, daily_profile: [1.0]}", "orders.daily_profile", "[1.0]", "at least 24"),
    ("orders={kind: never}", "orders.kind", "'never'", "'backlog'"),
    ("orders={visible: 5, count: 3, kind: backlog}", "orders.count", "an unknown key", "visible"),
    ("bundles={kind: file, path: /nowhere/b.csv}", "bundles.path", "/nowhere/b.csv: No such file", "lines"),
    ("words=/nowhere/w.txt", "words", "/nowhere/w.txt", "text file"),
    ("layout.kind=spiral", "layout.kind", "'spiral'", "'rows'"),
    ("layout.aisle_lanes=3", "layout.aisle_lanes", "3", "less than or equal to 2"),
    ("bots.count=3", "bots.count", "a value at 'bots'", "a dotted key"),
    ("bots", "", "'bots'", "KEY=VALUE"),
    # what would never end, or need more memory than there is
    ("floor.width_m=1e12", "floor.width_m", "1000000000000", "less than or equal to 20000"),
    ("bot.radius_m=1e-6", "bot.radius_m", "1e-06", "greater than or equal to 0.05"),
    ("bot.max_speed_mps=1e9", "bot.max_speed_mps", "1000000000", "less than or equal to 50"),
    ("bot.max_speed_mps=1e-300", "bot.max_speed_mps", "1e-300", "greater than or equal to 0.01"),
    ("bot.max_acceleration_mps2=1e300", "bot.max_acceleration_mps2", "1e+300", "less than or equal to 1000"),
    ("bot.grab_s=1e6", "bot.grab_s", "1000000", "less than or equal to 86400"),
    ("bucket.capacity=20000", "bucket.capacity", "20000", "less than or equal to 10000"),
    ("orders={kind: poisson, per_hour: 1e300}", "orders.per_hour", "1e+300", "less than or equal to 360000"),
    (
        f"orders={{kind: poisson, per_hour: 1e5, daily_profile: [{'100, ' * 24}]}}",
        "orders.daily_profile",
        "1e+07 arrivals in the busiest hour",
        "at most 360000",
    ),
    (f"word_stations=[{'[1, 2], ' * 1_001}]", "word_stations", "[(1, 2)", "at most 1000 items"),
    (f"name=[{'a, ' * 50_000}]", "name", "['a', 'a'", "string"),
    ('name="a\\nb"', "name", "'a\\nb'", "a name without control characters"),
    ("bots=[1", "bots", "no ',' or ']'", "YAML value"),
]


def test_a_number_may_be_written_with_an_exponent() -> None:
    scenario = load_warehouse(DEMO, ["bots=1e1", "bot.grab_s=5e-1", "floor.width_m=4e1"]).scenario
    assert (scenario.bots, scenario.bot.grab_s, scenario.floor.width_m) == (10, 0.5, 40.0)


def one_line(path: Path, *overrides: str) -> str:
    """What is said of a scenario."""
    with pytest.raises(InputError) as caught:
        load_warehouse(path, overrides)
    text = str(caught.value)
    assert "\n" not in text
    return text


@pytest.mark.parametrize(("override", "key", "found", "allowed"), WRONG_VALUES, ids=[w[0][:60] for w in WRONG_VALUES])
def test_a_wrong_value_is_told_in_one_line(override: str, key: str, found: str, allowed: str) -> None:
    line = one_line(DEMO, override)
    place, said_found, said_allowed = line.replace("; allowed: ", ": found ").split(": found ", 2)
    assert place.endswith(key)
    assert found in said_found
    assert allowed in said_allowed


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "found nothing"),
        (b"- a\n- b\n", "found a list"),
        (b"bots: [1\n", "line"),
        (b"bots: 3\nbots: 4\n", "twice"),
        (b"\xff\xfe\x00", "not UTF-8"),
        (b"!!python/object/apply:os.system ['true']\n", "could not determine a constructor"),
        (b"name: x\n", "found nothing; allowed: a value; this key is required"),
    ],
)
def test_a_file_that_is_no_scenario_is_told_in_one_line(tmp_path: Path, content: bytes, said: str) -> None:
    path = tmp_path / "scenario.yaml"
    path.write_bytes(content)
    line = one_line(path)
    assert line.startswith(str(path))
    assert said in line


def test_a_missing_scenario_is_told_in_one_line(tmp_path: Path) -> None:
    assert "No such file" in one_line(tmp_path / "none.yaml")
    assert "Is a directory" in one_line(tmp_path)


@pytest.mark.parametrize("content", ["", "12 34 é\n"])
def test_a_word_file_without_words_is_told_in_one_line(tmp_path: Path, content: str) -> None:
    path = tmp_path / "words.txt"
    path.write_text(content)
    line = one_line(DEMO, f"words={path}")
    assert str(path) in line and "words: found" in line and "; allowed: " in line


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("10,SOUP\n5,BOT\n", "line 2: found 5 s after 10 s"),
        ("now,SOUP\n", "line 1: found 'now,SOUP'"),
        ("5\n", "line 1: found '5'"),
        ("5,E9\n", "colours 0 to 3"),
        ("5,E\u00e9\n", "line 1"),
        ("# nothing\n", "found no line"),
    ],
)
def test_a_wrong_line_of_an_order_file_is_told_in_one_line(tmp_path: Path, content: str, said: str) -> None:
    path = tmp_path / "orders.csv"
    path.write_text(content)
    assert said in one_line(DEMO, f"orders={{kind: file, path: {path}}}")
