"""A tiny world with bots that jump from place to place: it executes trips and checks that each can be."""

from __future__ import annotations

import heapq
from collections import deque
from dataclasses import replace

import numpy as np

from soup_managers.fleets.minimal.fleet import TripFleet
from soup_managers.fleets.minimal.policies import Minimal as MinimalFleet
from soup_managers.policies.letter import Minimal as MinimalLetter
from soup_managers.policies.word import Minimal as MinimalWord
from soup_managers.stations.letter_manager import LetterManager
from soup_managers.stations.word_manager import WordManager
from soup_managers.traffic.router import Router
from soup_managers.view import WarehouseView
from soup_msgs_py.codes import Code, EventType, Phase
from soup_msgs_py.messages import (
    DELIVER,
    AssignBundle,
    AssignWord,
    Bots,
    BotStatus,
    Buckets,
    Bundle,
    CancelTrip,
    DeliverGoal,
    Event,
    LetterStationState,
    Reply,
    Snapshot,
    StoreGoal,
    TaskFeedback,
    TaskResult,
    TripGoal,
    TripResult,
    Word,
    WordStationState,
)
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.scenario.parameters import Floor, WordStationParameters
from soup_msgs_py.warehouse.layout import Layout

PITCH = 3.0


def layout_of(columns: int, rows: int, word_stations: int, letter_stations: int) -> Layout:
    """Aisles around single columns of storage spots; letter stations left, word stations right.

    L . s . s . W     . waypoints of the aisles (even columns and the rows between)
    . . . . . . .     s storage spots
    L . s . s . W     L, W stations
    """
    width, height = 2 * columns + 3, 2 * rows + 1
    number = {(c, r): r * width + c for r in range(height) for c in range(width)}
    waypoints = np.array([(c * PITCH, r * PITCH) for r in range(height) for c in range(width)])
    edges = []
    for (c, r), here in number.items():
        for step in ((c + 1, r), (c, r + 1)):
            if step in number:
                edges += [(here, number[step]), (number[step], here)]
    spots = [number[2 * c + 2, 2 * r] for c in range(columns) for r in range(rows)]
    right = [number[width - 1, 2 * (s % rows)] for s in range(word_stations)]
    left = [number[0, 2 * (s % rows)] for s in range(letter_stations)]
    return Layout(
        width_m=(width - 1) * PITCH,
        height_m=(height - 1) * PITCH,
        waypoints=waypoints,
        edges=np.array(edges, np.int32),
        edge_weights=np.ones(len(edges)),
        storage_spots=np.array(spots, np.int32),
        word_stations=np.array(right, np.int32),
        letter_stations=np.array(left, np.int32),
    )


def scenario_of(**changes) -> Scenario:
    """A small warehouse: 4 bots, 9 buckets of 8 tiles, 2 stations of each kind, one colour."""
    values = {
        "name": "tiny",
        "floor": Floor(width_m=60.0, height_m=60.0),
        "bots": 4,
        "buckets": 9,
        "word_stations": 2,
        "letter_stations": 2,
        "bucket": {"capacity": 8},
        "bundle_size": 3,
        "words": "words.txt",
        "colours": [1.0],
        "word_station": WordStationParameters(open_words=2),
    }
    return Scenario.model_validate(values | changes)


