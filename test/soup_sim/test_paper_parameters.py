"""The 2006 paper, "Simulation Parameters and Metrics" and what it builds on, sentence by sentence: the parameters.

Each parameter, changed in the scenario, changes the warehouse as the paper says. Blinding bots is in
`soup_bots/test_senses.py`, the policies of stations are in `test_station_policies.py`, the statistics in
`test_paper_statistics.py`.
"""

from __future__ import annotations

import math
import subprocess
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from world_hands import bucket_at_hand, clear, codes, do, loaded_at, place

from soup_lab.headless.simulation import Headless
from soup_msgs_py import messages as m
from soup_msgs_py.codes import Code, EventType
from soup_msgs_py.policies import Policies, PolicyChoice, load_policies
from soup_msgs_py.warehouse.tiles import LETTERS, tile_colour
from soup_sim.scenario_loader import Warehouse, load_warehouse
from soup_sim.summary import make_summary
from soup_sim.world import World

ROOT = Path(__file__).parents[2]
DEMO = ROOT / "config/scenarios/demo.yaml"


def warehouse_of(*overrides: str) -> Warehouse:
    return load_warehouse(DEMO, overrides)


def world_of(*overrides: str, seed: int = 1) -> World:
    return warehouse_of(*overrides).world(seed)


def events(said) -> list[m.Event]:
    return [s for s in said if isinstance(s, m.Event)]


# ---- "A warehouse has a configurable number of buckets, bucketbots, letter and word stations" --------------------


def test_the_numbers_of_buckets_bots_and_stations() -> None:
    warehouse = warehouse_of("buckets=33", "bots=5", "letter_stations=4", "word_stations=2")
    world = warehouse.world(1)
    snapshot = world.snapshot()
    assert (len(snapshot.buckets.x), len(snapshot.bots.x)) == (33, 5)
    assert (len(snapshot.letter_stations), len(snapshot.word_stations)) == (4, 2)
    summary = make_summary(world.statistics(), warehouse.scenario, Policies(), 1, 0)
    counts = ("buckets", "bots", "letter_stations", "word_stations")
    assert [summary[key] for key in counts] == [33, 5, 4, 2]


def throughput(*overrides: str) -> Counter[str]:
    """Tiles that the stations of each kind have moved after three minutes, by the default policies."""
    world = world_of("initial_inventory=0.3", *overrides)
    moved = Counter[str]()

    def note(event: m.Event) -> None:
        if event.type is EventType.TRANSFERRED:
            moved["word" if world.layout.is_word_station(event.station) else "letter"] += 1

    Headless(world, Policies(), 1, note).run(180.0)
    return moved


@pytest.mark.parametrize(("few", "many"), [("bots=1", "bots=12"), ("buckets=2", "buckets=60")])
def test_bots_and_buckets_affect_throughput(few: str, many: str) -> None:
    assert throughput(few).total() < throughput(many).total()


@pytest.mark.parametrize(
    ("kind", "work"),
    [("word", []), ("letter", ["orders={kind: all, count: 1}", "bundles={kind: poisson, per_hour: 3600}"])],
)
def test_stations_affect_throughput(kind: str, work: list[str]) -> None:
    slow = f"{kind}_station.transfer_s=60.0"
    one, many = (throughput(slow, f"{kind}_stations={count}", *work)[kind] for count in (1, 6))
    assert 0 < one <= 180 / 60 < many


# ---- "the capacity of buckets and the size of letter bundles ... are also configurable" ---------------------------


def test_the_capacity_of_buckets() -> None:
    for capacity in (5, 9):
        world = world_of(f"bucket.capacity={capacity}", "initial_inventory=0")
        station = world.scenario.word_station_count
        loaded_at(world, station)
        for tile in range(4):
            world.handle(m.AssignBundle(station, tile=tile))
        reply = do(world, m.Transfer(0, 9, station, (m.TileMove(),) * 12))
        assert reply.code is Code.BUCKET_FULL and reply.message.startswith(f"{capacity} of 12")


