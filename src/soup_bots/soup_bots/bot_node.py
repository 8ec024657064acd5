"""One bucketbot's own node: its services, actions and topics, carried to and from its mind in the crew."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import Twist
from nav_msgs.msg import Path as RosPath
from rclpy.action.server import ServerGoalHandle
from soup_msgs import action, msg, srv

from soup_live.actions import GoalServer
from soup_live.process import Live
from soup_live.qos import COMMANDS, LATCHED
from soup_live.services import Answer, serve
from soup_msgs_py import topics
from soup_msgs_py.codes import Code
from soup_msgs_py.messages import (
    BotReply,
    BotStatus,
    CancelDrive,
    CancelTrip,
    DriveFeedback,
    DriveResult,
    FollowPath,
    Release,
    SetVelocity,
    TripFeedback,
    TripResult,
)
from soup_msgs_py.mind import Message
from soup_msgs_py.wire import (
    drive_goal,
    fill_result,
    from_ros,
    grab_by_hand,
    to_path,
    to_ros,
    to_twist,
    transfer_by_hand,
    trip_goal,
)

NOT_YET = "the bot waits for the world"


class BotNode:
    """Node `bot_7` in namespace `/bot_7`.

    Attributes:
        bot: Number of the bot.
    """

    def __init__(self, live: Live, bot: int, ask: Callable[[Message], bool]) -> None:
        """Make the node.

        Args:
            live: The process.
            bot: Number of the bot.
            ask: Hands a request to the mind; False while it cannot take any.
        """
        self.bot = bot
        self._live, self._ask = live, ask
        self._node = node = live.node(topics.bot_node(bot), f"/{topics.bot_node(bot)}")
        self._cmd_vel = node.create_publisher(Twist, topics.CMD_VEL, COMMANDS)
        self._path = node.create_publisher(RosPath, topics.PATH, COMMANDS)
        self._status = node.create_publisher(msg.BotStatus, topics.STATUS, LATCHED)
        self._answers: dict[int, tuple[type, Answer]] = {}
        self._tokens = 0
        self._statuses = 0  # told so far
        serve(live, node, srv.Grab, topics.GRAB, self._on_grab, COMMANDS)
        serve(live, node, srv.Release, topics.RELEASE, self._on_release, COMMANDS)
        serve(live, node, srv.Transfer, topics.TRANSFER, self._on_transfer, COMMANDS)
        self._trips: dict[int, list[ServerGoalHandle]] = {}
        self._trip_server = GoalServer(
            live, node, action.CarryTrip, topics.TRIP,
            accept=self._on_trip, cancel=self._cancel_trip, check=lambda goal: from_ros(goal.trip),
            profile=COMMANDS,
        )  # fmt: skip
        self._drives: dict[int, ServerGoalHandle] = {}
        self._drive_server = GoalServer(
            live, node, action.Drive, topics.DRIVE,
            accept=self._on_drive, cancel=self._cancel_drive, check=lambda goal: drive_goal(goal, bot, 0),
            profile=COMMANDS,
        )  # fmt: skip

    @property
    def heard(self) -> bool:
        """Whether the world listens to this bot's velocities and paths."""
        return self._cmd_vel.get_subscription_count() > 0 and self._path.get_subscription_count() > 0

    # ---- what the mind says -------------------------------------------------------------------------------

    def set_velocity(self, velocity: SetVelocity) -> None:
        """Publish a target velocity."""
        self._cmd_vel.publish(to_twist(velocity))

    def follow_path(self, path: FollowPath) -> None:
        """Publish a path."""
        self._path.publish(to_path(path))

    def tell_status(self, status: BotStatus, run: int) -> None:
        """Publish what the bot is doing, in a run of the world."""
        message = to_ros(status)
        self._statuses += 1
        message.run, message.part, message.number = run, self._live.name, self._statuses
        self._status.publish(message)

    def answer(self, token: int, reply: BotReply) -> None:
        """Answer a request that was made by hand."""
        kind, answer = self._answers.pop(token, (None, None))
        if kind is not None and answer is not None:
            answer.give(fill_result(kind.Response(), reply.code, reply.message))

    def close(self) -> None:
        """Take the node out of the graph: another process has this bot's mind now."""
        for kind, answer in self._answers.values():
            answer.give(fill_result(kind.Response(), Code.STOPPED, "another process has taken over this bot"))
        self._live.leave(self._node)

    def tell_trip(self, feedback: TripFeedback) -> None:
        """Publish how far a trip has come."""
        for handle in self._trips.get(feedback.trip, ()):
            handle.publish_feedback(to_ros(feedback))

    def end_trip(self, result: TripResult) -> None:
        """End a trip's goal."""
        for handle in self._trips.pop(result.trip, ()):
            self._trip_server.finish(handle, result.code, result.message)

    def tell_drive(self, feedback: DriveFeedback) -> None:
        """Publish how far a drive has come, where it was asked for by a goal."""
        handle = self._drives.get(feedback.drive)
        if handle is not None:
            handle.publish_feedback(to_ros(feedback))

    def end_drive(self, result: DriveResult) -> None:
        """End a drive's goal."""
        handle = self._drives.pop(result.drive, None)
        if handle is not None:
            self._drive_server.finish(handle, result.code, result.message)

    # ---- what others ask ----------------------------------------------------------------------------------

    def _on_grab(self, request: srv.Grab.Request, answer: Answer) -> None:
        self._by_hand(srv.Grab, answer, lambda token: grab_by_hand(request, self.bot, token))

    def _on_release(self, request: srv.Release.Request, answer: Answer) -> None:
        self._by_hand(srv.Release, answer, lambda token: Release(self.bot, token))

    def _on_transfer(self, request: srv.Transfer.Request, answer: Answer) -> None:
        self._by_hand(srv.Transfer, answer, lambda token: transfer_by_hand(request, self.bot, token))

    def _by_hand(self, kind: Any, answer: Answer, read: Callable[[int], Message]) -> None:
        request = read(self._tokens)
        self._answers[self._tokens] = kind, answer
        self._tokens += 1
        if not self._ask(request):
            del self._answers[request.request]
            answer.give(fill_result(kind.Response(), Code.BUSY, NOT_YET))

    def _on_trip(self, handle: ServerGoalHandle) -> None:
        goal = trip_goal(handle.request, self.bot)
        self._trips.setdefault(goal.trip.trip, []).append(handle)
        if not self._ask(goal):
            self.end_trip(TripResult(self.bot, goal.trip.trip, Code.BUSY, NOT_YET))

    def _cancel_trip(self, handle: ServerGoalHandle) -> None:
        self._ask(CancelTrip(self.bot, handle.request.trip.trip))

    def _on_drive(self, handle: ServerGoalHandle) -> None:
        number = self._tokens
        self._tokens += 1
        self._drives[number] = handle
        if not self._ask(drive_goal(handle.request, self.bot, number)):
            self.end_drive(DriveResult(self.bot, number, Code.BUSY, NOT_YET))

    def _cancel_drive(self, handle: ServerGoalHandle) -> None:
        for number, other in self._drives.items():
            if other is handle:
                self._ask(CancelDrive(self.bot, number))
                return
