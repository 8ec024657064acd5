"""Which buckets are fetched next, for which stations, by which bots."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from soup_managers.explain import Explain
from soup_managers.fleets.coordinated.digging import Digging, Mask
from soup_managers.fleets.coordinated.lowest import lowest
from soup_managers.fleets.coordinated.policies import Coordinated
from soup_managers.fleets.coordinated.scores import Scores
from soup_managers.state.planning_state import Fill, PlanningState, Want
from soup_managers.state.robots import Purpose, Robot
from soup_msgs_py.mistakes import Mistakes
from soup_msgs_py.warehouse.layout import Ints

TRIES = 8  # buckets that are looked at for a station
STATIONS = 40  # the nearest ones that a scarce bot looks at
UNREACHABLE_S = 5.0  # how long a bucket is left alone after no way led to it
DIG_DISCOUNT = 0.5  # what a bucket is worth for each other one that must be moved first


@dataclass(frozen=True, slots=True)
class Wanted:
    """A bucket that is to be fetched.

    Attributes:
        bucket: The bucket.
        station: The station that it is for, -1 for none.
        digs: Whether it only has to go, because it is in the way of the one that the station wants.
    """

    bucket: int
    station: int
    digs: bool


@dataclass(frozen=True, slots=True, eq=False)
class Demand:
    """What a station wants, and which buckets may be fetched for it, shape (buckets,)."""

    needs: Want | Fill
    allowed: Mask


@dataclass(frozen=True, slots=True)
class Fetch:
    """A bot that is to fetch a bucket."""

    robot: Robot
    wanted: Wanted


class Fetching:
    """Matches stations that run out of work with buckets, and those with idle bots, by the policies' scores."""

    def __init__(
        self, state: PlanningState, policy: Coordinated, digging: Digging, explain: Explain, mistakes: Mistakes
    ) -> None:
        self._state, self._policy, self._digging = state, policy, digging
        self._bot_costs = Scores(mistakes, "bots", policy.bots, np.inf)
        self._bucket_scores = Scores(mistakes, "buckets", policy.buckets, 0.0)
        self._fill_scores = Scores(mistakes, "fills", policy.fills, 0.0)
        self._explain = explain
        self._diggers: dict[int, Robot] = {}  # who clears the way to a bucket, by the station that wants it
        self._not_before = np.zeros(state.view.scenario.buckets)  # when each bucket may be thought of again (s)

    def unreachable(self, bucket: int, now: float) -> None:
        """No way led to a bucket."""
        self._not_before[bucket] = now + UNREACHABLE_S

    def choose(self, now: float) -> list[Fetch]:
        """The buckets to fetch now, at most one for each station that is short, as far as idle bots go."""
        state = self._state
        idle = state.idle_bots()
        if not idle:
            return []
        words, letters = state.short_word_stations(), state.short_letter_stations()
        wanted: list[Wanted] = []
        if state.bots_are_scarce() and not self._digging.needed:
            wanted = self._choose_for_bots(idle, words, now)
        if not wanted:
            short = sorted((state.ahead_s(station), station) for station in words + letters)
            wanted = self._choose_buckets(self._demands([station for _, station in short], len(idle), now), idle)
        fetches = self._choose_bots(wanted, idle, now)
        self._diggers |= {fetch.wanted.station: fetch.robot for fetch in fetches if fetch.wanted.digs}
        return fetches

    def dig_out(self, spot: int, now: float) -> Fetch | None:
        """Move the first bucket that is in the way out of a spot; None where that cannot be, or is under way."""
        idle = self._state.idle_bots()
        bucket = self._outermost(spot)
        if bucket < 0 or not self._is_reachable(bucket, idle):
            return None
        return next(iter(self._choose_bots([Wanted(bucket, -1, True)], idle, now)), None)

    # ---- where bots are scarce -----------------------------------------------------------------------------

    def _choose_for_bots(self, idle: list[int], stations: list[int], now: float) -> list[Wanted]:
        """For each idle bot the bucket and word station that it serves best from where it stands.

        Who then goes to a letter station is decided when a bucket is done at its word station.
        """
        state, speed = self._state, self._state.view.scenario.bot.max_speed_mps
        usable = state.free_buckets & (self._not_before <= now)
        places = state.layout.waypoints[np.maximum(state.view.spot_of, 0)]
        wants = {station: state.want(station) for station in stations}
        wanted: list[Wanted] = []
        for bot in idle:
            if not wants:
                break
            robot = state.robots[bot]
            near = sorted(wants, key=lambda station: state.travel_s(robot.waypoint, station))[:STATIONS]
            bot_s = np.abs(places - state.robot_xy[bot]).sum(axis=1) / speed
            asked = [replace(wants[station], bot_s=bot_s) for station in near]
            scored = [self._policy.buckets.score(state, want) for want in asked]
            scores = np.array(list(self._bucket_scores.of_all(scored, len(near), len(usable))))
            scores[:, ~usable] = 0.0
            for place in lowest(-scores.ravel(), TRIES):
                row, bucket = divmod(int(place), len(usable))
                if scores[row, bucket] <= 0.0:
                    break
                if self._is_reachable(bucket, [bot]):
                    self._explain.choice("buckets", bucket, scores[row], station=near[row])
                    wanted.append(Wanted(bucket, near[row], False))
                    usable[bucket] = False
                    del wants[near[row]]
                    break
        return wanted

    # ---- bots ----------------------------------------------------------------------------------------------

    def _choose_bots(self, wanted: list[Wanted], idle: list[int], now: float) -> list[Fetch]:
        """A bot for each bucket, as far as they go; who stands under a bucket fetches it, nobody else could."""
        state = self._state
        under = {state.robots[bot].waypoint: bot for bot in idle}
        fetches, others = [], []
        free = np.ones(len(idle), bool)
        for want in wanted:
            bot = under.get(int(state.spot_of[want.bucket]), -1)
            if bot >= 0:
                fetches.append(Fetch(state.robots[bot], want))
                free[idle.index(bot)] = False
            else:
                others.append(want)
        if not others:
            return fetches
        bots = np.array(idle, np.int32)[free]
        free = free[free]
        places = [self._spot_xy(want.bucket) for want in others]
        if not len(bots):
            return fetches
        costs = self._policy.bots.match(state, bots, places)
        for want, cost in zip(others, self._bot_costs.of_all(costs, len(others), len(bots)), strict=True):
            usable = np.where(free, cost, np.inf)
            if not np.isfinite(usable).any():
                break
            best = int(usable.argmin())
            self._explain.choice("bots", int(bots[best]), -usable, bots, bucket=want.bucket)
            free[best] = False
            fetches.append(Fetch(state.robots[int(bots[best])], want))
        return fetches

    def _spot_xy(self, bucket: int) -> tuple[float, float]:
        x, y = self._state.layout.waypoints[self._state.spot_of[bucket]]
        return float(x), float(y)

    # ---- buckets -------------------------------------------------------------------------------------------

    def _demands(self, stations: list[int], most: int, now: float) -> list[Demand]:
        """What the shortest stations want that any free bucket serves.

        Where no bucket serves one of these, those behind them have their turn: else all would wait for each other.
        """
        state, demands = self._state, []
        usable = state.free_buckets & (self._not_before <= now)
        for rank, station in enumerate(stations):
            if demands and rank >= most:
                break
            if state.is_word_station(station):
                needs: Want | Fill = state.want(station)
                allowed = usable & (needs.tiles > 0)
            else:
                needs = state.fill(station)
                allowed = usable & self._has_room(needs.room)
            if allowed.any():
                demands.append(Demand(needs, allowed))
        return demands

    def _choose_buckets(self, demands: list[Demand], idle: list[int]) -> list[Wanted]:
        """A bucket for each station, where there is one."""
        state, policy = self._state, self._policy
        words = [demand.needs for demand in demands if isinstance(demand.needs, Want)]
        scored = policy.buckets.match(state, words) if words else []
        buckets = len(state.stock)
        word_scores = self._bucket_scores.of_all(scored, len(words), buckets)
        depths = self._digging.depths()[np.maximum(state.spot_of, 0)]
        chosen: dict[int, Wanted] = {}
        for demand in demands:
            needs, station = demand.needs, demand.needs.station
            if isinstance(needs, Want):
                scores = next(word_scores)
            else:
                scores = self._fill_scores.of(policy.fills.score(state, needs), buckets)
            scores = np.where(demand.allowed, scores, 0.0)
            if self._digging.needed:
                scores = scores * DIG_DISCOUNT**depths
            taken = -1
            for bucket in lowest(-scores, TRIES + len(chosen)):
                if scores[bucket] <= 0.0:
                    break
                first = self._first_to_move(bucket, int(depths[bucket]), station)
                if first >= 0 and first not in chosen and self._is_reachable(first, idle):
                    chosen[first] = Wanted(first, station, first != bucket)
                    taken = bucket
                    break
            self._explain.choice("buckets", taken, scores, station=station)
        return list(chosen.values())

    def _has_room(self, room: Ints) -> Mask:
        """Which buckets may be filled: those with room enough or, where none has that much, with any."""
        enough = room >= self._state.tiles_of(self._state.horizons.least_room)
        return enough if enough.any() else room > 0

    def _is_reachable(self, bucket: int, idle: list[int]) -> bool:
        """Whether no bot is under a bucket, or an idle one, which can fetch it itself."""
        spot = int(self._state.spot_of[bucket])
        robots = self._state.robots
        return not self._state.places.taken[spot] or any(robots[bot].waypoint == spot for bot in idle)

    def _first_to_move(self, bucket: int, depth: int, station: int) -> int:
        """The bucket itself or, where others are in its way, the first of them that can be moved; -1 for none."""
        if not depth:
            return bucket
        digger = self._diggers.get(station)
        if digger is not None and digger.purpose is Purpose.FETCH:
            return -1
        return self._outermost(int(self._state.spot_of[bucket]))

    def _outermost(self, spot: int) -> int:
        """The first bucket that is to be moved so that one can get out of a spot, -1 where that is under way."""
        in_the_way = self._digging.in_the_way(spot)
        bucket = int(self._state.view.bucket_at[in_the_way[0]]) if in_the_way else -1
        return bucket if bucket >= 0 and self._state.free_buckets[bucket] else -1
