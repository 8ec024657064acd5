"""Laws of the minimal coordination in random small warehouses; the world watches over every trip."""

from __future__ import annotations

import heapq
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from successor import takes_over
from tiny_warehouse import scenario_of
from world_hands import place

from soup_lab.headless.simulation import Headless
from soup_managers.fleets.minimal.fleet import TripFleet
from soup_managers.fleets.minimal.policies import Minimal as MinimalFleet
from soup_managers.policies.letter import Minimal as MinimalLetter
from soup_managers.policies.word import Minimal as MinimalWord
from soup_managers.stations.letter_manager import LetterManager
from soup_managers.stations.word_manager import WordManager
from soup_managers.view import WarehouseView
from soup_msgs_py.codes import Code, EventType
from soup_msgs_py.messages import BotReply, Event, FollowPath, Reply, TripGoal, TripResult
from soup_msgs_py.mind import NEVER, Message
from soup_msgs_py.policies import Policies, PolicyChoice
from soup_msgs_py.warehouse.words import WordList
from soup_sim.layouts import make_layout
from soup_sim.world import World

LETTERS, WORDS = "ABCDEF", 8
LOOKS_S = 1.0  # between two looks at what is waited for


class StrictWorld(World):
    """A world that nobody may ask for what cannot be.

    Attributes:
        forgiving: Managers may: they act on old news.
    """

    forgiving = False

    def handle(self, message: Any) -> list[Any]:
        return self._granted(super().handle(message))

    def advance(self, until: float, pause: bool = False) -> list[Any]:
        return self._granted(super().advance(until, pause))

    def _granted(self, said: list[Any]) -> list[Any]:
        for answer in said:
            if isinstance(answer, BotReply) or (isinstance(answer, Reply) and not self.forgiving):
                assert answer.success, answer.message
        return said


class Late:
    """A manager that takes in what it hears later, in order; now and then much later."""

    def __init__(self, mind: Any, lag: float, rng: np.random.Generator) -> None:
        self._mind, self._lag, self._rng = mind, lag, rng
        self._due = NEVER
        self._heard: list[Message] = []

    def __getattr__(self, name: str) -> Any:
        return getattr(self._mind, name)

    @property
    def next_wake(self) -> float:
        return min(self._due, self._mind.next_wake)

    def handle(self, message: Message, now: float) -> list[Message]:
        if not self._heard:
            self._due = now + (float(self._rng.uniform(0.1, 20.0)) if self._rng.random() < self._lag else 0.0)
        self._heard.append(message)
        return []

    def wake(self, now: float) -> list[Message]:
        said = self._mind.wake(now) if self._mind.next_wake <= now else []
        if self._due <= now:
            heard, self._due, self._heard = self._heard, NEVER, []
            said += [answer for message in heard for answer in self._mind.handle(message, now)]
        return said


class Warehouse(Headless):
    """A random tiny warehouse whose bots jump to where they want to drive, after a random time.

    Words of random letters, buckets a third full, more bots than free buckets or the other way round.

    Args:
        seed: Of all that is random.
        fewest_buckets: At least.
        failures: Probability that a bot gives a trip up on its way.
        instant: Whether bots jump at once.
        shared_view: Whether the managers share one view, as in one process, or have their own, as nodes do.
        lag: Probability that a manager hears much later what it is told.
    """

    def __init__(
        self,
        seed: int,
        *,
        fewest_buckets: int = 2,
        failures: float = 0.0,
        instant: bool = False,
        shared_view: bool = True,
        lag: float = 0.0,
    ) -> None:
        self.rng = rng = np.random.default_rng(seed)
        self.failures, self.instant, self.shared_view, self.lag = failures, instant, shared_view, lag
        self.log: list[Any] = []
        self.completed: list[int] = []
        self._jumps: list[tuple[float, int, int, FollowPath]] = []
        bots, buckets = int(rng.integers(1, 8)), int(rng.integers(fewest_buckets, 13))
        orders = {"kind": "all", "count": WORDS}
        scenario = scenario_of(bots=bots, buckets=buckets, initial_inventory=0.3, orders=orders)
        words = tuple("".join(rng.choice(list(LETTERS), rng.integers(2, 7))) for _ in range(WORDS))
        world = StrictWorld(scenario, make_layout(scenario), WordList(words, (), "words.txt"), seed)
        super().__init__(world, Policies(bot=PolicyChoice(name="straight")), seed)
        world.forgiving = lag > 0
        for role in () if shared_view else ("word", "letter", "fleet"):
            self.restart(role)

    def restart(self, role: str) -> None:
        """Kill a manager and start it again."""
        world, rng = self.world, self.rng
        view = self.fleet.view if self.shared_view else WarehouseView(world.scenario, world.layout)
        common = world.scenario, world.layout
        if role == "word":
            mind = WordManager(*common, MinimalWord(), view, rng)
        elif role == "letter":
            mind = LetterManager(*common, MinimalLetter(), view, rng, world.tile_profile)
        else:
            mind = TripFleet(*common, MinimalFleet(), view, rng)
        tasks = self.fleet.tasks() if role == "fleet" else ()
        takes_over(self, role, Late(mind, self.lag, rng) if self.lag else mind, tasks)

    def is_done(self) -> bool:
        """Whether all words are."""
        return len(self.completed) == WORDS

    def go_on(self, until: Callable[[], bool] | None = None) -> None:
        """Go on until all words are done, or something is true."""
        until = until or self.is_done
        for _ in range(20_000):
            if until():
                return
            if self._jumps and self._jumps[0][0] <= self.world.now:
                self._jump()
            else:
                self.run(min(self._jumps[0][0] if self._jumps else NEVER, self.world.now + LOOKS_S))
        raise AssertionError(f"words {self.completed} are done: {self.fleet.tasks()}")

    def _jump(self) -> None:
        _, _, _, path = heapq.heappop(self._jumps)
        code = Code.UNKNOWN if self.rng.random() < self.failures / 3 else Code.DONE  # a trip has three ways
        if code is Code.DONE:
            place(self.world, **{f"bot_{path.bot}": path.points[-1]})
        self.tell(self.crew, BotReply(path.bot, path.request, code, "", self.world.now, *path.points[-1]))

    def _say(self, speaker: Any, messages: list[Message]) -> None:
        for path in [said for said in messages if isinstance(said, FollowPath)]:
            messages.remove(path)
            wait = 0.0 if self.instant else float(self.rng.uniform(0.1, 20.0))
            heapq.heappush(self._jumps, (self.world.now + wait, path.bot, path.request, path))
        goals = [said.trip.bucket for said in messages if isinstance(said, TripGoal)]
        under_way = [mind.trip.bucket for mind in self.crew.minds.values() if mind.trip is not None] if goals else []
        assert len({*goals, *under_way}) == len(goals) + len(under_way), "a bucket is on two trips"
        for said in messages:
            if isinstance(said, Event) and said.type is EventType.WORD_COMPLETED:
                self.completed.append(said.job)
            assert not isinstance(said, TripResult) or said.code not in (Code.BUSY, Code.INVALID), said.message
        self.log += messages
        super()._say(speaker, messages)


