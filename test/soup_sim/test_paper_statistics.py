"""The 2006 paper, "Simulation Parameters and Metrics", sentence by sentence: what is tracked and reported.

"... the number of words completed, total number of letters in words completed, number of letters dispensed by letter
stations, total and average distances driven by bucketbots, number of bucket grabs and releases, number of bucketbot
and bucket collisions, bucketbot idle time, average bucket capacity utilization, average number of letter transfers per
word/letter station visit, and station idle time." Each figure of a summary is counted a second time here, from the
events of a small run and from looking at the bots very often.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from world_hands import bucket_at_hand, clear, do, place

from soup_lab.headless.simulation import Headless
from soup_managers.fleets.make import FLEET
from soup_managers.fleets.minimal.plans import Place, PlannedVisit, TripPlan
from soup_managers.fleets.minimal.policies import FleetPolicy
from soup_managers.fleets.minimal.state import FleetState
from soup_managers.kernels.bitset import first, members
from soup_msgs_py import messages as m
from soup_msgs_py.codes import BotState, EventType
from soup_msgs_py.policies import Policies, PolicyChoice
from soup_sim.scenario_loader import Warehouse, load_warehouse
from soup_sim.summary import KEYS, make_summary

ROOT = Path(__file__).parents[2]
DEMO = ROOT / "config/scenarios/demo.yaml"
WARMUP_S, END_S, LOOK_S = 40.0, 160.0, 0.05
LATER_S = 15.0  # so that transfers under way at the end are known
SECONDS = END_S - WARMUP_S


@dataclass
class Run:
    """A small run: its summary, its events and what was seen of its bots after the warm-up."""

    warehouse: Warehouse
    summary: dict[str, Any]
    events: list[m.Event]
    later: list[m.Event]
    driven: np.ndarray
    idle: float
    tiles_at_start: int

    @property
    def counted(self) -> list[m.Event]:
        """The events after the warm-up, which is over before all else at its last instant."""
        return [event for event in self.events if event.time >= WARMUP_S]

    def count(self, kind: EventType) -> int:
        return sum(event.type is kind for event in self.counted)

    def is_word_station(self, station: int) -> bool:
        return station < self.warehouse.scenario.word_station_count


class SeveralLetters(FleetPolicy):
    """Each trip brings a station all the waiting letters that the bucket holds, or has room for."""

    def plan(self, fleet: FleetState) -> Iterable[TripPlan]:
        for letter in list(fleet.letters()):
            storing = letter.key[0] == m.STORE
            able = fleet.view.with_room if storing else fleet.view.holders(letter.tile)
            buckets = list(members(able & fleet.free_buckets))
            if letter.place is not Place.QUEUED or not buckets or not fleet.free_bots:
                continue
            bucket, bot = buckets[0], fleet.bot_under(buckets[0])
            bot = first(fleet.free_bots) if bot < 0 else bot
            room, held, taken = fleet.view.room_in(bucket), Counter(fleet.view.contents[bucket]), []
            for other in list(fleet.letters()):
                fits = room > 0 if storing else held[other.tile] > 0
                if other.station == letter.station and fits:
                    taken.append(other)
                    room -= 1
                    held[other.tile] -= 1
            if fleet.free_bots >> bot & 1:
                yield TripPlan(bot, bucket, (PlannedVisit(letter.station, tuple(taken)),), fleet.view.spot_of[bucket])


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """One with many short words, a time to clear them away, and several letters a visit."""
    words = tmp_path_factory.mktemp("words") / "words.txt"
    words.write_text("at on tea set")
    warehouse = load_warehouse(
        DEMO,
        [
            f"words={words}",
            "word_station.clear_s=3.0",
            "word_station.transfer_s=0.5",
            "initial_inventory=0.4",
            "orders.visible=15",
        ],
    )
    world = warehouse.world(3, WARMUP_S)
    events: list[m.Event] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(FLEET, "several letters", SeveralLetters)
        policies = Policies(fleet=PolicyChoice(name="several letters"))
        headless = Headless(world, policies, 3, events.append)
    tiles = int(world.buckets().tiles.sum())
    headless.run(WARMUP_S)
    before = world.bots()
    driven, idle = np.zeros(warehouse.scenario.bots), 0.0
    for look in range(1, round(SECONDS / LOOK_S) + 1):
        headless.run(WARMUP_S + look * LOOK_S)
        now = world.bots()
        driven += np.hypot(now.x - before.x, now.y - before.y)
        idle += float(np.count_nonzero(now.state == BotState.FREE)) * LOOK_S
        before = now
    summary = make_summary(world.statistics(10.0), warehouse.scenario, policies, 3, 0)
    until_end = len(events)
    headless.run(END_S + LATER_S)
    return Run(warehouse, summary, events[:until_end], events[until_end:], driven, idle, tiles)


def test_the_run_is_worth_counting(run: Run) -> None:
    for kind in (EventType.WORD_COMPLETED, EventType.GRABBED, EventType.RELEASED, EventType.TRANSFERRED):
        assert run.count(kind) > 10
    assert run.summary["pile_on_word"] > 1.2 and run.summary["pile_on_letter"] > 1.2
    assert run.idle > 0.0


def test_the_number_of_words_completed(run: Run) -> None:
    assert run.summary["words_completed"] == run.count(EventType.WORD_COMPLETED)
    assert run.summary["words_per_second"] == pytest.approx(run.count(EventType.WORD_COMPLETED) / SECONDS)


def test_the_total_number_of_letters_in_words_completed(run: Run) -> None:
    # each tile that went into a word that was completed after the warm-up, whenever it went in
    done = {event.job for event in run.counted if event.type is EventType.WORD_COMPLETED}
    into = [e for e in run.events if e.type is EventType.TRANSFERRED and run.is_word_station(e.station)]
    assert run.summary["letters_in_words"] == sum(event.job in done for event in into)


def test_the_number_of_letters_dispensed_by_letter_stations(run: Run) -> None:
    moved = [event for event in run.counted if event.type is EventType.TRANSFERRED]
    assert run.summary["letters_dispensed"] == sum(not run.is_word_station(event.station) for event in moved) > 0


def test_the_time_of_words_from_their_order_to_their_completion(run: Run) -> None:
    ordered = {event.job: event.time for event in run.events if event.type is EventType.WORD_ARRIVED}
    done = [event for event in run.counted if event.type is EventType.WORD_COMPLETED]
    times = [event.time - ordered.get(event.job, 0.0) for event in done]  # without an event: from the start on
    assert any(event.job in ordered for event in done)
    assert run.summary["word_time_mean_s"] == pytest.approx(np.mean(times))
    assert run.summary["word_time_p95_s"] == pytest.approx(np.percentile(times, 95))


def test_the_age_of_the_oldest_word_that_waits(run: Run) -> None:
    ordered = {event.job: event.time for event in run.events if event.type is EventType.WORD_ARRIVED}
    opened = {event.job for event in run.events if event.type is EventType.WORD_ASSIGNED}
    since = [ordered.get(word, 0.0) for word in range(max(ordered) + 1) if word not in opened]
    assert run.summary["oldest_waiting_word_s"] == pytest.approx(END_S - min(since))


def test_without_a_completed_word_there_is_no_time_of_words() -> None:
    figures = load_warehouse(DEMO).world(1).statistics()
    assert figures["word_time_mean_s"] is None and figures["word_time_p95_s"] is None
    assert figures["oldest_waiting_word_s"] == 0.0


def test_total_and_average_distances_driven_by_bots(run: Run) -> None:
    assert run.summary["distance_total_m"] == pytest.approx(float(run.driven.sum()), rel=2e-3)
    assert run.summary["distance_mean_m"] == pytest.approx(float(run.driven.mean()), rel=2e-3)


def test_the_number_of_bucket_grabs_and_releases(run: Run) -> None:
    assert run.summary["grabs"] == run.count(EventType.GRABBED)
    assert run.summary["releases"] == run.count(EventType.RELEASED)


def test_the_number_of_bot_and_bucket_collisions() -> None:
    world = load_warehouse(DEMO).world(1)
    happened: list[EventType] = []

    def collide(x: float, y: float) -> None:
        said = world.handle(m.FollowPath(0, 1, ((x, y),))) + world.advance(world.now + 30.0)
        happened.extend(s.type for s in said if isinstance(s, m.Event))

    for _ in range(2):
        clear(world)
        place(world, bot_0=(10.0, 15.0), bot_1=(14.0, 15.0))
        collide(20.0, 15.0)
    bucket_at_hand(world, 0, 3)
    assert do(world, m.Grab(0, 1)).success
    buckets = world.buckets()
    away = np.hypot(buckets.x - buckets.x[3], buckets.y - buckets.y[3])
    away[3] = np.inf
    collide(float(buckets.x[away.argmin()]), float(buckets.y[away.argmin()]))
    figures = world.statistics()
    assert figures["bot_collisions"] == happened.count(EventType.BOT_COLLISION) == 2
    assert figures["bucket_collisions"] == happened.count(EventType.BUCKET_COLLISION) == 1


def test_bot_idle_time(run: Run) -> None:
    bots = run.warehouse.scenario.bots
    assert run.summary["bot_idle_fraction"] == pytest.approx(run.idle / (bots * SECONDS), abs=5e-3)


def test_average_bucket_capacity_utilization(run: Run) -> None:
    capacity = run.warehouse.scenario.buckets * run.warehouse.scenario.bucket.capacity
    tiles, since, area = run.tiles_at_start, 0.0, 0.0
    fill = {}
    for event in run.events:
        if event.type is EventType.TRANSFERRED:
            area += tiles * max(0.0, event.time - max(since, WARMUP_S))
            if since <= WARMUP_S < event.time:
                fill["start"] = tiles
            since = event.time
            tiles += -1 if run.is_word_station(event.station) else 1
    area += tiles * (END_S - max(since, WARMUP_S))
    assert run.summary["bucket_fill_mean"] == pytest.approx(area / SECONDS / capacity)
    assert run.summary["inventory_fill_start"] == pytest.approx(fill["start"] / capacity)
    assert run.summary["inventory_fill_end"] == pytest.approx(tiles / capacity)


def test_average_number_of_transfers_per_word_and_letter_station_visit(run: Run) -> None:
    # a visit: transfers of one bot at one station, between which it has neither grabbed nor released a bucket
    at: dict[int, int] = defaultdict(lambda: -1)
    tiles, visits = {True: 0, False: 0}, {True: 0, False: 0}
    for event in run.counted:
        if event.type in (EventType.GRABBED, EventType.RELEASED):
            at[event.bot] = -1
        elif event.type is EventType.TRANSFERRED:
            kind = run.is_word_station(event.station)
            tiles[kind] += 1
            visits[kind] += at[event.bot] != event.station
            at[event.bot] = event.station
    assert run.summary["pile_on_word"] == pytest.approx(tiles[True] / visits[True])
    assert run.summary["pile_on_letter"] == pytest.approx(tiles[False] / visits[False])


def test_station_idle_time(run: Run) -> None:
    scenario = run.warehouse.scenario
    busy = {True: 0.0, False: 0.0}
    for event in run.events + run.later:
        if event.type is EventType.TRANSFERRED:
            is_word = run.is_word_station(event.station)
            lasts = scenario.word_station.transfer_s if is_word else scenario.letter_station.transfer_s
        elif event.type is EventType.WORD_CLEARED:
            is_word, lasts = True, scenario.word_station.clear_s
        else:
            continue
        busy[is_word] += max(0.0, min(event.time, END_S) - max(event.time - lasts, WARMUP_S))
    words, letters = scenario.word_station_count * SECONDS, scenario.letter_station_count * SECONDS
    assert run.summary["word_station_idle_fraction"] == pytest.approx(1.0 - busy[True] / words)
    assert run.summary["letter_station_idle_fraction"] == pytest.approx(1.0 - busy[False] / letters)


# ---- "the maximum throughput is a function of the add/remove time and the number of letters per word" -------------


def test_the_bound_on_the_word_rate(run: Run) -> None:
    mean_letters = (2 + 2 + 3 + 3) / 4
    bound = 3 / (mean_letters * 0.5 + 3.0)
    assert run.summary["word_rate_bound"] == pytest.approx(bound)
    done = {EventType.TRANSFERRED: 0.5, EventType.WORD_CLEARED: 3.0}
    events = [event for event in run.counted if event.type in done and run.is_word_station(event.station)]
    busy = sum(min(done[event.type], event.time - WARMUP_S) for event in events)
    assert run.summary["fraction_of_bound"] == pytest.approx(busy / (3 * SECONDS))


def test_the_bound_of_the_fleet(run: Run) -> None:
    """Each letter takes two transfers and, where it came in and went out, its share of the way between the stations."""
    scenario, layout = run.warehouse.scenario, run.warehouse.layout
    places = layout.waypoints.tolist()
    apart = min(math.dist(places[a], places[b]) for a in layout.word_stations for b in layout.letter_stations)
    word, letter = scenario.word_station, scenario.letter_station
    way_s = (apart - word.tolerance_m - letter.tolerance_m) / scenario.bot.max_speed_mps / scenario.bucket.capacity
    bound = scenario.bots / ((2 + 2 + 3 + 3) / 4 * (word.transfer_s + letter.transfer_s + 2 * way_s))
    assert run.summary["fleet_rate_bound"] == pytest.approx(bound)
    busy = 0.0
    in_buckets: dict[bool, Counter[int]] = {True: Counter(), False: Counter()}  # letters brought, room made
    for event in run.counted:
        if event.type is not EventType.TRANSFERRED:
            continue
        is_word = run.is_word_station(event.station)
        busy += min(word.transfer_s if is_word else letter.transfer_s, event.time - WARMUP_S)
        if in_buckets[is_word][event.bucket] > 0:
            in_buckets[is_word][event.bucket] -= 1
            busy += way_s
        in_buckets[not is_word][event.bucket] += 1
    assert run.summary["fraction_of_fleet_bound"] == pytest.approx(busy / (scenario.bots * SECONDS))
    assert 0.0 < run.summary["fraction_of_fleet_bound"] < 1.0


@pytest.mark.parametrize(
    ("lines", "mean_letters"),
    [
        ("0,EXTRAORDINARY\n1,ANT\n", (13 + 3) / 2),
        ("0,A0 B1\n0,C2 D3 E0 F1\n5,QI\n", (2 + 4 + 2) / 3),
    ],
)
def test_the_bound_for_orders_from_a_file_is_about_the_words_of_that_file(
    tmp_path: Path, lines: str, mean_letters: float
) -> None:
    path = tmp_path / "orders.csv"
    path.write_text(lines)
    warehouse = load_warehouse(DEMO, [f"orders={{kind: file, path: {path}}}"])
    assert warehouse.words.mean_length != pytest.approx(mean_letters)
    for seconds in (0.0, 2.0):
        warehouse = load_warehouse(DEMO, [f"orders={{kind: file, path: {path}}}", f"word_station.clear_s={seconds}"])
        figures = warehouse.world(1).statistics()
        assert figures["word_rate_bound"] == pytest.approx(3 / (mean_letters * 1.0 + seconds))


def one_station(words: Path, *overrides: str) -> Warehouse:
    """One station, one bot that always stands there with every letter: nothing but the transfers takes time."""
    return load_warehouse(
        DEMO,
        [f"words={words}", "word_stations=1", "bots=1", "colours=[1.0]", "bucket.capacity=10000",
         "initial_inventory=1.0", "buckets=1", "bot.grab_s=0.0", "bot.tolerance_m=100.0",
         "word_station.tolerance_m=100.0", *overrides],
    )  # fmt: skip


@pytest.fixture(scope="module")
def never_waits(tmp_path_factory: pytest.TempPathFactory) -> Warehouse:
    """With long and short words."""
    words = tmp_path_factory.mktemp("words") / "words.txt"
    words.write_text("at extraordinary")
    return one_station(words)


def test_a_warehouse_whose_stations_never_wait_reaches_its_bound(tmp_path: Path) -> None:
    (tmp_path / "words.txt").write_text("ant bee")
    warehouse = one_station(tmp_path / "words.txt", "word_station.clear_s=1.0")
    world = warehouse.world(1)
    world.handle(m.Grab(0, 0, 0))
    world.advance(0.1)
    for word in range(1000):
        world.handle(m.AssignWord(word, 0))
        world.handle(m.Transfer(0, word + 1, 0, (m.TileMove(),) * 3))
        world.advance(world.now + 3 * warehouse.scenario.word_station.transfer_s + 1.0)
    figures = world.statistics()
    assert figures["fraction_of_bound"] == pytest.approx(1.0, rel=1e-2)
    assert figures["fraction_of_fleet_bound"] == pytest.approx(3 / 4, rel=1e-2)  # the bot waits for the clearing


@given(
    transfer_s=st.floats(0.1, 20.0),
    clear_s=st.sampled_from([0.0, 0.3, 7.0]),
    warmup_s=st.floats(0.0, 100.0),
    picks=st.lists(st.booleans(), min_size=1, max_size=12),
    ends_after=st.floats(0.0, 10.0),
)
@settings(max_examples=50)
def test_no_choice_of_words_exceeds_the_bound(
    never_waits: Warehouse, transfer_s: float, clear_s: float, warmup_s: float, picks: list[bool], ends_after: float
) -> None:
    """Whether short or long words are picked of a list of both, a station that never waits is at its bound."""
    scenario = never_waits.scenario
    station = scenario.word_station.model_copy(update={"transfer_s": transfer_s, "clear_s": clear_s})
    world = replace(never_waits, scenario=scenario.model_copy(update={"word_station": station})).world(1, warmup_s)
    world.handle(m.Grab(0, 0, 0))
    world.advance(0.01)
    for request, short in enumerate(picks, 1):
        word = min(world.snapshot().waiting_words, key=lambda word: len(word.tiles) if short else -len(word.tiles))
        world.handle(m.AssignWord(word.word, 0))
        world.handle(m.Transfer(0, request, 0, (m.TileMove(),) * len(word.tiles)))
        world.advance(world.now + len(word.tiles) * transfer_s + clear_s)
    until = world.now
    for now in (until, until + ends_after):
        world.advance(now)
        figures = world.statistics()
        assert figures["fraction_of_bound"] <= 1.0 + 1e-9
        assert figures["fraction_of_fleet_bound"] <= figures["fraction_of_bound"] + 1e-9  # clearing takes no bot
    assert world.statistics()["words_completed"] <= len(picks)


# ---- the summary --------------------------------------------------------------------------------------------------


def test_a_summary_holds_every_figure_and_what_was_run(run: Run) -> None:
    assert tuple(run.summary) == KEYS
    assert run.summary["sim_seconds"] == END_S
    assert run.summary["real_time_factor"] == pytest.approx(END_S / 10.0)
    assert run.summary["station_policies"] == {"word_station": "as_asked", "letter_station": "as_asked"}
    assert (run.summary["scenario"], run.summary["seed"], run.summary["violations"]) == ("demo", 3, 0)
