"""What a station decides by itself is a policy: named in the scenario, replaceable, part of a checkpoint."""

from __future__ import annotations

from pathlib import Path

import pytest
from world_hands import bucket_at_hand, do, loaded_at, place

from soup_msgs_py import messages as m
from soup_msgs_py.codes import Code, EventType
from soup_msgs_py.errors import InputError, RunError
from soup_msgs_py.scenario import load_scenario
from soup_msgs_py.warehouse.tiles import tile_letter
from soup_sim.checkpoint import fingerprint, restore_checkpoint, write_checkpoint
from soup_sim.scenario_loader import load_warehouse
from soup_sim.world import World

ROOT = Path(__file__).parents[2]
DEMO = ROOT / "config/scenarios/demo.yaml"

OWN = """
from soup_sim.station_policies import LetterStationPolicy, WordStationPolicy

class Newest(WordStationPolicy):
    def choose(self, moves, station, contents, rng):
        return len(moves) - 1

class AnyOne(LetterStationPolicy):
    def choose(self, moves, station, contents, rng):
        return int(rng.integers(len(moves)))

class InTurn(LetterStationPolicy):
    def __init__(self, start=0):
        self.count = start

    def choose(self, moves, station, contents, rng):
        self.count += 1
        return self.count % len(moves)

    def capture(self):
        return self.count

    def restore(self, state):
        self.count = state

class Wrong(LetterStationPolicy):
    def choose(self, moves, station, contents, rng):
        return 99
"""


@pytest.fixture
def own(tmp_path: Path) -> Path:
    """A file of one's own policies."""
    path = tmp_path / "own.py"
    path.write_text(OWN)
    return path


def world_of(*overrides: str, seed: int = 1) -> World:
    return load_warehouse(DEMO, overrides).world(seed)


def words_taken(world: World) -> list[str]:
    """Let a bot with a full bucket offer everything it has to word station 0; the words that got a tile, in turn."""
    loaded_at(world, 0)
    for word in world.snapshot().waiting_words[:4]:
        world.handle(m.AssignWord(word.word, 0))
    words = {word.word: word.text for word in world.stations().word_stations[0].open_words}
    said = world.handle(m.Transfer(0, 9, 0, (m.TileMove(),) * 10)) + world.advance(world.now + 60.0)
    return [words[s.job] for s in said if isinstance(s, m.Event) and s.tile >= 0]


def bundles_taken(world: World, count: int = 8) -> list[str]:
    """Let a bot take tiles from a station with bundles of A, B and C, of which B has fewest left; their letters."""
    station = world.scenario.word_station_count
    loaded_at(world, station)
    for tile in range(3):
        world.handle(m.AssignBundle(station, tile=tile))
    assert do(world, m.Transfer(0, 8, station, (m.TileMove(1),))).success
    said = world.handle(m.Transfer(0, 9, station, (m.TileMove(),) * count)) + world.advance(world.now + 60.0)
    return [tile_letter(s.tile) for s in said if isinstance(s, m.Event) and s.tile >= 0 and s.bot >= 0]


# ---- the ones that come with the warehouse ------------------------------------------------------------------------


def test_a_word_station_serves_its_oldest_open_word_unless_told_otherwise() -> None:
    world = world_of()
    texts = [word.text for word in world.snapshot().waiting_words[:4]]
    taken = words_taken(world)
    assert [texts.index(text) for text in taken] == sorted(texts.index(text) for text in taken)


def test_nearly_done_serves_the_word_that_lacks_the_fewest_letters() -> None:
    world = world_of("word_station.policy=nearly_done")
    texts = [word.text for word in world.snapshot().waiting_words[:4]]
    assert words_taken(world)[0] == min(texts, key=len)


def test_a_letter_station_empties_its_oldest_bundle_unless_told_otherwise() -> None:
    assert bundles_taken(world_of()) == list("AAAABBBC")


