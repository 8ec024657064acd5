"""Bots that drive by timetable in a world that knows nothing of it, and where they should be at any time."""

from __future__ import annotations

import heapq
import math
from itertools import pairwise
from pathlib import Path

import numpy as np

from soup_managers.traffic import Leg, Traffic
from soup_msgs_py import messages as m
from soup_msgs_py.codes import EventType
from soup_msgs_py.scenario import Scenario, load_scenario, load_words
from soup_sim.layouts import make_layout
from soup_sim.world import World

ROOT = Path(__file__).parents[2]
COLLISIONS = (EventType.BOT_COLLISION, EventType.BUCKET_COLLISION)


def scenario_of(name: str, *overrides: str) -> Scenario:
    return load_scenario(ROOT / f"config/scenarios/{name}.yaml", overrides)


def world_of(scenario: Scenario, seed: int) -> World:
    return World(scenario, make_layout(scenario), load_words(scenario, "test"), seed=seed)


def place_on(leg: Leg, time: float, V: float, A: float) -> tuple[float, float]:
    """Where a bot is that drives a leg: from rest to rest between its points, as fast as it can."""
    if time <= leg.stamps[0]:
        return leg.points[0]
    for (a, b), (start, end) in zip(pairwise(leg.points), pairwise(leg.stamps), strict=True):
        if time < end:
            length = math.dist(a, b)
            if length == 0.0:
                return a
            ramp = min(V / A, math.sqrt(length / A))
            gone, left = time - start, end - time
            if gone < ramp:
                along = A * gone * gone / 2.0
            elif left < ramp:
                along = length - A * left * left / 2.0
            else:
                along = A * ramp * ramp / 2.0 + V * (gone - ramp)
            return a[0] + (b[0] - a[0]) * along / length, a[1] + (b[1] - a[1]) * along / length
    return leg.points[-1]


