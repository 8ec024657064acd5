"""Leader election: managers that stand by and take over, and how others notice; the rules are in `election_rules`."""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from soup_msgs import msg
from std_srvs.srv import Trigger

from soup_live.diagnostics import Report
from soup_live.election_rules import Election, Standing
from soup_live.process import HandsOver, Live
from soup_live.qos import CLAIMS, LATCHED
from soup_live.services import Answer, serve
from soup_msgs_py import topics
from soup_msgs_py.messages import Charge
from soup_msgs_py.wire import to_ros

LOOK_S = 0.1
ASK_AGAIN_S = 2.0
SAY_AGAIN_S = 0.5  # wall time between two claims of who is in charge
SILENT_S = 3.0  # wall time after which who is silent is gone; the world goes on without managers after some more
BUSY_S = 1.0  # wall time; a process that has not looked for so long was stopped or busy
FORGOTTEN_S = 30.0  # wall time after which a claim that was heard is forgotten
RANK_BITS = 62


class ChargeWatch:
    """Follows who is in charge of a role.

    Whoever is in charge says so again and again, and is taken for gone when its publisher is, or when it is silent.
    DDS liveliness would tell as much, but Fast DDS 2.14 loses count of who is alive where a publisher leaves while it
    is late (`StatefulReader::matched_writer_remove`), and to take its events may block the process for good
    (`RMWSubscriptionEvent::take_event` and the thread that reports another one wait for each other).
    """

    def __init__(self, live: Live, node: Node, manager: str, heard: Callable[[Charge], None] | None = None) -> None:
        """Begin to follow.

        Args:
            live: The process.
            node: The node that subscribes.
            manager: Name of the manager's node.
            heard: Is told every claim, again and again while whoever made it is in charge.
        """
        self._heard = heard
        self._claims = 0
        self._spoke: dict[tuple[int, int], float] = {}  # claims (rank, term), and when they were heard last (wall time)
        self._looked = time.monotonic()
        topic = topics.of_manager(manager, topics.CHARGE)
        self._subscription = live.follow(node, msg.Charge, topic, self._on_charge, CLAIMS)

    @property
    def claim(self) -> int:
        """Another number for everybody who is in charge, in the order in which they were heard; 0 for nobody.

        Terms will not do: they begin anew where somebody takes over who has heard of nobody before.
        """
        return self._claims if self.alive() else 0

    @property
    def newest(self) -> int:
        """The same of whoever was heard last, though silent now: for who is patient with one that is busy."""
        return self._claims

    def alive(self, own: int | None = None, *, speaks: bool = False) -> int:
        """How many are in charge, or claim to be.

        Args:
            own: A rank that does not count.
            speaks: Whether the one with that rank claims to be in charge just now.
        """
        wall = time.monotonic()
        missed, self._looked = wall - self._looked, wall
        if missed > BUSY_S:  # who does not listen hears nobody
            self._spoke = {key: min(wall, spoke + missed) for key, spoke in self._spoke.items()}
        heard = {rank for (rank, _), spoke in self._spoke.items() if rank != own and wall - spoke <= SILENT_S}
        return min(len(heard), self._subscription.get_publisher_count() - speaks)

    def _on_charge(self, charge: Charge) -> None:
        key, wall = (charge.rank, charge.term), time.monotonic()
        if self._spoke.pop(key, None) is None:
            self._claims += 1
        self._spoke[key] = wall  # the last one
        while wall - self._spoke[first := next(iter(self._spoke))] > FORGOTTEN_S:
            del self._spoke[first]
        if self._heard is not None:
            self._heard(charge)


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
        self._policy = policy
        report.name = f"{live.name} (stands by)"
        self._election = Election(live.name, secrets.randbits(RANK_BITS), policy, time.monotonic())
        self._watch = ChargeWatch(live, node, node.get_name(), self._election.heard)
        self._publisher: Any = None
        self._say_due = 0.0
        self._begun = False
        self._asks = node.create_client(Trigger, self._topic(topics.HAND_OVER)) if take_over else None
        self._ask_due = 0.0
        live.every(LOOK_S, self._look)

    @property
    def missing(self) -> str:
        """What the manager waits for; empty where it is in charge."""
        if self._begun:
            return ""
        other = self._election.other
        if self._watch.alive() and other is not None:
            return f"stands by for the {other.part} that follows {called(other.policy)}"
        return "looks whether another one is in charge"

    def _topic(self, name: str) -> str:
        return topics.of_manager(self._node.get_name(), name)

    def _look(self) -> None:
        election, wall = self._election, time.monotonic()
        election.alive(self._watch.alive(election.claim.rank, speaks=self._publisher is not None))
        if election.look(wall, alone=election.standing is Standing.LOOKS and self._has_met_nobody()):
            self._publisher = self._node.create_publisher(msg.Charge, self._topic(topics.CHARGE), LATCHED)
            self._say_due = wall
        if self._publisher is not None and wall >= self._say_due:
            self._say_due = wall + SAY_AGAIN_S
            self._publisher.publish(to_ros(election.claim))
        match election.standing:
            case Standing.IN_CHARGE if not self._begun:
                self._begun = True
                self._report.name = self._live.name
                hands_back = self._asks is not None and election.other is not None
                back = "; Ctrl-C hands back" if hands_back else ""
                print(f"{self._live.name}: in charge ({called(self._policy)}){back}", flush=True)
                serve(self._live, self._node, Trigger, self._topic(topics.HAND_OVER), self._on_hand_over)
                self._begin()
            case Standing.STANDS_BY if self._publisher is not None:
                self._node.destroy_publisher(self._publisher)
                self._publisher = None
            case Standing.STANDS_BY if self._asks is not None and wall >= self._ask_due:
                self._ask_due = wall + ASK_AGAIN_S
                self._asks.call_async(Trigger.Request())
            case Standing.REPLACED:
                self._hand_over()

    def _has_met_nobody(self) -> bool:
        """Whether nobody was found yet whom a busy machine may keep from being found soon."""
        if self._asks is not None and self._election.other is None:
            return True  # it was started because somebody is in charge
        return self._node.count_publishers(topics.CLOCK) == 0  # slow among hundreds of bots

    def _on_hand_over(self, _request: Trigger.Request, answer: Answer) -> None:
        answer.give(Trigger.Response(success=True, message=f"the {self._live.name} stands by"))
        self._hand_over()

    def _hand_over(self) -> None:
        """End, to begin anew among those who stand by: the plans are somebody else's now."""
        self._live.stop(HandsOver(f"{self._live.name}: another one takes over, this one stands by"))


def called(policy: str) -> str:
    """A policy as a person calls it: its name, or that of its class."""
    return policy.rpartition(":")[2]