class TinyWorld:
    """The world and all bots in one: owns the truth, makes events, lets trips take random times and go wrong.

    Whatever the fleet must never ask for is an assertion in here.
    """

    def __init__(
        self,
        scenario: Scenario,
        layout: Layout,
        words: list[tuple[int, ...]],
        rng: np.random.Generator,
        *,
        failures: float = 0.0,
        instant: bool = False,
    ) -> None:
        self.scenario, self.layout, self.rng = scenario, layout, rng
        self.failures, self.instant = failures, instant
        self.now, self.sequence = 0.0, 0
        self.spots = layout.storage_spots.tolist()
        self.bucket_spot = rng.permutation(self.spots)[: scenario.buckets].tolist()
        self.bucket_bot = [-1] * scenario.buckets
        self.contents: list[dict[int, int]] = [{} for _ in range(scenario.buckets)]
        places = rng.permutation(len(layout.waypoints))[: scenario.bots]
        self.bot_xy = [tuple(map(float, layout.waypoints[p])) for p in places]
        self.bot_bucket = [-1] * scenario.bots
        self.waiting = {number: Word(number, "", tiles) for number, tiles in enumerate(words)}
        self.open: dict[int, tuple[int, Word]] = {}
        self.completed: list[int] = []
        self.staged: dict[int, tuple[int, Bundle]] = {}
        self.bundles = 0
        self.status = [BotStatus(0.0, b, Phase.IDLE, -1, None, 0, "") for b in range(scenario.bots)]
        self.doing: dict[int, int] = {}  # bot to trip
        self.agenda: list[tuple[float, int, int, int, list]] = []
        self.serial = 0
        self.trips = 0
        self.forgiving = False  # a manager that acts on old news is refused, otherwise that is an error
        self.delivered = dict.fromkeys(self.waiting, 0)
        self.out: deque = deque()

    def fill(self, tiles: list[int]) -> None:
        """Put tiles into random buckets with room."""
        for tile in tiles:
            able = [b for b, c in enumerate(self.contents) if sum(c.values()) < self.scenario.bucket.capacity]
            bucket = int(self.rng.choice(able))
            self.contents[bucket][tile] = self.contents[bucket].get(tile, 0) + 1

    def snapshot(self) -> Snapshot:
        """What is true now."""
        bots = self.scenario.bots
        zeros = np.zeros(bots)
        x, y = (np.array([xy[axis] for xy in self.bot_xy]) for axis in (0, 1))
        places = [
            self.bot_xy[b] if b >= 0 else self.layout.waypoints[s]
            for b, s in zip(self.bucket_bot, self.bucket_spot, strict=True)
        ]
        tiles = np.array([sum(c.values()) for c in self.contents], np.uint16)
        words, letters = self.scenario.word_station_count, self.scenario.letter_station_count
        return Snapshot(
            self.now,
            self.sequence,
            Bots(
                self.now,
                x,
                y,
                zeros,
                zeros,
                zeros,
                np.array(self.bot_bucket, np.int32),
                np.zeros(bots, np.uint8),
            ),
            Buckets(
                self.now,
                np.array([p[0] for p in places]),
                np.array([p[1] for p in places]),
                np.array(self.bucket_bot, np.int32),
                tiles,
            ),
            tuple(dict(c) for c in self.contents),
            tuple(
                WordStationState(s, *self.layout.station_xy(s), -1, tuple(w for at, w in self.open.values() if at == s))
                for s in range(words)
            ),
            tuple(
                LetterStationState(
                    s, *self.layout.station_xy(s), -1, tuple(b for at, b in self.staged.values() if at == s)
                )
                for s in range(words, words + letters)
            ),
            tuple(self.waiting.values()),
            (),
            len(self.completed),
            tuple(self.spots),
        )

    def handle(self, message) -> None:
        """Take in what a manager says to the world or to a bot."""
        if isinstance(message, AssignWord):
            self._assign_word(message)
        elif isinstance(message, AssignBundle):
            self._assign_bundle(message)
        elif isinstance(message, TripGoal):
            self._begin(message)
        elif isinstance(message, CancelTrip) and self.doing.get(message.bot) == message.trip:
            self._later(message.bot, message.trip, [("fail", Code.CANCELLED)])

    def _assign_word(self, ask: AssignWord) -> None:
        places = self.scenario.word_station.open_words
        if ask.word not in self.waiting or sum(at == ask.station for at, _ in self.open.values()) >= places:
            assert self.forgiving
            self.out.append(("word", Reply(Code.STATION_FULL, "")))
            return
        word = self.waiting.pop(ask.word)
        self.open[ask.word] = ask.station, replace(word, filled=(False,) * len(word.tiles))
        self.event(EventType.WORD_ASSIGNED, job=ask.word, station=ask.station)
        self.out.append(("word", Reply(Code.DONE, "")))

    def _assign_bundle(self, ask: AssignBundle) -> None:
        places = self.scenario.letter_station.staged_bundles
        if sum(at == ask.station for at, _ in self.staged.values()) >= places:
            assert self.forgiving
            self.out.append(("letter", Reply(Code.STATION_FULL, "")))
            return
        bundle = Bundle(self.bundles, ask.tile, self.scenario.bundle_size)
        self.bundles += 1
        self.staged[bundle.bundle] = ask.station, bundle
        self.out.append(("letter", Reply(Code.DONE, "", bundle.bundle)))
        self.event(EventType.BUNDLE_STAGED, job=bundle.bundle, station=ask.station, tile=ask.tile, count=bundle.count)

    def _begin(self, goal: TripGoal) -> None:
        bot, trip = goal.bot, goal.trip
        assert bot not in self.doing, f"bot {bot} is on two trips"
        under_way = [self.status[b].trip for b in self.doing]
        assert trip.bucket not in [t.bucket for t in under_way if t], f"bucket {trip.bucket} is on two trips"
        assert self.bucket_bot[trip.bucket] in (-1, bot)
        self.trips += 1
        self.doing[bot] = trip.trip
        self.status[bot] = BotStatus(self.now, bot, Phase.FETCHING, self.bot_bucket[bot], trip, 0, "")
        self.out.append(("fleet", self.status[bot]))
        steps: list = [] if self.bot_bucket[bot] == trip.bucket else [("grab", trip.bucket)]
        for number, visit in enumerate(trip.visits):
            assert visit.route[-1] == self.layout.station_xy(visit.station)
            steps += [("move", visit.station, move) for move in visit.moves] + [("visited", number + 1)]
        if trip.store_route:
            steps += [("release", trip.store_route[-1])]
        if self.rng.random() < self.failures:
            steps = [*steps[: int(self.rng.integers(len(steps)))], ("fail", Code.COLLIDED)]
        self._later(bot, trip.trip, steps)

    def _later(self, bot: int, trip: int, steps: list) -> None:
        self.serial += 1
        wait = 0.0 if self.instant else float(self.rng.uniform(0.1, 20.0))
        heapq.heappush(self.agenda, (self.now + wait, self.serial, bot, trip, steps))

    def step(self) -> None:
        """Do the next step of a trip."""
        self.now, _, bot, trip, steps = heapq.heappop(self.agenda)
        if self.doing.get(bot) != trip:
            return
        if not steps:
            self._end(bot, Code.DONE)
            return
        step, *rest = steps
        if step[0] == "fail" or not self._do(bot, step):
            self._end(bot, step[1] if step[0] == "fail" else Code.NOT_NEEDED)
        else:
            self._later(bot, trip, rest)

    def _do(self, bot: int, step: tuple) -> bool:
        if step[0] == "grab":
            bucket = step[1]
            assert self.bucket_bot[bucket] < 0
            self.bucket_bot[bucket], self.bot_bucket[bot] = bot, bucket
            self.bot_xy[bot] = tuple(map(float, self.layout.waypoints[self.bucket_spot[bucket]]))
            self.event(EventType.GRABBED, bot=bot, bucket=bucket)
        elif step[0] == "release":
            bucket = self.bot_bucket[bot]
            self.bot_xy[bot] = step[1]
            spot = next(s for s in self.spots if tuple(self.layout.waypoints[s]) == step[1])
            resting = [s for s, b in zip(self.bucket_spot, self.bucket_bot, strict=True) if b < 0]
            assert spot not in resting, f"spot {spot} is taken"
            self.bucket_spot[bucket], self.bucket_bot[bucket], self.bot_bucket[bot] = spot, -1, -1
            self.event(EventType.RELEASED, bot=bot, bucket=bucket)
        elif step[0] == "visited":
            self.status[bot] = replace(self.status[bot], visits_done=step[1], bucket=self.bot_bucket[bot])
            self.out.append(("fleet", self.status[bot]))
        else:
            return self._move(bot, *step[1:])
        return True

    def _move(self, bot: int, station: int, move) -> bool:
        bucket = self.bot_bucket[bot]
        contents = self.contents[bucket]
        self.bot_xy[bot] = self.layout.station_xy(station)
        about = {"bot": bot, "bucket": bucket, "station": station, "tile": move.tile, "job": move.job}
        if self.layout.is_word_station(station):
            assert move.job in self.open and move.tile in self.open[move.job][1].missing, "a tile was promised twice"
            assert contents.get(move.tile, 0) > 0, f"bucket {bucket} holds no {move.tile}"
            contents[move.tile] -= 1
            self.delivered[move.job] += 1
            word = self.open[move.job][1]
            letter = next(i for i, t in enumerate(word.tiles) if t == move.tile and not word.filled[i])
            filled = tuple(there or i == letter for i, there in enumerate(word.filled))
            self.open[move.job] = station, replace(word, filled=filled)
            self.event(EventType.TRANSFERRED, **about)
            if all(filled):
                del self.open[move.job]
                self.completed.append(move.job)
                self.event(EventType.WORD_COMPLETED, job=move.job, station=station, count=len(filled))
                self.event(EventType.WORD_CLEARED, job=move.job, station=station)
            return True
        assert move.job in self.staged, "a tile was promised twice"
        assert sum(contents.values()) < self.scenario.bucket.capacity, f"bucket {bucket} is full"
        contents[move.tile] = contents.get(move.tile, 0) + 1
        bundle = self.staged[move.job][1]
        self.staged[move.job] = station, replace(bundle, count=bundle.count - 1)
        self.event(EventType.TRANSFERRED, **about)
        if bundle.count == 1:
            del self.staged[move.job]
            self.event(EventType.BUNDLE_EMPTIED, job=move.job, station=station)
        return True

    def _end(self, bot: int, code: Code) -> None:
        trip = self.doing.pop(bot)
        self.status[bot] = BotStatus(self.now, bot, Phase.IDLE, self.bot_bucket[bot], None, 0, "")
        said = [TripResult(bot, trip, code, ""), self.status[bot]]
        for message in said if self.rng.random() < 0.5 else said[::-1]:
            self.out.append(("fleet", message))

    def event(self, kind: EventType, **about) -> None:
        """Tell all managers what happened."""
        self.sequence += 1
        bot = about.get("bot", -1)
        x, y = self.bot_xy[bot] if bot >= 0 else (-1.0, -1.0)
        self.out.append(("all", Event(self.now, self.sequence, kind, x=x, y=y, **about)))


