"""Many bucketbots in one process: a node each, one crew, one set of subscriptions to what the world tells."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from rclpy.event_handler import PublisherEventCallbacks
from soup_msgs import action, msg

from soup_bots.bot_node import NOT_YET, BotNode
from soup_bots.crew import FOR_BOTS, Crew
from soup_bots.steering import KNOWN
from soup_bots.steering.base import Steering
from soup_bots.trip.bot_mind import ByHandReply
from soup_bots.warm_up import rehearse
from soup_live.actions import GoalClient
from soup_live.diagnostics import Report
from soup_live.domain import stay_on_this_machine
from soup_live.process import Live
from soup_live.qos import CHARGES, COMMANDS, DISPLAY, EVERY_ONE, LATCHED
from soup_live.world_client import WorldClient
from soup_msgs_py import mail, topics
from soup_msgs_py.codes import Code
from soup_msgs_py.command_line.arguments import written_bots
from soup_msgs_py.errors import InputError
from soup_msgs_py.messages import (
    BotReply,
    BotStatus,
    CancelDrive,
    CancelTrip,
    Charge,
    DriveFeedback,
    DriveGoal,
    DriveResult,
    FollowPath,
    Grab,
    Release,
    SetVelocities,
    SetVelocity,
    Snapshot,
    Transfer,
    TripFeedback,
    TripGoal,
    TripResult,
)
from soup_msgs_py.mind import NEVER, Message
from soup_msgs_py.policies import PolicyChoice, load_policy
from soup_msgs_py.wire import (
    MOST_ORDERS,
    Announcement,
    from_ros,
    from_stamp,
    read_cdr,
    to_outcome,
    to_ros,
    to_ros_of,
)

RIVALS_S = 3.0  # wall time after which a process that does not give up its bots counts as dead
CLOSE_S = 0.5  # wall time that the last answers of a bot's node are given
LOOK_BACK_S = 1.0  # wall time between two looks whether bots that were given up have a mind
ABSENT = 2  # looks after each other at which a bot has none: then its mind is gone for good
ANSWERS_KEPT = 1000  # more than can be on their way at once
SAME_S = 1e-6  # simulated; stamps are whole nanoseconds
ROLE_SEED = 3  # word, letter and fleet manager come before the bots


def run_bots(bots: Sequence[int], choice: PolicyChoice, seed: int) -> None:
    """Run bots until a signal comes.

    Raises:
        InputError: The policy does not exist, or the world has no such bots.
    """
    load_policy(choice, "bot", KNOWN, Steering)
    stay_on_this_machine()
    with Live(f"bots {written_bots(tuple(bots))}", starts_again=True) as live:
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
        # before all else that the fleet may see of this process: who is seen can be asked
        live.subscribe(node, msg.Order, topics.ORDERS, self._on_order, EVERY_ONE)
        self._outcomes = node.create_publisher(msg.Outcome, topics.OUTCOMES, EVERY_ONE)
        self._bots = {bot: BotNode(live, bot, self._ask) for bot in bots}
        self._charge = Charge(live.name, 0, time.time_ns(), choice.name, self._numbers)
        self._given_up: list[tuple[float, BotNode]] = []  # since when (wall s)
        live.every(CLOSE_S, self._close_given_up)
        self._absent: dict[int, int] = {}  # bots that were given up -> looks since they had a mind
        self._returning: dict[int, BotNode] = {}  # those that are about to be taken back
        live.every(LOOK_BACK_S, self._look_back)
        self._rivals: dict[int, float] = {}  # rank of a process that still has some of these bots -> heard when
        # how often a world was seen to listen to requests, now and when the crew came in step with its run: a world
        # that was killed is still seen for a while
        self._worlds_met, self._worlds_before, self._run = 0, 0, 0
        met = PublisherEventCallbacks(matched=live.guard(self._on_matched))
        self._requests = node.create_publisher(msg.BotRequest, topics.REQUESTS, EVERY_ONE, event_callbacks=met)
        self._report = Report(live, node)
        self._report.values = {"bots": written_bots(self._numbers), "policy": choice.name}
        self._buckets = b""
        self._answered: dict[tuple[int, int, float, Code], None] = {}  # the newest replies, in their order
        self._next_sense = 0.0
        self._drive_clients: dict[int, GoalClient] = {}
        self._carriers: dict[type, Callable[[Any], None]] = {
            SetVelocity: lambda m: self._bots[m.bot].set_velocity(m),
            SetVelocities: self._set_velocities,
            FollowPath: lambda m: self._bots[m.bot].follow_path(m),
            Grab: self._request,
            Release: self._request,
            Transfer: self._request,
            BotStatus: self._tell_status,
            TripFeedback: lambda m: self._bots[m.bot].tell_trip(m),
            DriveFeedback: lambda m: self._bots[m.bot].tell_drive(m),
            TripResult: self._end_trip,
            DriveResult: self._end_drive,
            ByHandReply: lambda m: self._bots[m.reply.bot].answer(m.token, m.reply),
            DriveGoal: self._ask_other,
        }
        self._client = WorldClient(
            live, node, self._report, self._make_crew, self._carry, self._missing,
            concerns=lambda event: event.type in FOR_BOTS, looks=self._next_look,
            bots=frozenset(self._numbers), take_reply=self._on_reply,
        )  # fmt: skip
        self._charges = node.create_publisher(msg.Charge, topics.BOTS_CHARGE, LATCHED)
        self._charges.publish(to_ros(self._charge))
        live.follow(node, msg.Charge, topics.BOTS_CHARGE, self._on_charge, CHARGES)
        live.follow(node, msg.BotReply, topics.REPLIES, self._on_reply, EVERY_ONE, run=lambda: self._client.run)
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
        crew = Crew(announcement.scenario, announcement.layout, tuple(sorted(self._bots)), steering, rng)
        crew.mistakes.tell = self._report.mistake
        self._next_sense = announcement.time + crew.sense_offset_s
        return crew

    def _on_charge(self, other: Charge) -> None:
        """Another process has minds of bots: of two with one bot the newer keeps it."""
        for bot in self._returning.keys() & set(other.bots):
            self._returning.pop(bot).close()
        shared = self._bots.keys() & set(other.bots)
        self._rivals.pop(other.rank, None)
        if not shared or other.rank == self._charge.rank:
            return
        if other.rank < self._charge.rank:
            self._rivals[other.rank] = time.monotonic()
            return
        crew = self._client.mind
        for bot in sorted(shared):
            if isinstance(crew, Crew) and bot in crew.minds:
                self._carry(crew.kill(bot))
            self._given_up.append((time.monotonic(), self._bots.pop(bot)))
            self._absent[bot] = 0
        self._tell_charge()

    def _tell_charge(self) -> None:
        self._charge = replace(self._charge, bots=tuple(sorted(self._bots)))
        self._charges.publish(to_ros(self._charge))
        self._client.speak_for(frozenset(self._bots))
        self._report.values["bots"] = written_bots(self._charge.bots)

    def _look_back(self) -> None:
        """Take bots back that another process had taken over, and that have no mind any more."""
        for bot in list(self._absent):
            minds = self._node.count_publishers(topics.bot_topic(bot, topics.STATUS)) - (bot in self._returning)
            self._absent[bot] = 0 if minds else self._absent[bot] + 1
            if self._absent[bot] == ABSENT and bot not in self._returning:
                self._returning[bot] = BotNode(self._live, bot, self._ask)
        if any(bot.heard for bot in self._returning.values()) and self._client.in_step:
            self._client.next_snapshot(self._take_back)

    def _take_back(self, snapshot: Snapshot) -> None:
        crew = self._client.mind
        back = [bot for bot, node in self._returning.items() if node.heard]
        if not isinstance(crew, Crew) or not self._client.in_step:
            return
        for bot in back:
            self._bots[bot] = self._returning.pop(bot)
            del self._absent[bot]
        self._tell_charge()
        self._carry(crew.come_back(back, snapshot, self._client.now))

    def _close_given_up(self) -> None:
        """Take nodes out of the graph whose last answers are on their way."""
        while self._given_up and time.monotonic() - self._given_up[0][0] > CLOSE_S:
            self._given_up.pop(0)[1].close()

    def _missing(self) -> str:
        if not self._bots:
            return "other processes have taken over all its bots"
        if any(time.monotonic() - heard < RIVALS_S for heard in self._rivals.values()):
            return "waits until another process gives up its bots"
        client = self._client
        if client.begun:
            if self._run != client.run:
                self._run, self._worlds_before = client.run, self._worlds_met
            return ""
        # the world listens on this topic last of all, to each bot before
        if self._worlds_met == self._worlds_before or self._requests.get_subscription_count() == 0:
            return f"waits for the world (nobody listens on {topics.REQUESTS})"
        if not all(bot.heard for bot in self._bots.values()):
            return "waits for the world to listen to every bot"
        return ""

    def _on_matched(self, info: Any) -> None:
        self._worlds_met = info.total_count

    def _ask(self, message: Message) -> bool:
        if isinstance(message, DriveGoal) and message.drive < MOST_ORDERS:  # perhaps of another bot
            self._client.mail.got(mail.drives(message.bot))
        takes = self._client.begun and message.bot in self._bots
        if takes:
            self._client.tell(message)
        return takes

    # ---- what the fleet asks ------------------------------------------------------------------------------

    def _on_order(self, order: msg.Order) -> None:
        asked = from_ros(order)
        if order.part == self._live.name:
            self._client.mail.got(mail.orders(order.part))
        self._take_order(order, asked)
        self._client.settle()

    def _take_order(self, order: msg.Order, asked: DriveGoal | CancelDrive | TripGoal | CancelTrip) -> None:
        if order.bot not in self._bots or order.run != self._client.run:
            return
        if isinstance(asked, DriveGoal | CancelDrive):
            asked = replace(asked, drive=asked.drive + MOST_ORDERS)  # goals of the bot's own actions are below
        if self._ask(asked):
            return
        if isinstance(asked, DriveGoal):
            self._end_drive(DriveResult(asked.bot, asked.drive, Code.BUSY, NOT_YET))
        elif isinstance(asked, TripGoal):
            self._end_trip(TripResult(asked.bot, asked.trip.trip, Code.BUSY, NOT_YET))

    def _end_drive(self, result: DriveResult) -> None:
        if result.drive < MOST_ORDERS:
            self._bots[result.bot].end_drive(result)
        else:
            ended = replace(result, drive=result.drive - MOST_ORDERS)
            self._tell_fleet(ended)

    def _end_trip(self, result: TripResult) -> None:
        self._bots[result.bot].end_trip(result)
        self._tell_fleet(result)

    def _tell_fleet(self, result: DriveResult | TripResult) -> None:
        self._client.mail.sent(mail.outcomes(self._live.name))
        self._outcomes.publish(to_outcome(result, self._client.run, self._live.name))

    # ---- what the world tells -----------------------------------------------------------------------------

    def _on_reply(self, reply: BotReply) -> None:
        """Take in what came on the topic of replies or with a beat, whichever was faster."""
        key = reply.bot, reply.request, reply.time, reply.code
        if reply.bot not in self._bots or key in self._answered:
            return
        self._answered[key] = None
        if len(self._answered) > ANSWERS_KEPT:
            del self._answered[next(iter(self._answered))]
        self._client.now = max(self._client.now, reply.time)
        self._client.tell(reply, is_asked=True)

    def _on_buckets(self, cdr: bytes) -> None:
        self._buckets = cdr

    def _next_look(self) -> float:
        crew = self._client.mind
        return self._next_sense if isinstance(crew, Crew) and crew.wants_to_sense else NEVER

    def _on_bots(self, cdr: bytes) -> None:
        crew = self._client.mind
        if not isinstance(crew, Crew) or not self._client.in_step or not crew.wants_to_sense or not self._buckets:
            return
        poses, buckets = read_cdr(cdr, msg.Bots), read_cdr(self._buckets, msg.Buckets)
        if not all(self._live.belongs(seen.run, self._client.run) for seen in (poses, buckets)):
            return
        now = from_stamp(poses.header.stamp)
        if now < self._next_sense - SAME_S:
            return
        self._next_sense = now + crew.sense_period_s
        self._client.now = max(self._client.now, now)
        self._carry(crew.sense(from_ros(poses), from_ros(buckets), self._client.now))

    # ---- what the crew says -------------------------------------------------------------------------------

    def _carry(self, messages: list[Message]) -> None:
        for message in messages:
            self._carriers[type(message)](message)

    def _tell_status(self, status: BotStatus) -> None:
        self._client.mail.sent(mail.outcomes(self._live.name))
        self._bots[status.bot].tell_status(status, self._client.run)

    def _set_velocities(self, message: SetVelocities) -> None:
        for bot, vx, vy in zip(message.bots.tolist(), message.vx.tolist(), message.vy.tolist(), strict=True):
            self._bots[bot].set_velocity(SetVelocity(bot, vx, vy))

    def _request(self, request: Grab | Release | Transfer) -> None:
        self._requests.publish(to_ros_of(self._client.run, request))

    def _ask_other(self, goal: DriveGoal) -> None:
        """Ask a bot of another process to drive; that it may not hear is part of asking."""
        client = self._drive_clients.get(goal.bot)
        if client is None:
            name = topics.bot_topic(goal.bot, topics.DRIVE)
            client = self._drive_clients[goal.bot] = GoalClient(
                self._live, self._node, action.Drive, name, profile=COMMANDS,
                sent=lambda: self._client.mail.sent(mail.drives(goal.bot)),
            )  # fmt: skip
        client.send(goal.drive, to_ros(goal), lambda _feedback: None, lambda _code, _message: None)
