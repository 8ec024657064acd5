"""A process that takes part in a live warehouse without being a part of it: it asks, and hears what the world tells."""

from __future__ import annotations

import contextlib
import itertools
import os
import signal
import time
from collections import deque
from collections.abc import Callable
from typing import Any, TypeVar

from rclpy.qos import QoSProfile
from soup_msgs import msg

from soup_live.actions import GoalClient
from soup_live.allegiance import Allegiance
from soup_live.domain import stay_on_this_machine
from soup_live.domain_id import domain_id
from soup_live.handle import Handle
from soup_live.leader_election import ChargeWatch
from soup_live.process import LEAVES, Live
from soup_live.qos import EVERY_ONE, LATCHED, WATCH
from soup_msgs_py import topics
from soup_msgs_py.closes import Closes
from soup_msgs_py.codes import Code
from soup_msgs_py.errors import RunError
from soup_msgs_py.messages import Bots, Buckets, Event, Snapshot, Stations
from soup_msgs_py.wire import Announcement, from_ros, read_result

TIMEOUT_S = 20.0  # wall time in which a warehouse, or who serves what is asked for, is found
SILENT_S = 10.0  # wall time after which a world that says nothing is gone; it sends a snapshot every second
ACCEPTED_S = 120.0  # wall time; a fleet manager that has just begun may still have to compile what it computes with
LEAVE_S = 5.0  # wall time that those who were asked get to end what is cancelled at the end
LOOK_S = 0.1
Told = TypeVar("Told", Bots, Buckets, Stations)


