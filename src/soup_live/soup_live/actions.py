"""Actions without a thread a goal: servers whose goals end when a mind says so, patient clients."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node
from rclpy.qos import LivelinessPolicy, QoSProfile

from soup_live.process import Live
from soup_live.qos import EVERY_ONE
from soup_msgs_py.codes import Code
from soup_msgs_py.wire import MalformedMessage, fill_result, read_result

ACCEPTED_S = 3.0  # wall time; a server that has not answered then never got the goal, or is asked again
RESULTS_KEPT_S = 5  # wall time; each is asked for as soon as who asked has heard that its goal is accepted

# A profile that no action server offers. The states of all its goals, sent whenever one changes, are what an action
# costs most, and say nothing that the results do not. `ros2 doctor` takes that for a mistake; docs/hosts.md explains.
NO_STATUS = QoSProfile(depth=1, liveliness=LivelinessPolicy.MANUAL_BY_TOPIC)


class GoalServer(ActionServer):
    """An action server whose goals end when somebody says so, not when a callback returns.

    Args:
        accept: Gets the handle of every accepted goal.
        cancel: Gets the handle of a goal that should end early.
        check: Raises `MalformedMessage` for a goal that makes no sense; such a goal is refused.
        profile: Deep enough for all goals that come at once.
    """

    def __init__(
        self,
        live: Live,
        node: Node,
        kind: Any,
        name: str,
        *,
        accept: Callable[[ServerGoalHandle], None],
        cancel: Callable[[ServerGoalHandle], None],
        check: Callable[[Any], object],
        profile: QoSProfile = EVERY_ONE,
    ) -> None:
        """Offer the action."""
        self._live = live
        self._accept = live.guard(accept)
        self._cancel = live.guard(cancel)
        self._check = check
        super().__init__(
            node,
            kind,
            name,
            lambda _handle: kind.Result(),
            goal_callback=self._on_goal,
            cancel_callback=self._on_cancel,
            goal_service_qos_profile=profile,
            result_service_qos_profile=profile,
            cancel_service_qos_profile=profile,
            feedback_pub_qos_profile=profile,
            result_timeout=RESULTS_KEPT_S,
        )

    def _on_goal(self, goal: Any) -> GoalResponse:
        try:
            self._check(goal)
        except MalformedMessage as error:
            self._live.drop(error)
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT

    def _on_cancel(self, handle: ServerGoalHandle) -> CancelResponse:
        self._cancel(handle)
        return CancelResponse.ACCEPT

    def notify_execute(self, goal_handle: Any, execute_callback: Any) -> None:
        """Called by rclpy where it would start the execution: hand the goal on instead."""
        self._accept(goal_handle)

    def add_future(self, future: Any) -> None:
        """Called by rclpy for the result of every goal: without the executor's help it is sent at once.

        The executor would look at those of all open goals each time that the server has anything to do.
        """

    def remove_future(self, future: Any) -> None:
        """Called by rclpy when a result is over."""

    def finish(self, handle: ServerGoalHandle, code: Code, message: str) -> None:
        """End a goal."""
        result = fill_result(self.action_type.Result(), code, message)

        def end(goal_handle: ServerGoalHandle) -> Any:
            if goal_handle.is_cancel_requested and code is not Code.DONE:
                goal_handle.canceled()
            elif code is Code.DONE:
                goal_handle.succeed()
            else:
                goal_handle.abort()
            return result

        super().notify_execute(handle, end)


class GoalClient:
    """Asks for goals of one action server; what is asked before the server is there is sent when it is.

    Attributes:
        client: The action client underneath.
        signs: What is seen of the server's node, where somebody can tell.
    """

    def __init__(
        self,
        live: Live,
        node: Node,
        kind: Any,
        name: str,
        signs: Callable[[], int] | None = None,
        profile: QoSProfile = EVERY_ONE,
        term: Callable[[], int] = lambda: 0,
        sent: Callable[[], None] = lambda: None,
        ended: Callable[[], None] = lambda: None,
        accepted_s: float = ACCEPTED_S,
    ) -> None:
        """Look for the server.

        Args:
            live: The process.
            node: The node that asks.
            kind: Type of the action.
            name: Its name.
            signs: How many publishers of the server's node are seen on a topic that only that node speaks on, or any
                number that changes with the server; 0 for none. A server once found counts as there for as long as
                that number stays: looking it up in the graph costs the more the larger the graph is, a millisecond
                and more among hundreds of bots.
            profile: Deep enough for all goals that are asked for at once.
            term: Tells one who serves the action from the one before: with the server its goals are gone.
            sent: Is called for each goal that is on its way to the server.
            ended: Is called for each result that comes from it, before `on_result` is.
            accepted_s: Wall time after which a server that has not answered never got the goal.
        """
        self._term, self._sent, self._ended = term, sent, ended
        self._accepted_s = accepted_s
        self.client = ActionClient(
            node,
            kind,
            name,
            goal_service_qos_profile=profile,
            result_service_qos_profile=profile,
            cancel_service_qos_profile=profile,
            feedback_sub_qos_profile=profile,
            status_sub_qos_profile=NO_STATUS,
        )
        self._live, self._node = live, node
        # the service that a server makes last; rclpy's own look at the server includes the states of its goals
        self._probe_of = kind.Impl.GetResultService, f"{name}/_action/get_result", profile
        self._probe: Any = None
        self._goals: dict[int, _Goal] = {}
        self._unsent: list[_Goal] = []
        self.signs = signs
        self._found_with = 0  # signs when the server was found; 0 where it is not

    @property
    def ready(self) -> bool:
        """Whether the server is there."""
        if self.signs is None:
            return self._is_there(keep_looking=True)
        signs = self.signs()
        if signs != self._found_with:
            self._found_with = signs if signs > 0 and self._is_there() else 0
        return 0 < signs == self._found_with

    def _is_there(self, *, keep_looking: bool = False) -> bool:
        if self._probe is None:
            kind, name, profile = self._probe_of
            self._probe = self._node.create_client(kind, name, qos_profile=profile)
        found = self._probe.service_is_ready()
        if found and not keep_looking:
            self._node.destroy_client(self._probe)
            self._probe = None
        return found

    def send(
        self, key: int, goal: Any, on_feedback: Callable[[Any], None], on_result: Callable[[Code, str], None]
    ) -> None:
        """Ask for a goal under a number of one's own; `on_result` is called once."""
        guard = self._live.guard
        running = _Goal(key, goal, guard(on_feedback), guard(on_result))
        self._goals[key] = running
        self._unsent.append(running)
        if self.ready:
            self._send_all()

    def cancel(self, key: int) -> None:
        """Ask the server to end a goal early."""
        running = self._goals.get(key)
        if running is not None:
            running.cancelled = True
            running.cancel_if_accepted()

    def look(self) -> None:
        """If the server is there, send what waits for it; if not, end the goals that it had, as stopped."""
        if not self._goals:
            return
        ready, wall, term = self.ready, time.monotonic(), self._term()
        for running in [running for running in self._goals.values() if running.sent]:
            lost = running.handle is None and wall - running.sent_at > self._accepted_s
            if lost or not ready or running.term != term:
                self._end(running, Code.STOPPED, "who was asked is gone")
        if ready:
            self._send_all()

    def _send_all(self) -> None:
        unsent, self._unsent = self._unsent, []
        for running in unsent:
            running.sent, running.sent_at, running.term = True, time.monotonic(), self._term()
            self._sent()
            future = self.client.send_goal_async(
                running.goal, feedback_callback=lambda m, tell=running.on_feedback: tell(m.feedback)
            )
            future.add_done_callback(self._live.guard(lambda done, running=running: self._on_accepted(running, done)))

    def _on_accepted(self, running: _Goal, done: Any) -> None:
        handle = done.result()
        if not handle.accepted:
            self._end(running, Code.INVALID, "the goal was refused as malformed")
            return
        running.handle = handle
        guard = self._live.guard
        handle.get_result_async().add_done_callback(guard(lambda got: self._on_result(running, got)))
        if running.cancelled:
            running.cancel_if_accepted()

    def _on_result(self, running: _Goal, got: Any) -> None:
        self._ended()
        try:
            code, message = read_result(got.result().result)
        except MalformedMessage:  # a server that was started again knows nothing of this goal
            code, message = Code.UNKNOWN, "who was asked does not know how it ended"
        self._end(running, code, message)

    def _end(self, running: _Goal, code: Code, message: str) -> None:
        if self._goals.get(running.key) is running:
            del self._goals[running.key]
            running.on_result(code, message)


@dataclass(eq=False)
class _Goal:
    key: int
    goal: Any
    on_feedback: Callable[..., Any]
    on_result: Callable[..., Any]
    handle: Any = None
    sent: bool = False
    sent_at: float = 0.0  # wall time (s)
    term: int = 0
    cancelled: bool = False

    def cancel_if_accepted(self) -> None:
        if self.handle is not None:
            self.handle.cancel_goal_async()
