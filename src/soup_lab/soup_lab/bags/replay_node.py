"""Replays a bag: publishes what was recorded, in its order and with its spacing, as if the warehouse ran."""

from __future__ import annotations

import argparse
import math
import statistics
import sys
import time
from collections import deque
from collections.abc import Iterator, Sequence

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rich.console import Console
from rosbags.interfaces import Qos, QosDurability, QosReliability
from soup_msgs import srv
from std_srvs.srv import SetBool

from soup_lab.bags.arguments import parse_replay
from soup_lab.bags.interfaces import UnknownType, is_installed, message_class
from soup_lab.bags.pace import ReplayPace
from soup_lab.bags.reader import Bag, Recorded, open_bag
from soup_lab.bags.record_node import COMPLETE
from soup_lab.bags.record_node import NAME as RECORDER
from soup_lab.bags.record_node import NODE as RECORDER_NODE
from soup_lab.progress import PLAIN_S, ProgressLine
from soup_live.diagnostics import PartsWatch
from soup_live.domain import only_world, stay_on_this_machine
from soup_live.process import Live, exit_status
from soup_live.services import Answer, serve
from soup_msgs_py import topics
from soup_msgs_py.codes import Code
from soup_msgs_py.errors import InputError
from soup_msgs_py.wire import fill_result

TICK_S = 0.001  # wall time between two looks at what is due
BURST_S = 0.02  # the longest that messages are published without a look at what others ask
TELL_S = 0.5
DEPTH = 1000
LATENESS_KEPT = 10_000  # messages
FAREWELL_S = 1.0  # wall time for everybody to get the last messages
FOUND_S, SETTLED_S = 15.0, 0.5  # wall time to find those who listen; for which nobody new was found
HEARD_S = 2.0  # wall time within which a recorder that is there has been heard of: it reports once a second