def test_the_size_of_bundles() -> None:
    for size in (1, 7):
        world = world_of(f"bundle_size={size}")
        (staged,) = events(world.handle(m.AssignBundle(world.scenario.word_station_count, tile=4)))
        assert (staged.type, staged.count) == (EventType.BUNDLE_STAGED, size)


# ---- "The choice of word dictionary and letter color distribution affects the number and profile of letters" ------


def test_the_word_dictionary(tmp_path: Path) -> None:
    path = tmp_path / "words.txt"
    path.write_text("Banana, and SOUP!")
    world = world_of(f"words={path}")
    assert {word.text for word in world.snapshot().waiting_words} == {"BANANA", "AND", "SOUP"}
    held = {tile % LETTERS for content in world.snapshot().contents for tile in content}
    assert held == {ord(letter) - ord("A") for letter in "BANANDSOUP"}


def test_the_letter_colour_distribution() -> None:
    world = world_of("colours=[0.5, 0.0, 0.3, 0.2]", "orders.visible=3000")
    ordered = Counter(tile_colour(tile) for word in world.snapshot().waiting_words for tile in word.tiles)
    shares = [ordered[colour] / ordered.total() for colour in range(4)]
    assert shares == pytest.approx([0.5, 0.0, 0.3, 0.2], abs=0.02)


def test_with_a_uniform_distribution_each_letter_is_equally_likely(tmp_path: Path) -> None:
    path = tmp_path / "alphabet.txt"
    path.write_text("abcdefghijklmnopqrstuvwxyz")
    world = world_of(f"words={path}", "colours={kind: uniform, count: 3}")
    assert world.tile_profile == pytest.approx(np.full(3 * LETTERS, 1.0 / (3 * LETTERS)))


def test_most_sets_of_words_make_more_use_of_e_than_of_z() -> None:
    profile = world_of().tile_profile
    assert profile[ord("E") - ord("A")] > 10 * profile[ord("Z") - ord("A")]


def test_five_hundred_colours_in_a_pareto_distribution_make_13000_tiles_and_an_80_20_curve() -> None:
    scenario = warehouse_of("colours={kind: pareto, count: 500}").scenario
    assert scenario.tile_kinds == 13_000
    shares = sorted(scenario.colours.shares, reverse=True)
    assert sum(shares[:100]) == pytest.approx(0.8, abs=0.01)


# ---- "The size of the physical objects, namely the warehouse, bucketbots and buckets" -----------------------------


def test_the_size_of_the_warehouse() -> None:
    small, large = warehouse_of(), warehouse_of("floor={width_m: 80.0, height_m: 60.0}")
    assert (large.layout.width_m, large.layout.height_m) == (80.0, 60.0)
    assert len(large.layout.storage_spots) > 3 * len(small.layout.storage_spots)


@pytest.mark.parametrize("radius", [0.3, 0.6])
def test_the_size_of_bots(radius: float) -> None:
    world = world_of(f"bot.radius_m={radius}", "bucket.radius_m=0.3")
    clear(world)
    place(world, bot_0=(10.0, 15.0), bot_1=(20.0, 15.0))
    world.handle(m.FollowPath(0, 1, ((20.0, 15.0),)))
    assert next(e for e in events(world.advance(9.0))).type is EventType.BOT_COLLISION
    assert world.bots().x[0] == pytest.approx(20.0 - 2.0 * radius)


@pytest.mark.parametrize("radius", [0.4, 0.7])
def test_the_size_of_buckets(radius: float) -> None:
    world = world_of(f"bucket.radius_m={radius}", "bot.radius_m=0.3", "buckets=1")
    x, y = bucket_at_hand(world, 0, 0)
    assert do(world, m.Grab(0, 1)).success
    world.handle(m.SetVelocity(0, -4.0, 0.0))
    world.advance(60.0)
    assert world.buckets().x[0] == pytest.approx(radius), "a bucket keeps inside the floor"
    assert x > 1.0 and y > 1.0


