"""Dispatch: what each bot does next, by the scores of the policy's decisions (task allocation)."""

from __future__ import annotations

import numpy as np

from soup_managers.explain import Explain
from soup_managers.fleets.coordinated.digging import Digging
from soup_managers.fleets.coordinated.dock_queues import DockQueues
from soup_managers.fleets.coordinated.docking import Docking
from soup_managers.fleets.coordinated.fetching import Fetch, Fetching
from soup_managers.fleets.coordinated.lowest import lowest
from soup_managers.fleets.coordinated.moves import Moves
from soup_managers.fleets.coordinated.policies import Coordinated
from soup_managers.fleets.coordinated.scores import Scores
from soup_managers.fleets.coordinated.startup_barrier import StartupBarrier
from soup_managers.state.planning_state import PlanningState
from soup_managers.state.robots import Activity, Purpose, Robot
from soup_msgs_py.messages import TileMove
from soup_msgs_py.mistakes import Mistakes

BURIED_S = 20.0  # what it costs that a stored bucket closes the way to another one
TRIES = 8  # alternatives that are tried at once
WAITS_S = 15.0  # a bucket waits no longer for a bundle
NEXT_WORD_S = 0.4  # nor for the next word: it is chosen for the buckets that are there
KEEP_ROOM = 0.25  # share of the capacity: a bucket with less room is done at a letter station


