"""The judge finds nothing in a legal history, and every law that is broken in it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from soup_msgs_py.codes import BotState, EventType
from soup_msgs_py.messages import (
    Bots,
    Buckets,
    Bundle,
    Event,
    LetterStationState,
    Snapshot,
    Word,
    WordStationState,
)
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.scenario.parameters import (
    BotParameters,
    BucketParameters,
    Floor,
    LetterStationParameters,
    WordStationParameters,
)
from soup_msgs_py.warehouse.layout import Layout
from soup_sim.validate import Judge, Law, judge_log

A, B, C = 0, 1, 2
SPOTS = [(10.0, 10.0), (14.0, 10.0), (18.0, 10.0), (22.0, 10.0), (26.0, 10.0)]
LETTER_STATION, WORD_STATION = (2.0, 10.0), (38.0, 10.0)
LANES = [(30.0, 10.0), (19.5, 10.0)]  # waypoints that are no storage spots, the second one too near to one

#   y=15             0 1            the bots at the end
#   y=10   L   0   1   2   .   .            W
#   y= 5       0   1                the bots at the start
LAYOUT = Layout(
    width_m=40.0,
    height_m=20.0,
    waypoints=np.array([*SPOTS, WORD_STATION, LETTER_STATION, *LANES]),
    edges=np.zeros((0, 2), np.int32),
    edge_weights=np.zeros(0),
    storage_spots=np.arange(5, dtype=np.int32),
    word_stations=np.array([5], np.int32),
    letter_stations=np.array([6], np.int32),
)
SCENARIO = Scenario(
    name="a court room",
    floor=Floor(width_m=40.0, height_m=20.0),
    bots=2,
    buckets=3,
    word_stations=1,
    letter_stations=1,
    bot=BotParameters(radius_m=1.0, max_speed_mps=4.0, collision_penalty_s=5.0, tolerance_m=0.1),
    bucket=BucketParameters(capacity=4),
    word_station=WordStationParameters(open_words=1, transfer_s=5.0, clear_s=2.0),
    letter_station=LetterStationParameters(staged_bundles=1, transfer_s=5.0),
    bundle_size=2,
    words="none.txt",
)


def bots(time: float, *places: tuple[float, float], carried: tuple[int, ...] = (-1, -1)) -> Bots:
    x, y = np.array(places, float).T
    still = np.zeros(len(places))
    state = np.full(len(places), BotState.FREE, np.uint8)
    return Bots(time, x, y, still, still, still, np.array(carried, np.int32), state)


def buckets(
    time: float,
    *places: tuple[float, float],
    on: tuple[int, ...] = (-1, -1, -1),
    tiles: tuple[int, ...] = (3, 1, 0),
) -> Buckets:
    x, y = np.array(places, float).T
    return Buckets(time, x, y, np.array(on, np.int32), np.array(tiles, np.uint16))


START = Snapshot(
    time=0.0,
    sequence=0,
    bots=bots(0.0, (10, 5), (14, 5)),
    buckets=buckets(0.0, *SPOTS[:3]),
    contents=({A: 2, B: 1}, {C: 1}, {}),
    word_stations=(WordStationState(0, *WORD_STATION, -1, ()),),
    letter_stations=(LetterStationState(1, *LETTER_STATION, -1, ()),),
    waiting_words=(Word(1, "ab", (A, B)),),
    waiting_bundles=(),
    words_completed=0,
    storage_spots=(0, 1, 2, 3, 4),
)


def happened(time: float, event_type: EventType, place: tuple[float, float] = (-1.0, -1.0), **what: Any) -> Event:
    return Event(time, 0, event_type, x=place[0], y=place[1], **what)


def numbered(events: list[Event]) -> list[Event]:
    return [replace(event, sequence=number) for number, event in enumerate(events, 1)]


T = EventType
at_word, at_letter = {"bot": 0, "bucket": 0, "station": 0}, {"bot": 1, "bucket": 1, "station": 1}
HISTORY = {
    "assign": happened(0, T.WORD_ASSIGNED, job=1, station=0),
    "stage": happened(0, T.BUNDLE_STAGED, job=7, tile=C, count=2, station=1),
    "grab": happened(2, T.GRABBED, SPOTS[0], bot=0, bucket=0),
    "A": happened(14.5, T.TRANSFERRED, WORD_STATION, **at_word, tile=A, job=1),
    "B": happened(19.5, T.TRANSFERRED, WORD_STATION, **at_word, tile=B, job=1),
    "complete": happened(19.5, T.WORD_COMPLETED, job=1, station=0, count=2),
    "clear": happened(21.5, T.WORD_CLEARED, job=1, station=0),
    "second grab": happened(22, T.GRABBED, SPOTS[1], bot=1, bucket=1),
    "bundle": happened(23, T.BUNDLE_ARRIVED, job=8, tile=C, count=2),
    "C": happened(30, T.TRANSFERRED, LETTER_STATION, **at_letter, tile=C, job=7),
    "last C": happened(35, T.TRANSFERRED, LETTER_STATION, **at_letter, tile=C, job=7),
    "empty": happened(35, T.BUNDLE_EMPTIED, job=7, station=1),
    "stage again": happened(35, T.BUNDLE_STAGED, job=8, tile=C, count=2, station=1),
    "release": happened(40, T.RELEASED, SPOTS[4], bot=0, bucket=0),
    "order": happened(41, T.WORD_ARRIVED, job=2, tiles=(C, A, B), text="cab"),
    "collide": happened(44, T.BOT_COLLISION, (17.0, 15.0), bots=(0, 1)),
    "resume": happened(49, T.RESUMED, bot=0),
    "second resume": happened(49, T.RESUMED, bot=1),
    "make spot": happened(49.5, T.SPOT_MADE, LANES[0], waypoint=7),
    "remove spot": happened(49.5, T.SPOT_REMOVED, SPOTS[3], waypoint=3),
}
NAMES = list(HISTORY)
END = Snapshot(
    time=50.0,
    sequence=len(HISTORY),
    bots=bots(50.0, (16, 15), (18, 15), carried=(-1, 1)),
    buckets=buckets(50.0, SPOTS[4], (18, 15), SPOTS[2], on=(-1, 1, -1), tiles=(1, 3, 0)),
    contents=({A: 1}, {C: 3}, {}),
    word_stations=(WordStationState(0, *WORD_STATION, -1, ()),),
    letter_stations=(LetterStationState(1, *LETTER_STATION, -1, (Bundle(8, C, 2),)),),
    waiting_words=(Word(2, "cab", (C, A, B)),),
    waiting_bundles=(),
    words_completed=1,
    storage_spots=(0, 1, 2, 4, 7),
)

Story = dict[str, Event]
Change = Callable[[Story], Story]


def judged(story: Story, start: Snapshot = START, end: Snapshot = END, scenario: Scenario = SCENARIO) -> Judge:
    events = numbered(list(story.values()))
    return judge_log(scenario, LAYOUT, start, events, replace(end, sequence=len(events)))


def expect(judge: Judge, law: Law, words: str) -> None:
    said = [f"{violation.law}: {violation.sentence}" for violation in judge.violations]
    assert any(sentence.startswith(f"{law}: ") and words in sentence for sentence in said), said


def alter(name: str, **what: Any) -> Change:
    """The same story with one event told otherwise."""
    return lambda story: {n: replace(e, **what) if n == name else e for n, e in story.items()}


def add(after: str, event: Event) -> Change:
    """The same story with one more event."""

    def change(story: Story) -> Story:
        at = NAMES.index(after) + 1
        told = list(story.items())
        return dict([*told[:at], ("added", event), *told[at:]])

    return change


def drop(name: str) -> Change:
    """The same story without an event."""
    return lambda story: {n: e for n, e in story.items() if n != name}


def both(first: Change, second: Change) -> Change:
    return lambda story: second(first(story))


def test_a_legal_history_breaks_no_law():
    judge = judged(HISTORY)
    assert judge.violations == []
    assert judge.count == 0


def test_a_legal_history_breaks_no_law_whenever_one_looks():
    judge = Judge(SCENARIO, LAYOUT, START)
    events = numbered(list(HISTORY.values()))
    collided = NAMES.index("collide")
    for event in events[:2]:
        judge.event(event)
    judge.poses(bots(1.0, (10, 9), (14, 5)), buckets(1.0, *SPOTS[:3]))
    judge.event(events[2])
    judge.poses(bots(3.0, (12, 13), (14, 5), carried=(0, -1)), buckets(3.0, (12, 13), *SPOTS[1:3], on=(0, -1, -1)))
    for event in events[3 : collided + 1]:
        judge.event(event)
    for time in (44.0, 46.0, 49.0):
        judge.poses(replace(END.bots, time=time), replace(END.buckets, time=time))
    for event in events[collided + 1 :]:
        judge.event(event)
    judge.poses(replace(END.bots, time=49.5), replace(END.buckets, time=49.5))
    judge.finish(END)
    assert judge.violations == []


@pytest.mark.parametrize("name", [name for name in NAMES if name != "bundle"])
def test_a_history_that_leaves_an_event_out_is_found_out(name: str):
    assert judged(drop(name)(HISTORY)).count > 0


@pytest.mark.parametrize("name", [name for name in NAMES if name != "collide"])
def test_a_history_that_tells_an_event_twice_is_found_out(name: str):
    assert judged(add(name, HISTORY[name])(HISTORY)).count > 0


X_WORD = happened(16, T.WORD_ARRIVED, job=5, tiles=(A,), text="a")
WRONG_HISTORIES: dict[str, tuple[Change, Law, str]] = {
    "time_goes_back": (
        alter("order", time=39.0),
        Law.CLOCK,
        "event 15 (word_arrived) is at 39 s, after one at 40 s",
    ),
    "time_is_no_number": (alter("order", time=math.nan), Law.CLOCK, "is at nan s"),
    # tiles
    "a_tile_comes_out_of_a_bucket_that_has_none": (
        alter("A", tile=C),
        Law.TILES,
        "tile C0 came out of bucket 0, which holds none",
    ),
    "a_tile_goes_into_a_word_that_does_not_need_it": (
        alter("B", tile=A),
        Law.TILES,
        "tile A0 went into word 1, which does not need it",
    ),
    "a_tile_goes_into_a_word_that_is_not_open": (
        alter("A", job=3),
        Law.TILES,
        "tile A0 went into word 3, which is not open at word station 0",
    ),
    "a_tile_comes_out_of_a_bundle_that_is_not_staged": (
        alter("C", job=8),
        Law.TILES,
        "tile C0 came out of bundle 8, which is not staged at letter station 1",
    ),
    "a_tile_comes_out_of_a_bundle_of_another_kind": (
        alter("C", tile=B),
        Law.TILES,
        "tile B0 came out of bundle 7, which holds tiles C0",
    ),
    "a_tile_comes_out_of_an_empty_bundle": (
        add("last C", replace(HISTORY["last C"], time=40.0)),
        Law.TILES,
        "tile C0 came out of bundle 7, which is empty",
    ),
    "a_bundle_is_staged_with_other_tiles": (
        alter("stage again", tile=A),
        Law.TILES,
        "bundle 8 arrived with 2 tiles C0 and was staged with 2 tiles A0",
    ),
    # words
    "a_word_is_assigned_twice": (
        add("assign", HISTORY["assign"]),
        Law.WORDS,
        "word 1 was assigned to word station 0, but it was not waiting",
    ),
    "a_word_is_assigned_to_a_letter_station": (
        alter("assign", station=1),
        Law.NUMBERS,
        "word 1 was assigned to letter station 1, no word station",
    ),
    "a_word_arrives_twice": (alter("order", job=1), Law.WORDS, "word 1 arrived a second time"),
    "a_word_is_completed_too_early": (
        add("A", replace(HISTORY["complete"], time=14.5)),
        Law.WORDS,
        "word 1 was completed: 1 of its letters are missing",
    ),
    "a_word_is_completed_too_late": (
        alter("complete", time=20.0),
        Law.WORDS,
        "word 1 was not completed when its last letter came in at 19.5 s",
    ),
    "a_word_is_completed_twice": (
        add("complete", HISTORY["complete"]),
        Law.WORDS,
        "word 1 was completed: it was already",
    ),
    "a_word_is_completed_that_is_not_open": (
        add("grab", happened(3, T.WORD_COMPLETED, job=9, station=0, count=2)),
        Law.WORDS,
        "word 9 was completed: it is not open at word station 0",
    ),
    "a_word_is_completed_with_more_letters_than_it_has": (
        alter("complete", count=3),
        Law.WORDS,
        "word 1 was completed: with 3 letters instead of 2",
    ),
    "a_word_is_cleared_too_early": (
        alter("clear", time=20.5),
        Law.WORDS,
        "word 1 was cleared 1 s after it was completed instead of 2 s",
    ),
    "a_word_is_cleared_before_it_is_completed": (
        add("A", replace(HISTORY["clear"], time=15.0)),
        Law.WORDS,
        "word 1 was cleared before it was completed",
    ),
    "a_completed_word_keeps_its_place_until_it_is_cleared": (
        both(
            add("complete", happened(19.5, T.WORD_ASSIGNED, job=5, station=0)),
            lambda story: {"more": replace(X_WORD, time=0.0), **story},
        ),
        Law.CAPACITY,
        "word station 0 has 2 open words, at most 1 fit",
    ),
    # bundles
    "a_bundle_has_another_size": (
        alter("bundle", count=3),
        Law.BUNDLES,
        "bundle 8 came in with 3 tiles, the size of a bundle is 2",
    ),
    "a_bundle_comes_in_twice": (alter("bundle", job=7), Law.BUNDLES, "bundle 7 came in a second time"),
    "a_bundle_is_staged_on_a_word_station": (
        alter("stage", station=0),
        Law.NUMBERS,
        "bundle 7 was staged on station 0: no letter station",
    ),
    "a_bundle_is_staged_where_no_place_is_free": (
        alter("bundle", type=T.BUNDLE_STAGED, station=1),
        Law.CAPACITY,
        "letter station 1 has 2 staged bundles, 1 fit",
    ),
    "a_bundle_is_emptied_with_tiles_in_it": (
        add("C", replace(HISTORY["empty"], time=30.0)),
        Law.BUNDLES,
        "bundle 7 was emptied with 1 tiles in it",
    ),
    "a_bundle_is_emptied_too_late": (
        both(alter("empty", time=36.0), alter("stage again", time=36.0)),
        Law.BUNDLES,
        "bundle 7 was not emptied when its last tile left at 35 s",
    ),
    "a_bundle_is_emptied_that_is_not_staged": (
        alter("empty", job=9),
        Law.BUNDLES,
        "bundle 9 was emptied: it is not staged at letter station 1",
    ),
    # buckets, stations and bots
    "a_station_does_two_things_at_a_time": (
        both(
            alter("second grab", time=2.0),
            add("A", happened(17, T.TRANSFERRED, WORD_STATION, bot=1, bucket=1, station=0, tile=B, job=1)),
        ),
        Law.STATIONS,
        "word station 0 transferred 2.5 s after it was free, it takes 5 s",
    ),
    "a_station_transfers_while_it_clears_a_word": (
        add("clear", happened(24.5, T.TRANSFERRED, WORD_STATION, **at_word, tile=A, job=1)),
        Law.STATIONS,
        "word station 0 transferred 3 s after it was free, it takes 5 s",
    ),
    "a_bot_transfers_too_early_after_its_grab": (
        alter("C", time=26.9),
        Law.OPERATIONS,
        "bot 1 transferred 4.9 s after its last operation, not 5 s",
    ),
    "a_bot_grabs_in_no_time": (
        both(alter("release", time=35.0), add("release", happened(35.2, T.GRABBED, SPOTS[4], bot=0, bucket=0))),
        Law.OPERATIONS,
        "bot 0 grabbed 0.2 s after its last operation, not 0.5 s",
    ),
    "a_bot_releases_in_no_time": (
        alter("release", time=19.9),
        Law.OPERATIONS,
        "bot 0 released 0.4 s after its last operation, not 0.5 s",
    ),
    "a_transfer_happens_away_from_the_station": (
        alter("A", x=37.8),
        Law.TOLERANCE,
        "bot 0 transferred 0.2 m away from word station 0",
    ),
    "a_transfer_uses_a_bucket_that_is_not_on_the_bot": (
        alter("A", bucket=1),
        Law.CARRYING,
        "bot 0 transferred from or to bucket 1, which it did not carry",
    ),
    "a_transfer_happens_at_no_station": (
        alter("A", station=2),
        Law.NUMBERS,
        "bot 0 transferred at station 2: there is none",
    ),
    "a_bot_that_does_not_exist_grabs": (
        alter("grab", bot=2),
        Law.NUMBERS,
        "bot 2 grabbed bucket 0: there is no such bot or bucket",
    ),
    "a_bucket_is_grabbed_from_afar": (
        alter("grab", x=10.2),
        Law.TOLERANCE,
        "bot 0 grabbed bucket 0 from 0.2 m away",
    ),
    "a_bucket_is_grabbed_from_no_place": (alter("grab", x=math.nan), Law.TOLERANCE, "from nan m away"),
    "a_bucket_is_grabbed_from_another_bot": (
        alter("second grab", bucket=0),
        Law.CARRYING,
        "bot 1 grabbed bucket 0, which bot 0 carried",
    ),
    "a_bot_grabs_a_second_bucket": (
        alter("second grab", bot=0, time=30.0),
        Law.CARRYING,
        "bot 0 grabbed bucket 1 while it carried bucket 0",
    ),
    "a_bot_releases_what_it_does_not_carry": (
        alter("release", bucket=2),
        Law.CARRYING,
        "bot 0 released bucket 2, which it did not carry",
    ),
    "a_bucket_is_released_beside_a_storage_spot": (
        alter("release", x=26.2),
        Law.TOLERANCE,
        "bot 0 released bucket 0 at (26.2, 10), where no storage spot is",
    ),
    "a_bucket_is_released_on_another_one": (
        alter("release", x=18.0),
        Law.STORAGE,
        "bucket 0 rests at (18, 10), where bucket 2 rests already",
    ),
    "a_bucket_is_released_where_a_storage_spot_was": (
        add("second grab", happened(23, T.SPOT_REMOVED, SPOTS[4], waypoint=4)),
        Law.TOLERANCE,
        "bot 0 released bucket 0 at (26, 10), where no storage spot is",
    ),
    "a_storage_spot_is_removed_under_a_bucket": (
        alter("remove spot", waypoint=2, x=18.0),
        Law.STORAGE,
        "storage spot 2 was removed under bucket 2",
    ),
    "a_storage_spot_is_removed_where_none_is": (
        alter("remove spot", waypoint=8, x=19.5),
        Law.STORAGE,
        "spot_removed at waypoint 8, where none is",
    ),
    "a_storage_spot_is_made_where_one_is": (
        alter("make spot", waypoint=3, x=22.0),
        Law.STORAGE,
        "spot_made at waypoint 3, where one is already",
    ),
    "a_storage_spot_is_made_elsewhere": (
        alter("make spot", x=30.5),
        Law.STORAGE,
        "spot_made at (30.5, 10), waypoint 7 is at (30, 10)",
    ),
    "a_storage_spot_is_made_at_no_waypoint": (
        alter("make spot", waypoint=9),
        Law.NUMBERS,
        "spot_made at waypoint 9, which is none",
    ),
    "a_storage_spot_is_made_on_a_station": (
        alter("make spot", waypoint=5, x=38.0),
        Law.STORAGE,
        "waypoint 5 is a station and became a storage spot",
    ),
    "a_storage_spot_is_made_too_near_to_another_one": (
        alter("make spot", waypoint=8, x=19.5),
        Law.STORAGE,
        "storage spots 8 and 2 are too near for two buckets",
    ),
    "a_bot_is_faster_than_it_can_be": (alter("A", time=8.9), Law.SPEED, "bot 0 moved 28 m in 6.9 s"),
    # collisions
    "a_bot_resumes_too_early": (
        alter("resume", time=48.0),
        Law.COLLISIONS,
        "bot 0 resumed 4 s after its last collision instead of 5 s",
    ),
    "a_bot_resumes_too_late": (
        both(alter("second resume", time=49.5), alter("resume", time=49.5)),
        Law.COLLISIONS,
        "bot 0 resumed 5.5 s after its last collision instead of 5 s",
    ),
    "a_bot_resumes_in_spite_of_a_second_collision": (
        add("collide", happened(46, T.BUCKET_COLLISION, (17, 15), bots=(1,), buckets=(1, 2))),
        Law.COLLISIONS,
        "bot 1 resumed 3 s after its last collision instead of 5 s",
    ),
    "a_bot_never_resumes": (
        drop("resume"),
        Law.COLLISIONS,
        "bot 0 has not resumed, 6 s after its last collision",
    ),
    "a_bot_resumes_without_a_collision": (
        alter("resume", bot=1),
        Law.COLLISIONS,
        "bot 1 resumed without a collision",
    ),
    "a_bot_that_does_not_exist_collides": (
        alter("collide", bots=(0, 1, 2)),
        Law.NUMBERS,
        "there is no bot 2, it cannot collide",
    ),
}


@pytest.mark.parametrize("name", WRONG_HISTORIES)
def test_in_a_wrong_history(name: str):
    change, law, words = WRONG_HISTORIES[name]
    expect(judged(change(HISTORY)), law, words)


def test_an_event_number_is_missing():
    events = numbered(list(HISTORY.values()))
    judge = judge_log(SCENARIO, LAYOUT, START, events[:14] + events[15:], END)
    expect(judge, Law.SEQUENCE, "event 16 (bot_collision) came after event 14")


def test_more_tiles_are_in_a_bucket_than_fit():
    start = replace(START, contents=({A: 2, B: 1}, {C: 3}, {}), buckets=buckets(0, *SPOTS[:3], tiles=(3, 3, 0)))
    expect(judged(HISTORY, start), Law.CAPACITY, "bucket 1 holds 5 tiles, at most 4 fit")


def test_a_bucket_starts_with_more_than_it_holds():
    start = replace(START, contents=({A: 5}, {C: 1}, {}))
    expect(judged(HISTORY, start), Law.CAPACITY, "bucket 0 starts with the contents {0: 5}")


def test_two_buckets_start_on_one_storage_spot():
    start = replace(START, buckets=buckets(0, SPOTS[0], SPOTS[1], (14.05, 10)))
    expect(judged(HISTORY, start), Law.STORAGE, "bucket 2 rests at (14.05, 10), where bucket 1 rests already")


def test_a_bot_that_starts_with_a_penalty_resumes_within_it():
    penalised = replace(START.bots, state=np.array([BotState.PENALISED, BotState.FREE], np.uint8))
    start = replace(START, bots=penalised)
    story = {"resumed": happened(0.5, T.RESUMED, bot=0), **HISTORY}
    story["assign"], story["stage"] = (replace(story[name], time=0.5) for name in ("assign", "stage"))
    assert judged(story, start).violations == []
    expect(judged(HISTORY, start), Law.COLLISIONS, "bot 0 moved 5 m and must stand after a collision")


def test_a_snapshot_in_the_middle_of_a_word_is_a_good_start():
    """Judging may begin anywhere: with a letter in a word, a tile out of a bundle, a bucket on a bot."""
    begun = list(HISTORY.values())[: NAMES.index("B")]
    middle = replace(
        START,
        time=15.0,
        sequence=0,
        bots=bots(15.0, WORD_STATION, (14, 5), carried=(0, -1)),
        buckets=buckets(15.0, WORD_STATION, *SPOTS[1:3], on=(0, -1, -1), tiles=(2, 1, 0)),
        contents=({A: 1, B: 1}, {C: 1}, {}),
        word_stations=(WordStationState(0, *WORD_STATION, 0, (Word(1, "ab", (A, B), (True, False)),)),),
        letter_stations=(LetterStationState(1, *LETTER_STATION, -1, (Bundle(7, C, 2),)),),
        waiting_words=(),
    )
    transferring = np.array([BotState.TRANSFERRING, BotState.FREE], np.uint8)
    middle = replace(middle, bots=replace(middle.bots, state=transferring))
    assert judge_log(SCENARIO, LAYOUT, START, numbered(begun), replace(middle, sequence=len(begun))).count == 0
    rest = dict(list(HISTORY.items())[len(begun) :])
    assert judged(rest, middle).violations == []


WRONG_ENDS: dict[str, tuple[dict[str, Any], Law, str]] = {
    "another_event_was_last": (
        {"sequence": 30},
        Law.SEQUENCE,
        "the snapshot follows event 30, the last event is 20",
    ),
    "it_is_older_than_the_last_event": (
        {"time": 48.0},
        Law.CLOCK,
        "the snapshot is from 48 s, the last event from 49.5 s",
    ),
    "a_tile_is_lost": ({"contents": ({}, {C: 3}, {})}, Law.TILES, "1 tiles A0 were lost in this run"),
    "a_tile_is_made": (
        {"contents": ({A: 1}, {C: 3, B: 1}, {})},
        Law.TILES,
        "1 tiles B0 were made in this run",
    ),
    "a_tile_is_in_another_bucket": (
        {"contents": ({}, {C: 3}, {A: 1})},
        Law.TILES,
        "bucket 2 holds 1 tiles A0 in the snapshot, 0 by the events",
    ),
    "a_bucket_is_missing": (
        {"contents": ({A: 1}, {C: 3})},
        Law.NUMBERS,
        "the snapshot holds the contents of 2 buckets, there are 3",
    ),
    "a_waiting_word_is_lost": (
        {"waiting_words": ()},
        Law.SNAPSHOT,
        "word 2 does not wait in the snapshot, but does by the events",
    ),
    "a_waiting_word_has_other_letters": (
        {"waiting_words": (Word(2, "cab", (C, A, A)),)},
        Law.SNAPSHOT,
        "word 2 waits with other letters than it arrived with",
    ),
    "a_word_is_open_that_was_never_assigned": (
        {"word_stations": (WordStationState(0, *WORD_STATION, -1, (Word(2, "c", (C,)),)),)},
        Law.SNAPSHOT,
        "word 2 is open in the snapshot, not by the events",
    ),
    "a_bundle_has_lost_a_tile": (
        {"letter_stations": (LetterStationState(1, *LETTER_STATION, -1, (Bundle(8, C, 1),)),)},
        Law.SNAPSHOT,
        "bundle 8 is on letter station 1 with 1 tiles C0 in the snapshot, on letter station 1 with 2",
    ),
    "a_bundle_is_gone": (
        {"letter_stations": (LetterStationState(1, *LETTER_STATION, -1, ()),)},
        Law.SNAPSHOT,
        "bundle 8 is nowhere in the snapshot",
    ),
    "a_storage_spot_is_gone": (
        {"storage_spots": (0, 1, 2, 4)},
        Law.SNAPSHOT,
        "waypoint 7 is no storage spot in the snapshot, but is by the events",
    ),
    "a_storage_spot_is_still_there": (
        {"storage_spots": (0, 1, 2, 3, 4, 7)},
        Law.SNAPSHOT,
        "waypoint 3 is one in the snapshot, not by the events",
    ),
    "more_words_are_completed": (
        {"words_completed": 2},
        Law.SNAPSHOT,
        "the snapshot counts 2 completed words, the events 1",
    ),
}


@pytest.mark.parametrize("name", WRONG_ENDS)
def test_in_the_last_snapshot(name: str):
    change, law, words = WRONG_ENDS[name]
    judge = judge_log(SCENARIO, LAYOUT, START, numbered(list(HISTORY.values())), replace(END, **change))
    expect(judge, law, words)


@pytest.mark.parametrize(
    ("open_word", "words"),
    [
        (
            Word(1, "ab", (A, B), (False, False)),
            "word 1 lacks 2 letters in the snapshot, 1 or others by events",
        ),
        (Word(1, "aa", (A, A), (True, False)), "word 1 is on another station or has other letters"),
        (None, "word 1 is not open in the snapshot, but is by the events"),
    ],
)
def test_an_open_word_of_the_last_snapshot_is_not_what_it_became(open_word: Word | None, words: str):
    events = numbered(list(HISTORY.values()))[: NAMES.index("B")]
    station = WordStationState(0, *WORD_STATION, -1, (open_word,) if open_word else ())
    expect(
        judge_log(SCENARIO, LAYOUT, START, events, replace(END, word_stations=(station,))),
        Law.SNAPSHOT,
        words,
    )


@pytest.mark.parametrize(
    ("last", "words"),
    [
        ("complete", "word 1 has all its letters since 19.5 s and was never completed"),
        ("empty", "bundle 7 has no tiles since 35 s and was never emptied"),
    ],
)
def test_a_history_ends_before_what_was_due(last: str, words: str):
    events = numbered(list(HISTORY.values()))[: NAMES.index(last)]
    expect(judge_log(SCENARIO, LAYOUT, START, events, END), Law.SNAPSHOT, words)


# Looking once, 10 s after the start, when bot 0 has grabbed bucket 0 and taken it to (26, 14).
LOOK_BOTS = bots(10.0, (26, 14), (14, 5), carried=(0, -1))
LOOK_BUCKETS = buckets(10.0, (26, 14), *SPOTS[1:3], on=(0, -1, -1))


def looked(change_bots: dict[str, Any], change_buckets: dict[str, Any], times: int = 1) -> Judge:
    judge = Judge(SCENARIO, LAYOUT, START)
    for event in numbered(list(HISTORY.values())[:3]):
        judge.event(event)
    for _ in range(times):
        judge.poses(replace(LOOK_BOTS, **change_bots), replace(LOOK_BUCKETS, **change_buckets))
    return judge


def array(*values: float) -> np.ndarray:
    return np.array(values, float)


def numbers(*values: int) -> np.ndarray:
    return np.array(values, np.int32)


def test_a_legal_look_breaks_no_law():
    assert looked({}, {}, times=2).violations == []


WRONG_LOOKS: dict[str, tuple[dict[str, Any], dict[str, Any], Law, str]] = {
    "a_bot_is_off_the_floor": ({"x": array(26, -0.1)}, {}, Law.FLOOR, "bot 1 is off the floor, at (-0.1, 5)"),
    "a_bucket_is_off_the_floor": (
        {},
        {"y": array(20.1, 10, 10)},
        Law.FLOOR,
        "bucket 0 is off the floor, at (26, 20.1)",
    ),
    "two_bots_overlap": (
        {"x": array(26, 27.5), "y": array(14, 14)},
        {},
        Law.OVERLAP,
        "bots 0 and 1 overlap, 1.5 m",
    ),
    "a_carried_bucket_overlaps_a_resting_one": (
        {"x": array(19, 14), "y": array(11, 5)},
        {"x": array(19, 14, 18), "y": array(11, 10, 10)},
        Law.OVERLAP,
        "buckets 0 and 2 overlap, 1.41421 m apart, and one of them is carried",
    ),
    "a_carried_bucket_is_not_where_its_bot_is": (
        {},
        {"x": array(26.01, 14, 18)},
        Law.CARRYING,
        "bucket 0 is not where bot 0 is, which carries it",
    ),
    "a_bucket_is_on_two_bots": (
        {"bucket": numbers(0, 0)},
        {},
        Law.CARRYING,
        "bot 1 carries bucket 0, that is on bot 0",
    ),
    "two_buckets_are_on_a_bot": (
        {},
        {"bot": numbers(0, 0, -1)},
        Law.CARRYING,
        "bucket 1 is on bot 0, that has bucket 0",
    ),
    "a_bot_carries_a_bucket_that_there_is_not": (
        {"bucket": numbers(0, 3)},
        {},
        Law.NUMBERS,
        "bot 1 carries bucket 3, which is none",
    ),
    "a_bucket_is_on_a_bot_that_there_is_not": (
        {},
        {"bot": numbers(0, 2, -1)},
        Law.NUMBERS,
        "bucket 1 is on bot 2, which is none",
    ),
    "a_bot_carries_a_bucket_that_it_never_grabbed": (
        {"bucket": numbers(0, 1)},
        {"bot": numbers(0, 1, -1)},
        Law.SNAPSHOT,
        "bot 1 carries bucket 1 in the poses, -1 by the events",
    ),
    "a_bucket_is_on_a_bot_that_never_grabbed_it": (
        {"bucket": numbers(0, 1)},
        {"bot": numbers(0, 1, -1)},
        Law.SNAPSHOT,
        "bucket 1 is on bot 1 in the poses, -1 by the events",
    ),
    "a_resting_bucket_moves_to_another_spot": (
        {},
        {"x": array(26, 14, 22)},
        Law.STORAGE,
        "bucket 2 moved 4 m from where it rests",
    ),
    "a_bucket_rests_beside_a_storage_spot": (
        {},
        {"x": array(26, 14, 19)},
        Law.STORAGE,
        "bucket 2 rests at (19, 10), where no storage spot is",
    ),
    "a_bot_tells_of_too_high_a_speed": (
        {"vx": array(3, 0), "vy": array(3, 0)},
        {},
        Law.SPEED,
        "bot 0 drives at 4.24264 m/s, its maximum is 4 m/s",
    ),
    "a_bot_is_where_it_cannot_have_come": (
        {"x": array(39, 14), "y": array(0, 5), "time": 9.0},
        {"x": array(39, 14, 18), "y": array(0, 10, 10), "time": 9.0},
        Law.SPEED,
        "bot 0 moved 30.6757 m in 7 s",
    ),
    "a_bucket_has_another_number_of_tiles": (
        {},
        {"tiles": np.array([3, 1, 1], np.uint16)},
        Law.TILES,
        "bucket 2 holds 1 tiles in the poses, 0 by the events",
    ),
    "a_place_is_no_number": (
        {"x": array(math.nan, 14)},
        {},
        Law.NUMBERS,
        "bot 0 has a place, heading or speed that is no number",
    ),
    "a_bucket_is_nowhere": ({}, {"y": array(14, math.inf, 10)}, Law.NUMBERS, "bucket 1 has a place"),
    "a_bot_is_missing": ({"x": array(26)}, {}, Law.NUMBERS, "the poses show too few or too many bots"),
    "buckets_are_from_another_time": (
        {},
        {"time": 9.0},
        Law.CLOCK,
        "poses of buckets at 9 s, of bots at 10 s",
    ),
}


@pytest.mark.parametrize("name", WRONG_LOOKS)
def test_at_one_look(name: str):
    change_bots, change_buckets, law, words = WRONG_LOOKS[name]
    expect(looked(change_bots, change_buckets), law, words)


def test_bots_that_touch_do_not_overlap():
    assert looked({"x": array(26, 24), "y": array(14, 14)}, {}).violations == []


def test_an_unloaded_bot_may_be_under_a_resting_bucket():
    assert looked({"y": array(14, 10)}, {}).violations == []


def test_what_stays_wrong_is_counted_once():
    assert looked({}, {"x": array(26, 14, 22)}, times=3).count == 1


def test_poses_go_back_in_time():
    judge = looked({}, {})
    judge.poses(replace(LOOK_BOTS, time=9.0), replace(LOOK_BUCKETS, time=9.0))
    expect(judge, Law.CLOCK, "poses at 9 s came after poses at 10 s")


def test_poses_that_are_older_than_the_last_event_need_not_agree_with_it():
    judge = Judge(SCENARIO, LAYOUT, START)
    for event in numbered(list(HISTORY.values())[:3]):
        judge.event(event)
    judge.poses(replace(START.bots, time=0.5), replace(START.buckets, time=0.5))
    assert judge.violations == []


def test_a_bot_drives_while_it_must_stand():
    judge = Judge(SCENARIO, LAYOUT, START)
    judge.event(Event(1.0, 1, T.BOT_COLLISION, bots=(0, 1)))
    judge.poses(
        replace(START.bots, time=2.0, vx=array(1, 0)),
        replace(START.buckets, time=2.0),
    )
    expect(judge, Law.COLLISIONS, "bot 0 drives at 1 m/s and must stand after a collision")


def test_a_bot_moves_while_it_must_stand():
    judge = Judge(SCENARIO, LAYOUT, START)
    judge.event(Event(0.0, 1, T.BOT_COLLISION, bots=(0, 1)))
    judge.poses(replace(START.bots, time=2.0, x=array(10, 14.5)), replace(START.buckets, time=2.0))
    judge.event(Event(3.0, 2, T.GRABBED, bot=0, bucket=0, x=10.0, y=10.0))
    expect(judge, Law.COLLISIONS, "bot 1 moved 0.5 m and must stand after a collision")
    expect(judge, Law.COLLISIONS, "bot 0 moved 5 m and must stand after a collision")


def test_a_bot_drives_on_after_its_penalty_at_no_more_than_its_speed():
    """Seen before the collision and after the penalty only: the time of the penalty is no time to drive."""
    for distance, count in ((8.0, 0), (8.1, 1)):
        judge = Judge(SCENARIO, LAYOUT, START)
        judge.event(Event(1.0, 1, T.BOT_COLLISION, bots=(1,)))
        judge.event(Event(6.0, 2, T.RESUMED, bot=1))
        judge.poses(replace(START.bots, time=7.0, x=array(10, 14 + distance)), replace(START.buckets, time=7.0))
        assert judge.count == count


def test_all_violations_are_counted_but_only_some_kept():
    judge = Judge(SCENARIO, LAYOUT, START, keep=3)
    for sequence in range(1, 11):
        judge.event(Event(1.0, sequence, T.RESUMED, bot=0))
    assert judge.count == 10
    assert len(judge.violations) == 3
    assert judge.violations[0].time == 1.0