def test_larger_bodies_restrict_the_space() -> None:
    narrow = warehouse_of("layout.pitch_m=2.0", "bot.radius_m=0.95", "buckets=30")
    assert len(narrow.layout.storage_spots) < len(warehouse_of().layout.storage_spots)


# ---- "how close a bucketbot must be to a bucket to pick it up, and ... to a station to be considered present" -----


@pytest.mark.parametrize(("tolerance", "code"), [(0.05, Code.OUT_OF_TOLERANCE), (0.15, Code.DONE)])
def test_how_close_a_bot_must_be_to_a_bucket(tolerance: float, code: Code) -> None:
    world = world_of(f"bot.tolerance_m={tolerance}")
    x, y = bucket_at_hand(world, 0, 3)
    place(world, bot_0=(x + 0.1, y))
    assert do(world, m.Grab(0, 1)).code is code


@pytest.mark.parametrize("kind", ["word_station", "letter_station"])
@pytest.mark.parametrize(("tolerance", "is_there"), [(0.2, False), (0.4, True)])
def test_how_close_a_bot_must_be_to_a_station(kind: str, tolerance: float, is_there: bool) -> None:
    world = world_of(f"{kind}.tolerance_m={tolerance}")
    station = 0 if kind == "word_station" else world.scenario.word_station_count
    loaded_at(world, station)
    x, y = world.layout.station_xy(station)
    place(world, bot_0=(x, y + 0.3))
    assert (do(world, m.Transfer(0, 9, station)).code is not Code.OUT_OF_TOLERANCE) == is_there


# ---- "The temporal costs of various actions are also configurable" ------------------------------------------------


@pytest.mark.parametrize("seconds", [0.0, 0.5, 2.0])
def test_the_time_to_pick_up_and_to_set_down_a_bucket(seconds: float) -> None:
    world = world_of(f"bot.grab_s={seconds}", f"bot.release_s={2.0 * seconds}")
    bucket_at_hand(world, 0, 3)
    grabbed = do(world, m.Grab(0, 1))
    assert grabbed.success and grabbed.time == pytest.approx(seconds)
    released = do(world, m.Release(0, 2))
    assert released.success and released.time == pytest.approx(3.0 * seconds)


@pytest.mark.parametrize("seconds", [0.0, 1.0, 5.0])
def test_the_time_to_add_a_tile(seconds: float) -> None:
    world = world_of(f"letter_station.transfer_s={seconds}")
    station = world.scenario.word_station_count
    loaded_at(world, station)
    world.handle(m.AssignBundle(station, tile=4))
    started = world.now
    assert do(world, m.Transfer(0, 9, station, (m.TileMove(),) * 3)).time - started == pytest.approx(3 * seconds)


def build(world: World) -> tuple[list[m.Event], float]:
    """Have a bot with all the letters build the two words of word station 0; the events, and when it began."""
    loaded_at(world, 0)
    for word in world.snapshot().waiting_words[:2]:
        world.handle(m.AssignWord(word.word, 0))
    started = world.now
    said = world.handle(m.Transfer(0, 9, 0, (m.TileMove(),) * 6))
    return events(said + world.advance(world.now + 200.0)), started


@pytest.fixture
def ant(tmp_path: Path) -> tuple[str, ...]:
    """Overrides: one word of three letters, one colour, buckets full of its letters."""
    (tmp_path / "words.txt").write_text("ant")
    return f"words={tmp_path / 'words.txt'}", "colours=[1.0]", "initial_inventory=1.0"


@pytest.mark.parametrize("seconds", [0.5, 5.0])
def test_the_time_to_remove_a_tile(ant: tuple[str, ...], seconds: float) -> None:
    told, started = build(world_of(*ant, f"word_station.transfer_s={seconds}"))
    taken = [event.time - started for event in told if event.type is EventType.TRANSFERRED]
    assert taken == pytest.approx([seconds * (n + 1) for n in range(6)])


