"""Managers that stand by and take over, and how others notice: over DDS liveliness."""

from __future__ import annotations

import secrets
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from soup_msgs import msg
from std_srvs.srv import Trigger

from soup_msgs_py import topics
from soup_msgs_py.live.process import Live
from soup_msgs_py.live.report import Report
from soup_msgs_py.live.services import Answer, serve
from soup_msgs_py.messages import Charge
from soup_msgs_py.qos import ALIVE
from soup_msgs_py.succession import Standing, Succession
from soup_msgs_py.wire import to_ros

LOOK_S = 0.1
ASK_AGAIN_S = 2.0
DOUBTED_S = 2.0  # wall time after which a count of who is alive is doubted where it is not that of who is there
COUNTED_S = 2.5  # wall time in which all who are alive say so, on a busy machine, too
RANK_BITS = 62


class ChargeWatch:
    """Follows who is in charge of a role.

    DDS counts who is alive, one up and one down at a time. Where a publisher leaves at the moment at which it is late,
    or speaks again, Fast DDS may miss one of them (`StatefulReader::matched_writer_remove` forgets the writer before
    its liveliness), and counts wrong from then on: nobody would be in charge, or somebody for ever. So where fewer or
    more are alive than are there, another subscription counts anew.
    """

    def __init__(self, live: Live, node: Node, manager: str, heard: Callable[[Charge], None] | None = None) -> None:
        """Begin to follow.

        Args:
            live: The process.
            node: The node that subscribes.
            manager: Name of the manager's node.
            heard: Is told every claim.
        """
        self._live, self._node, self._heard = live, node, heard
        self._topic = topics.of_manager(manager, topics.CHARGE)
        self._claims: set[tuple[int, int]] = set()  # rank and term of all that were heard
        self._before = 0  # how many were alive, while they are counted anew
        self._counted_at = 0.0  # when the new count will be there (wall time)
        self._known = self._confirmed = _Counts()
        self._since = 0.0  # since when the count is as it is (wall time)
        self._subscribe()
        live.every(LOOK_S, self._look)

    @property
    def alive(self) -> int:
        """How many are in charge, or claim to be."""
        return max(self._counts.alive, self._before)

    @property
    def claim(self) -> int:
        """Another number for everybody who is in charge, in the order in which they were heard; 0 for nobody.

        Terms will not do: they begin anew where somebody takes over who has heard of nobody before.
        """
        return len(self._claims) if self.alive else 0

    def _subscribe(self) -> None:
        counts = self._counts = _Counts()

        def on_liveliness(info: Any) -> None:
            counts.alive = info.alive_count

        def on_matched(info: Any) -> None:
            counts.there = info.current_count

        guard = self._live.guard
        events = SubscriptionEventCallbacks(liveliness=guard(on_liveliness), matched=guard(on_matched))
        self._subscription = self._live.follow(
            self._node, msg.Charge, self._topic, self._on_charge, ALIVE, event_callbacks=events
        )

    def _look(self) -> None:
        """Count anew where the count may be wrong; what then is counted once more is taken for true."""
        wall, counts = time.monotonic(), replace(self._counts)
        if wall < self._counted_at:
            return
        if self._counted_at:
            self._counted_at, self._before, self._confirmed = 0.0, 0, counts
        if counts != self._known:
            self._known, self._since = counts, wall
        sure = counts.alive == counts.there or counts == self._confirmed
        if not sure and wall - self._since >= DOUBTED_S:
            self._counted_at, self._before = wall + COUNTED_S, self.alive
            self._node.destroy_subscription(self._subscription)
            self._subscribe()

    def _on_charge(self, charge: Charge) -> None:
        self._claims.add((charge.rank, charge.term))
        if self._heard is not None:
            self._heard(charge)


@dataclass
class _Counts:
    alive: int = 0
    there: int = 0


class InCharge:
    """A manager's place among those of its role."""

    def __init__(
        self,
        live: Live,
        node: Node,
        report: Report,
        policy: str,
        *,
        take_over: bool,
        begin: Callable[[], None] = lambda: None,
    ) -> None:
        """Look around.

        Args:
            live: The process.
            node: Node of the manager.
            report: What it says of itself, under another name while it stands by.
            policy: What it follows.
            take_over: Whether to ask whoever is in charge to hand over.
            begin: Called once, when it is in charge.
        """
        self._live, self._node, self._report, self._begin = live, node, report, begin
        report.name = f"{live.name} (stands by)"
        self._succession = Succession(live.name, secrets.randbits(RANK_BITS), policy, time.monotonic())
        self._watch = ChargeWatch(live, node, node.get_name(), self._succession.heard)
        self._publisher: Any = None
        self._begun = False
        self._asks = node.create_client(Trigger, self._topic(topics.HAND_OVER)) if take_over else None
        self._ask_due = 0.0
        live.every(LOOK_S, self._look)

    @property
    def missing(self) -> str:
        """What the manager waits for; empty where it is in charge."""
        if self._begun:
            return ""
        other = self._succession.other
        if self._watch.alive and other is not None:
            return f"stands by for the {other.part} that follows {other.policy}"
        return "looks whether another one is in charge"

    def _topic(self, name: str) -> str:
        return topics.of_manager(self._node.get_name(), name)

    def _look(self) -> None:
        succession, wall = self._succession, time.monotonic()
        succession.alive(self._watch.alive - (self._publisher is not None))
        # to count is slow among hundreds of bots
        looks = succession.standing is Standing.LOOKS
        if succession.look(wall, alone=looks and self._node.count_publishers(topics.CLOCK) == 0):
            self._publisher = self._node.create_publisher(msg.Charge, self._topic(topics.CHARGE), ALIVE)
            self._publisher.publish(to_ros(succession.claim))
        match succession.standing:
            case Standing.IN_CHARGE if not self._begun:
                self._begun = True
                self._report.name = self._live.name
                serve(self._live, self._node, Trigger, self._topic(topics.HAND_OVER), self._on_hand_over)
                self._begin()
            case Standing.STANDS_BY if self._publisher is not None:
                self._node.destroy_publisher(self._publisher)
                self._publisher = None
            case Standing.STANDS_BY if self._asks is not None and wall >= self._ask_due:
                self._ask_due = wall + ASK_AGAIN_S
                self._asks.call_async(Trigger.Request())
            case Standing.REPLACED:
                other = succession.other
                policy = other.policy if other is not None else "unknown"
                print(f"{self._live.name}: ends, another one ({policy}) has taken over", file=sys.stderr, flush=True)
                self._live.stop()

    def _on_hand_over(self, _request: Trigger.Request, answer: Answer) -> None:
        answer.give(Trigger.Response(success=True, message=f"the {self._live.name} ends"))
        self._live.stop()
