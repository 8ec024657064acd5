"""Records a live graph: all its topics, raw as they come, into a rosbag2 bag."""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rich.console import Console
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime

from soup_lab.bags.arguments import parse_record
from soup_lab.bags.gaps import Gaps
from soup_lab.bags.interfaces import Definitions, UnknownType, message_class
from soup_lab.bags.repair import go_on, is_cut_off
from soup_lab.bags.writer import NEVER, BagWriter, Topic
from soup_lab.progress import PLAIN_S, ProgressLine
from soup_live.diagnostics import Report
from soup_live.domain import stay_on_this_machine
from soup_live.process import Live, exit_status
from soup_live.qos import EVERY_ONE
from soup_live.raw import RawSubscription
from soup_msgs_py import topics
from soup_msgs_py.errors import InputError, RunError

NAME, NODE = "bag recorder", "bag_recorder"
# Topics on which things happen as soon as a warehouse begins, and of which a bag should lack nothing: listening before
# there is anybody to speak is the only way to hear the first word.
FROM_THE_FIRST = {
    topics.EVENTS: "soup_msgs/msg/Event",
    topics.REPLIES: "soup_msgs/msg/BotReply",
    topics.REQUESTS: "soup_msgs/msg/BotRequest",
}
OF_ALL = (topics.DIAGNOSTICS, "/parameter_events")  # the recorder itself speaks there, before anybody else may
COMPLETE = "complete_at"  # the value that says when all topics of the graph were being recorded (s since 1970)
LOOK_S, CALM_LOOK_S = 0.25, 0.5  # wall time between two looks for new topics: while some come, and later
CALM_S = 1.0  # without a new topic; then all that is there is being recorded
FLUSH_S = 0.5  # wall time whose messages a kill can cost
TELL_S = 0.5
DRAIN_S, QUIET_S = 1.5, 0.4  # at the end, for what has arrived already, also on a busy machine
DEPTH = 10_000  # messages that may wait to be written
MIB = 1 << 20


@dataclass
class Stream:
    """What is known of one recorded topic."""

    number: int | None = None  # in the bag; a topic gets into it with its first message
    topic: Topic | None = None
    gaps: Gaps = field(default_factory=Gaps)
    expected: int = 0  # publishers that the graph shows
    matched: int = 0  # publishers that are heard now
    publishers: int = 0  # that have ever been heard
    lost: int = 0  # messages that DDS says it lost

    @property
    def dropped(self) -> int:
        """Messages that are missing, at least."""
        return max(self.lost, self.gaps.count(self.publishers))


