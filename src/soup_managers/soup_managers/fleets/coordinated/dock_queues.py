"""Dock queues: who is bound for which station, and who has which place in the line before it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from soup_managers.state.planning_state import PlanningState
from soup_managers.state.robots import Activity, Purpose, Robot
from soup_managers.traffic import Traffic

FAR_S = 15.0  # a bot that comes from farther takes the hindmost place in a line
WAITING_SPOTS = 4  # storage spots near each station that are kept for buckets that wait for a place in its line


class DockQueues:
    """The lines of all stations: place 0 is the dock, the others are behind it.

    Attributes:
        places: The waypoints of each station's line, the dock first.
        moved: Stations in whose lines somebody may move up, or may come.
        bound_changed: Whether others are bound for stations than when this was set to False.
    """

    def __init__(self, state: PlanningState, places: Sequence[Sequence[int]]) -> None:
        """Begin with nobody in the lines.

        Args:
            state: Knows who is bound for a station.
            places: The waypoints of each station's line, the dock first.
        """
        self._state = state
        self.places = places
        self.moved: set[int] = set()
        self.bound_changed = False
        self._who: list[list[Robot | None]] = [[None] * len(line) for line in places]
        self._station_of = {place: station for station, line in enumerate(places) for place in line}

    def station_at(self, waypoint: int) -> int:
        """The station in whose line a waypoint is, -1 for none."""
        return self._station_of.get(waypoint, -1)

    def at(self, station: int, slot: int) -> Robot | None:
        """Who has a place."""
        return self._who[station][slot]

    def gap(self, station: int) -> tuple[int, Robot] | None:
        """The foremost free place that has somebody behind it, and the next one there."""
        line = self._who[station]
        for slot, who in enumerate(line):
            if who is None:
                behind = next((other for other in line[slot:] if other is not None), None)
                return None if behind is None else (slot, behind)
        return None

    def slot_for(self, robot: Robot, station: int, now: float) -> int:
        """The place in a station's line that a bot can get to, -1 for none.

        It comes behind all who are there before it, and before those who arrive later. One that comes from far
        takes the hindmost: others may be served before it is there.
        """
        if self._state.closed[station]:
            return -1
        line = self._who[station]
        travel = self._state.travel_s(robot.waypoint, station)
        low, high = 0, len(line)
        for slot, other in enumerate(line):
            if other is None:
                continue
            if other.activity is Activity.DRIVES and other.arrives > now + travel:
                high = slot
                break
            low = slot + 1
        if low >= high:
            return -1
        return low if travel <= FAR_S else high - 1

    def bind(self, robot: Robot, station: int) -> None:
        """A bot is bound for a station, and has no place in its line yet."""
        robot.takes_place(station, -1)
        self._state.bound[station].append(robot)
        self._changed(station)

    def unbind(self, robot: Robot) -> None:
        """A bot is bound for no station; who is behind it may move up."""
        station = robot.station
        if station < 0:
            return
        self._state.bound[station].remove(robot)
        self._changed(station)
        if robot.slot >= 0:
            self._who[station][robot.slot] = None
            self.moved.add(station)
        robot.takes_place(-1, -1)

    def put(self, robot: Robot, slot: int) -> None:
        """A bot has another place in the line of the station that it is bound for; -1 for none."""
        line = self._who[robot.station]
        if robot.slot >= 0:
            line[robot.slot] = None
        robot.takes_place(robot.station, slot)
        if slot >= 0:
            line[slot] = robot

    def keep(self, robot: Robot) -> None:
        """A bot that waits in a line with a bucket, and is not in the books yet, has the place where it is."""
        station = self.station_at(robot.waypoint)
        if robot.bucket >= 0 and station >= 0:
            self.enter(robot, station, self.places[station].index(robot.waypoint))

    def enter(self, robot: Robot, station: int, slot: int) -> None:
        """A bot is found at a place in a station's line, and serves there if nobody else has it."""
        if self._who[station][slot] is None:
            self.bind(robot, station)
            robot.is_for(Purpose.SERVE)
            self.put(robot, slot)

    def _changed(self, station: int) -> None:
        self._state.changed(station)
        self.bound_changed = True


def spots_near(docks: Sequence[int], spots: np.ndarray, traffic: Traffic) -> list[list[int]]:
    """The storage spots nearest to each station, no spot for two of them.

    Args:
        docks: The waypoints of the stations' docks.
        spots: The storage spots, as waypoints.
        traffic: Knows how long ways take.
    """
    near: list[list[int]] = [[] for _ in docks]
    times = [traffic.times_to(dock)[spots] for dock in docks]
    for _ in range(WAITING_SPOTS):
        for found, time in zip(near, times, strict=True):
            best = int(time.argmin()) if len(time) else -1
            if best >= 0 and np.isfinite(time[best]):
                found.append(int(spots[best]))
                for others in times:
                    others[best] = np.inf
    return near
