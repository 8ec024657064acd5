"""What a bot does with its bucket when a station is done with it: to another station, or into storage."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from soup_managers.state.planning_state import PlanningState
from soup_managers.state.robots import Robot
from soup_msgs_py.warehouse.layout import Floats

LEAST_ROOM = 0.3  # share of the capacity: no bucket with less is taken to be filled, whatever the stock lacks


class OnwardChoice(ABC):
    """Scores stations as the next stop of a bucket that is on a bot. Extend it and implement `score`."""

    @abstractmethod
    def score(self, state: PlanningState, robot: Robot) -> Floats:
        """How good each station is as the next stop.

        Args:
            state: The warehouse.
            robot: The bot, with its bucket, where it stands.

        Returns:
            Scores, shape (stations,): the highest above 0 is taken that has a place in its line; if there is
            none, the bucket is stored.
        """


class AlwaysStore(OnwardChoice):
    """One station a trip: the bucket goes into storage."""

    def score(self, state: PlanningState, robot: Robot) -> Floats:
        """Nothing above 0."""
        return np.zeros(len(state.docks))


class ServeOn(OnwardChoice):
    """On to the word station with most tiles per second; else, with enough room, to be filled.

    Args:
        least_tiles: Fewer tiles are not worth a visit: tiles or, below 1, a share of the capacity of a bucket.
        least_room: With less room, counted alike, a bucket is not taken to a letter station.
        overhead_s: What a visit costs besides travel and transfers.
    """

    def __init__(self, least_tiles: float = 0.2, least_room: float = 0.4, overhead_s: float = 15.0) -> None:
        self._least_tiles, self._least_room, self._overhead_s = least_tiles, least_room, overhead_s

    def score(self, state: PlanningState, robot: Robot) -> Floats:
        """Word stations above 1, letter stations below."""
        scores = np.zeros(len(state.docks))
        least_tiles, least_room = state.tiles_of(self._least_tiles), state.tiles_of(self._least_room)
        for station in state.short_word_stations():
            tiles = state.serves(robot.bucket, station)
            if tiles >= least_tiles:
                travel_s = state.travel_s(robot.waypoint, station)
                cost_s = tiles * state.transfer_s(station) + travel_s + self._overhead_s
                scores[station] = 1.0 + tiles / cost_s
        if not scores.any() and state.room(robot.bucket) >= least_room:
            for station in state.short_letter_stations():
                wait_s = state.ahead_s(station) + state.travel_s(robot.waypoint, station)
                scores[station] = 1.0 / (1.0 + wait_s)
        return scores


class Sparing(ServeOn):
    """Sparing with bots where they are scarce: as few of their seconds for a letter as may be. Else as `serve_on`.

    On to the word station with most tiles per second, waits counted, but to none that costs too much for what it
    takes. A bucket crosses the floor to be filled only with room that is worth the way; the further the stock is below
    that of the start, the less room is enough, so that as many letters come in as go out.

    Args:
        least_tiles: Fewer tiles are not worth a visit: tiles or, below 1, a share of the capacity of a bucket.
        most_s: A visit costs no more of the bot than this for each tile, transfers aside.
        overhead_s: What a visit costs besides travel, waits and transfers.
        least_room: With less room, counted like tiles, a full stock gets no bucket that is filled.
        balance: By how many times the share that is missing in the stock this room is less, as a share of the capacity.
    """

    def __init__(
        self,
        least_tiles: float = 0.075,
        most_s: float = 4.0,
        overhead_s: float = 4.0,
        least_room: float = 0.7,
        balance: float = 5.0,
    ) -> None:
        super().__init__()
        self._few_tiles, self._most_s, self._hop_s = least_tiles, most_s, overhead_s
        self._full_room, self._balance = least_room, balance

    def score(self, state: PlanningState, robot: Robot) -> Floats:
        """Word stations above 1, letter stations below."""
        if not state.bots_are_scarce():
            return super().score(state, robot)
        scores = np.zeros(len(state.docks))
        least_tiles, is_filled = state.tiles_of(self._few_tiles), robot.station >= state.word_stations
        for station in state.short_word_stations():
            tiles = state.serves(robot.bucket, station)
            if tiles >= least_tiles:
                wait_s = max(state.travel_s(robot.waypoint, station), state.ahead_s(station)) + self._hop_s
                if is_filled or wait_s <= self._most_s * tiles:
                    scores[station] = 1.0 + tiles / wait_s
        if not scores.any() and state.room(robot.bucket) >= self._enough_room(state):
            for station in state.short_letter_stations():
                wait_s = max(state.travel_s(robot.waypoint, station), state.ahead_s(station))
                scores[station] = 1.0 / (1.0 + wait_s)
        return scores

    def _enough_room(self, state: PlanningState) -> float:
        """The room with which a bucket goes to be filled (tiles)."""
        capacity = state.view.scenario.bucket.capacity
        room = state.tiles_of(self._full_room) - self._balance * state.missing_stock * capacity
        return max(room, LEAST_ROOM * capacity)
