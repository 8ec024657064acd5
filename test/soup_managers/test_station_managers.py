"""Word and letter manager: they fill free places, ask the fleet for what jobs need, and ask again."""

from dataclasses import replace

import numpy as np
import pytest
from tiny_warehouse import BUCKETS, CAPACITY, let, tiny_world

from soup_managers.policies.letter import Minimal as MinimalLetter
from soup_managers.policies.word import Minimal as MinimalWord
from soup_managers.stations.letter_manager import LetterManager
from soup_managers.stations.word_manager import WordManager
from soup_managers.view import WarehouseView
from soup_msgs_py.codes import Code, EventType
from soup_msgs_py.messages import (
    DELIVER,
    STORE,
    AssignBundle,
    AssignWord,
    Bundle,
    DeliverGoal,
    Event,
    Reply,
    StoreGoal,
    TaskResult,
)
from soup_msgs_py.mind import NEVER
from soup_sim.world import World

DONE = Reply(Code.DONE, "")


def holding(*kinds: int) -> dict[int, dict[int, int]]:
    """Each bucket holds a tile of some kinds."""
    return {bucket: dict.fromkeys(kinds, 1) for bucket in range(BUCKETS)}


@pytest.fixture
def world() -> World:
    """Four waiting words of two letters; nine buckets, half full with kinds 0 to 3."""
    words = {0: (0, 1), 1: (2, 3), 2: (0, 0), 3: (1, 1)}
    return let(tiny_world(initial_inventory=0.5), contents=holding(0, 1, 2, 3), waiting=words)


def word_manager(world: World) -> WordManager:
    view = WarehouseView(world.scenario, world.layout)
    return WordManager(world.scenario, world.layout, MinimalWord(), view, np.random.default_rng(1))


def letter_manager(world: World) -> LetterManager:
    """Its profile: kinds 0 to 3, a quarter each."""
    view = WarehouseView(world.scenario, world.layout)
    profile = np.zeros(view.kinds)
    profile[:4] = 0.25
    return LetterManager(world.scenario, world.layout, MinimalLetter(), view, np.random.default_rng(1), profile)


def assigned(sequence: int, word: int, station: int) -> Event:
    return Event(0.0, sequence, EventType.WORD_ASSIGNED, job=word, station=station)


# words


def test_the_oldest_word_is_opened_first_and_its_letters_are_asked_of_the_fleet(world):
    manager = word_manager(world)
    assert manager.handle(world.snapshot(), 0.0) == [AssignWord(0, 0)]
    assert manager.handle(DONE, 0.0) == []
    assert manager.handle(assigned(1, 0, 0), 0.0) == [DeliverGoal(0, 0, 0, (0, 1)), AssignWord(1, 1)]


def test_the_event_may_come_before_the_reply(world):
    manager = word_manager(world)
    manager.handle(world.snapshot(), 0.0)
    assert manager.handle(assigned(1, 0, 0), 0.0) == [DeliverGoal(0, 0, 0, (0, 1))]
    assert manager.handle(DONE, 0.0) == [AssignWord(1, 1)]


def test_after_a_refusal_a_second_passes_before_it_asks_again(world):
    manager = word_manager(world)
    manager.handle(world.snapshot(), 0.0)
    assert manager.handle(Reply(Code.STATION_FULL, "no place"), 3.0) == []
    assert manager.next_wake == 4.0
    assert manager.wake(4.0) == [AssignWord(0, 0)]


def test_a_request_that_nobody_answers_is_made_again(world):
    manager = word_manager(world)
    manager.handle(world.snapshot(), 0.0)
    assert manager.wake(manager.next_wake) == [AssignWord(0, 0)]


def test_words_that_others_opened_are_asked_of_the_fleet_too(world):
    manager = word_manager(world)
    manager.handle(world.snapshot(), 0.0)
    assert manager.handle(assigned(1, 3, 1), 0.0) == [DeliverGoal(3, 1, 3, (1, 1))]