def test_nearly_empty_empties_the_bundle_with_the_fewest_tiles_left() -> None:
    assert bundles_taken(world_of("letter_station.policy=nearly_empty")) == list("BBBAAAAC")


@pytest.mark.parametrize(("policy", "jobs"), [("as_asked", [1, 2, 0, 2]), ("nearly_empty", [2, 2, 1, 0])])
def test_what_is_asked_for_is_done_and_no_more_but_in_the_order_of_the_station(policy: str, jobs: list[int]) -> None:
    world = world_of(f"letter_station.policy={policy}")
    station = world.scenario.word_station_count
    loaded_at(world, station)
    for tile in range(3):
        world.handle(m.AssignBundle(station, tile=tile))
    assert do(world, m.Transfer(0, 7, station, (m.TileMove(1, 1), m.TileMove(2, 2), m.TileMove(2, 2)))).success
    asked = tuple(m.TileMove(job, job) for job in (1, 2, 0, 2))
    said = world.handle(m.Transfer(0, 9, station, asked)) + world.advance(world.now + 9.0)
    transferred = [s for s in said if isinstance(s, m.Event) and s.type is EventType.TRANSFERRED]
    assert [event.job for event in transferred] == jobs


def test_a_wish_that_cannot_be_fulfilled_keeps_the_others_from_nothing() -> None:
    world = world_of()
    station = world.scenario.word_station_count
    loaded_at(world, station)
    world.handle(m.AssignBundle(station, tile=0))
    reply = do(world, m.Transfer(0, 9, station, (m.TileMove(5), m.TileMove(0), m.TileMove(0, 8), m.TileMove(0))))
    assert reply.code is Code.NOTHING_STAGED
    assert reply.message == "2 of 4 tiles moved; no F0 is staged on letter station 3"


def served_first(policy: str) -> list[int]:
    """Three bots wait at a wide station, the first to come is being served; the order in which they are answered."""
    world = world_of(f"letter_station={{policy: {policy}, tolerance_m: 3.0, transfer_s: 1.0}}", "bot.radius_m=0.3")
    station = world.scenario.word_station_count
    x, y = world.layout.station_xy(station)
    for bot in range(3):
        bucket_at_hand(world, bot, bot)
        assert do(world, m.Grab(bot, 1)).success
        place(world, **{f"bot_{bot}": (x + 1.0, y - 1.5 + 1.5 * bot)})
        for other in range(bot):
            place(world, **{f"bot_{other}": (x + 1.0, y - 1.5 + 1.5 * other)})
    for tile in range(3):
        world.handle(m.AssignBundle(station, tile=tile))
    for bot, tiles in enumerate((2, 3, 1)):
        assert world.handle(m.Transfer(bot, 9, station, (m.TileMove(),) * tiles)) == []
    return [s.bot for s in world.advance(world.now + 60.0) if isinstance(s, m.BotReply)]


def test_bots_that_wait_at_a_station_are_served_in_the_order_of_its_policy() -> None:
    assert served_first("as_asked") == [0, 1, 2]
    assert served_first("nearly_empty") == [0, 2, 1]


# ---- one's own ----------------------------------------------------------------------------------------------------


def test_a_policy_of_ones_own_decides(own: Path) -> None:
    world = world_of(f"word_station.policy={own}:Newest")
    texts = [word.text for word in world.snapshot().waiting_words[:4]]
    assert words_taken(world)[0] == texts[3]


def test_the_example_fills_a_bucket_with_what_it_holds_most_of() -> None:
    world = world_of(f"letter_station.policy={ROOT / 'examples/alike.py'}:Alike", "initial_inventory=0")
    assert bundles_taken(world, count=4) == list("BBBA")


def test_a_policy_gets_its_options_and_each_station_one_of_its_own(own: Path) -> None:
    policy = f"letter_station.policy={{name: '{own}:InTurn', options: {{start: 1}}}}"
    world = world_of(policy, "initial_inventory=0")
    assert bundles_taken(world, count=3) == list("CAB")
    assert len({id(station.policy) for station in world._serving.letters}) == 3


