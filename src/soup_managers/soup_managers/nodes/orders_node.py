"""What the fleet asks of bots, on one topic to all of them, and how it ends, on another.

Bots serve actions, too, for people and their programs. A client of two actions for each of hundreds of bots would keep
a new fleet manager from its work for a quarter of a minute: DDS makes thousands of endpoints known to everybody.
"""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node
from soup_msgs import msg

from soup_live.process import Live
from soup_live.qos import EVERY_ONE
from soup_msgs_py import mail, topics
from soup_msgs_py.codes import Code
from soup_msgs_py.mail import Mail
from soup_msgs_py.messages import CancelDrive, CancelTrip, DriveGoal, DriveResult, TripGoal, TripResult
from soup_msgs_py.wire import from_ros, to_order

Result = DriveResult | TripResult
GONE = "who was asked is gone"


class Orders:
    """Orders that are under way."""

    def __init__(
        self,
        live: Live,
        node: Node,
        run: Callable[[], int],
        ended: Callable[[Result], None],
        host: Callable[[int], str],
        post: Callable[[], Mail],
    ) -> None:
        """Nothing is asked yet.

        Args:
            live: The process.
            node: The node that asks.
            run: Tells which run of the world it follows.
            ended: Is told how what it asked for ended.
            host: The process that has a bot's mind; empty where nobody has said so.
            post: Where what is sent and heard is counted.
        """
        self._node, self._run, self._ended, self._host, self._post = node, run, ended, host, post
        self._publisher = node.create_publisher(msg.Order, topics.ORDERS, EVERY_ONE)
        self._signs: dict[int, Callable[[], int]] = {}
        self._asked: dict[int, dict[tuple[type[Result], int], Result]] = {}  # by bot: what will be told if it is gone
        live.subscribe(node, msg.Outcome, topics.OUTCOMES, self._on_outcome, EVERY_ONE)

    def follow(self, bot: int, signs: Callable[[], int]) -> None:
        """There is a bot; `signs` tells how many nodes of it are seen that are alive."""
        self._signs[bot] = signs

    @property
    def heard(self) -> bool:
        """Whether all processes with bots hear what is asked: they begin to listen before they speak."""
        listeners = self._publisher.get_subscription_count()
        return listeners > 0 and listeners >= self._node.count_publishers(topics.OUTCOMES)

    def is_there(self, bot: int) -> bool:
        """Whether a bot's node is seen."""
        return self._signs[bot]() > 0

    def ask(self, goal: DriveGoal | TripGoal) -> None:
        """Ask a bot for something; how it ends is told once."""
        if isinstance(goal, DriveGoal):
            gone: Result = DriveResult(goal.bot, goal.drive, Code.STOPPED, GONE)
            number = goal.drive
        else:
            gone = TripResult(goal.bot, goal.trip.trip, Code.STOPPED, GONE)
            number = goal.trip.trip
        self._asked.setdefault(goal.bot, {})[type(gone), number] = gone
        self._send(goal)

    def cancel(self, cancel: CancelDrive | CancelTrip) -> None:
        """Ask a bot to end something early."""
        self._send(cancel)

    def _send(self, order: DriveGoal | TripGoal | CancelDrive | CancelTrip) -> None:
        host = self._host(order.bot)
        if host:
            self._post().sent(mail.orders(host))
        self._publisher.publish(to_order(order, self._run(), host))

    def look(self) -> None:
        """End what was asked of bots that are gone."""
        for bot in [bot for bot, asked in self._asked.items() if asked and not self.is_there(bot)]:
            for gone in self._asked.pop(bot).values():
                self._ended(gone)

    def clear(self) -> None:
        """Another world has begun."""
        self._asked.clear()

    def _on_outcome(self, outcome: msg.Outcome) -> None:
        result: Result = from_ros(outcome)
        if outcome.run != self._run():
            return
        self._post().got(mail.outcomes(outcome.part))
        number = result.drive if isinstance(result, DriveResult) else result.trip
        self._asked.get(result.bot, {}).pop((type(result), number), None)
        self._ended(result)
