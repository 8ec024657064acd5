"""What the nodes of the word and the letter manager share: a service of the world, an action of the fleet."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import numpy as np
from soup_msgs import msg

from soup_live.actions import GoalClient
from soup_live.diagnostics import Report
from soup_live.domain import stay_on_this_machine
from soup_live.leader_election import ChargeWatch, InCharge
from soup_live.process import Live, exit_status
from soup_live.qos import EVERY_ONE, LATCHED
from soup_live.world_client import WorldClient
from soup_managers.explain import Explain, write_lines
from soup_managers.stations.station_manager import StationManager
from soup_msgs_py import mail, topics
from soup_msgs_py.codes import Code
from soup_msgs_py.command_line.output_files import SharedFile
from soup_msgs_py.command_line.part_arguments import parse_manager
from soup_msgs_py.messages import (
    DELIVER,
    AssignBundle,
    AssignWord,
    CancelTask,
    DeliverGoal,
    StoreGoal,
    TaskResult,
)
from soup_msgs_py.mind import Message, Mind
from soup_msgs_py.policies import MANAGERS, PolicyChoice, load_policies
from soup_msgs_py.wire import Announcement, from_ros, task_feedback, to_ros

LOOK_FOR_FLEET_S = 1.0


def role_rng(role: str, seed: int) -> np.random.Generator:
    """The random numbers of a manager; the same as in one process."""
    child = np.random.SeedSequence([seed, 1]).spawn(len(MANAGERS))[MANAGERS.index(role)]
    return np.random.Generator(np.random.PCG64(child))


class StationManagerNode:
    """Node of a manager that fills stations and asks the fleet."""

    def __init__(
        self,
        live: Live,
        name: str,
        kind: str,
        make_mind: Callable[[Announcement], StationManager],
        *,
        service: tuple[Any, str],
        action: tuple[Any, str],
        policy: str,
        take_over: bool,
    ) -> None:
        """Make the node.

        Args:
            live: The process.
            name: Of the node.
            kind: Of the tasks, DELIVER or STORE.
            make_mind: Makes the manager for a world.
            service: Type and name of the world's service.
            action: Type and name of the fleet's action.
            policy: Name of the policy, for the report.
            take_over: Whether to ask another manager of the role to hand over.
        """
        self._live, self._kind = live, kind
        node = live.node(name)
        self._world = node.create_client(*service, qos_profile=EVERY_ONE)
        fleet = ChargeWatch(live, node, topics.FLEET_MANAGER_NODE)
        self._fleet = GoalClient(
            live, node, *action, signs=lambda: fleet.claim, term=lambda: fleet.claim,
            sent=lambda: self._client.mail.sent(mail.goals(kind)),
            ended=lambda: self._client.mail.got(mail.results(kind)),
        )  # fmt: skip
        starts = "python3 scripts/run_{}.py starts one"
        fleet_starts, world_starts = starts.format("fleet_manager"), starts.format("world")
        self._waits_for_fleet = f"waits for the fleet manager (nobody serves {action[1]}; {fleet_starts})"
        self._waits_for_world = f"waits for the world (nobody serves {service[1]}; {world_starts})"
        self._report = Report(live, node)
        self._report.values = {"policy": policy}

        def make(world: Announcement) -> Mind:
            mind = make_mind(world)
            mind.mistakes.tell = self._report.mistake
            return mind

        self._charge = InCharge(live, node, self._report, policy, take_over=take_over)
        self._client = WorldClient(live, node, self._report, make, self._carry, self._missing)
        if kind == DELIVER:
            live.subscribe(node, msg.Bound, topics.BOUND, self._on_bound, LATCHED)
        live.every(LOOK_FOR_FLEET_S, self._fleet.look)

    def _missing(self) -> str:
        if self._charge.missing:
            return self._charge.missing
        if not self._client.in_step and not self._world.service_is_ready():
            return self._waits_for_world
        return "" if self._fleet.ready else self._waits_for_fleet

    def _carry(self, messages: list[Message]) -> None:
        for message in messages:
            match message:
                case AssignWord() | AssignBundle():
                    self._client.call(self._world, to_ros(message), self._on_reply)
                case DeliverGoal() | StoreGoal():
                    self._ask_fleet(message)
                case CancelTask():
                    self._fleet.cancel(message.task)

    def _on_reply(self, response: Any) -> None:
        self._client.tell(from_ros(response))

    def _on_bound(self, bound: msg.Bound) -> None:
        told = from_ros(bound)
        if self._live.belongs(bound.run, self._client.run):
            self._client.mail.got(mail.BOUND, bound.number)
            self._client.tell(told)

    def _ask_fleet(self, goal: DeliverGoal | StoreGoal) -> None:
        kind, task = self._kind, goal.task

        def on_feedback(feedback: Any) -> None:
            self._client.tell(task_feedback(feedback, kind, task))

        def on_result(code: Code, message: str) -> None:
            self._client.tell(TaskResult(kind, task, code, message))

        request = to_ros(goal)
        request.run = self._client.run
        self._fleet.send(task, request, on_feedback, on_result)


def run_manager(
    argv: Sequence[str] | None,
    role: str,
    policies: Path | None,
    check: Callable[[PolicyChoice], object],
    make_node: Callable[[Live, PolicyChoice, int, Explain, bool], object],
) -> int:
    """The program of any manager; its exit status.

    Args:
        argv: Command line.
        role: word, letter or fleet.
        policies: The policies file where the command line names none.
        check: Raises `InputError` for a policy that cannot be.
        make_node: Makes the node for a policy, a seed, what is told of its decisions, and whether to take over.
    """
    options = parse_manager(argv, role, policies)

    def run() -> None:
        choice = getattr(load_policies(options.policies, {role: options.policy}), role)
        check(choice)
        stay_on_this_machine()
        with ExitStack() as files:
            live = files.enter_context(Live(f"{role} manager", starts_again=True))
            sink = None
            if options.explain is not None:
                # the managers of one warehouse may share the file
                sink = write_lines(files.enter_context(closing(SharedFile(options.explain, live.tell))))
            make_node(live, choice, options.seed, Explain(sink), options.take_over and not options.stand_by)
            live.spin()

    return exit_status(run)