class Warehouse:
    """A tiny world and the three managers; carries the messages to each of them in order.

    Args:
        world: The world.
        shared_view: Whether the managers share one view, as in one process, or have their own, as nodes do.
        lag: Probability that a manager takes in no messages while the world makes a step.
        seed: For lags and policies.
    """

    def __init__(self, world: TinyWorld, *, shared_view: bool = True, lag: float = 0.0, seed: int = 0) -> None:
        self.world = world
        self.rng = np.random.default_rng(seed)
        self.router = Router(world.layout)
        self.shared = WarehouseView(world.scenario, world.layout) if shared_view else None
        self.minds: dict[str, WordManager | LetterManager | TripFleet] = {}
        self.log: list = []
        self.lag = lag
        world.forgiving = lag > 0
        self.inbox: dict[str, deque] = {role: deque() for role in ("word", "letter", "fleet")}
        for role in ("word", "letter", "fleet"):
            self.start(role)
        self.tell("fleet", *world.status)
        self.settle()

    def start(self, role: str) -> None:
        """Start a manager, or start it anew with nothing but what the world says."""
        world = self.world
        view = self.shared or WarehouseView(world.scenario, world.layout)
        common = world.scenario, world.layout
        if role == "word":
            self.minds[role] = WordManager(*common, MinimalWord(), view, self.rng)
        elif role == "letter":
            kinds = np.full(view.kinds, 1.0 / view.kinds)
            self.minds[role] = LetterManager(*common, MinimalLetter(), view, self.rng, kinds)
        else:
            self.minds[role] = TripFleet(*common, MinimalFleet(), view, self.rng, self.router)
        self.tell(role, world.snapshot())

    def restart(self, role: str) -> None:
        """Kill a manager and start it again, as the nodes do."""
        tasks = self.fleet.tasks()
        self.start(role)
        if role == "fleet":
            self.tell("fleet", *self.world.status)
            for task in tasks:
                self.tell(
                    "word" if task.kind == DELIVER else "letter",
                    TaskResult(task.kind, task.task, Code.STOPPED, "the fleet manager is gone"),
                )

    @property
    def fleet(self) -> TripFleet:
        """The fleet manager."""
        mind = self.minds["fleet"]
        assert isinstance(mind, TripFleet)
        return mind

    def tell(self, role: str, *messages) -> None:
        """Give messages to a manager and pass on what it says."""
        for message in messages:
            self.carry(self.minds[role].handle(message, self.world.now))

    def carry(self, said: list) -> None:
        """Bring what a manager said to whom it concerns."""
        self.log += said
        for message in said:
            if isinstance(message, (DeliverGoal, StoreGoal)):
                self.world.out.append(("fleet", message))
            elif isinstance(message, (TaskFeedback, TaskResult)):
                self.world.out.append(("word" if message.kind == DELIVER else "letter", message))
            else:
                self.world.handle(message)

    def settle(self) -> None:
        """Deliver all messages but those to managers that lag; who comes first is random where any may."""
        awake = [role for role in self.minds if not self.lag or self.rng.random() >= self.lag]
        out = self.world.out
        while True:
            while out:
                role, message = out.popleft()
                for name in self.minds if role == "all" else (role,):
                    self.inbox[name].append(message)
            waiting = [role for role in awake if self.inbox[role]]
            if not waiting:
                return
            role = waiting[int(self.rng.integers(len(waiting)))] if self.lag else waiting[0]
            self.tell(role, self.inbox[role].popleft())

    def advance(self) -> bool:
        """Go on to the next thing that happens; whether there is one."""
        world = self.world
        alarm = min(mind.next_wake for mind in self.minds.values())
        step = world.agenda[0][0] if world.agenda else np.inf
        if alarm == np.inf and step == np.inf:
            some_lag = any(self.inbox.values())
            self.settle()
            return some_lag
        if alarm <= step:
            world.now = max(world.now, alarm)
            for mind in self.minds.values():
                if mind.next_wake <= world.now:
                    self.carry(mind.wake(world.now))
        else:
            world.step()
        self.settle()
        return True

    def run(self, steps: int = 20_000, until=None) -> None:
        """Go on until all words are done, or something is true."""
        world = self.world
        for _ in range(steps):
            if until() if until is not None else not (world.waiting or world.open):
                return
            assert self.advance(), f"stuck: {self.fleet.tasks()}"
        raise AssertionError(f"{len(world.completed)} words done after {steps} steps: {self.fleet.tasks()}")