def test_the_random_draws_of_a_policy_follow_the_seed(own: Path) -> None:
    policy = f"letter_station.policy={own}:AnyOne"
    assert bundles_taken(world_of(policy)) == bundles_taken(world_of(policy))
    assert any(bundles_taken(world_of(policy, seed=seed)) != bundles_taken(world_of(policy)) for seed in (2, 3, 4))


@pytest.mark.parametrize("name", ["InTurn", "AnyOne"])
def test_what_a_policy_remembers_is_in_a_checkpoint(own: Path, tmp_path: Path, name: str) -> None:
    warehouse = load_warehouse(DEMO, [f"letter_station.policy={own}:{name}"])
    world, restored = warehouse.world(1), warehouse.world(2)
    bundles_taken(world, count=2)
    write_checkpoint(tmp_path / "half", world)
    restore_checkpoint(tmp_path / "half", restored)
    station = world.scenario.word_station_count
    ask = m.Transfer(0, 10, station, (m.TileMove(),) * 6)
    assert restored.handle(ask) + restored.advance(200.0) == world.handle(ask) + world.advance(200.0)


def test_a_checkpoint_of_another_policy_does_not_fit_but_its_file_may_have_moved(own: Path) -> None:
    there = own.parent / "there"
    there.mkdir()
    moved = there / "own.py"
    moved.write_text(OWN)
    prints = [
        fingerprint(load_scenario(DEMO, [f"letter_station.policy={name}"]))
        for name in (f"{own}:InTurn", f"{moved}:InTurn", f"{own}:AnyOne")
    ]
    assert prints[0] == prints[1] != prints[2]


def test_a_policy_that_chooses_what_is_not_there_ends_the_run_with_a_sentence(own: Path) -> None:
    with pytest.raises(RunError, match=r"station 3: policy Wrong chose number 99; allowed: 0 to 2"):
        bundles_taken(world_of(f"letter_station.policy={own}:Wrong"))


# ---- what a person may write wrongly ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("word_station.policy=newest", "word_station.policy: found 'newest'; allowed: as_asked, nearly_done, FILE.py"),
        (
            "letter_station.policy=nearly_done",
            "letter_station.policy: found 'nearly_done'; allowed: as_asked, nearly_empty",
        ),
        ("word_station.policy=nowhere.py:X", "word_station.policy: found no file"),
        ("word_station.policy=OWN:Nothing", "found no 'Nothing'; allowed: the name of a class in it"),
        ("word_station.policy=OWN:InTurn", "found another thing; allowed: a class that extends WordStationPolicy"),
        ("word_station.policy={name: as_asked, options: {x: 1}}", "word_station.policy: as_asked.options.x: found"),
        ("word_station.policy=3", "word_station.policy: found 3; allowed: "),
        ("word_station.policy={nam: as_asked}", "word_station.policy.nam: found an unknown key; allowed: name"),
    ],
)
def test_a_wrong_station_policy_is_told_in_one_line(own: Path, override: str, said: str) -> None:
    with pytest.raises(InputError) as caught:
        load_warehouse(DEMO, [override.replace("OWN", str(own))])
    assert said in str(caught.value) and "\n" not in str(caught.value)


def test_a_policy_file_is_looked_for_beside_the_scenario_and_for_an_override_here(own: Path, monkeypatch) -> None:
    scenario = own.parent / "demo.yaml"
    text = DEMO.read_text().replace("../words", str(ROOT / "config/words"))
    scenario.write_text(text.replace("word_station: {", 'word_station: {policy: "own.py:Newest", '))
    monkeypatch.chdir(ROOT)
    assert load_scenario(scenario).word_station.policy.name == f"{own}:Newest"
    named_here = load_scenario(scenario, ["letter_station.policy=examples/alike.py:Alike"])
    assert named_here.letter_station.policy.name == f"{ROOT}/examples/alike.py:Alike"
    assert named_here.word_station.policy.name == f"{own}:Newest"