class Recorder:
    """Records what it finds, from the moment at which it finds it."""

    def __init__(self, live: Live, writer: BagWriter, wanted: Callable[[str], bool], limits: Limits) -> None:
        """Begin to look for topics.

        Args:
            live: The process.
            writer: The bag.
            wanted: Whether to record a topic.
            limits: When to begin a new file, and when to stop.
        """
        self._live, self._writer, self._wanted, self._limits = live, writer, wanted, limits
        self._node = live.node(NODE)
        self._report = Report(live, self._node)
        self._definitions = Definitions()
        self._streams: dict[str, Stream] = {topic.name: Stream(k, topic) for k, topic in enumerate(writer.topics)}
        self._heard: set[str] = set()
        self._subscriptions: list[RawSubscription] = []
        self._passed_over: dict[str, str] = {}
        self._changed = time.monotonic()
        self._look_due = 0.0
        self._complete = 0.0  # wall time at which all that the graph had was being recorded
        self._last = 0
        for name, kind in FROM_THE_FIRST.items():
            if wanted(name):
                self._begin(name, kind, EVERY_ONE)
        live.every(LOOK_S, self._look)
        live.every(FLUSH_S, self._keep)

    @property
    def dropped(self) -> int:
        """Messages that are missing, at least."""
        return sum(stream.dropped for stream in self._streams.values())

    def finish(self) -> None:
        """Take what still waits, note what is missing, and make the bag whole."""
        for subscription in self._subscriptions:
            subscription.take_rest()
        dropped = {name: stream.dropped for name, stream in self._streams.items() if stream.dropped}
        self._writer.notes = {"dropped": json.dumps(dropped), "not_recorded": json.dumps(self._passed_over)}
        self._writer.close()

    # ---- finding topics -----------------------------------------------------------------------------------

    def _look(self) -> None:
        now = time.monotonic()
        if now < self._look_due:
            return
        found = self._node.get_topic_names_and_types()
        new = [(self._qos_of(name), name, kinds) for name, kinds in found if self._is_new(name)]
        # latched ones first: what they hold comes at once, before what changes it
        for profile, name, kinds in sorted(new, key=lambda entry: not _is_latched(entry[0])):
            if profile is not None:
                self._changed = now
                self._begin(name, kinds[0], profile)
        # they were begun when nobody else spoke on them yet; to count for all topics would cost too much
        for name in (FROM_THE_FIRST.keys() | set(OF_ALL)) & self._streams.keys():
            self._streams[name].expected = self._node.count_publishers(name)
        calm = now - self._changed > CALM_S
        self._look_due = now + (CALM_LOOK_S if calm else 0.0)
        if calm and all(stream.matched >= stream.expected for stream in self._streams.values()):
            self._complete = time.time()
        if self._complete:
            self._report.works()
        else:
            self._report.waits("looks for topics")
        self._tell_values()

    def _is_new(self, name: str) -> bool:
        hidden = any(part.startswith("_") for part in name.split("/"))
        return not hidden and name not in self._heard and name not in self._passed_over and self._wanted(name)

    def _qos_of(self, name: str) -> QoSProfile | None:
        """What suits all publishers of a topic; None without any."""
        offers = [info.qos_profile for info in self._node.get_publishers_info_by_topic(name)]
        if not offers:
            return None
        reliable = all(offer.reliability is ReliabilityPolicy.RELIABLE for offer in offers)
        latched = all(offer.durability is DurabilityPolicy.TRANSIENT_LOCAL for offer in offers)
        return QoSProfile(
            depth=DEPTH,
            history=HistoryPolicy.KEEP_LAST,
            reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
            durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        )

    def _begin(self, name: str, kind: str, profile: QoSProfile) -> None:
        try:
            cls = message_class(kind)
            definition, hashed = self._definitions.of(kind)
        except UnknownType as error:
            self._passed_over[name] = str(error)
            print(f"{self._live.name}: {name} is not recorded: its type is {error}", file=sys.stderr, flush=True)
            return
        self._heard.add(name)
        stream = self._streams.setdefault(name, Stream())
        if stream.number is None:
            stream.topic = Topic(name, kind, definition, hashed, offered(profile))
        stream.expected = self._node.count_publishers(name)

        def on_matched(info: Any) -> None:
            stream.matched, stream.publishers = info.current_count, info.total_count

        def on_lost(info: Any) -> None:
            stream.lost += info.total_count_change

        events = SubscriptionEventCallbacks(
            matched=self._live.guard(on_matched), message_lost=self._live.guard(on_lost)
        )
        self._subscriptions.append(
            RawSubscription(
                self._live, self._node, cls, name, lambda cdr, number: self._take(stream, cdr, number), profile, events
            )
        )

    # ---- messages -----------------------------------------------------------------------------------------

    def _take(self, stream: Stream, cdr: bytes, number: int) -> None:
        self._last = max(self._last, time.time_ns())
        stream.gaps.take(number)
        try:
            if stream.number is None:
                assert stream.topic is not None
                stream.number = self._writer.add(stream.topic)
            self._writer.write(stream.number, self._last, cdr)
        except OSError as error:
            self._live.stop(RunError(f"{self._writer.folder}: {error.strerror}"))

    def _keep(self) -> None:
        """Hand over to the disk what has come; see to it that neither the file nor the disk gets too full."""
        writer, limits = self._writer, self._limits
        try:
            writer.flush()
            first = writer.file_first
            old = first < NEVER and time.time_ns() - first > limits.file_s * 1e9
            if old or writer.file_size > limits.file_bytes:
                writer.split()
        except OSError as error:
            self._live.stop(RunError(f"{writer.folder}: {error.strerror}"))
            return
        free = shutil.disk_usage(writer.folder).free
        if free < limits.free_bytes:
            self._live.stop(RunError(f"{writer.folder}: ended, since only {free / MIB:,.0f} MiB of the disk are free"))

    def _tell_values(self) -> None:
        writer = self._writer
        values = {
            "messages": writer.messages,
            "bytes": writer.size,
            "dropped": self.dropped,
            "topics": len(self._heard),
            COMPLETE: self._complete,
        }
        self._report.values = {name: str(value) for name, value in values.items()}


@dataclass(frozen=True)
class Limits:
    """When to begin a new file (bytes; s of wall time), and how much of the disk to leave free (bytes)."""

    file_bytes: float
    file_s: float
    free_bytes: float


