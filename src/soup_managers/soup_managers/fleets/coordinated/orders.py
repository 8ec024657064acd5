"""What the fleet asks of its bots: each order has a number, and all of them are said once the fleet has decided."""

from __future__ import annotations

from collections.abc import Iterable

from soup_managers.state.robots import Robot
from soup_managers.traffic import Leg
from soup_msgs_py.messages import CancelDrive, DriveGoal, Point, Trip, TripGoal, Visit
from soup_msgs_py.mind import Message

NO_DRIVE = 0  # number of no drive: who is asked to end that one says what it does


class Orders:
    """Orders of one decision; numbers grow, also over a restart of the fleet."""

    def __init__(self) -> None:
        """Nothing was asked for yet."""
        self._number = 0
        self._said: list[Message] = []

    def heard(self, number: int) -> None:
        """A bot is on an order with this number."""
        self._number = max(self._number, number)

    def drive(self, robot: Robot, leg: Leg, now: float) -> None:
        """Ask a bot for a drive on reserved ways."""
        self._count(robot, now)
        self._said.append(DriveGoal(robot.number, robot.order, leg.points, leg.stamps, robot.bucket))

    def operate(
        self, robot: Robot, bucket: int, now: float, visits: tuple[Visit, ...] = (), store: tuple[Point, ...] = ()
    ) -> None:
        """Ask a bot to lift a bucket, to serve with it or to set it down, where it stands."""
        self._count(robot, now)
        self._said.append(TripGoal(robot.number, Trip(robot.order, bucket, (), visits, store)))

    def stop(self, robot: Robot) -> None:
        """Ask a bot to stop on its way."""
        self._said.append(CancelDrive(robot.number, robot.order))

    def ask(self, bots: Iterable[int]) -> None:
        """Ask bots what they do."""
        self._said += [CancelDrive(bot, NO_DRIVE) for bot in bots]

    def take(self) -> list[Message]:
        """What is to be said now."""
        said, self._said = self._said, []
        return said

    def _count(self, robot: Robot, now: float) -> None:
        self._number += 1
        robot.asked(self._number, now)
