"""The fleet manager's node: serves the fleet's two actions, and asks each bot for trips."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from rclpy.action.server import ServerGoalHandle
from rclpy.serialization import deserialize_message
from soup_msgs import action, msg, srv

from soup_managers.departures import Departures
from soup_managers.explain import Explain
from soup_managers.make_fleet import Fleet, load_fleet, make_fleet
from soup_managers.station_manager_node import role_rng, run_manager
from soup_managers.view import WarehouseView
from soup_msgs_py import topics
from soup_msgs_py.codes import Code, Phase
from soup_msgs_py.live.actions import GoalClient, GoalServer
from soup_msgs_py.live.follower import Follower
from soup_msgs_py.live.process import Live
from soup_msgs_py.live.report import Report
from soup_msgs_py.messages import (
    DELIVER,
    STORE,
    BotStatus,
    Bound,
    CancelDrive,
    CancelTask,
    CancelTrip,
    DriveGoal,
    DriveResult,
    SetStorageSpot,
    TaskFeedback,
    TaskResult,
    Tasks,
    TaskState,
    TripGoal,
    TripResult,
)
from soup_msgs_py.mind import Message
from soup_msgs_py.policies import PolicyChoice
from soup_msgs_py.qos import DISPLAY, LATCHED
from soup_msgs_py.wire import Announcement, from_ros, to_ros, trip_feedback

TASKS_PERIOD_S = 0.5
NOT_YET = "the fleet manager waits for the world"
LOOK_AT_BOTS_S = 0.2
LEAD_S = 0.05  # wall time that a drive needs from the fleet over its bot to the world, with room


class FleetManagerNode:
    """Node `/fleet_manager`."""

    def __init__(self, live: Live, choice: PolicyChoice, seed: int, explain: Explain) -> None:
        """Make the node; the bots are looked for when the world has told how many there are.

        Args:
            live: The process.
            choice: The fleet policy.
            seed: Seed of its random numbers.
            explain: Is told its decisions.
        """
        self._live, self._choice, self._seed, self._explain = live, choice, seed, explain
        self._node = node = live.node(topics.FLEET_MANAGER_NODE)
        self._tasks = node.create_publisher(msg.Tasks, topics.TASKS, LATCHED)
        self._world = node.create_client(srv.SetStorageSpot, topics.SET_STORAGE_SPOT)
        self._bound = node.create_publisher(msg.Bound, topics.BOUND, LATCHED)
        self._fleet: Fleet | None = None
        self._published: tuple[TaskState, ...] | None = None
        self._looked: tuple[float, float] | None = None  # wall and simulated time of the last look
        self._servers = {
            DELIVER: self._serve(DELIVER, action.DeliverLetters, topics.DELIVER_LETTERS),
            STORE: self._serve(STORE, action.StoreBundle, topics.STORE_BUNDLE),
        }
        self._goals: dict[tuple[str, int], list[ServerGoalHandle]] = {}
        self._bots: dict[int, GoalClient] = {}
        self._drives: dict[int, GoalClient] = {}
        self._newest: dict[int, BotStatus] = {}
        self._silent: dict[int, BotStatus] = {}  # newest status of bots whose trip action is not seen yet
        self._known: set[int] = set()
        self._departures = Departures()
        self._is_new = False  # another world has begun, and its fleet is not told yet what came before it
        self._report = Report(live, node)
        self._report.values = {"policy": choice.name, "bots": "0"}
        self._carriers: dict[type, Callable[[Any], None]] = {
            TaskFeedback: self._tell_task,
            TaskResult: self._end_task,
            TripGoal: self._ask_bot,
            DriveGoal: self._ask_to_drive,
            Bound: lambda m: self._bound.publish(to_ros(m)),
            CancelTrip: lambda m: self._bots[m.bot].cancel(m.trip),
            CancelDrive: lambda m: self._drives[m.bot].cancel(m.drive),
            SetStorageSpot: self._ask_world,
        }
        self._follower = Follower(
            live, node, self._report, self._make_mind, self._carry, lambda: "",
            holds=lambda: self._departures.earliest(time.monotonic()),
        )  # fmt: skip
        live.subscribe(node, msg.Bots, topics.BOTS, self._on_poses, DISPLAY, raw=True)
        self._poses = b""
        live.every(TASKS_PERIOD_S, self._look_at_fleet)
        live.every(LOOK_AT_BOTS_S, self._look_at_bots)

    def _make_mind(self, world: Announcement) -> Fleet:
        for bot in range(len(self._bots), world.scenario.bots):
            status = topics.bot_topic(bot, topics.STATUS)
            signs = self._live.follow(self._node, msg.BotStatus, status, self._on_status, LATCHED).get_publisher_count
            trip, drive = topics.bot_topic(bot, topics.TRIP), topics.bot_topic(bot, topics.DRIVE)
            self._bots[bot] = GoalClient(self._live, self._node, action.CarryTrip, trip, signs)
            self._drives[bot] = GoalClient(self._live, self._node, action.Drive, drive, signs)
        policy = load_fleet(self._choice)
        self._is_new = True
        self._departures.clear()
        view = WarehouseView(world.scenario, world.layout)
        rng = role_rng("fleet", self._seed)
        self._fleet = make_fleet(world.scenario, world.layout, policy, view, rng, self._explain)
        return self._fleet

    # ---- the other managers -------------------------------------------------------------------------------

    def _serve(self, kind: str, action_type: Any, name: str) -> GoalServer:
        def accept(handle: ServerGoalHandle) -> None:
            goal = from_ros(handle.request)
            self._goals.setdefault((kind, goal.task), []).append(handle)
            if self._follower.mind is None:
                self._end_task(TaskResult(kind, goal.task, Code.BUSY, NOT_YET))
            else:
                self._follower.tell(goal)

        def cancel(handle: ServerGoalHandle) -> None:
            self._follower.tell(CancelTask(kind, handle.request.task))

        return GoalServer(self._live, self._node, action_type, name, accept=accept, cancel=cancel, check=from_ros)

    def _tell_task(self, feedback: TaskFeedback) -> None:
        for handle in self._goals.get((feedback.kind, feedback.task), ()):
            handle.publish_feedback(to_ros(feedback))

    def _end_task(self, result: TaskResult) -> None:
        for handle in self._goals.pop((result.kind, result.task), ()):
            self._servers[result.kind].finish(handle, result.code, result.message)

    # ---- the bots -----------------------------------------------------------------------------------------

    def _on_status(self, status: BotStatus) -> None:
        self._newest[status.bot] = status
        if status.phase is Phase.DRIVING:
            self._departures.confirm(status.bot)
        if status.bot in self._known:
            self._follower.tell(status)
        elif status.bot in self._bots:
            self._silent[status.bot] = status

    def _look_at_bots(self) -> None:
        """A bot counts as soon as it can be asked; one that is gone fails what it was asked for.

        In a new world others may have begun before the fleet.
        """
        if self._is_new and self._follower.in_step:
            self._is_new = False
            for handles in list(self._goals.values()):
                self._follower.tell(from_ros(handles[-1].request))
            for bot in self._known:
                self._follower.tell(self._newest[bot])
        for bot in [bot for bot in self._silent if self._bots[bot].ready and self._drives[bot].ready]:
            self._known.add(bot)
            self._follower.tell(self._silent.pop(bot))
        for client in (*self._bots.values(), *self._drives.values()):
            client.look()
        self._report.values["bots"] = str(len(self._known))

    def _ask_bot(self, goal: TripGoal) -> None:
        bot, trip = goal.bot, goal.trip.trip

        def on_feedback(feedback: Any) -> None:
            self._follower.tell(trip_feedback(feedback, bot, trip))

        def on_result(code: Code, message: str) -> None:
            self._follower.tell(TripResult(bot, trip, code, message))

        self._bots[bot].send(trip, to_ros(goal), on_feedback, on_result)

    def _ask_world(self, wish: SetStorageSpot) -> None:
        self._world.call_async(to_ros(wish))  # an event tells whether it did

    def _ask_to_drive(self, goal: DriveGoal) -> None:
        bot, drive = goal.bot, goal.drive

        def on_result(code: Code, message: str) -> None:
            self._departures.confirm(bot)
            self._follower.tell(DriveResult(bot, drive, code, message))

        self._departures.ask(goal, time.monotonic())
        self._drives[bot].send(drive, to_ros(goal), lambda _: None, on_result)

    # ---- now and then -------------------------------------------------------------------------------------

    def _on_poses(self, cdr: bytes) -> None:
        self._poses = cdr
        if self._fleet is not None and self._fleet.wants_places:
            self._tell_poses()

    def _tell_poses(self) -> None:
        if self._poses and self._follower.in_step:
            self._follower.tell(from_ros(deserialize_message(self._poses, msg.Bots)))
            self._poses = b""

    def _set_lead(self, fleet: Fleet) -> None:
        """Have bots told of drives early enough for the speed at which simulated time goes now."""
        wall = time.monotonic()
        before, self._looked = self._looked, (wall, self._follower.now)
        if before is not None and wall > before[0]:
            fleet.lead_s = LEAD_S * max((self._looked[1] - before[1]) / (wall - before[0]), 1.0)

    def _look_at_fleet(self) -> None:
        fleet = self._fleet
        if fleet is None or not self._follower.in_step:
            return
        self._tell_poses()
        self._set_lead(fleet)
        tasks = fleet.tasks()
        if tasks != self._published:
            self._published = tasks
            self._tasks.publish(to_ros(Tasks(self._follower.now, tasks)))

    def _carry(self, messages: list[Message]) -> None:
        for message in messages:
            self._carriers[type(message)](message)


def main(argv: Sequence[str] | None = None, *, policies: Path | None = None) -> int:
    """Run the fleet manager in this process; its exit status."""

    def check(choice: PolicyChoice) -> None:
        load_fleet(choice)

    return run_manager(argv, "fleet", policies, check, FleetManagerNode)


if __name__ == "__main__":
    sys.exit(main())