class Progress:
    """Tells how the recording goes."""

    def __init__(self, console: Console, writer: BagWriter, recorder: Recorder) -> None:
        """Begin."""
        self._writer, self._recorder = writer, recorder
        self._line = ProgressLine(console, "looks for topics", PLAIN_S)
        self._before = (time.monotonic(), 0)

    def __call__(self) -> None:
        """Show how much there is now."""
        if not self._line.due:
            return
        now, size = time.monotonic(), self._writer.size
        since, before = self._before
        self._before = now, size
        rate = (size - before) / max(now - since, 1e-9) / MIB
        self._line.tell(
            f"{self._writer.messages:,} messages · {size / MIB:,.1f} MiB · {rate:.2f} MiB/s · "
            f"{len(self._writer.topics)} topics · dropped {self._recorder.dropped}"
        )

    def close(self) -> None:
        """Take the line away."""
        self._line.close()


def _is_latched(profile: QoSProfile | None) -> bool:
    return profile is not None and profile.durability is DurabilityPolicy.TRANSIENT_LOCAL


def offered(profile: QoSProfile) -> Qos:
    """A profile as bags hold it; how deep a publisher's history is, nobody can see from outside."""
    nothing = QosTime(0, 0)
    reliable = profile.reliability is ReliabilityPolicy.RELIABLE
    return Qos(
        QosHistory.KEEP_LAST,
        1 if _is_latched(profile) else DEPTH,
        QosReliability.RELIABLE if reliable else QosReliability.BEST_EFFORT,
        QosDurability.TRANSIENT_LOCAL if _is_latched(profile) else QosDurability.VOLATILE,
        nothing, nothing, QosLiveliness.AUTOMATIC, nothing, False,
    )  # fmt: skip


def main(argv: Sequence[str] | None = None) -> int:
    """Record until a signal comes; the exit status."""
    options = parse_record(argv)
    return exit_status(lambda: record(options))


def record(options: argparse.Namespace) -> None:
    """Record as the command line says.

    Raises:
        InputError: The folder is there already, or the disk is full before it begins.
        RunError: The disk became full.
    """
    folder: Path = options.folder.absolute()
    compress = options.compression == "zstd"
    limits = Limits(options.split_mib * MIB, options.split_s or float("inf"), options.leave_free_mib * MIB)
    check_room(folder, limits.free_bytes)
    if options.go_on and is_cut_off(folder):
        writer, found = go_on(folder, compress=compress)
        print(f"{folder}: {found}", file=sys.stderr, flush=True)
        writer.split()
    else:
        writer = BagWriter.create(folder, compress=compress)

    def wanted(name: str) -> bool:
        chosen = options.topics is None or options.topics.fullmatch(name)
        return bool(chosen and not (options.exclude and options.exclude.fullmatch(name)))

    stay_on_this_machine()
    console = Console()
    try:
        with Live(NAME, ends_soon=False) as live:
            recorder = Recorder(live, writer, wanted, limits)
            show = Progress(console, writer, recorder)
            live.every(TELL_S, show)
            try:
                live.spin()
                live.drain(DRAIN_S, QUIET_S)
            finally:
                show.close()
                finish(recorder, writer)
    except BaseException:
        writer.abandon()
        raise
    console.print(
        f"{folder}: {writer.messages:,} messages on {len(writer.topics)} topics, {writer.size / MIB:,.1f} MiB, "
        f"dropped {recorder.dropped}",
        highlight=False,
    )


def finish(recorder: Recorder, writer: BagWriter) -> None:
    """Make the bag whole.

    Raises:
        RunError: There is no room for its end.
    """
    try:
        recorder.finish()
    except OSError as error:
        writer.abandon()
        why = f"{error.strerror}; the bag lacks its end and is repaired when it is opened"
        raise RunError(f"{writer.folder}: {why}") from error


def check_room(folder: Path, least: float) -> None:
    """Make sure that the disk has room for a bag.

    Raises:
        InputError: There is no such disk, or it is full.
    """
    try:
        free = shutil.disk_usage(folder.parent).free
    except OSError as error:
        raise InputError(folder, "", error.strerror or error, "a new folder in one that exists") from error
    if free < least:
        found = f"{free / MIB:,.0f} MiB of free disk"
        raise InputError(folder, "", found, f"at least {least / MIB:,.0f} MiB (--leave-free-mib)")


if __name__ == "__main__":
    sys.exit(main())