class Replay:
    """A bag that is being replayed.

    Attributes:
        published: Messages so far.
        lateness: By how much each was late (wall s), the newest of them.
    """

    def __init__(self, live: Live, node: Node, bag: Bag, kinds: dict[str, type], options: argparse.Namespace) -> None:
        """Make the publishers; `begin` begins, and offers the services.

        Args:
            live: The process.
            node: A node of it.
            bag: The bag.
            kinds: Topics to replay, with the classes of their messages.
            options: `speed`, `start`, `loop` and `paused` of the command line.
        """
        self._live, self._bag, self._loop = live, bag, options.loop
        self._node = node
        self._kinds = kinds
        self._profiles = {name: _profile(bag.qos[name]) for name in kinds}
        self._latched = frozenset(name for name, profile in self._profiles.items() if _is_latched(profile))
        self._publishers = {
            name: node.create_publisher(kinds[name], name, profile) for name, profile in self._profiles.items()
        }
        self._said: set[str] = set()  # latched topics that hold something
        self._steps: list[Answer] = []
        self.published = 0
        self.lateness: deque[float] = deque(maxlen=LATENESS_KEPT)
        self._first = bag.instant(options.start) if options.start is not None else bag.first
        self._pace = ReplayPace(options.speed, time.monotonic(), self._first, paused=options.paused)
        self._at = self._first
        self._coming: Iterator[Recorded] = iter(())
        self._next: Recorded | None = None
        self._from_start = options.start is None

    def begin(self) -> None:
        """Begin with the first message, or with the moment that was asked for."""
        if self._from_start:
            self._read_from(self._first)
            self._pace.jump(time.monotonic(), self._first)
        else:
            self._go_to(self._first)
        serve(self._live, self._node, SetBool, topics.PAUSE, self._on_pause)
        serve(self._live, self._node, srv.Step, topics.STEP, self._on_step)
        serve(self._live, self._node, srv.SetSpeed, topics.SET_SPEED, self._on_set_speed)
        serve(self._live, self._node, srv.Seek, topics.SEEK, self._on_seek)
        self._live.every(TICK_S, self._tick)

    @property
    def simulated(self) -> float:
        """The simulated time that the replay is at (s)."""
        return self._bag.simulated(self._at)

    @property
    def given_up_s(self) -> float:
        """Wall time by which the replay took longer than asked."""
        return self._pace.given_up_s

    def found(self) -> int:
        """How many subscriptions the publishers have found."""
        return sum(publisher.get_subscription_count() for publisher in self._publishers.values())

    # ---- messages -----------------------------------------------------------------------------------------

    def _tick(self) -> None:
        wall = time.monotonic()
        while not self._pace.paused and self._next is not None:
            limit = self._pace.now(wall)
            name, at, cdr = self._next
            if limit is not None and at > limit:
                break
            self._say(name, cdr)
            self._at = at
            now = time.monotonic()
            if self._pace.speed < math.inf:
                self.lateness.append(max(0.0, now - self._pace.due(at)))
                self._pace.late(now, at)
            self._advance()
            if now - wall > BURST_S:
                break
        if self._pace.reached(self._next[1] if self._next is not None else None):
            self._answer_steps()
        if self._next is None and not self._pace.paused:
            self._on_end()

    def _on_end(self) -> None:
        self._answer_steps()
        if self._loop:
            self._go_to(self._first)
            return
        # everybody gets the time to get the last messages
        deadline = time.monotonic() + FAREWELL_S
        for publisher in self._publishers.values():
            publisher.wait_for_all_acked(Duration(seconds=max(0.0, deadline - time.monotonic())))
        self._live.stop()

    def _say(self, name: str, cdr: bytes) -> None:
        self._publishers[name].publish(cdr)
        self.published += 1
        if name in self._latched:
            self._said.add(name)

    def _advance(self) -> None:
        self._next = next(self._coming, None)

    def _read_from(self, at: int) -> None:
        self._coming = self._bag.messages(self._kinds, start=at)
        self._advance()

    def _go_to(self, at: int) -> None:
        """Go on from another moment, at which all that is latched is as it was then.

        From the newest snapshot before that moment on, everything is said: whoever follows the world from its
        snapshots then knows what it would have known.
        """
        bag = self._bag
        at = min(max(at, bag.first), bag.last)
        snapshot = bag.newest([topics.SNAPSHOT], at).get(topics.SNAPSHOT)
        begin = snapshot[1] if snapshot is not None else at + 1
        held = bag.newest(self._latched, begin - 1)
        for name in self._said - held.keys():
            # what it holds had not been said yet at that moment
            self._node.destroy_publisher(self._publishers[name])
            self._publishers[name] = self._node.create_publisher(self._kinds[name], name, self._profiles[name])
        self._said &= held.keys()
        for name, _, cdr in sorted(held.values(), key=lambda message: message[1]):
            self._say(name, cdr)
        self._read_from(begin)
        while self._next is not None and self._next[1] <= at:
            self._say(self._next[0], self._next[2])
            self._advance()
        self._at = at
        self._pace.jump(time.monotonic(), at)

    # ---- services -----------------------------------------------------------------------------------------

    def _answer_steps(self) -> None:
        for answer in self._steps:
            answer.give(fill_result(srv.Step.Response(), Code.DONE, f"it is {self.simulated:g} s now"))
        self._steps.clear()

    def _on_pause(self, request: SetBool.Request, answer: Answer) -> None:
        self._pace.pause(time.monotonic(), request.data)
        self._answer_steps()
        state = "stands" if request.data else "goes on"
        answer.give(SetBool.Response(success=True, message=f"time {state} at {self.simulated:g} s"))

    def _on_step(self, request: srv.Step.Request, answer: Answer) -> None:
        if not self._pace.paused:
            why = "the replay is not paused; call /world/pause first"
            answer.give(fill_result(srv.Step.Response(), Code.MOVING, why))
        elif not 0.0 < request.seconds < math.inf:
            why = f"found {request.seconds:g} s; allowed: a number above 0"
            answer.give(fill_result(srv.Step.Response(), Code.INVALID, why))
        else:
            until = self._bag.instant(self.simulated + request.seconds)
            self._steps.append(answer)
            self._pace.step(time.monotonic(), max(until, self._at))

    def _on_set_speed(self, request: srv.SetSpeed.Request, answer: Answer) -> None:
        factor = request.real_time_factor
        if not factor > 0.0:
            why = f"found {factor:g} times the recorded speed; allowed: a number above 0, inf for no limit"
            answer.give(fill_result(srv.SetSpeed.Response(), Code.INVALID, why))
            return
        self._pace.set_speed(time.monotonic(), factor)
        answer.give(fill_result(srv.SetSpeed.Response(), Code.DONE, f"{factor:g} times the recorded speed"))

    def _on_seek(self, request: srv.Seek.Request, answer: Answer) -> None:
        first, last = self._bag.simulated(self._bag.first), self._bag.simulated(self._bag.last)
        if not first <= request.time <= last:
            why = f"found {request.time:g} s; allowed: {first:g} to {last:g}, which the bag holds"
            answer.give(fill_result(srv.Seek.Response(), Code.INVALID, why))
            return
        self._answer_steps()
        self._go_to(self._bag.instant(request.time))
        answer.give(fill_result(srv.Seek.Response(), Code.DONE, f"it is {self.simulated:g} s now"))