class Dispatch:
    """Sends buckets on to stations and to storage, bots under them, and bots without work out of the way."""

    def __init__(
        self,
        state: PlanningState,
        policy: Coordinated,
        queues: DockQueues,
        barrier: StartupBarrier,
        moves: Moves,
        docking: Docking,
        digging: Digging,
        explain: Explain,
        mistakes: Mistakes,
    ) -> None:
        """Begin with nothing decided.

        Args:
            state: The bots, buckets and stations.
            policy: Its decisions.
            queues: The lines of stations.
            barrier: Whether bots may be sent about yet.
            moves: Sends bots.
            docking: Has buckets come to stations.
            digging: Which buckets are in each other's way.
            explain: Is told the decisions.
            mistakes: Is told what the policy decides that cannot be.
        """
        self._state, self._traffic, self._places = state, state.traffic, state.places
        self._policy, self._queues, self._barrier, self._moves = policy, queues, barrier, moves
        self._docking, self._digging, self._explain = docking, digging, explain
        self._fetching = Fetching(state, policy, digging, explain, mistakes)
        self._onward_scores = Scores(mistakes, "onward", policy.onward, 0.0)
        self._storage_costs = Scores(mistakes, "storage", policy.storage, np.inf)
        self._kept_free = np.zeros(len(state.layout.waypoints), bool)
        self._kept_free[[spot for spots in docking.spots for spot in spots]] = True

    def onward(self, robot: Robot, now: float) -> None:
        """What a bot with a bucket that stands does next."""
        if robot.activity is not Activity.STANDS or robot.bucket < 0:
            return
        if not self._barrier.over and not self._serves_where_it_stands(robot):
            self._moves.later(robot, now, "waits until all bots have told what they do")
            return
        if robot.purpose is Purpose.SERVE:
            if robot.slot != 0:
                return
            station = robot.station
            tiles = self._tiles(robot, station)
            if tiles:
                self._moves.serve(robot, station, tiles, now)
                return
            if self._state.is_word_station(station):
                if self._next_word_comes(robot, now):
                    self._moves.later(robot, now, "waits for the next word")
                    return
            elif self._worth_waiting(robot, now):
                self._moves.later(robot, now, "waits for a bundle")
                return
        if not self._serve_on(robot, now):
            self._store(robot, now)

    def _tiles(self, robot: Robot, station: int) -> tuple[TileMove, ...]:
        """The tiles that can be moved between a bot's bucket and a station."""
        state = self._state
        if state.is_word_station(station):
            return state.tasks.deliveries(station, state.stock.of(robot.bucket))
        return state.tasks.fillings(station, state.room(robot.bucket))

    def _serves_where_it_stands(self, robot: Robot) -> bool:
        """Have a bot serve at the dock where it stands, if that is free and its bucket is of use; whether so."""
        if robot.purpose is Purpose.SERVE:
            return robot.slot == 0 and bool(self._tiles(robot, robot.station))
        station = self._docking.finds_place(robot)
        if station < 0 or not self._tiles(robot, station):
            return False
        self._queues.enter(robot, station, 0)
        return True

    def _worth_waiting(self, robot: Robot, now: float) -> bool:
        """Whether a bucket stays for a while at a letter station that has nothing for it just now."""
        room = self._state.room(robot.bucket)
        return robot.blocked(now) <= WAITS_S and room > KEEP_ROOM * self._state.stock.capacity

    def _next_word_comes(self, robot: Robot, now: float) -> bool:
        """Whether a word is about to be opened at the station: a place is free and words wait."""
        view = self._state.view
        if not view.waiting_words or not view.free_places[robot.station]:
            return False
        return robot.blocked(now) <= NEXT_WORD_S

    def _serve_on(self, robot: Robot, now: float) -> bool:
        scores = self._policy.onward.score(self._state, robot)
        scores = self._onward_scores.of(scores, len(self._state.docks))
        station = self._docking.send_to_best(robot, scores, now)
        self._explain.choice("onward", station, scores, bot=robot.number, bucket=robot.bucket)
        return station >= 0

    def _store(self, robot: Robot, now: float) -> None:
        """Put the bucket away."""
        spots = self._places.free_spots()
        open_ = self._digging.open_spots()[spots]
        kept = self._kept_free[spots]
        spots = spots[open_ & ~kept] if (open_ & ~kept).any() else spots[open_]
        if not len(spots):
            self._moves.later(robot, now, "no storage spot is free")
            return
        travel = self._traffic.times_from(robot.waypoint)[spots]
        costs = self._policy.storage.cost(self._state, robot.bucket, spots, travel)
        costs = self._storage_costs.of(costs, len(spots)) + BURIED_S * self._digging.buried(spots)
        costs = np.where(np.isfinite(travel), costs, np.inf)
        chosen = -1
        for choice in lowest(costs, TRIES):
            if np.isfinite(costs[choice]) and self._moves.go(robot, int(spots[choice]), now, Purpose.STORE):
                chosen = int(spots[choice])
                self._queues.unbind(robot)
                break
        self._explain.choice("storage", chosen, -costs, spots, bot=robot.number, bucket=robot.bucket)
        if chosen < 0:
            self._moves.later(robot, now, "no way leads to a free storage spot now")

    # ---- bots without a bucket -------------------------------------------------------------------------------

    def needs_parking(self, robot: Robot) -> bool:
        """Whether a bot without work is in the way where it stands."""
        waypoint = robot.waypoint
        return not self._places.is_spot[waypoint] or (self._digging.needed and not self._places.occupied[waypoint])

    def park(self, robot: Robot, now: float) -> None:
        """A bot without work that stands on a lane goes under a bucket, out of the way."""
        spots = self._places.spots[self._places.taken[self._places.spots] == 0]
        under = self._places.occupied[spots]
        if self._digging.needed and under.any():
            spots = spots[under]  # beside one it would close the way to those behind
        costs = self._traffic.estimates(robot.waypoint, spots)
        for choice in lowest(costs, TRIES):
            if self._moves.go(robot, int(spots[choice]), now, Purpose.PARK, hurried=True):
                return
        self._moves.later(robot, now, "no way leads off the lane now")

    def fetch(self, now: float) -> None:
        """Have buckets fetched for the stations that run out of work."""
        for fetch in self._fetching.choose(now):
            self._send_for(fetch, now)

    def free_the_way(self, robot: Robot, now: float) -> None:
        """Have a bucket moved that keeps a bot with a bucket from getting out of a block."""
        if robot.activity is Activity.STANDS and robot.bucket >= 0 and self._digging.needed:
            fetch = self._fetching.dig_out(robot.waypoint, now)
            if fetch is not None:
                self._send_for(fetch, now)

    def _send_for(self, fetch: Fetch, now: float) -> None:
        """Have a bot fetch a bucket; where it cannot get there now, the bucket is left alone for a while."""
        robot, bucket = fetch.robot, fetch.wanted.bucket
        spot = int(self._state.spot_of[bucket])
        if not self._moves.go(robot, spot, now, Purpose.FETCH, target=bucket):
            self._fetching.unreachable(bucket, now)
            return
        if not fetch.wanted.digs:
            self._queues.bind(robot, fetch.wanted.station)
