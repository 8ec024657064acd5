"""Docking: buckets come to stations, wait in the lines before the docks, and move up."""

from __future__ import annotations

from soup_managers.fleets.coordinated.digging import Digging
from soup_managers.fleets.coordinated.dock_queues import FAR_S, DockQueues, spots_near
from soup_managers.fleets.coordinated.lowest import lowest
from soup_managers.fleets.coordinated.moves import Moves
from soup_managers.state.planning_state import PlanningState
from soup_managers.state.robots import Activity, Purpose, Robot
from soup_msgs_py.warehouse.layout import Floats

TRIES = 8  # stations that are tried at once
GIVE_UP_S = 20.0  # a bucket that could not get to its station for so long does something else


class Docking:
    """Moves the lines of stations up, and has buckets come.

    Attributes:
        spots: Storage spots near each station, which are kept for buckets that wait for a place in its line.
    """

    def __init__(self, state: PlanningState, digging: Digging, queues: DockQueues, moves: Moves) -> None:
        """Begin with nobody in the lines.

        Args:
            state: The bots, buckets and stations.
            digging: Knows which spots a bot with a bucket gets to.
            queues: The lines of stations.
            moves: Sends bots.
        """
        self._state, self._traffic, self._places = state, state.traffic, state.places
        self._digging, self._queues, self._moves = digging, queues, moves
        self.spots = spots_near(state.docks, self._places.spots, self._traffic)

    def move_up(self, station: int, now: float) -> None:
        """Move a station's line up, and let those who wait for a place in it come."""
        queues, closed = self._queues, bool(self._state.closed[station])
        places = queues.places[station]
        while (gap := queues.gap(station)) is not None:
            slot, robot = gap
            if robot.activity is not Activity.STANDS:
                break
            if not self._take_place(robot, slot, now, "waits to move up"):
                break
        waiting = [
            (self._state.travel_s(robot.waypoint, station), robot.number, robot)
            for robot in self._state.bound[station]
            if robot.slot < 0 and robot.activity is Activity.STANDS and robot.bucket >= 0
        ]
        waiting.sort()
        for _, _, robot in waiting:
            if closed or now - robot.blocked_since > GIVE_UP_S:
                queues.unbind(robot)
                robot.has_nothing_to_do()
                robot.unblocked()
                self._moves.undecided.append(robot)
        if closed:
            return
        waiting = [entry for entry in waiting if entry[2].station == station]
        crowded = len(self._state.bound[station]) > len(places)
        for travel, _, robot in waiting:
            if crowded and travel > FAR_S and self._come_near(robot, station, now):
                continue
            slot = queues.slot_for(robot, station, now)
            if slot < 0:
                continue
            why = f"no way leads to {self._state.layout.station_name(station)} now"
            if not self._take_place(robot, slot, now, why):
                robot.blocked(now)

    def _take_place(self, robot: Robot, slot: int, now: float, why: str) -> bool:
        """Send a bot to another place in the line that it is bound for; it waits where no way leads there now."""
        before = robot.slot
        self._queues.put(robot, slot)
        if self._moves.go(robot, self._queues.places[robot.station][slot], now, Purpose.SERVE):
            return True
        self._queues.put(robot, before)
        self._moves.later(robot, now, why)
        return False

    def _come_near(self, robot: Robot, station: int, now: float) -> bool:
        """Send a bucket that comes from far to a free storage spot near its station, where it waits for a place.

        So nobody keeps a place in the line while it crosses the floor.
        """
        open_ = self._digging.open_spots()
        for spot in self.spots[station]:
            if self._places.is_free(spot) and open_[spot] and self._moves.go(robot, spot, now, Purpose.SERVE):
                return True
        return False

    def send_to_best(self, robot: Robot, scores: Floats, now: float) -> int:
        """Send a bucket to the best station that has a place and a way to it; which, or -1.

        Args:
            robot: The bot that carries it.
            scores: Of each station, shape (stations,); not above zero for those where it is of no use.
            now: Simulated time (s).
        """
        for station in lowest(-scores, TRIES):
            if scores[station] <= 0.0:
                return -1
            slot = self._queues.slot_for(robot, station, now) if station != robot.station else -1
            if slot < 0:
                continue
            place = self._queues.places[station][slot]
            is_there = self._traffic.at(robot.number) == place
            if is_there or self._moves.go(robot, place, now, Purpose.SERVE):
                robot.is_for(Purpose.SERVE)
                self._queues.unbind(robot)
                self._queues.bind(robot, station)
                self._queues.put(robot, slot)
                if is_there:
                    self._moves.arrived(robot, now)
                return station
        return -1

    def finds_place(self, robot: Robot) -> int:
        """The station at whose dock a bot stands, if nobody else has that place; else -1."""
        station = self._queues.station_at(robot.waypoint)
        if station < 0 or self._queues.places[station][0] != self._traffic.at(robot.number):
            return -1
        return station if self._queues.at(station, 0) is None else -1