class Guest(Closes):
    """Finds the warehouse of this `ROS_DOMAIN_ID`, hears the world, asks servers, cancels what is left at the end.

    It says nothing that the world waits for: simulated time goes on, whatever it does. Messages come in while it waits.
    One at a time in a process, in its main thread.

    Attributes:
        timeout_s: Wall time in which somebody has to be found who serves what is asked for.
        time: Simulated time (s), as far as it has been heard of.
        scenario: The scenario of the run.
        layout: Its floor: waypoints, storage spots, stations.
    """

    def __init__(self, *, timeout_s: float = TIMEOUT_S) -> None:
        """Find the warehouse.

        Args:
            timeout_s: Wall time in which it has to be found, and later who serves what is asked for.

        Raises:
            InputError: The environment names a domain that there is not.
            RunError: There is no warehouse.
        """
        stay_on_this_machine()
        self.time = 0.0
        self.timeout_s = timeout_s
        self._waits = self._left = False
        self._heard = 0.0  # wall time at which the world said something, or waiting for it began
        self._allegiance: Allegiance[Announcement] = Allegiance()
        self._announcement: Announcement | None = None
        self._newest: dict[type, Any] = {}
        self._numbers = itertools.count()  # of goals
        self._goals: list[Handle] = []
        self._calls: list[tuple[Handle, Any]] = []  # of services, each with its client
        self._action_clients: dict[str, GoalClient] = {}
        self._service_clients: dict[str, Any] = {}
        self._watches: list[deque[Event]] = []
        self._sequence = -1  # of the newest event
        self._live = Live("script", ends_soon=False, guest=True)
        try:
            for number in LEAVES:
                signal.signal(number, self._on_signal)
            self._listen()
            self._find(
                lambda: self._announcement is not None and Bots in self._newest and Snapshot in self._newest,
                f"no warehouse in domain {domain_id()} (nothing on {topics.SCENARIO})", "run_warehouse.py",
            )  # fmt: skip
        except BaseException:
            self.close()
            raise
        assert self._announcement is not None
        self.scenario, self.layout = self._announcement.scenario, self._announcement.layout

    def _listen(self) -> None:
        live = self._live
        self._node = node = live.node(f"script_{os.getpid()}")
        self._fleet = ChargeWatch(live, node, topics.FLEET_MANAGER_NODE)
        live.follow(node, msg.Scenario, topics.SCENARIO, self._on_announcement, LATCHED)
        live.subscribe(node, msg.Snapshot, topics.SNAPSHOT, self._on_snapshot, LATCHED)
        for kind, topic in ((msg.Bots, topics.BOTS), (msg.Buckets, topics.BUCKETS), (msg.Stations, topics.STATIONS)):
            live.follow(node, kind, topic, self._on_told, WATCH, run=self._run)
        live.follow(node, msg.Event, topics.EVENTS, self._on_event, EVERY_ONE, run=self._run)
        live.every(LOOK_S, self._look)

    def close(self) -> None:
        """Cancel what is under way, and leave the graph. Can be called twice."""
        if self._left:
            return
        self._left = self._waits = True
        try:
            for goal in self._goals:
                goal.cancel()
            deadline = time.monotonic() + LEAVE_S
            with contextlib.suppress(RunError):  # that the world is gone has been said
                while not all(goal.done for goal in self._goals) and time.monotonic() < deadline:
                    self._live.drain(LOOK_S, LOOK_S)
                    for client in self._action_clients.values():
                        client.look()
        finally:
            self._live.close()

    # ---- ask ----------------------------------------------------------------------------------------------

    def _action_client(self, kind: Any, name: str, profile: QoSProfile) -> GoalClient:
        client = self._action_clients.get(name)
        if client is None:
            # who looks for signs, as managers do, asks again where somebody was only busy; a script would not
            term = (lambda: self._fleet.newest) if name == topics.DELIVER_LETTERS else (lambda: 0)
            client = self._action_clients[name] = GoalClient(
                self._live, self._node, kind, name, profile=profile, term=term, accepted_s=ACCEPTED_S
            )
        return client

    def _find_server(self, client: GoalClient, name: str, starter: str) -> None:
        is_known = (lambda: self._fleet.newest > 0) if name == topics.DELIVER_LETTERS else (lambda: True)
        self._find(lambda: client.ready and is_known(), f"nobody serves {name}", starter)

    def _send(self, client: GoalClient, name: str, goal: Any, what: str, starter: str) -> Handle:
        self._find_server(client, name, starter)
        key = next(self._numbers)
        handle = Handle(what, lambda: client.cancel(key))
        self._goals = [*(goal for goal in self._goals if not goal.done), handle]
        client.send(key, goal, handle.tell, handle.end)
        return handle

    def _call(self, kind: Any, name: str, profile: QoSProfile, request: Any, what: str, starter: str) -> Handle:
        client = self._service_clients.get(name)
        if client is None:
            client = self._service_clients[name] = self._node.create_client(kind, name, qos_profile=profile)
        self._find(client.service_is_ready, f"nobody serves {name}", starter)
        handle = Handle(what)
        self._calls.append((handle, client))

        def answered(future: Any) -> None:
            handle.end(*read_result(future.result()))

        client.call_async(request).add_done_callback(self._live.guard(answered))
        return handle

    # ---- hear ---------------------------------------------------------------------------------------------

    def _run(self) -> int:
        return self._announcement.run if self._announcement is not None else 0

    def _on_announcement(self, announcement: Announcement) -> None:
        self._allegiance.announce(announcement, time.monotonic())
        self._look()

    def _on_snapshot(self, told: msg.Snapshot) -> None:
        self._allegiance.hear(told.run, time.monotonic())
        if self._live.belongs(told.run, self._run()):
            self._on_told(from_ros(told))

    def _on_told(self, told: Bots | Buckets | Stations | Snapshot) -> None:
        self._heard = time.monotonic()
        self.time = max(self.time, told.time)
        self._newest[type(told)] = told

    def _on_event(self, event: Event) -> None:
        self.time, self._sequence = max(self.time, event.time), event.sequence
        for events in self._watches:
            events.append(event)

    def _look(self) -> None:
        """Notice that the world is another one, or gone."""
        wall = time.monotonic()
        announcement = self._allegiance.change(wall)
        if announcement is not None and self._announcement is None:
            self._announcement, self._heard = announcement, wall
        elif announcement is not None:
            self._live.stop(RunError("the world was started again; what was known of it is void"))
        elif self._announcement is not None and wall - self._heard > SILENT_S:
            self._live.stop(RunError(f"the world has said nothing for {SILENT_S:g} s"))
        for client in self._action_clients.values():
            client.look()
        self._calls = [(handle, client) for handle, client in self._calls if not handle.done]
        for handle, client in self._calls:
            if not client.service_is_ready():
                handle.end(Code.STOPPED, "who was asked is gone")

    def _fresh(self, kind: type[Told]) -> Told:
        """The second that comes: the first may have been on its way before that was done which it is to show."""
        for _ in range(2):
            self._newest.pop(kind, None)
            self._spin(lambda: kind in self._newest)
        return self._newest[kind]

    # ---- wait ---------------------------------------------------------------------------------------------

    def _find(self, found: Callable[[], bool], missing: str, starter: str) -> None:
        if not self._spin(found, self.timeout_s):
            raise RunError(f"{missing} within {self.timeout_s:g} s; python3 scripts/{starter} starts one")

    def _spin(self, until: Callable[[], bool], timeout_s: float | None = None) -> bool:
        """Carry messages until something holds; whether it does."""
        if self._left:
            raise RuntimeError("this warehouse has been left")
        self._waits, self._heard = True, time.monotonic()
        try:
            held = self._live.spin(until, timeout_s)
        finally:
            self._waits = False
        if not held and self._live.stopping:
            raise KeyboardInterrupt
        return held

    def _on_signal(self, _number: int, _frame: object) -> None:
        """End what waits; while the script does something of its own, end that."""
        self._live.stop()
        if not self._waits:
            raise KeyboardInterrupt