@pytest.mark.parametrize("seconds", [0.0, 4.0])
def test_the_time_to_move_a_finished_word_out_and_prepare_for_the_next(ant: tuple[str, ...], seconds: float) -> None:
    told, started = build(world_of(*ant, f"word_station.clear_s={seconds}"))
    done, cleared = (
        [event.time - started for event in told if event.type is kind]
        for kind in (EventType.WORD_COMPLETED, EventType.WORD_CLEARED)
    )
    assert done == pytest.approx([3.0, 6.0 + seconds])
    assert cleared == pytest.approx([3.0 + seconds, 6.0 + 2 * seconds])


# ---- "Bucketbot motion is described by its velocity and acceleration, both of which are configurable" -------------


@pytest.mark.parametrize(("speed", "acceleration"), [(4.0, 20.0), (2.0, 20.0), (4.0, 1.0)])
def test_velocity_and_acceleration(speed: float, acceleration: float) -> None:
    world = world_of(f"bot.max_speed_mps={speed}", f"bot.max_acceleration_mps2={acceleration}")
    clear(world)
    place(world, bot_0=(5.0, 15.0))
    world.handle(m.FollowPath(0, 1, ((35.0, 15.0),)))
    fastest = 0.0
    reply = None
    while reply is None:
        said = world.advance(world.now + 0.1)
        fastest = max(fastest, float(world.bots().vx[0]))
        reply = next((s for s in said if isinstance(s, m.BotReply)), None)
    assert reply.success and reply.time == pytest.approx(30.0 / speed + speed / acceleration)
    assert fastest == pytest.approx(speed)


def test_turning_takes_time_where_the_scenario_says_so() -> None:
    times = []
    for rate in ("null", "1.0"):
        world = world_of(f"bot.turn_rate_radps={rate}")
        clear(world)
        place(world, bot_0=(5.0, 15.0))
        times.append(do(world, m.FollowPath(0, 1, ((15.0, 15.0), (15.0, 25.0)))).time)
    assert times[1] - times[0] >= math.pi / 2 - 1e-9


@pytest.mark.parametrize("seconds", [1.0, 8.0])
def test_the_temporal_penalty_for_collisions(seconds: float) -> None:
    world = world_of(f"bot.collision_penalty_s={seconds}")
    clear(world)
    place(world, bot_0=(10.0, 15.0), bot_1=(14.0, 15.0))
    world.handle(m.FollowPath(0, 1, ((20.0, 15.0),)))
    collision, *resumed = events(world.advance(60.0))
    assert [event.time - collision.time for event in resumed] == pytest.approx([seconds, seconds])


# ---- "The testbed can run with or without a graphic display" ------------------------------------------------------


