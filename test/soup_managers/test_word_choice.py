"""Which word is opened: the one that buckets at hand serve best, none too late, and none that there is no room for."""

from collections import Counter
from collections.abc import Sequence

import numpy as np
import pytest
from tiny_warehouse import BUCKETS, BUNDLE, CAPACITY, let, tiny_world

from soup_managers.policies.letter import Ahead
from soup_managers.policies.word import Served
from soup_managers.view import WarehouseView


def view_of(words: dict[int, tuple[int, ...]], tiles: Sequence[int], *open_words: tuple[int, ...]) -> WarehouseView:
    """A warehouse whose buckets are filled in turn; the open words are on the second station."""
    contents = {bucket: Counter(tiles[bucket::BUCKETS]) for bucket in range(BUCKETS)}
    opened = {-1 - k: (1, letters, (0,) * len(letters)) for k, letters in enumerate(open_words)}
    world = let(tiny_world(initial_inventory=0.5), contents=contents, waiting=words, opened=opened)
    view = WarehouseView(world.scenario, world.layout)
    view.reset(world.snapshot())
    return view


def opened(view: WarehouseView) -> int | None:
    choice = Served().choose(view, [0, 1], np.random.default_rng(1))
    return None if choice is None else choice.word


def brought_in(view: WarehouseView) -> int:
    profile = np.zeros(view.kinds)
    profile[:4] = 9.0
    return Ahead().choose_kind(view, profile, np.random.default_rng(1))


def test_the_word_that_a_bucket_at_the_station_serves_best_is_opened():
    view = view_of({0: (0, 1), 1: (0, 2), 2: (2, 3)}, [0, 1, 2, 3])
    view.bound = {0: [bucket for bucket, held in enumerate(view.contents) if held.keys() & {2, 3}]}
    assert opened(view) == 2


@pytest.mark.parametrize(("newest", "expected"), [(6, 6), (60, 0)])
def test_a_word_that_many_others_have_passed_is_opened_though_no_bucket_at_the_station_serves_it(newest, expected):
    view = view_of({0: (4, 4), newest - 1: (5, 5), newest: (2, 3)}, [2, 3])
    view.bound = {0: [bucket for bucket, held in enumerate(view.contents) if held.keys() & {2, 3}]}
    assert opened(view) == expected


@pytest.mark.parametrize(
    ("stock", "expected"),
    [
        (70, 1),  # room for two: no bundle goes in
        (62, 1),  # room for all, but the one that needs none leaves more
        (4, 0),  # much room: the oldest
    ],
)
def test_where_room_is_scarce_the_word_is_opened_that_leaves_most(stock, expected):
    assert opened(view_of({0: (1, 2), 1: (0, 0)}, [0] * stock)) == expected


def test_no_word_is_opened_whose_letters_there_is_no_room_for():
    """They would wait for each other for ever: each bundle that comes in takes the room of the other one."""
    assert opened(view_of({0: (1, 2)}, [0] * 70)) is None
    assert opened(view_of({0: (1, 2)}, [0] * 66)) == 0
    assert opened(view_of({0: (1, 2)}, [0] * 66, (3, 3, 4))) is None


def test_letters_that_no_open_word_lacks_leave_the_room_for_those_that_one_will_lack():
    full, half = [0] * (BUCKETS * CAPACITY - BUNDLE), [0] * 20
    assert brought_in(view_of({0: (1, 2)}, half)) == 1
    assert brought_in(view_of({0: (1, 2)}, full)) == -1
    assert brought_in(view_of({0: (1, 2)}, full, (3, 0))) == 3
