"""The fleet manager's node: serves the fleet's two actions, and asks bots for drives and trips."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from rclpy.action.server import ServerGoalHandle
from soup_msgs import action, msg, srv

from soup_live.actions import GoalServer
from soup_live.diagnostics import Report
from soup_live.leader_election import InCharge
from soup_live.process import Live
from soup_live.qos import CHARGES, DISPLAY, LATCHED
from soup_live.world_client import WorldClient
from soup_managers.explain import Explain
from soup_managers.fleets.make import Fleet, load_fleet, make_fleet
from soup_managers.nodes.hosts import Hosts
from soup_managers.nodes.orders_node import Orders
from soup_managers.nodes.station_manager_node import role_rng, run_manager
from soup_managers.view import WarehouseView
from soup_msgs_py import mail, topics
from soup_msgs_py.codes import Code
from soup_msgs_py.messages import (
    DELIVER,
    STORE,
    BotGone,
    BotStatus,
    Bound,
    CancelDrive,
    CancelTask,
    CancelTrip,
    Charge,
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
from soup_msgs_py.mind import NEVER, Message
from soup_msgs_py.policies import PolicyChoice
from soup_msgs_py.wire import Announcement, MalformedMessage, from_ros, read_cdr, to_ros, to_ros_of

TASKS_PERIOD_S = 0.5
NOT_YET = "the fleet manager waits for the world"
LOOK_AT_BOTS_S = 0.2
PLACES_S = 0.2  # simulated time between two looks at where bots are, while the fleet has to see that


class FleetManagerNode:
    """Node `/fleet_manager`."""

    def __init__(self, live: Live, choice: PolicyChoice, seed: int, explain: Explain, take_over: bool) -> None:
        """Make the node; the bots are looked for when the world has told how many there are.

        Args:
            live: The process.
            choice: The fleet policy.
            seed: Seed of its random numbers.
            explain: Is told its decisions.
            take_over: Whether to ask another fleet manager to hand over.
        """
        self._live, self._choice, self._seed, self._explain = live, choice, seed, explain
        self._node = node = live.node(topics.FLEET_MANAGER_NODE)
        self._tasks = node.create_publisher(msg.Tasks, topics.TASKS, LATCHED)
        self._world = node.create_client(srv.SetStorageSpot, topics.SET_STORAGE_SPOT)
        self._bound = node.create_publisher(msg.Bound, topics.BOUND, LATCHED)
        self._fleet: Fleet | None = None
        self._published: tuple[TaskState, ...] | None = None
        self._servers: dict[str, GoalServer] = {}
        self._goals: dict[tuple[str, int], list[ServerGoalHandle]] = {}
        self._bots = 0  # whose statuses are followed
        self._newest: dict[int, tuple[int, BotStatus]] = {}  # with the run that it is of
        self._silent: set[int] = set()  # bots that have spoken, but may not hear yet
        self._known: set[int] = set()
        self._hosts = Hosts()
        self._orders = Orders(
            live, node, lambda: self._client.run, self._on_result, self._hosts.name, lambda: self._client.mail
        )
        self._bounds = 0  # told so far
        self._next_places = 0.0  # simulated time (s) of the next look at where bots are
        self._is_new = False  # another world has begun, and its fleet is not told yet what came before it
        self._report = Report(live, node)
        self._report.values = {"policy": choice.name, "bots": "0"}
        self._carriers: dict[type, Callable[[Any], None]] = {
            TaskFeedback: self._tell_task,
            TaskResult: self._end_task,
            TripGoal: self._orders.ask,
            DriveGoal: self._orders.ask,
            Bound: self._tell_bound,
            CancelTrip: self._orders.cancel,
            CancelDrive: self._orders.cancel,
            SetStorageSpot: self._ask_world,
        }
        self._charge = InCharge(live, node, self._report, choice.name, take_over=take_over, begin=self._begin)
        self._client = WorldClient(
            live, node, self._report, self._make_mind, self._carry, lambda: self._charge.missing,
            looks=self._next_look,
        )  # fmt: skip
        live.follow(node, msg.Charge, topics.BOTS_CHARGE, self._on_bots_charge, CHARGES)
        live.subscribe(node, msg.Bots, topics.SENSED_BOTS, self._on_poses, DISPLAY, raw=True)
        live.every(TASKS_PERIOD_S, self._look_at_fleet)
        live.every(LOOK_AT_BOTS_S, self._look_at_bots)

    def _make_mind(self, world: Announcement) -> Fleet:
        for bot in range(self._bots, world.scenario.bots):
            status = topics.bot_topic(bot, topics.STATUS)
            take = partial(self._on_status, bot)
            subscription = self._live.subscribe(self._node, msg.BotStatus, status, take, LATCHED)
            self._orders.follow(bot, partial(self._minds_of, bot, subscription.get_publisher_count))
        self._bots = max(self._bots, world.scenario.bots)
        self._orders.clear()
        policy = load_fleet(self._choice)
        self._is_new = True
        self._next_places = world.time
        view = WarehouseView(world.scenario, world.layout)
        rng = role_rng("fleet", self._seed)
        self._fleet = make_fleet(world.scenario, world.layout, policy, view, rng, self._explain)
        self._fleet.mistakes.tell = self._report.mistake
        return self._fleet

    def _begin(self) -> None:
        """In charge now: let the others ask."""
        self._servers = {
            DELIVER: self._serve(DELIVER, action.DeliverLetters, topics.DELIVER_LETTERS),
            STORE: self._serve(STORE, action.StoreBundle, topics.STORE_BUNDLE),
        }

    # ---- the other managers -------------------------------------------------------------------------------

    def _serve(self, kind: str, action_type: Any, name: str) -> GoalServer:
        def accept(handle: ServerGoalHandle) -> None:
            goal = from_ros(handle.request)
            if _is_a_managers(handle):
                self._client.mail.got(mail.goals(kind))
            self._goals.setdefault((kind, goal.task), []).append(handle)
            if self._client.mind is None:
                self._end_task(TaskResult(kind, goal.task, Code.BUSY, NOT_YET))
            elif handle.request.run in (0, self._client.run):
                self._client.tell(goal)
            else:
                self._client.settle()

        def cancel(handle: ServerGoalHandle) -> None:
            self._client.tell(CancelTask(kind, handle.request.task))

        return GoalServer(self._live, self._node, action_type, name, accept=accept, cancel=cancel, check=from_ros)

    def _tell_task(self, feedback: TaskFeedback) -> None:
        for handle in self._goals.get((feedback.kind, feedback.task), ()):
            handle.publish_feedback(to_ros(feedback))

    def _end_task(self, result: TaskResult) -> None:
        for handle in self._goals.pop((result.kind, result.task), ()):
            if _is_a_managers(handle):
                self._client.mail.sent(mail.results(result.kind))
            self._servers[result.kind].finish(handle, result.code, result.message)

    # ---- the bots -----------------------------------------------------------------------------------------

    def _on_status(self, bot: int, message: msg.BotStatus) -> None:
        status: BotStatus = from_ros(message)
        if status.bot != bot:
            raise MalformedMessage(f"bot {status.bot} on the topic of bot {bot}")
        self._newest[status.bot] = message.run, status
        self._client.mail.got(mail.outcomes(message.part), message.number, bot)
        if status.bot in self._known:
            self._tell_newest(status.bot)
        else:
            self._silent.add(status.bot)
        self._client.settle()

    def _tell_newest(self, bot: int) -> None:
        """Tell the fleet what a bot said last, unless that was in another run of the world."""
        run, status = self._newest[bot]
        if run == self._client.run:
            self._client.tell(status)

    def _look_at_bots(self) -> None:
        """A bot counts as soon as it can be asked; one that is gone fails what it was asked for.

        In a new world others may have begun before the fleet.
        """
        if self._is_new and self._client.in_step:
            self._is_new = False
            for (kind, task), handles in list(self._goals.items()):
                if handles[-1].request.run in (0, self._client.run):
                    self._client.tell(from_ros(handles[-1].request))
                else:
                    self._end_task(TaskResult(kind, task, Code.STOPPED, "it belongs to another run of the world"))
            for bot in self._known:
                self._tell_newest(bot)
        if self._silent and self._orders.heard:
            for bot in sorted(self._silent):
                self._tell_newest(bot)
            self._known |= self._silent
            self._silent.clear()
        self._orders.look()
        self._report.values["bots"] = str(len(self._known))

    def _minds_of(self, bot: int, seen: Callable[[], int]) -> int:
        # who was killed is still seen for a while
        return 0 if self._hosts.is_gone(bot) else seen()

    def _on_bots_charge(self, charge: Charge) -> None:
        for bot in sorted(self._hosts.hear(charge)):
            self._client.tell(BotGone(bot))

    def _on_result(self, result: DriveResult | TripResult) -> None:
        self._client.tell(result)

    def _ask_world(self, wish: SetStorageSpot) -> None:
        self._client.call(self._world, to_ros(wish), lambda _: None)  # an event tells whether it did

    def _tell_bound(self, bound: Bound) -> None:
        self._bounds += 1
        self._client.mail.sent(mail.BOUND)
        message = to_ros_of(self._client.run, bound)
        message.number = self._bounds
        self._bound.publish(message)

    # ---- now and then -------------------------------------------------------------------------------------

    def _next_look(self) -> float:
        return self._next_places if self._fleet is not None and self._fleet.wants_places else NEVER

    def _on_poses(self, cdr: bytes) -> None:
        fleet = self._fleet
        if fleet is None or not self._client.in_step or not fleet.wants_places:
            return
        poses = read_cdr(cdr, msg.Bots)
        if self._live.belongs(poses.run, self._client.run):
            bots = from_ros(poses)
            self._client.now = max(self._client.now, bots.time)
            self._next_places = bots.time + PLACES_S
            self._client.tell(bots)

    def _look_at_fleet(self) -> None:
        fleet = self._fleet
        if fleet is None or not self._client.in_step:
            return
        self._report.values["stalled_bots"] = "; ".join(f"{bot}: {why}" for bot, why in fleet.stalled.items()) or "none"
        tasks = fleet.tasks()
        if tasks != self._published:
            self._published = tasks
            self._tasks.publish(to_ros_of(self._client.run, Tasks(self._client.now, tasks)))

    def _carry(self, messages: list[Message]) -> None:
        for message in messages:
            self._carriers[type(message)](message)


def _is_a_managers(handle: ServerGoalHandle) -> bool:
    """Whether a goal says which run it is of, as those of managers do: time waits for such a goal and its result."""
    return handle.request.run != 0


def main(argv: Sequence[str] | None = None, *, policies: Path | None = None) -> int:
    """Run the fleet manager in this process; its exit status."""

    def check(choice: PolicyChoice) -> None:
        load_fleet(choice)

    return run_manager(argv, "fleet", policies, check, FleetManagerNode)


if __name__ == "__main__":
    sys.exit(main())
