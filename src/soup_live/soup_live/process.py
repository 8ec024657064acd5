"""What every process of the live graph shares: start, spin, signals, clean end.

Everything runs on one thread. `Live.spin` loops `spin_once` of the events executor (its `spin` does not
deliver in the PyPI wheels); signals are looked at between two callbacks, at most `LONGEST_WAIT_S` apart.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable
from typing import Any

import rclpy
from rclpy.action import ActionClient, ActionServer
from rclpy.executors import ExternalShutdownException
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from rclpy.subscription import Subscription

from soup_live.domain_id import domain_id
from soup_live.ending import Ending, disarm
from soup_msgs_py.blame import blaming
from soup_msgs_py.closes import Closes
from soup_msgs_py.command_line.display import display
from soup_msgs_py.errors import InputError, RunError
from soup_msgs_py.wire import MalformedMessage, from_ros, read_cdr

LONGEST_WAIT_S = 0.1  # between two looks at the signals
STILL_S = 10.0  # a process that was stopped for so long has been given up by the others
TOLD_MS = 100  # wall time (ms) in which a process that was stopped is told that it goes on
LEAVES = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class Live(Closes):
    """A process in the live graph; use it as a context manager.

    Attributes:
        name: For messages to a person.
        malformed: Messages that made no sense and were dropped.
        last_malformed: What was wrong with the last one.
        foreign: Messages of another run of the world, which were dropped.
        ended_by: The signal that ended the process, 0 for none.
        told: What it has last told the person who started it; its reports say that, too.
    """

    def __init__(self, name: str, *, starts_again: bool = False, ends_soon: bool = True, guest: bool = False) -> None:
        """Join the ROS graph.

        Args:
            name: For messages to a person.
            starts_again: Whether to end with `StoodStill` after the process was stopped for a while. The others have
                given it up by then, and it would hear no more of them.
            ends_soon: Whether the process has to be gone soon after it was told to end, whatever a callback does then.
                Not for who has to end others first, or has much to put on disk.
            guest: Whether the process is there for more than this, as that of a notebook or of tests is. What it does
                after it has left the graph may take as long as it likes.

        Raises:
            InputError: The environment names a domain that there is not.
        """
        domain_id()  # whether it makes sense
        self.name = name
        self._still = Stillness() if starts_again else None
        self.malformed = 0
        self.last_malformed = ""
        self.foreign = 0
        self.ended_by = 0
        self.told = ""
        self._stopping = False
        self._carried = 0  # callbacks so far
        self._error: BaseException | None = None
        self._nodes: list[Node] = []
        self._left: list[Any] = []  # waitables of nodes that are not in the graph any more
        self._periodic: list[_Periodic] = []
        self._farewells: list[Callable[[], None]] = []
        self._ends_soon = ends_soon
        self._ending = Ending(name, lambda: 1 if self._error else 0, to_the_last=not guest)
        self._handlers = {number: signal.signal(number, self._on_signal) for number in LEAVES}
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        self._executor = EventsExecutor()

    def node(self, name: str, namespace: str = "/") -> Node:
        """A new node, without the services and topics that nobody uses here."""
        node = Node(name, namespace=namespace, start_parameter_services=False, enable_rosout=False)
        self._nodes.append(node)
        self._executor.add_node(node)
        return node

    def subscribe(
        self,
        node: Node,
        kind: type,
        topic: str,
        take: Callable[[Any], object],
        profile: QoSProfile,
        raw: bool = False,
    ) -> Subscription:
        """Hand every message of a topic to `take`; what raises `MalformedMessage` is counted and dropped.

        Messages are unpacked here and not by the executor: what is too long is refused before, and one that cannot be
        unpacked ends nobody. With `raw`, `take` gets the bytes.
        """
        hear = take if raw else lambda cdr: take(read_cdr(cdr, kind))
        return node.create_subscription(kind, topic, self.guard(hear), profile, raw=True)

    def follow(
        self,
        node: Node,
        kind: type,
        topic: str,
        take: Callable[[Any], None],
        profile: QoSProfile,
        run: Callable[[], int] | None = None,
    ) -> Subscription:
        """Hand every message of a topic, turned into its dataclass, to `take`.

        Where `run` is given, it tells which run of the world is followed: what says that it belongs to another one is
        counted and dropped. Before any world has been heard of that is 0, and everything is taken.
        """

        def hear(message: Any) -> None:
            converted = from_ros(message)
            if run is None or self.belongs(message.run, run()):
                take(converted)

        return self.subscribe(node, kind, topic, hear, profile)

    def drop(self, error: MalformedMessage) -> None:
        """Count a message that made no sense, and remember why it made none."""
        self.malformed += 1
        self.last_malformed = str(error)

    def belongs(self, said: int, run: int) -> bool:
        """Whether what was said in a run of the world is meant for this one, 0 for any; if not, it is counted."""
        if run in (0, said):
            return True
        self.foreign += 1
        return False

    def leave(self, node: Node) -> None:
        """Take a node out of the graph, though the process goes on.

        rclpy leaves waitables to their owners: each would keep the node alive, and with the last one the process's
        place in DDS, until static destructors run. The executor may still hold them until it is shut down.
        """
        self._nodes.remove(node)
        self._executor.remove_node(node)
        node.destroy_node()
        for waitable in reversed(list(node.waitables)):  # what listens to a subscription before the subscription
            if isinstance(waitable, ActionServer | ActionClient):  # others see at once that they are gone
                waitable.destroy()
            else:
                self._left.append(waitable)

    def guard(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Wrap a callback: an exception ends the process in order instead of inside the executor."""

        def guarded(*arguments: Any) -> Any:
            if self._stopping or self._stood_still():
                return None
            self._carried += 1
            try:
                return function(*arguments)
            except MalformedMessage as error:
                self.drop(error)
            except BaseException as error:  # whatever it is, the process must end in order
                self._error = self._error or error
                self._stopping = True
            return None

        return guarded

    def every(self, period_s: float, function: Callable[[], None]) -> None:
        """Call a function about every `period_s` seconds of wall time, never sooner after its last end."""
        self._periodic.append(_Periodic(period_s, self.guard(function)))

    def tell(self, line: str) -> None:
        """Say something to the person who started the process, wherever that was."""
        self.told = line
        print(f"{self.name}: {line}", file=sys.stderr, flush=True)

    def at_end(self, function: Callable[[], None]) -> None:
        """Call a function before the process leaves the graph."""
        self._farewells.append(function)

    def stop(self, error: BaseException | None = None) -> None:
        """End `spin` after the callback that runs now; with an error, `spin` raises it."""
        self._error = self._error or error
        self._stopping = True

    @property
    def stopping(self) -> bool:
        """Whether the process is about to end."""
        return self._stopping

    def spin(self, until: Callable[[], bool] | None = None, timeout_s: float | None = None) -> bool:
        """Carry messages until the process is to stop, `until` holds, or the wall time is over.

        Returns:
            Whether `until` holds.
        """
        deadline = time.monotonic() + timeout_s if timeout_s is not None else None
        while not self._stopping:
            if until is not None and until():
                return True
            if self._stood_still():
                break
            now = time.monotonic()
            if deadline is not None and now >= deadline:
                return False
            wait = LONGEST_WAIT_S if deadline is None else min(LONGEST_WAIT_S, deadline - now)
            for periodic in self._periodic:
                wait = min(wait, periodic.run_if_due(now))
            try:
                self._executor.spin_once(timeout_sec=wait)
            except ExternalShutdownException:
                self._stopping = True
        if self._error is not None:
            raise self._error
        return False

    def _stood_still(self) -> bool:
        """Whether the process was stopped for so long that what it hears now is no longer meant for it."""
        if self._still is None or not self._still.look():
            return False
        self.stop(StoodStill(f"{self.name}: stood still for {self._still.seconds:.0f} s, starts again"))
        return True

    def drain(self, longest_s: float, quiet_s: float) -> None:
        """After `spin`: carry what has already arrived, until nothing has come for a while.

        Args:
            longest_s: The most wall time to take.
            quiet_s: Wall time without a callback after which nothing more is expected.
        """
        self._stopping = False
        deadline = time.monotonic() + longest_s
        carried, since = self._carried, time.monotonic()
        while not self._stopping and time.monotonic() < min(deadline, since + quiet_s):
            self._executor.spin_once(timeout_sec=quiet_s)
            if self._carried != carried:
                carried, since = self._carried, time.monotonic()
        self._stopping = True
        if self._error is not None:
            raise self._error

    def close(self) -> None:
        """Leave the graph; other parts learn of it at once. Can be called twice."""
        self._stopping = True
        if not rclpy.ok():
            return
        self._ending.leaves()
        for farewell in self._farewells:
            farewell()
        while self._nodes:
            self.leave(self._nodes[0])
        self._executor.shutdown()
        for waitable in self._left:
            waitable.destroy()
        self._left.clear()
        rclpy.try_shutdown()
        self._ending.left()
        for number, handler in self._handlers.items():
            signal.signal(number, handler)

    def _on_signal(self, number: int, _frame: object) -> None:
        self.ended_by = number
        self._stopping = True
        if self._ends_soon:
            self._ending.told()