def test_a_run_without_a_display_loads_none_and_no_ros() -> None:
    code = (
        "import soup_lab.headless.simulation, sys; print([n for n in ('soup_dashboard', 'rclpy') if n in sys.modules])"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == "[]"


# ---- "ALPHABET SOUP loads modules specified in its configuration file at runtime" ---------------------------------


def test_modules_that_the_configuration_names_are_loaded(tmp_path: Path) -> None:
    policies = tmp_path / "policies.yaml"
    policies.write_text(f"word: {ROOT / 'examples/longest_word.py'}:LongestWord\n")
    warehouse = warehouse_of(f"letter_station.policy={ROOT / 'examples/alike.py'}:Alike")
    world = warehouse.world(1)
    run = Headless(world, load_policies(policies), 1)
    run.run(1.0)
    opened = [word for station in world.stations().word_stations for word in station.open_words]
    waiting = world.snapshot().waiting_words[: world.scenario.orders.visible - len(opened)]  # type: ignore[union-attr]
    assert min(len(word.text) for word in opened) >= max(len(word.text) for word in waiting)
    assert {type(station.policy).__name__ for station in world._serving.letters} == {"Alike"}


# ---- "The Alphabet Soup Testbed" ----------------------------------------------------------------------------------


@pytest.mark.parametrize("most", [1, 3])
def test_a_word_station_has_a_finite_number_of_jobs(most: int) -> None:
    world = world_of(f"word_station.open_words={most}")
    said = [s for word in range(5) for s in world.handle(m.AssignWord(word, 0))]
    assert codes(said) == [Code.DONE] * most + [Code.STATION_FULL] * (5 - most)


@pytest.mark.parametrize("most", [1, 3])
def test_a_letter_station_has_a_limit_on_the_bundles_staged(most: int) -> None:
    world = world_of(f"letter_station.staged_bundles={most}")
    said = [s for _ in range(5) for s in world.handle(m.AssignBundle(world.scenario.word_station_count, tile=0))]
    assert codes(said) == [Code.DONE] * most + [Code.STATION_FULL] * (5 - most)


@pytest.mark.parametrize("share", [0.0, 0.35, 1.0])
def test_the_initial_inventory_is_a_fraction_of_the_capacity_drawn_from_words_and_colours(share: float) -> None:
    world = world_of(f"initial_inventory={share}", "buckets=96")
    held = Counter[int]()
    for content in world.snapshot().contents:
        held.update(content)
    assert held.total() == pytest.approx(share * 96 * 40, abs=1)
    assert world.statistics()["inventory_fill_start"] == pytest.approx(share, abs=1e-3)
    if share:
        common = np.argsort(world.tile_profile)[-5:]
        found = [held[int(tile)] / held.total() for tile in common]
        assert found == pytest.approx(world.tile_profile[common].tolist(), abs=0.025)


# ---- "all of the jobs are known the night before, while in [others] the jobs are dropping ... in real time" -------


def test_orders_are_a_backlog_or_all_known_or_drop_in_or_come_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "orders.csv"
    path.write_text("0,SOUP\n2.5,A0 B1\n50,LATE\n")
    expected = {
        "{kind: backlog, visible: 7}": (7, 7),
        "{kind: all, count: 11}": (11, 11),
        "{kind: poisson, per_hour: 3600, at_start: 2}": (2, None),
        f"{{kind: file, path: {path}}}": (0, 2),
    }
    waiting: list[m.Word] = []
    for orders, (at_start, after) in expected.items():
        world = world_of(f"orders={orders}")
        assert len(world.snapshot().waiting_words) == at_start, orders
        world.advance(30.0)
        waiting = list(world.snapshot().waiting_words)
        assert len(waiting) == after if after is not None else 15 < len(waiting) < 50, orders
    assert [word.text for word in waiting] == ["SOUP", "AB"]
    assert waiting[1].tiles == (0, LETTERS + 1)


def test_bundles_are_chosen_or_come_by_themselves() -> None:
    world = world_of()
    world.advance(100.0)
    assert world.snapshot().waiting_bundles == ()
    world = world_of("bundles={kind: poisson, per_hour: 3600, at_start: 1}")
    assert len(world.snapshot().waiting_bundles) == 1
    world.advance(100.0)
    assert len(world.snapshot().waiting_bundles) > 50


# ---- "A potentially realistic scenario": where the example of the paper stands ------------------------------------


def test_the_papers_example_is_the_scenario_of_that_name() -> None:
    scenario = load_warehouse(ROOT / "config/scenarios/paper.yaml").scenario
    assert (scenario.floor.width_m, scenario.floor.height_m) == (250.0, 350.0)
    assert 2 * scenario.bot.radius_m == 2 * scenario.bucket.radius_m == 2.0
    assert (scenario.bot.max_acceleration_mps2, scenario.bot.max_speed_mps) == (20.0, 4.0)
    assert (scenario.word_station_count, scenario.letter_station_count) == (25, 25)
    assert (scenario.bots, scenario.buckets) == (250, 850)
    assert (scenario.bucket.capacity, scenario.bundle_size) == (40, 4)
    assert (scenario.word_station.transfer_s, scenario.letter_station.transfer_s) == (5.0, 5.0)
    assert (scenario.bot.grab_s, scenario.bot.release_s) == (0.5, 0.5)
    assert scenario.colours.shares == [4 / 5, 1 / 10, 1 / 20, 1 / 20]


def test_the_minimal_coordination_is_a_choice_by_name() -> None:
    chosen = load_policies(ROOT / "config/policies/minimal.yaml")
    assert chosen.fleet == PolicyChoice(name="minimal")