def _is_latched(profile: QoSProfile) -> bool:
    return profile.durability is DurabilityPolicy.TRANSIENT_LOCAL


def _profile(recorded: Qos | None) -> QoSProfile:
    """The quality of service that a topic was recorded with."""
    reliable = recorded is None or recorded.reliability is not QosReliability.BEST_EFFORT
    latched = recorded is not None and recorded.durability is QosDurability.TRANSIENT_LOCAL
    return QoSProfile(
        depth=max(recorded.depth, 1) if latched and recorded is not None else DEPTH,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


def told(replay: Replay) -> str:
    """Where a replay is now."""
    return f"{replay.simulated:,.1f} s · {replay.published:,} messages{lateness(replay)}"


def lateness(replay: Replay) -> str:
    """How well the replay keeps its pace."""
    late = replay.lateness
    text = f" · median {statistics.median(late) * 1e3:.1f} ms late" if late else ""
    return text + (f" · slower than asked by {replay.given_up_s:.1f} s" if replay.given_up_s else "")


def main(argv: Sequence[str] | None = None) -> int:
    """Replay a bag; the exit status."""
    options = parse_replay(argv)
    return exit_status(lambda: replay(options))


def replay(options: argparse.Namespace) -> None:
    """Replay as the command line says.

    Raises:
        InputError: The bag, or what was asked for, is not in order; or a world runs in this domain.
    """
    console = Console()
    with open_bag(options.folder.absolute()) as bag:
        kinds = {
            name: _class_of(bag, name)
            for name in bag.kinds
            if bag.counts[name] and (options.topics is None or options.topics.fullmatch(name))
        }
        if not kinds:
            raise InputError(
                "--topics", "", "no topic of the bag that matches", ", ".join(sorted(bag.kinds)[:5]) + " ..."
            )
        last = bag.simulated(bag.last)
        if options.start is not None and options.start > last:
            raise InputError("--start", "", f"{options.start:g} s", f"at most {last:g} s, where the bag ends")
        stay_on_this_machine()
        with Live("replay") as live:
            node = live.node("replay")
            with only_world(live, node):
                work = Replay(live, node, bag, kinds, options)
                find_listeners(live, node, work)
                line = ProgressLine(console, "looks for listeners", PLAIN_S)
                live.every(TELL_S, lambda: line.tell(told(work)) if line.due else None)
                work.begin()
                try:
                    live.spin()
                finally:
                    line.close()
    console.print(f"{work.published:,} messages up to {work.simulated:,.1f} s{lateness(work)}", highlight=False)


def _class_of(bag: Bag, name: str) -> type:
    allowed = "a type that is installed (or --topics without it)"
    try:
        found = message_class(bag.kinds[name])
    except UnknownType as error:
        raise InputError(bag.folder, name, str(error), allowed) from error
    if not is_installed(bag.kinds[name], bag.definitions[name]):
        raise InputError(bag.folder, name, f"{bag.kinds[name]} of another version than what is installed", allowed)
    return found


def find_listeners(live: Live, node: Node, work: Replay) -> None:
    """Wait until whoever listens has been found, so that the first messages reach everybody.

    That a publisher knows of a subscription does not say that the subscription knows of it, too. A recorder, which is
    to lack nothing, says so itself.
    """
    watch = PartsWatch(live, node)
    began = since = time.time()
    before = -1

    def settled() -> bool:
        nonlocal since, before
        now, found = time.time(), work.found()
        if found != before:
            since, before = now, found
        if now - since <= SETTLED_S or now - began <= HEARD_S:
            return False
        records = RECORDER in watch.at_work or RECORDER in watch.waiting or RECORDER_NODE in node.get_node_names()
        complete = float(watch.at_work.get(RECORDER, {}).get(COMPLETE, "0"))
        return not records or complete > since + SETTLED_S

    live.spin(settled, FOUND_S)


if __name__ == "__main__":
    sys.exit(main())