seeds = st.integers(0, 2**32 - 1)
fewer = settings(max_examples=40)


@fewer
@given(seeds, st.booleans(), st.booleans())
def test_all_words_get_done_and_nothing_is_promised_twice(seed, instant, shared_view):
    warehouse = Warehouse(seed, instant=instant, shared_view=shared_view)
    warehouse.go_on()
    assert sorted(warehouse.completed) == list(range(WORDS))


@fewer
@given(seeds, st.floats(0.1, 0.6))
def test_failed_trips_are_tried_again_until_all_words_are_done(seed, failures):
    warehouse = Warehouse(seed, failures=failures)
    warehouse.go_on()
    assert sorted(warehouse.completed) == list(range(WORDS))


@fewer
@given(seeds, st.floats(0.1, 0.9), st.sampled_from([0.0, 0.3]))
def test_messages_that_lag_behind_delay_words_but_lose_none(seed, lag, failures):
    # late news make the letter manager bring in more than it wants: that must not fill all buckets
    warehouse = Warehouse(seed, fewest_buckets=6, failures=failures, shared_view=False, lag=lag)
    warehouse.go_on()
    assert sorted(warehouse.completed) == list(range(WORDS))


@fewer
@given(seeds, st.lists(st.sampled_from(["word", "letter", "fleet"]), min_size=1, max_size=6), st.booleans())
@example(24, ["word"], True)
def test_managers_that_are_started_anew_at_any_time_go_on(seed, roles, shared_view):
    warehouse = Warehouse(seed, failures=0.2, shared_view=shared_view)
    rng = np.random.default_rng(seed)
    for role in roles:
        target = warehouse.world.now + float(rng.uniform(1.0, 60.0))
        warehouse.go_on(until=lambda target=target: warehouse.world.now >= target or warehouse.is_done())
        warehouse.restart(role)
    warehouse.go_on()
    assert sorted(warehouse.completed) == list(range(WORDS))


@fewer
@given(seeds)
def test_without_failures_no_trip_is_in_vain(seed):
    warehouse = Warehouse(seed)
    warehouse.go_on()
    warehouse.go_on(until=lambda: all(mind.trip is None for mind in warehouse.crew.minds.values()))
    trips = [said for said in warehouse.log if isinstance(said, TripGoal)]
    moved = [said for said in warehouse.log if isinstance(said, Event) and said.type is EventType.TRANSFERRED]
    assert len(trips) == len(moved)


@pytest.mark.parametrize("seed", range(3))
def test_the_same_seed_gives_the_same_messages(seed):
    first, second = (Warehouse(seed, failures=0.2) for _ in range(2))
    first.go_on()
    second.go_on()
    assert first.log == second.log


@fewer
@given(seeds, st.floats(1.0, 400.0))
def test_a_view_kept_by_events_is_the_view_of_a_new_snapshot(seed, moment):
    warehouse = Warehouse(seed, failures=0.2)
    world = warehouse.world
    warehouse.go_on(until=lambda: world.now >= moment or warehouse.is_done())
    kept = warehouse.fleet.view
    fresh = type(kept)(world.scenario, world.layout)
    fresh.reset(world.snapshot())
    for name, value in vars(fresh).items():
        if isinstance(value, (int, list, dict)) and name not in ("_heard", "resets", "waiting_words"):
            assert comparable(name, getattr(kept, name), warehouse) == comparable(name, value, warehouse), name
        elif isinstance(value, np.ndarray):
            told, true = comparable(name, getattr(kept, name), warehouse), comparable(name, value, warehouse)
            np.testing.assert_array_equal(told, true, name)
    np.testing.assert_array_equal(kept.contents.tiles, fresh.contents.tiles)
    np.testing.assert_array_equal(kept.contents.total, fresh.contents.total)
    assert list(kept.waiting_words) == list(fresh.waiting_words)


def comparable(name: str, value, warehouse: Warehouse):
    """What both views must agree in: not in sets that have become empty, nor in where what is under way was last."""
    if name in ("spot_of", "bucket_x", "bucket_y"):
        return np.asarray(value)[warehouse.world.buckets().bot < 0].tolist()
    if name in ("bot_x", "bot_y"):
        return value[[mind.trip is None for mind in warehouse.crew.minds.values()]]
    return {k: v for k, v in value.items() if v != 0} if isinstance(value, dict) else value
