"""What bots do one after the other: they are sent on a leg, arrive, operate, and wait where a step is not possible."""

from __future__ import annotations

from soup_managers.fleets.coordinated.dock_queues import DockQueues
from soup_managers.fleets.coordinated.liveness import Liveness
from soup_managers.fleets.coordinated.orders import Orders
from soup_managers.fleets.coordinated.recovery import RETRY_S, Recovery
from soup_managers.fleets.coordinated.startup_barrier import StartupBarrier
from soup_managers.state.planning_state import PlanningState
from soup_managers.state.robots import Activity, Purpose, Robot
from soup_msgs_py.messages import TileMove, Visit

AT_ONCE = 10  # bots that may try again in RETRY_S
LOOKS = 40_000  # at one instant; then ways are looked for in a hurry, and after twice as many no more


class Moves:
    """Sends bots about, and keeps those that have to decide something and those that wait.

    Attributes:
        undecided: Bots with buckets that stand and have to do something else, the first one first.
    """

    def __init__(
        self,
        state: PlanningState,
        queues: DockQueues,
        liveness: Liveness,
        recovery: Recovery,
        barrier: StartupBarrier,
        orders: Orders,
    ) -> None:
        """Begin with nobody on its way.

        Args:
            state: The bots, buckets and stations.
            queues: The lines of stations.
            liveness: Is told who was asked for something.
            recovery: Is told where bots go.
            barrier: Whether bots may be sent about yet.
            orders: What is asked of bots.
        """
        self.undecided: list[Robot] = []
        self._waiting: dict[int, Robot] = {}  # those whose next step was not possible: tried again
        self._state, self._traffic = state, state.traffic
        self._queues, self._liveness, self._recovery = queues, liveness, recovery
        self._barrier, self._orders = barrier, orders
        self._looks_at, self._looks_before = -1.0, 0  # when ways were looked for last, and how many looks before then

    def go(
        self, robot: Robot, goal: int, now: float, purpose: Purpose, *, target: int = -1, hurried: bool = False
    ) -> bool:
        """Send a bot that stands to a waypoint for a purpose; False, and nothing has changed, where no way leads now.

        Args:
            robot: The bot.
            goal: The waypoint; where it stands already, it has arrived.
            now: Simulated time (s).
            purpose: What it goes there for.
            target: The bucket that it is to fetch.
            hurried: Whether not to look for a way for long.
        """
        if self._traffic.at(robot.number) == goal:
            robot.is_for(purpose, target)
            self.arrived(robot, now)
            return True
        if not self._barrier.over:
            return False
        looks = self._looks(now)
        if looks > 2 * LOOKS:
            return False
        leg = self._traffic.plan(
            robot.number,
            goal,
            now,
            loaded=robot.bucket >= 0,
            blocked_spots=self._state.view.occupied,
            hurried=hurried or looks > LOOKS,
        )
        if leg is None:
            return False
        robot.is_for(purpose, target)
        self._waiting.pop(robot.number, None)
        self._recovery.departs(robot, goal, leg)
        self._liveness.asked(robot, now, leg.depart)
        self._orders.drive(robot, leg, now)
        return True

    def arrived(self, robot: Robot, now: float) -> None:
        """A bot stands where it was to go: it operates there, or something is to be decided."""
        robot.arrived()
        match robot.purpose:
            case Purpose.FETCH:
                self._operate(robot, robot.target, now)
            case Purpose.STORE:
                x, y = self._state.layout.waypoints[robot.waypoint]
                self._operate(robot, robot.bucket, now, store=((float(x), float(y)),))
            case Purpose.SERVE if robot.slot == 0:
                self.undecided.append(robot)
            case Purpose.SERVE:
                self._queues.moved.add(robot.station)
            case _:
                robot.has_nothing_to_do()

    def serve(self, robot: Robot, station: int, tiles: tuple[TileMove, ...], now: float) -> None:
        """A bot at a dock moves tiles between its bucket and the station."""
        robot.unblocked()
        self._operate(robot, robot.bucket, now, visits=(Visit(station, tiles, ()),))

    def _operate(
        self,
        robot: Robot,
        bucket: int,
        now: float,
        visits: tuple[Visit, ...] = (),
        store: tuple[tuple[float, float], ...] = (),
    ) -> None:
        robot.works()
        self._orders.operate(robot, bucket, now, visits, store)

    def worked(self, robot: Robot) -> None:
        """A bot has lifted, set down or served."""
        robot.arrived()
        if robot.purpose is Purpose.FETCH:
            robot.lifted()
        elif robot.purpose is Purpose.STORE:
            robot.set_down()
            return
        if robot.purpose is Purpose.SERVE and robot.slot != 0:
            self._queues.moved.add(robot.station)
        else:
            self.undecided.append(robot)

    # ---- what is not possible yet --------------------------------------------------------------------------

    def later(self, robot: Robot, now: float, why: str) -> None:
        """Try again later what a bot is to do."""
        # where many wait, after a restart for instance, nearly all would try in vain again and again
        many = len(self._waiting) / AT_ONCE if self._barrier.over else 1.0
        robot.waits(why, now + RETRY_S * max(1.0, many))
        self._waiting[robot.number] = robot

    def due(self, now: float) -> list[Robot]:
        """Bots that are to try again now."""
        return [robot for robot in self._waiting.values() if robot.retry_at <= now]

    def stop_waiting(self, robot: Robot) -> None:
        """A bot tries again, or has something else to do."""
        self._waiting.pop(robot.number, None)

    def all_may_retry(self, now: float) -> None:
        """What was not possible may be tried at once."""
        for robot in self._waiting.values():
            robot.may_retry(now)

    def resume(self, robot: Robot) -> None:
        """A bot that waited has something to decide."""
        if robot.activity is not Activity.STANDS:
            return
        if robot.purpose is Purpose.SERVE and robot.slot != 0:
            self._queues.moved.add(robot.station)
        elif robot.bucket >= 0:
            self.undecided.append(robot)

    def _looks(self, now: float) -> int:
        """How much has been looked for ways at this instant.

        Where many stand in each other's way, after a stop of all for instance, each way takes long to find. The world
        waits for the fleet meanwhile, and would give it up.
        """
        if self._looks_at != now:
            self._looks_at, self._looks_before = now, self._traffic.looked
        return self._traffic.looked - self._looks_before