class StartsAgain(RunError):
    """The process is to begin anew, in the same terminal.

    Attributes:
        again: What to add to its command line.
        status: Exit status where another process started it, and does so again.
    """

    again: tuple[str, ...] = ()
    status = 1


class StoodStill(StartsAgain):
    """The process was stopped for so long that it has to start again."""


class HandsOver(StartsAgain):
    """Somebody else is in charge now; the process begins anew to stand by for it."""

    again = ("--stand-by",)
    status = 0


class Stillness:
    """Notices that the process was stopped for a while, and told to continue.

    Attributes:
        seconds: For how long, at most (s).
    """

    def __init__(self) -> None:
        """Begin now."""
        self.seconds = 0.0
        self._looked = time.monotonic()
        self._continued = False
        signal.signal(signal.SIGCONT, self._on_continue)

    def look(self) -> bool:
        """Whether the process was stopped for long since the last look."""
        now = time.monotonic()
        gap, self._looked = now - self._looked, now
        if gap >= STILL_S:
            # a thread may go on a little before the signal comes that lets it
            for _ in range(TOLD_MS):
                if self._continued:
                    break
                time.sleep(0.001)
        continued, self._continued = self._continued, False
        if not continued or gap < STILL_S:
            return False
        self.seconds = gap
        return True

    def _on_continue(self, _number: int, _frame: object) -> None:
        self._continued = True


class _Periodic:
    def __init__(self, period_s: float, function: Callable[..., Any]) -> None:
        self.period_s = period_s
        self.function = function
        self.due = 0.0

    def run_if_due(self, now: float) -> float:
        """Run the function if its time has come; seconds until it comes again."""
        if now >= self.due:
            self.function()
            self.due = time.monotonic() + self.period_s
        return max(0.0, self.due - now)


def exit_status(main: Callable[[], int | None]) -> int:
    """Run a program's main function; its exit status: 0 done, 1 the run failed, 2 the input is wrong."""
    try:
        with display(), blaming():
            return main() or 0
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    except StartsAgain as error:
        print(error, file=sys.stderr, flush=True)
        if multiprocessing.parent_process() is None:
            disarm()
            more = [argument for argument in error.again if argument not in sys.orig_argv]
            os.execv(sys.executable, [*sys.orig_argv, *more])
        return error.status  # whoever started it starts it again
    except RunError as error:
        print(error, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 1
