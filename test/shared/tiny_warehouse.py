"""A tiny warehouse, made as any is made, and how a test says what is the case in it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from world_hands import changed

from soup_msgs_py.messages import Point
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.words import WordList
from soup_sim.layouts import make_layout
from soup_sim.world import World

Tiles = tuple[int, ...]
BUCKETS, CAPACITY, BUNDLE = 9, 8, 3


def scenario_of(**changes: Any) -> Scenario:
    """4 bots, 9 buckets of 8 tiles, 2 stations of each kind, one colour; nobody orders anything.

    . . . . . . . . .     . waypoints
    . . S . S . S . .     S storage spots
    L . . . . . . . W     L, W stations, in every third row
    """
    values = {
        "name": "tiny",
        "floor": {"width_m": 29.0, "height_m": 41.0},
        "bots": 4,
        "buckets": BUCKETS,
        "word_stations": 2,
        "letter_stations": 2,
        "bucket": {"capacity": CAPACITY},
        "bundle_size": BUNDLE,
        "words": "words.txt",
        "colours": [1.0],
        "word_station": {"open_words": 2},
        "orders": {"kind": "none"},
        "layout": {"kind": "rows", "aisle_lanes": 1, "margin_columns": 1, "block_columns": 1, "block_rows": 1},
    }
    return Scenario.model_validate(values | changes)


def tiny_world(words: tuple[str, ...] = ("TINY",), seed: int = 1, **changes: Any) -> World:
    """The world of a tiny warehouse at its start."""
    scenario = scenario_of(**changes)
    return World(scenario, make_layout(scenario), WordList(words, (), "words.txt"), seed)


def let(
    world: World,
    *,
    contents: Mapping[int, Mapping[int, int]] | None = None,
    waiting: Mapping[int, Tiles] | None = None,
    opened: Mapping[int, tuple[int, Tiles, Tiles]] | None = None,
    staged: Mapping[int, tuple[int, int, int]] | None = None,
    sequence: int | None = None,
) -> World:
    """Have facts be as they are given, all of a kind; the same world.

    Args:
        world: The world.
        contents: By bucket, how many tiles of each kind it holds; all others are empty.
        waiting: The tiles of words that wait, by their numbers.
        opened: By word, its station, its tiles, and 1 for each of them that is filled; it waits no more.
        staged: By bundle, its station, its kind, and how many tiles are left.
        sequence: The number of the last event.
    """
    with changed(world) as state:
        serving, stations = state["serving"], state["serving"]["stations"]
        if contents is not None:
            serving["contents"] = [list(contents.get(b, {}).items()) for b in range(world.scenario.buckets)]
        if waiting is not None:
            state["waiting_words"] = [(number, "", tiles) for number, tiles in waiting.items()]
        if opened is not None:
            state["waiting_words"] = [word for word in state["waiting_words"] if word[0] not in opened]
            for number in range(world.scenario.word_station_count):
                words = [(w, "", tiles, map(bool, filled)) for w, (at, tiles, filled) in opened.items() if at == number]
                stations[number]["open_words"] = words
        if staged is not None:
            for number in range(world.scenario.word_station_count, len(stations)):
                stations[number]["staged"] = [(b, *about) for b, (at, *about) in staged.items() if at == number]
        if sequence is not None:
            state["agenda"]["sequence"] = sequence
    return world


def home(world: World, bucket: int) -> Point:
    """Where a bucket is."""
    buckets = world.buckets()
    return float(buckets.x[bucket]), float(buckets.y[bucket])
