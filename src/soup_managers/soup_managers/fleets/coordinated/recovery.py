"""Fleet recovery: what happens when a bot dies, forgets its order or collides.

Where it stands and where it may still go is kept clear of all others, its task goes to another bot or waits for it.
"""

from __future__ import annotations

from soup_managers.fleets.coordinated.dock_queues import DockQueues
from soup_managers.fleets.coordinated.liveness import Liveness
from soup_managers.fleets.coordinated.orders import Orders
from soup_managers.fleets.coordinated.take_over import purpose_of
from soup_managers.state.planning_state import PlanningState
from soup_managers.state.robots import Activity, Purpose, Robot
from soup_managers.traffic import Leg
from soup_msgs_py.codes import Code
from soup_msgs_py.messages import BotStatus, Trip

RETRY_S = 0.5  # before a way that could not be planned is tried again
ASK_S = 5.0  # between two questions to all lost bots that are silent
NEVER_LEFT = frozenset({Code.LATE, Code.BUSY, Code.PENALISED})  # results of drives that did not begin
GONE = frozenset({Code.STOPPED, Code.UNKNOWN})  # results that somebody else had to give


class Recovery:
    """Enters bots in the fleet's books: where they are seen, where an earlier fleet sent them, where they went wrong.

    Attributes:
        halted: Bots that were told to stop on their way, and are not seen to stand yet.
    """

    def __init__(
        self,
        state: PlanningState,
        queues: DockQueues,
        liveness: Liveness,
        orders: Orders,
    ) -> None:
        """Begin with bots of which nothing is known.

        Args:
            state: The bots, buckets and stations.
            queues: The lines of stations.
            liveness: Knows whom nobody can rely on.
            orders: What is asked of bots.
        """
        self.halted: set[int] = set()
        self._state, self._traffic, self._places = state, state.traffic, state.places
        self._layout, self._view = state.layout, state.view
        self._queues, self._liveness, self._orders = queues, liveness, orders
        bot = state.view.scenario.bot
        self._tolerance_m, self._penalty_s = bot.tolerance_m, bot.collision_penalty_s
        self._brakes_s = bot.max_speed_mps / bot.max_acceleration_mps2
        self._legs: dict[int, Leg] = {}  # the last one of each bot
        self._asks_at = 0.0

    # ---- where bots are --------------------------------------------------------------------------------------

    def _moves(self, robot: Robot, goal: int) -> None:
        """A bot leaves where it is and will stand on a waypoint."""
        if robot.waypoint >= 0:
            self._places.leave(robot.waypoint)
        self._places.take(goal)
        self._state.robot_xy[robot.number] = self._layout.waypoints[goal]

    def departs(self, robot: Robot, goal: int, leg: Leg) -> None:
        """A bot is sent to a waypoint."""
        self._moves(robot, goal)
        self._legs[robot.number] = leg
        robot.sent(goal, leg.arrive)

    def stands(self, robot: Robot, bucket: int, now: float) -> None:
        """Enter a bot where it is seen."""
        x, y = float(self._view.bot_x[robot.number]), float(self._view.bot_y[robot.number])
        waypoint = self._traffic.nearest(x, y)
        self._moves(robot, waypoint)
        robot.found(bucket, waypoint)
        self.halted.discard(robot.number)
        self._traffic.stand_at(robot.number, x, y, now)
        self._stop_others(robot, now)

    def stands_in_the_way(self, robot: Robot, now: float) -> None:
        """Nobody answers for a bot, or it still does what nobody knows any more: it stands there until it is idle."""
        self.stands(robot, int(self._view.bot_bucket[robot.number]), now)
        self._liveness.lose(robot, now)
        self.note_closed()

    def note_closed(self) -> None:
        """Close the stations in whose lines somebody stands whom nobody can tell to leave."""
        closed = self._state.closed
        closed[:] = False
        for robot in self._liveness.lost.values():
            station = self._queues.station_at(robot.waypoint)
            if station >= 0:
                closed[station] = True
                self._queues.moved.add(station)

    # ---- what an earlier fleet has begun --------------------------------------------------------------------

    def drives_for_another(self, robot: Robot, status: BotStatus, now: float) -> bool:
        """Whether a bot that is not on a drive of this fleet is on one: its mind was started again and goes on with it.

        Then it is as if the fleet had found it so.
        """
        if robot.activity is Activity.STANDS and status.stamps[-1] > now:
            self.failed(robot, Code.CANCELLED, "drives, though it was to stand", True, now)
        return robot.activity is Activity.AWAY

    def adopt_drive(self, robot: Robot, status: BotStatus) -> None:
        """A bot drives where an earlier fleet has sent it: what for is to be seen by where that is."""
        self._liveness.placed(robot.number)
        self.halted.discard(robot.number)
        self._traffic.adopt(robot.number, status.points, status.stamps)
        goal = self._traffic.nearest(*status.points[-1])
        self._moves(robot, goal)
        robot.adopted_on(goal, status.bucket, status.stamps[-1])
        self.note_closed()
        if robot.bucket < 0:
            bucket = int(self._view.bucket_at[goal])
            if bucket >= 0 and self._state.free_buckets[bucket]:
                robot.is_for(Purpose.FETCH, bucket)
            return
        if self._places.is_spot[goal]:
            robot.is_for(Purpose.STORE)
        self._queues.keep(robot)

    def end_adopted(self, robot: Robot, status: BotStatus, now: float) -> bool:
        """The drive of an earlier fleet has ended; whether at its goal, and not before."""
        robot.ended_adopted(status.bucket)
        x, y = self._layout.waypoints[robot.waypoint]
        away = abs(self._view.bot_x[robot.number] - x) + abs(self._view.bot_y[robot.number] - y)
        if away > self._tolerance_m:
            self.failed(robot, Code.CANCELLED, "stopped on its way", True, now)
            return False
        return True

    def adopt_trip(self, robot: Robot, trip: Trip, bucket: int, now: float) -> None:
        """A bot lifts, sets down or serves, and will tell how that ended."""
        self.stands(robot, bucket, now)
        robot.works()
        robot.asked(trip.trip, now)
        purpose = purpose_of(trip)
        if purpose is Purpose.FETCH:
            robot.lifts(trip.bucket)
        elif purpose is Purpose.STORE:
            robot.is_for(purpose)
        else:
            station = trip.visits[0].station
            if self._queues.places[station][0] == self._traffic.at(robot.number):
                self._queues.enter(robot, station, 0)

    # ---- what goes wrong ---------------------------------------------------------------------------------------

    def overdue(self, robot: Robot, now: float) -> None:
        """A bot has not confirmed its drive, or is idle though it has not told how what it did ended."""
        began = self._liveness.ended(robot)
        if not began:
            self._orders.stop(robot)
        why = f"bot {robot.number} does not answer"
        self.failed(robot, Code.CANCELLED if began else Code.STOPPED, why, began, now)

    def failed(self, robot: Robot, code: Code, why: str, began: bool, now: float) -> None:
        """What a bot was asked for went wrong: it is left alone until it is seen where it stands.

        One that is gone in the middle of a drive still gets to its end: the path is with the world.

        Args:
            robot: The bot.
            code: What went wrong.
            why: The same for people.
            began: Whether it had said that it began.
            now: Simulated time (s).
        """
        gone, drove = code in GONE, robot.activity is Activity.DRIVES
        if drove and (code in NEVER_LEFT or not began):
            self._traffic.undo(robot.number, now)
            self._stop_others(robot, now)
            robot.stops_here(now)
        elif not gone:
            if drove and robot.number not in self.halted:
                # it has stopped near where it was then: nobody must be sent there
                self._traffic.halt(robot.number, self._liveness.idle_since(robot.number, now), 0.0)
                self._stop_others(robot, now)
            robot.stops_here(now)
        if gone:
            self._liveness.forget_idle(robot)
        self._queues.unbind(robot)
        struck = code in (Code.COLLIDED, Code.PENALISED)
        robot.failed(why, now + (self._penalty_s if struck else RETRY_S))
        self._liveness.lose(robot, now)
        if drove and not gone:
            robot.not_seen_before(robot.failed_at + self._brakes_s)
        self.note_closed()

    def struck(self, robot: Robot, now: float) -> None:
        """A collision has stopped a bot on its way for which nobody answers: it will not get to its end."""
        if robot.activity is Activity.DRIVES:
            self.failed(robot, Code.STOPPED, f"nobody answers for bot {robot.number}, which has collided", True, now)
        self.stands_in_the_way(robot, now)

    def does_not_stop(self, robot: Robot, now: float) -> None:
        """A bot that was told to stop has not said that it did: its mind hears nothing, and its body drives on."""
        if robot.activity is not Activity.DRIVES or robot.number not in self.halted:
            return
        self.halted.discard(robot.number)
        leg = self._legs[robot.number]
        self._traffic.adopt(robot.number, leg.points, leg.stamps)
        # as if an earlier fleet had asked it: what it tells next is where it stands
        robot.drives_for_nobody()
        self._stop_others(robot, now)

    def ask_silent(self, now: float) -> None:
        """Ask lost bots what they do: what they were asked for may never have come to them."""
        if now >= self._asks_at:
            self._asks_at = now + ASK_S
            self._orders.ask(sorted(self._liveness.silent))

    def _stop_others(self, robot: Robot, now: float) -> None:
        """Stop the bots that are to pass where a bot stands for good, and those that are to pass where they stop."""
        stopped = [robot]
        while stopped:
            for number in self._traffic.conflicts(stopped.pop().number, now):
                other = self._state.robots[number]
                if other.activity is Activity.DRIVES and number not in self.halted and not other.adopted:
                    self.halted.add(number)
                    self._orders.stop(other)
                    answered = self._liveness.told_to_stop(other, now)
                    self._traffic.halt(number, now, answered - now)  # until then it may drive on
                    stopped.append(other)