def test_a_new_word_manager_asks_for_what_open_words_still_lack(world):
    let(world, opened={0: (1, (0, 1), (1, 0))})
    assert word_manager(world).handle(world.snapshot(), 0.0)[0] == DeliverGoal(0, 1, 0, (1,))


def test_a_delivery_that_ended_early_is_asked_for_again_after_a_while(world):
    manager = word_manager(world)
    let(world, opened={0: (1, (0, 1), (1, 0))})
    manager.handle(world.snapshot(), 0.0)
    assert manager.handle(TaskResult(DELIVER, 0, Code.STOPPED, "gone"), 2.0) == []
    assert manager.next_wake == 3.0
    assert DeliverGoal(0, 1, 0, (1,)) in manager.wake(3.0)


def test_a_full_station_gets_no_word(world):
    let(world, opened={number: (number % 2, (0, 1), (0, 0)) for number in range(4)})
    manager = word_manager(world)
    said = manager.handle(world.snapshot(), 0.0)
    assert [type(message) for message in said] == [DeliverGoal] * 4
    assert manager.next_wake == NEVER


# letters


def test_nothing_comes_in_while_the_stock_is_what_it_was(world):
    manager = letter_manager(world)
    assert manager.handle(world.snapshot(), 0.0) == []


def test_the_kind_that_is_furthest_below_its_share_comes_in(world):
    let(world, contents=holding(0, 1, 3))
    manager = letter_manager(world)
    assert manager.handle(world.snapshot(), 0.0) == [AssignBundle(2, tile=2)]


def test_a_kind_that_open_words_lack_comes_before_all_others(world):
    let(world, contents=holding(0, 1) | {0: {0: 1, 1: 1, 3: 1}}, opened={9: (0, (3, 3, 7), (0, 0, 0))})
    manager = letter_manager(world)
    assert manager.handle(world.snapshot(), 0.0) == [AssignBundle(2, tile=3)]


def test_a_staged_bundle_is_to_be_stored(world):
    let(world, contents=holding(0, 1, 2, 3) | {0: {}, 1: {}})
    manager = letter_manager(world)
    (asked,) = manager.handle(world.snapshot(), 0.0)
    manager.handle(Reply(Code.DONE, "", 0), 0.0)
    event = Event(0.0, 1, EventType.BUNDLE_STAGED, station=asked.station, tile=asked.tile, job=0, count=3)
    said = manager.handle(event, 0.0)
    assert said[0] == StoreGoal(0, asked.station, 0, asked.tile, 3)
    assert isinstance(said[1], AssignBundle)


def test_bundles_that_arrived_are_staged_first_in_first_out(world):
    manager = letter_manager(world)
    snapshot = replace(world.snapshot(), waiting_bundles=(Bundle(5, 1, 3), Bundle(4, 2, 3)))
    assert manager.handle(snapshot, 0.0) == [AssignBundle(2, bundle=5)]
    manager.handle(DONE, 0.0)
    staged = Event(0.0, 1, EventType.BUNDLE_STAGED, station=2, tile=1, job=5, count=3)
    assert manager.handle(staged, 0.0)[1:] == [AssignBundle(3, bundle=4)]


def test_a_new_letter_manager_asks_for_what_is_left_of_staged_bundles(world):
    let(world, staged={0: (3, 1, 2)})
    assert letter_manager(world).handle(world.snapshot(), 0.0)[0] == StoreGoal(0, 3, 0, 1, 2)


def test_a_store_task_that_ended_early_is_asked_for_again(world):
    let(world, staged={0: (3, 1, 2)})
    manager = letter_manager(world)
    manager.handle(world.snapshot(), 0.0)
    manager.handle(TaskResult(STORE, 0, Code.UNKNOWN, "not staged"), 2.0)
    assert StoreGoal(0, 3, 0, 1, 2) in manager.wake(3.0)


def test_no_more_comes_in_than_the_buckets_hold(world):
    full = {bucket: {0: CAPACITY} for bucket in range(BUCKETS)}
    let(world, contents=full | {0: {0: CAPACITY - 2}})  # room for two tiles, a bundle has three
    assert letter_manager(world).handle(world.snapshot(), 0.0) == []
