"""Many bucketbots in one process: a node each, one crew, one set of subscriptions to what the world tells."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from rclpy.serialization import deserialize_message
from soup_msgs import action, msg

from soup_bots.bot_mind import ByHandReply
from soup_bots.bot_node import BotNode
from soup_bots.crew import FOR_BOTS, Crew
from soup_bots.rehearsal import rehearse
from soup_bots.steering import KNOWN
from soup_bots.steering.base import Steering
from soup_msgs_py import topics
from soup_msgs_py.arguments import written_bots
from soup_msgs_py.errors import InputError
from soup_msgs_py.live.actions import GoalClient
from soup_msgs_py.live.domain import stay_on_this_machine
from soup_msgs_py.live.follower import Follower
from soup_msgs_py.live.process import Live
from soup_msgs_py.live.report import Report
from soup_msgs_py.messages import (
    BotReply,
    BotStatus,
    DriveGoal,
    DriveResult,
    FollowPath,
    Grab,
    Release,
    SetVelocities,
    SetVelocity,
    Transfer,
    TripFeedback,
    TripResult,
)
from soup_msgs_py.mind import NEVER, Message
from soup_msgs_py.policies import PolicyChoice, load_policy
from soup_msgs_py.qos import DISPLAY, EVERY_ONE
from soup_msgs_py.wire import Announcement, from_ros, from_stamp, to_ros

SAME_S = 1e-6  # simulated; stamps are whole nanoseconds
ROLE_SEED = 3  # word, letter and fleet manager come before the bots


def run_bots(bots: Sequence[int], choice: PolicyChoice, seed: int) -> None:
    """Run bots until a signal comes.

    Raises:
        InputError: The policy does not exist, or the world has no such bots.
    """
    load_policy(choice, "bot", KNOWN, Steering)
    stay_on_this_machine()
    with Live(f"bots {written_bots(tuple(bots))}") as live:
        BotHost(live, bots, choice, seed)
        live.spin()


class BotHost:
    """The bots of one process."""

    def __init__(self, live: Live, bots: Sequence[int], choice: PolicyChoice, seed: int) -> None:
        """Make their nodes; their minds are made when the world has told its scenario.

        Args:
            live: The process.
            bots: Their numbers.
            choice: How they avoid each other.
            seed: Seed of the random numbers for that.
        """
        self._live, self._numbers, self._choice, self._seed = live, tuple(bots), choice, seed
        self._node = node = live.node(f"bots_{bots[0]}")
        self._bots = {bot: BotNode(live, bot, self._ask) for bot in bots}
        self._requests = node.create_publisher(msg.BotRequest, topics.REQUESTS, EVERY_ONE)
        self._report = Report(live, node)
        self._report.values = {"bots": written_bots(self._numbers), "policy": choice.name}
        self._buckets = b""
        self._next_sense = 0.0
        self._drive_clients: dict[int, GoalClient] = {}
        self._carriers: dict[type, Callable[[Any], None]] = {
            SetVelocity: lambda m: self._bots[m.bot].set_velocity(m),
            SetVelocities: self._set_velocities,
            FollowPath: lambda m: self._bots[m.bot].follow_path(m),
            Grab: self._request,
            Release: self._request,
            Transfer: self._request,
            BotStatus: lambda m: self._bots[m.bot].tell_status(m),
            TripFeedback: lambda m: self._bots[m.bot].tell_trip(m),
            TripResult: lambda m: self._bots[m.bot].end_trip(m),
            DriveResult: lambda m: self._bots[m.bot].end_drive(m),
            ByHandReply: lambda m: self._bots[m.reply.bot].answer(m.token, m.reply),
            DriveGoal: self._ask_other,
        }
        self._follower = Follower(
            live, node, self._report, self._make_crew, self._carry, self._missing,
            concerns=lambda event: event.type in FOR_BOTS, looks=self._next_look,
        )  # fmt: skip
        live.follow(node, msg.BotReply, topics.REPLIES, self._on_reply, EVERY_ONE)
        live.subscribe(node, msg.Buckets, topics.SENSED_BUCKETS, self._on_buckets, DISPLAY, raw=True)
        live.subscribe(node, msg.Bots, topics.SENSED_BOTS, self._on_bots, DISPLAY, raw=True)

    def _make_crew(self, announcement: Announcement) -> Crew:
        last, count = max(self._numbers), announcement.scenario.bots
        if last >= count:
            raise InputError("bots", "", f"bot {last}", f"0 to {count - 1}, which the world has")
        children = np.random.SeedSequence([self._seed, 1]).spawn(ROLE_SEED + 1)[ROLE_SEED].spawn(last + 1)
        rng = np.random.Generator(np.random.PCG64(children[last]))
        steering, another = (load_policy(self._choice, "bot", KNOWN, Steering) for _ in range(2))
        rehearse(announcement.scenario, announcement.layout, another, np.random.default_rng(self._seed))
        crew = Crew(announcement.scenario, announcement.layout, self._numbers, steering, rng)
        self._next_sense = announcement.time + crew.sense_offset_s
        return crew

    def _missing(self) -> str:
        if self._requests.get_subscription_count() == 0:
            return f"waits for the world (nobody listens on {topics.REQUESTS})"
        if not self._follower.begun and not all(bot.heard for bot in self._bots.values()):
            return "waits for the world to listen to every bot"
        return ""

    def _ask(self, message: Message) -> bool:
        if self._follower.begun:
            self._follower.tell(message)
        return self._follower.begun

    # ---- what the world tells -----------------------------------------------------------------------------

    def _on_reply(self, reply: BotReply) -> None:
        if reply.bot in self._bots:
            self._follower.now = max(self._follower.now, reply.time)
            self._follower.tell(reply)

    def _on_buckets(self, cdr: bytes) -> None:
        self._buckets = cdr

    def _next_look(self) -> float:
        crew = self._follower.mind
        return self._next_sense if isinstance(crew, Crew) and crew.wants_to_sense else NEVER

    def _on_bots(self, cdr: bytes) -> None:
        crew = self._follower.mind
        if not isinstance(crew, Crew) or not self._follower.in_step or not crew.wants_to_sense or not self._buckets:
            return
        poses = deserialize_message(cdr, msg.Bots)
        now = from_stamp(poses.header.stamp)
        if now < self._next_sense - SAME_S:
            return
        self._next_sense = now + crew.sense_period_s
        self._follower.now = max(self._follower.now, now)
        buckets = from_ros(deserialize_message(self._buckets, msg.Buckets))
        self._carry(crew.sense(from_ros(poses), buckets, self._follower.now))

    # ---- what the crew says -------------------------------------------------------------------------------

    def _carry(self, messages: list[Message]) -> None:
        for message in messages:
            self._carriers[type(message)](message)

    def _set_velocities(self, message: SetVelocities) -> None:
        for bot, vx, vy in zip(message.bots.tolist(), message.vx.tolist(), message.vy.tolist(), strict=True):
            self._bots[bot].set_velocity(SetVelocity(bot, vx, vy))

    def _request(self, request: Grab | Release | Transfer) -> None:
        self._requests.publish(to_ros(request))

    def _ask_other(self, goal: DriveGoal) -> None:
        """Ask a bot of another process to drive; that it may not hear is part of asking."""
        client = self._drive_clients.get(goal.bot)
        if client is None:
            name = topics.bot_topic(goal.bot, topics.DRIVE)
            client = self._drive_clients[goal.bot] = GoalClient(self._live, self._node, action.Drive, name)
        client.send(goal.drive, to_ros(goal), lambda _feedback: None, lambda _code, _message: None)