class Drivers:
    """All bots of a world at work: fetch a bucket, queue at a station, store the bucket, and again.

    Attributes:
        legs: All legs that were driven.
        late: For each, how much later it arrived than it could have without traffic, once its goal was free (s).
        refused: How often there was no leg to a place that should be free.
    """

    def __init__(self, world: World, seed: int, dwell_s: tuple[float, float] = (0.5, 5.0)) -> None:
        self.world, self.rng, self.dwell_s = world, np.random.default_rng(seed), dwell_s
        self.limits = world.scenario.bot.max_speed_mps, world.scenario.bot.max_acceleration_mps2
        self.traffic = Traffic(world.scenario, world.layout)
        self.spots = world.layout.storage_spots.tolist()
        bots, buckets = world.bots(), world.buckets()
        number = {(x, y): w for w, (x, y) in enumerate(world.layout.waypoints.tolist())}
        self.bucket_at = {
            number[x, y]: b for b, (x, y) in enumerate(zip(buckets.x.tolist(), buckets.y.tolist(), strict=True))
        }
        self.promised: set[int] = set()  # spots that somebody goes to, or will set a bucket down on
        self.carried = [-1] * world.scenario.bots
        self.current: list[Leg | None] = [None] * world.scenario.bots
        self.legs: list[Leg] = []
        self.late: list[float] = []
        self.refused = 0
        self.requests = 0
        self.station = [-1] * world.scenario.bots
        self.served = [False] * world.scenario.bots
        self.agenda: list[tuple[float, int]] = []
        for bot, place in enumerate(zip(bots.x.tolist(), bots.y.tolist(), strict=True)):
            self.traffic.stand(bot, number[place], 0.0)
        for leg in self.traffic.clear_lanes(0.0, self.promised):
            self.promised.add(leg.waypoints[-1])
            self._drive(leg)
        for bot in range(world.scenario.bots):
            if self.current[bot] is None:
                heapq.heappush(self.agenda, (0.0, bot))

    # ---- what bots do ----------------------------------------------------------------------------------------

    def run(self, until: float, looks: int = 0) -> None:
        """Drive until a time; look `looks` times whether all bots are where they should be."""
        times = np.sort(self.rng.uniform(self.world.now, until, looks)).tolist()
        while self.agenda and self.agenda[0][0] <= until:
            time, bot = heapq.heappop(self.agenda)
            while times and times[0] < time:
                self._advance(times.pop(0))
                self.look()
            self._advance(time)
            self.traffic.forget_before(time)
            self._next(bot)

    def look(self) -> None:
        """Every bot is where its leg says, to a micrometre."""
        bots, now = self.world.bots(), self.world.now
        for bot, leg in enumerate(self.current):
            if leg is not None:
                x, y = place_on(leg, now, *self.limits)
                assert math.dist((x, y), (bots.x[bot], bots.y[bot])) < 1e-6, (bot, now, leg)

    def _advance(self, time: float) -> None:
        for said in self.world.advance(time):
            if isinstance(said, m.Event):
                assert said.type not in COLLISIONS, said
            elif isinstance(said, m.BotReply):
                assert said.success, said
                leg = self.current[said.bot]
                if leg is not None and said.message == "there" and said.time > leg.depart:
                    assert abs(said.time - leg.arrive) < 1e-6

    def _next(self, bot: int) -> None:
        here, now = self.traffic.at(bot), self.world.now
        if self.carried[bot] < 0:
            if here in self.bucket_at and self.station[bot] == -2:
                self._ask(m.Grab(bot, self._number(), self.bucket_at[here]))
                self.carried[bot] = self.bucket_at.pop(here)
                self.promised.discard(here)
                self.station[bot] = int(self.rng.integers(len(self.traffic.lines)))
                self.served[bot] = False
                heapq.heappush(self.agenda, (now + self.world.scenario.bot.grab_s + 1e-6, bot))
                return
            free = [spot for spot in self.bucket_at if spot not in self.promised]
            self._go(bot, free, lambda: self.station.__setitem__(bot, -2))
        elif self.served[bot]:
            if here in self.spots:
                self._ask(m.Release(bot, self._number()))
                self.bucket_at[here], self.carried[bot] = self.carried[bot], -1
                self.promised.discard(here)
                heapq.heappush(self.agenda, (now + self.world.scenario.bot.release_s + 1e-6, bot))
                return
            self._go(bot, [s for s in self.spots if s not in self.bucket_at and s not in self.promised])
        else:
            self._queue(bot, here)

    def _queue(self, bot: int, here: int) -> None:
        line = self.traffic.lines[self.station[bot]]
        if here == line[0]:
            self.served[bot] = True
            heapq.heappush(self.agenda, (self.world.now + float(self.rng.uniform(*self.dwell_s)), bot))
            return
        for place in line[: line.index(here)] if here in line else line:
            leg = self.traffic.plan(bot, place, self.world.now, loaded=True, blocked_spots=self._resting())
            if leg is not None:
                self._drive(leg)
                return
        heapq.heappush(self.agenda, (self.world.now + 0.5, bot))

    def _go(self, bot: int, spots: list[int], done=lambda: None) -> None:
        here = self.traffic.at(bot)
        spots = [spot for spot in spots if self.traffic.free_from(spot) < math.inf or spot == here]
        if spots:
            goal = spots[int(self.rng.integers(len(spots)))]
            loaded = self.carried[bot] >= 0
            leg = self.traffic.plan(bot, goal, self.world.now, loaded=loaded, blocked_spots=self._resting())
            if leg is not None:
                self.promised.discard(here)
                self.promised.add(goal)
                done()
                self._drive(leg)
                return
            self.refused += 1
        heapq.heappush(self.agenda, (self.world.now + 1.0, bot))

    def _drive(self, leg: Leg) -> None:
        start, goal = leg.waypoints[0], leg.waypoints[-1]
        self.current[leg.bot] = leg
        self.legs.append(leg)
        self.late.append(leg.arrive - self.world.now - self.traffic.travel_time(start, goal))
        self._ask(m.FollowPath(leg.bot, self._number(), leg.points, leg.stamps))
        heapq.heappush(self.agenda, (leg.arrive + 1e-6, leg.bot))

    def _ask(self, request) -> None:
        for said in self.world.handle(request):
            assert not isinstance(said, m.BotReply) or said.success, said

    def _number(self) -> int:
        self.requests += 1
        return self.requests

    def _resting(self) -> np.ndarray:
        resting = np.zeros(len(self.world.layout.waypoints), dtype=bool)
        resting[list(self.bucket_at)] = True
        resting[list(self.promised)] = True
        return resting
