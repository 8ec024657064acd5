"""What a bot does with its bucket when a station is done with it: to another station, or into storage."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable

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

        def visit_s(station: int, tiles: int) -> float:
            return tiles * state.transfer_s(station) + state.travel_s(robot.waypoint, station) + self._overhead_s

        def wait_s(station: int) -> float:
            return state.ahead_s(station) + state.travel_s(robot.waypoint, station)

        least_tiles, least_room = state.tiles_of(self._least_tiles), state.tiles_of(self._least_room)
        return _words_before_letters(state, robot, least_tiles, visit_s, least_room, wait_s)


class Sparing(OnwardChoice):
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
        self._plenty = ServeOn()
        self._least_tiles, self._most_s, self._overhead_s = least_tiles, most_s, overhead_s
        self._least_room, self._balance = least_room, balance

    def score(self, state: PlanningState, robot: Robot) -> Floats:
        """Word stations above 1, letter stations below."""
        if not state.bots_are_scarce():
            return self._plenty.score(state, robot)
        is_filled = robot.station >= state.word_stations

        def wait_s(station: int) -> float:
            return max(state.travel_s(robot.waypoint, station), state.ahead_s(station))

        def visit_s(station: int, tiles: int) -> float | None:
            cost_s = wait_s(station) + self._overhead_s
            return cost_s if is_filled or cost_s <= self._most_s * tiles else None

        least_tiles = state.tiles_of(self._least_tiles)
        return _words_before_letters(state, robot, least_tiles, visit_s, self._enough_room(state), wait_s)

    def _enough_room(self, state: PlanningState) -> float:
        """The room with which a bucket goes to be filled (tiles)."""
        capacity = state.view.scenario.bucket.capacity
        room = state.tiles_of(self._least_room) - self._balance * state.missing_stock * capacity
        return max(room, LEAST_ROOM * capacity)


def _words_before_letters(
    state: PlanningState,
    robot: Robot,
    least_tiles: int,
    visit_s: Callable[[int, int], float | None],
    least_room: float,
    wait_s: Callable[[int], float],
) -> Floats:
    """The word stations by tiles a second or, where none is worth a visit, the letter stations by the wait.

    Args:
        state: The warehouse.
        robot: The bot, with its bucket.
        least_tiles: With fewer tiles a word station is not visited.
        visit_s: What a visit of a word station costs for so many tiles (s); None where it is not worth it.
        least_room: With less room the bucket is not taken to a letter station (tiles).
        wait_s: How long it takes until a letter station begins with the bucket (s).

    Returns:
        Scores, shape (stations,): of word stations above 1, of letter stations below.
    """
    scores = np.zeros(len(state.docks))
    for station in state.short_word_stations():
        tiles = state.serves(robot.bucket, station)
        if tiles >= least_tiles:
            cost_s = visit_s(station, tiles)
            if cost_s is not None:
                scores[station] = 1.0 + tiles / cost_s
    if not scores.any() and state.room(robot.bucket) >= least_room:
        for station in state.short_letter_stations():
            scores[station] = 1.0 / (1.0 + wait_s(station))
    return scores
