"""What the page is told about the warehouse."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from soup_dashboard.page import Shown
from soup_dashboard.store import LATEST_WORDS, Store
from soup_msgs_py.codes import BotState, EventType
from soup_msgs_py.messages import (
    Bots,
    Buckets,
    Bundle,
    Event,
    LetterStationState,
    Stations,
    Word,
    WordStationState,
)
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.scenario.parameters import Floor
from soup_msgs_py.warehouse.layout import Layout

# letter station 1 . . storage spot . . word station 0
LAYOUT = Layout(
    40.0,
    20.0,
    np.array([[38.0, 10.0], [2.0, 10.0], [20.0, 10.0]]),
    np.array([[0, 2], [2, 1]], dtype=np.int32),
    np.ones(2),
    np.array([2], dtype=np.int32),
    np.array([0], dtype=np.int32),
    np.array([1], dtype=np.int32),
)
SCENARIO = Scenario(
    name="small",
    floor=Floor(width_m=40.0, height_m=20.0),
    bots=2,
    buckets=1,
    word_stations=1,
    letter_stations=1,
    words="any.txt",
)
SOUP = Word(5, "SOUP", (18, 14, 20, 15), (True, False, False, True))


@pytest.fixture
def store() -> Store:
    store = Store()
    store.take_scenario(SCENARIO, LAYOUT)
    return store


def shown(store: Store) -> dict[str, Any]:
    return json.loads(store.frame())


def stations(*words: Word) -> Stations:
    return Stations(
        1.0,
        (WordStationState(0, 38.0, 10.0, 1, words),),
        (LetterStationState(1, 2.0, 10.0, -1, (Bundle(0, 30, 4),)),),
    )


def completed(word: int, sequence: int = 0) -> Event:
    return Event(12.34, sequence, EventType.WORD_COMPLETED, station=0, job=word, count=4)


def test_before_a_world_is_heard_of_there_is_no_floor_and_nothing_on_it():
    store = Store()
    assert store.floor() == "null"
    assert shown(store) == {
        "time": 0.0,
        "bots": None,
        "buckets": None,
        "stations": [],
        "figures": [],
        "completed": [],
        "notice": "",
    }


def test_the_floor_has_its_size_its_storage_spots_and_word_stations_before_letter_stations(store: Store):
    floor = json.loads(store.floor())
    assert (floor["name"], floor["width"], floor["height"], floor["capacity"]) == ("small", 40.0, 20.0, 40)
    assert floor["spots"] == {"x": [20.0], "y": [10.0]}
    assert floor["stations"] == {"x": [38.0, 2.0], "y": [10.0, 10.0]}
    assert floor["word_stations"] == 1


def test_bots_and_buckets_come_as_one_array_a_quantity_to_the_centimetre(store: Store):
    nothing = np.zeros(2)
    state = np.array([BotState.MOVING, BotState.FREE], dtype=np.uint8)
    carried = np.array([0, -1], dtype=np.int32)
    store.take_bots(
        Bots(3.0, np.array([1.23456, 2.0]), nothing, np.array([1.5708, 0]), nothing, nothing, carried, state)
    )
    tiles = np.array([7], dtype=np.uint16)
    store.take_buckets(Buckets(3.0, np.array([1.23456]), np.zeros(1), np.zeros(1, dtype=np.int32), tiles))
    frame = shown(store)
    assert frame["time"] == 3.0
    assert frame["bots"] == {
        "x": [1.23, 2.0],
        "y": [0.0, 0.0],
        "heading": [1.57, 0.0],
        "bucket": [0, -1],
        "state": [1, 0],
    }
    assert frame["buckets"] == {"x": [1.23], "y": [0.0], "bot": [0], "tiles": [7]}


def test_a_word_station_shows_which_letters_are_in_place_and_a_letter_station_its_bundles(store: Store):
    store.take_stations(stations(SOUP, Word(6, "TO", (19, 14))))
    assert shown(store)["stations"] == [
        {"station": 0, "bot": 1, "words": [["SOUP", [1, 0, 0, 1]], ["TO", [0, 0]]]},
        {"station": 1, "bot": -1, "bundles": [["E1", 4]]},
    ]


def test_a_completed_word_is_written_out_as_its_station_or_its_arrival_spelt_it(store: Store):
    store.take_stations(stations(SOUP))
    store.take_event(Event(2.0, 0, EventType.WORD_ARRIVED, job=6, text="TO"))
    store.take_event(completed(5))
    store.take_event(completed(6))
    assert shown(store)["completed"] == [[12.3, 0, "TO"], [12.3, 0, "SOUP"]]


def test_a_completed_word_that_nobody_spelt_has_its_number(store: Store):
    store.take_event(completed(9))
    assert shown(store)["completed"] == [[12.3, 0, "word 9"]]


def test_only_the_latest_completed_words_are_kept(store: Store):
    for word in range(LATEST_WORDS + 5):
        store.take_event(completed(word, word))
    texts = [text for _, _, text in shown(store)["completed"]]
    assert texts == [f"word {word}" for word in reversed(range(5, LATEST_WORDS + 5))]


def test_figures_are_told_in_the_words_and_units_of_the_table(store: Store):
    store.take_figures({"words_completed": 3, "words_per_second": 0.123456, "fraction_of_bound": 0.5})
    assert shown(store)["figures"] == [
        ["words_completed", "words completed", "3", ""],
        ["words_per_second", "word rate", "0.123", "words/s"],
        ["fraction_of_bound", "share of the bound", "50", "%"],
        ["bots", "bots", "2", ""],
        ["buckets", "buckets", "1", ""],
        ["word_stations", "word stations", "1", ""],
        ["letter_stations", "letter stations", "1", ""],
        ["scenario", "scenario", "small", ""],
    ]


def test_a_new_world_makes_the_old_one_forgotten(store: Store):
    store.take_stations(stations(SOUP))
    store.take_event(completed(5))
    store.take_scenario(SCENARIO, LAYOUT)
    frame = shown(store)
    assert (frame["stations"], frame["completed"]) == ([], [])


def test_a_browser_is_sent_the_floor_once_a_world_and_a_frame_only_when_something_is_new(store: Store):
    browser = Shown()
    assert browser.news(store) == f"warehouse.floor({store.floor()});warehouse.frame({store.frame()});"
    assert browser.news(store) == ""
    store.take_event(completed(5))
    assert browser.news(store) == f"warehouse.frame({store.frame()});"
    store.take_scenario(SCENARIO, LAYOUT)
    assert browser.news(store).startswith("warehouse.floor(")


def test_whom_the_warehouse_lacks_is_in_the_frame_until_it_is_back(store: Store):
    before = store.revision
    store.take_notice("no word manager")
    assert json.loads(store.frame())["notice"] == "no word manager"
    store.take_notice("no word manager")
    assert store.revision == before + 1
    store.take_notice("")
    assert json.loads(store.frame())["notice"] == ""
