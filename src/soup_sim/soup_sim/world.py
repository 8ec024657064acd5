"""The world: the one owner of every durable fact. Requests go in, events and answers come out; it knows no ROS.

Example:
    >>> world = World(scenario, layout, words, seed=1)      # doctest: +SKIP
    >>> world.handle(FollowPath(0, 1, ((3.0, 4.0),)))       # doctest: +SKIP
    >>> for said in world.advance(10.0): print(said)        # doctest: +SKIP
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from typing import Any

import numpy as np

from soup_msgs_py import messages as m
from soup_msgs_py.codes import BotState, Code, EventType
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.scenario.floor_plan import CellsLayout
from soup_msgs_py.warehouse.layout import Layout
from soup_msgs_py.warehouse.words import WordList
from soup_sim.agenda import Agenda, Common, Said
from soup_sim.arrivals import TimedBundle, TimedWord
from soup_sim.bodies import Bodies
from soup_sim.bounds import bounds
from soup_sim.driving import Driving
from soup_sim.layouts.cells import start_places
from soup_sim.lifting import Lifting
from soup_sim.orders import Orders, Supply, initial_contents, tile_profile
from soup_sim.serving import Serving
from soup_sim.standstill import STALLED, reasons
from soup_sim.stations import OpenWord, StagedBundle
from soup_sim.statistics import Statistics

LONGEST_DURATION_S = 1e9


class World:
    """A warehouse and everything in it.

    Args:
        scenario: All parameters.
        layout: The floor, from `layouts.make_layout`.
        words: The word list that customers order from.
        seed: Seed of every random draw of the world.
        warmup_s: Rates and counts cover what comes after this simulated time.
        timed_words: The orders of a scenario that has them in a file.
        timed_bundles: The bundles of a scenario that has them in a file.
        run: What tells this run from others, where somebody may follow several one after another.
    """

    def __init__(
        self,
        scenario: Scenario,
        layout: Layout,
        words: WordList,
        seed: int,
        warmup_s: float = 0.0,
        timed_words: tuple[TimedWord, ...] = (),
        timed_bundles: tuple[TimedBundle, ...] = (),
        run: int = 0,
    ) -> None:
        self.scenario, self.layout, self.run = scenario, layout, run
        self.seed, self.warmup_s = seed, warmup_s
        order_rng, fill_rng, place_rng, supply_rng, station_rng = (
            np.random.Generator(np.random.PCG64(child)) for child in np.random.SeedSequence(seed).spawn(5)
        )
        self.tile_profile = tile_profile(words, scenario.colours.shares)
        contents = initial_contents(
            scenario.buckets, scenario.bucket.capacity, scenario.initial_inventory, self.tile_profile, fill_rng
        )
        starts, spots = _start_places(scenario, layout, place_rng)

        self._orders = Orders(scenario, words, timed_words, order_rng)
        self._supply = Supply(scenario, self.tile_profile, timed_bundles, supply_rng)
        self._agenda = Agenda()
        inventory = sum(sum(content.values()) for content in contents)
        self._statistics = Statistics(scenario, bounds(scenario, layout, self._orders.mean_length), inventory)
        self._bodies = Bodies(scenario, layout, layout.waypoints[starts], layout.waypoints[spots])
        self._common = Common(self._agenda, self._bodies, self._statistics)
        self._driving = Driving(self._common, scenario.bot.collision_penalty_s)
        self._lifting = Lifting(self._common, scenario, layout)
        self._serving = Serving(self._common, scenario, layout, contents, station_rng)
        for bucket, spot in enumerate(spots.tolist()):
            self._lifting.storage.rest(bucket, spot)

        self._waiting_words: OrderedDict[int, m.Word] = OrderedDict()
        self._waiting_bundles: OrderedDict[int, m.Bundle] = OrderedDict()
        self._agenda.can(
            word_arrives=self._awaited_word_arrives,
            bundle_arrives=self._awaited_bundle_arrives,
            warmed_up=self.count_anew,
        )
        self._waiting_words.update((word.word, word) for word in self._orders.at_start())
        self._statistics.ordered(self._waiting_words, self.now)
        self._waiting_bundles.update((bundle.bundle, bundle) for bundle in self._supply.at_start())
        self._await_word()
        self._await_bundle()
        if warmup_s > 0.0:
            self._agenda.at(warmup_s, "warmed_up")
        self._stalled = -1.0, ""
        self._doors: dict[type, Callable[[Any], None]] = {
            m.SetVelocity: self._driving.set_velocity,
            m.SetVelocities: self._driving.set_velocities,
            m.FollowPath: self._driving.follow_path,
            m.Grab: self._lifting.grab,
            m.Release: self._lifting.release,
            m.Transfer: self._serving.transfer,
            m.AssignWord: self._assign_word,
            m.AssignBundle: self._assign_bundle,
            m.SetStorageSpot: self._lifting.set_storage_spot,
        }

    # ---- time -----------------------------------------------------------------------------------------------

    @property
    def now(self) -> float:
        """Simulated time in seconds."""
        return self._agenda.now

    @property
    def next_time(self) -> float:
        """When the next thing happens by itself; infinity for never."""
        return self._agenda.next_time

    def advance(self, until: float, pause: bool = False) -> list[Said]:
        """Let the world run on to a time; what it said meanwhile, in order of time.

        With `pause` it stops earlier, at the first instant at which it said something; `now` tells.
        """
        if until < self._agenda.now:
            raise ValueError(f"time does not go back from {self._agenda.now} to {until}")
        self._agenda.run(until, pause)
        return self._agenda.empty_outbox()

    def handle(self, message: Any) -> list[Said]:
        """Take in one request at the present time.

        Returns:
            What the world says at once. A bot's request that takes time is answered later, by `advance`.

        Raises:
            TypeError: The message is nothing that one can ask of the world.
        """
        door = self._doors.get(type(message))
        if door is None:
            raise TypeError(f"the world takes no {type(message).__name__}")
        bot = getattr(message, "bot", None)
        if bot is not None and not 0 <= bot < self.scenario.bots:
            problem = f"there is no bot {bot}; they are 0 to {self.scenario.bots - 1}"
            return [m.BotReply(bot, getattr(message, "request", -1), Code.UNKNOWN, problem, self.now, 0.0, 0.0)]
        door(message)
        return self._agenda.empty_outbox()

    # ---- orders ---------------------------------------------------------------------------------------------

    def _assign_word(self, request: m.AssignWord) -> None:
        word = self._waiting_words.get(request.word)
        if word is None:
            self._refuse(Code.UNKNOWN, f"word {request.word} is not waiting")
            return
        if not self.layout.is_word_station(request.station):
            self._refuse(Code.UNKNOWN, f"station {request.station} is not a word station")
            return
        station = self._serving.words[request.station]
        if not station.has_place():
            self._refuse(Code.STATION_FULL, f"word station {request.station} has {station.places} open words already")
            return
        del self._waiting_words[request.word]
        station.open_words.append(OpenWord(word, [False] * len(word.tiles)))
        self._common.emit(EventType.WORD_ASSIGNED, job=word.word, station=request.station)
        self._agenda.say(m.Reply(Code.DONE, f"word {word.word} is open", word.word))
        while len(self._waiting_words) < self._orders.keeps_waiting():
            self._word_arrives()

    def _await_word(self) -> None:
        time = self._orders.next_time(self.now)
        if time < float("inf"):
            self._agenda.at(time, "word_arrives")

    def _awaited_word_arrives(self) -> None:
        self._word_arrives()
        self._await_word()

    def _word_arrives(self) -> None:
        word = self._orders.draw()
        self._waiting_words[word.word] = word
        self._common.emit(EventType.WORD_ARRIVED, job=word.word, tiles=word.tiles, text=word.text)

    def _await_bundle(self) -> None:
        time = self._supply.next_time(self.now)
        if time < float("inf"):
            self._agenda.at(time, "bundle_arrives")

    def _awaited_bundle_arrives(self) -> None:
        bundle = self._supply.draw()
        self._waiting_bundles[bundle.bundle] = bundle
        self._common.emit(EventType.BUNDLE_ARRIVED, job=bundle.bundle, tile=bundle.tile, count=bundle.count)
        self._await_bundle()

    def _assign_bundle(self, request: m.AssignBundle) -> None:
        if not self.layout.is_letter_station(request.station):
            self._refuse(Code.UNKNOWN, f"station {request.station} is not a letter station")
            return
        station = self._serving.letters[request.station - self.scenario.word_station_count]
        if not station.has_place():
            text = f"letter station {request.station} has {station.places} staged bundles already"
            self._refuse(Code.STATION_FULL, text)
            return
        if request.bundle != -1:
            bundle = self._waiting_bundles.pop(request.bundle, None)
            if bundle is None:
                self._refuse(Code.UNKNOWN, f"bundle {request.bundle} is not waiting")
                return
        elif not self._supply.is_chosen:
            self._refuse(Code.NOT_NEEDED, "bundles come by themselves in this scenario; stage one that has arrived")
            return
        elif 0 <= request.tile < len(self.tile_profile):
            bundle = self._supply.order(request.tile)
        else:
            self._refuse(Code.UNKNOWN, f"there is no tile kind {request.tile}")
            return
        station.staged.append(StagedBundle(bundle.bundle, bundle.tile, bundle.count))
        self._common.emit(
            EventType.BUNDLE_STAGED,
            job=bundle.bundle,
            tile=bundle.tile,
            count=bundle.count,
            station=request.station,
        )
        self._agenda.say(m.Reply(Code.DONE, f"bundle {bundle.bundle} is staged", bundle.bundle))

    def _refuse(self, code: Code, message: str) -> None:
        self._agenda.say(m.Reply(code, message))

    # ---- looking --------------------------------------------------------------------------------------------

    def bots(self) -> m.Bots:
        """The bodies of all bots now."""
        x, y, vx, vy, heading = self._bodies.table(self.now)
        return m.Bots(self.now, x, y, heading, vx, vy, self._bodies.bucket.copy(), self._common.states.copy())

    def buckets(self) -> m.Buckets:
        """All buckets now."""
        x, y = self._bodies.bucket_places(self.now)
        return m.Buckets(self.now, x, y, self._bodies.carrier.copy(), self._serving.tiles.copy())

    def stations(self) -> m.Stations:
        """All stations now."""
        return m.Stations(
            self.now,
            tuple(station.state() for station in self._serving.words),
            tuple(station.state() for station in self._serving.letters),
        )

    def snapshot(self) -> m.Snapshot:
        """Everything that a newcomer needs."""
        stations = self.stations()
        return m.Snapshot(
            time=self.now,
            sequence=self._agenda.sequence,
            bots=self.bots(),
            buckets=self.buckets(),
            contents=tuple(dict(sorted(content.items())) for content in self._serving.contents),
            word_stations=stations.word_stations,
            letter_stations=stations.letter_stations,
            waiting_words=tuple(self._waiting_words.values()),
            waiting_bundles=tuple(self._waiting_bundles.values()),
            words_completed=self._serving.words_completed,
            storage_spots=tuple(sorted(self._lifting.storage.bucket_on)),
            run=self.run,
            paths=self._driving.timed_paths(),
        )

    # ---- figures --------------------------------------------------------------------------------------------

    def count_anew(self) -> None:
        """Have the figures cover what comes from now on."""
        self._statistics.begin_window(self.now, self._bodies.driven(self.now))

    def stalled(self) -> str:
        """Since when nothing is moved though words are on order, and why; empty while work goes on."""
        since = self._statistics.stalled_since(self.now)
        if since is None:
            return ""
        if self._stalled[0] != since:  # looked for once: bots that go about in vain must not change what is said
            why = "; ".join(reasons(self.scenario, self.layout, self.snapshot()))
            self._stalled = since, f"{STALLED} {since:,.0f} s: {why}"
        return self._stalled[1]

    def statistics(self, wall_seconds: float = 0.0) -> dict[str, Any]:
        """The figures of the run so far, with the keys of a summary."""
        figures = self._statistics.figures(self.now, self._bodies.driven(self.now))
        figures["wall_seconds"] = wall_seconds
        figures["real_time_factor"] = self.now / wall_seconds if wall_seconds > 0 else 0.0
        return figures

    # ---- checkpoint -----------------------------------------------------------------------------------------

    @property
    def sequence(self) -> int:
        """Number of the newest event."""
        return self._agenda.sequence

    def bots_on_paths(self) -> list[int]:
        """The bots that follow a path, or wait for the time of its beginning."""
        return self._driving.on_paths()

    def end_transfers(self) -> list[Said]:
        """Have all transfers end with the tiles that are being moved now; what the world says at once."""
        self._serving.end_soon()
        return self._agenda.empty_outbox()

    def capture(self) -> dict[str, Any]:
        """Everything that a world with the same scenario, words and layout needs to go on alike: plain JSON values."""
        assert not self._agenda.empty_outbox(), "a checkpoint is taken between requests"
        return {
            "agenda": self._agenda.capture(),
            "bodies": self._bodies.capture(),
            "statistics": self._statistics.capture(),
            "driving": self._driving.capture(),
            "lifting": self._lifting.capture(),
            "serving": self._serving.capture(),
            "orders": self._orders.capture(),
            "supply": self._supply.capture(),
            "penalised_until": self._common.penalised_until,
            "operation": [None if state is None else int(state) for state in self._common.operation],
            "waiting_words": [(w.word, w.text, w.tiles) for w in self._waiting_words.values()],
            "waiting_bundles": [(b.bundle, b.tile, b.count) for b in self._waiting_bundles.values()],
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go back (or on) to the moment at which `capture` was called."""
        for name in ("agenda", "bodies", "statistics", "driving", "lifting", "serving", "orders", "supply"):
            getattr(self, f"_{name}").restore(state[name])
        self._common.penalised_until = list(state["penalised_until"])
        self._common.operation = [None if value is None else BotState(value) for value in state["operation"]]
        for bot in range(self.scenario.bots):
            self._common.note_state(bot)
        self._waiting_words = OrderedDict(
            (number, m.Word(number, text, tuple(tiles))) for number, text, tiles in state["waiting_words"]
        )
        self._waiting_bundles = OrderedDict((values[0], m.Bundle(*values)) for values in state["waiting_bundles"])


def _start_places(scenario: Scenario, layout: Layout, rng: np.random.Generator) -> tuple[Any, Any]:
    """The waypoints where bots begin, and those where buckets rest at the start: drawn, or as a world of cells says."""
    if isinstance(scenario.layout, CellsLayout):
        return start_places(scenario.layout)
    spots = rng.permutation(len(layout.storage_spots))[: scenario.buckets]
    free = np.setdiff1d(np.arange(len(layout.waypoints)), layout.stations)
    return free[rng.permutation(len(free))[: scenario.bots]], layout.storage_spots[spots]
