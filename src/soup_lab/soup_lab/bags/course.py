"""The course of one run, as its bag tells it: where it began, all events since, where everything was meanwhile."""

from __future__ import annotations

import math
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from rosgraph_msgs.msg import Clock
from soup_msgs import msg

from soup_lab.bags.interfaces import is_installed
from soup_lab.bags.reader import Bag
from soup_msgs_py import topics
from soup_msgs_py.errors import InputError
from soup_msgs_py.messages import Bots, Buckets, Event, Snapshot
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.wire import Announcement, MalformedMessage, from_cdr, from_ros, from_stamp, read_cdr

POSES_EVERY_S = 1.0  # simulated seconds between two of the looks at all places that are kept


@dataclass(frozen=True, slots=True)
class Sight:
    """A snapshot in the bag: the last event that it contains, its simulated time (s), where it is in the bag (ns)."""

    sequence: int
    time: float
    at: int


@dataclass
class Course:
    """What a bag tells about one run.

    A world that was killed and restored goes on from an earlier moment: what had happened after that, did not happen.
    A bag may end, begin or be asked for in the middle of an instant: its topics then know different things. `start` and
    `end` are the first and the last snapshot between which all events are there; beyond `end` nothing can be judged.
    """

    announcement: Announcement
    start: Snapshot | None = None
    end: Snapshot | None = None
    events: dict[int, Event] = field(default_factory=dict)
    sights: list[Sight] = field(default_factory=list)
    poses: list[tuple[Bots, Buckets]] = field(default_factory=list)
    places: list[tuple[float, Any, Any]] = field(default_factory=list)  # time, (bots, 2) places (m), (bots,) states
    last: float = 0.0
    wall_seconds: float = 0.0
    bounds: tuple[float, float] | None = None  # of the stations and of the fleet, as the world told (words/s)
    latency_s: float = 0.0
    parts: dict[str, dict[str, str]] = field(default_factory=dict)  # what processes at work last reported, by name
    restarts: int = 0
    senseless: Counter[str] = field(default_factory=Counter)  # messages that make no sense and are left out, by topic
    foreign: list[str] = field(default_factory=list)  # topics of another version, which are left out
    _undecided: set[int] = field(default_factory=set)  # events at the instant that a restored world goes on from

    @property
    def known(self) -> int:
        """The last event of which the bag tells that it happened."""
        return max([0, *self.events, *(sight.sequence for sight in self.sights)])

    @property
    def missing(self) -> int:
        """Events that the bag lacks, of those between its beginning and the last one that it knows of."""
        first = min(self.events, default=self.known + 1) if self.start is None else self.start.sequence + 1
        return self.known - first + 1 - sum(number >= first for number in self.events)

    @property
    def gap_at(self) -> float | None:
        """When the first event happened before which others are missing (s); None without any."""
        complete = self._complete()
        return min((event.time for number, event in self.events.items() if number > complete), default=None)

    def goes_on_from(self, announcement: Announcement) -> None:
        """The world was started again."""
        self.announcement, self.restarts = announcement, self.restarts + 1
        time = announcement.time
        self.events = {number: event for number, event in self.events.items() if event.time <= time}
        self.sights = [sight for sight in self.sights if sight.time <= time]
        self.poses = [pose for pose in self.poses if pose[0].time <= time]
        self.places = [place for place in self.places if place[0] <= time]
        self.last = time
        # of those at that very instant, the first snapshot after it tells which have happened
        self._undecided = {number for number, event in self.events.items() if event.time == time}

    def take_event(self, event: Event) -> None:
        """Something happened."""
        self._undecided.discard(event.sequence)
        self.events[event.sequence] = event
        self.last = max(self.last, event.time)

    def take_sight(self, sight: Sight) -> None:
        """A snapshot came."""
        for number in self._undecided:
            if number > sight.sequence:
                del self.events[number]
        if self._undecided:
            self.sights = [earlier for earlier in self.sights if earlier.sequence <= sight.sequence]
            self._undecided = set()
        self.sights.append(sight)

    def choose_snapshots(self, bag: Bag) -> None:
        """Find the first and the last snapshot between which all events are there."""
        # a recorder that began while events happened may lack some between its first snapshot and its first event
        least = min(self.events, default=1) - 1
        self.start = self._first_that_makes_sense(bag, [sight for sight in self.sights if sight.sequence >= least])
        complete = self._complete()
        self.end = self._first_that_makes_sense(
            bag, [sight for sight in reversed(self.sights) if sight.sequence <= complete]
        )

    def _complete(self) -> int:
        """The last event up to which, from the first snapshot on, none is missing."""
        number = 0 if self.start is None else self.start.sequence
        while number + 1 in self.events:
            number += 1
        return number

    def _first_that_makes_sense(self, bag: Bag, sights: list[Sight]) -> Snapshot | None:
        for sight in sights:
            for _, _, cdr in bag.messages([topics.SNAPSHOT], sight.at, sight.at + 1):
                try:
                    snapshot = from_cdr(cdr, msg.Snapshot)
                except MalformedMessage:
                    continue
                if snapshot.sequence == sight.sequence:
                    return snapshot
        return None


def read_course(bag: Bag, stop: float = math.inf) -> Course:
    """Read a run from a bag. Messages that make no sense are left out, and counted.

    Args:
        bag: The bag.
        stop: The simulated time to end at (s).

    Raises:
        InputError: The bag is not one of a warehouse.
    """
    there = [name for name in _KINDS if name in bag.kinds]
    foreign = [name for name in there if not is_installed(bag.kinds[name], bag.definitions[name])]
    for name in (topics.SCENARIO, topics.EVENTS):
        if name not in bag.kinds:
            raise InputError(bag.folder, "", f"a bag without {name}", "a bag of a warehouse")
        if name in foreign:
            found = f"{bag.kinds[name]} of another version than what is installed"
            raise InputError(bag.folder, name, found, "a bag that this version has recorded")
    course: Course | None = None
    buckets: Buckets | None = None
    senseless: Counter[str] = Counter()
    names = [name for name in there if name not in foreign]
    runs = _runs(bag)
    for name, at, cdr in bag.messages(names):
        try:
            message = read_cdr(cdr, _KINDS[name])
            if name == topics.SCENARIO:
                announcement = from_ros(message)
                if course is None:
                    course = Course(announcement, senseless=senseless, foreign=foreign)
                elif announcement.run != course.announcement.run:
                    course.goes_on_from(announcement)
            elif course is None:
                continue
            elif name in _OF_A_RUN and message.run not in runs:
                raise MalformedMessage(f"run {message.run}, of which the bag does not tell")
            elif name == topics.DIAGNOSTICS:
                _note_parts(course, message)
            elif name == topics.CLOCK:
                course.last = max(course.last, min(from_stamp(message.clock), stop))
            elif name == topics.STATISTICS:
                course.wall_seconds, course.latency_s = message.wall_seconds, message.latency_s
                course.bounds = message.word_rate_bound, message.fleet_rate_bound
                course.last = max(course.last, min(message.sim_seconds, stop))
            elif name == topics.SNAPSHOT:
                sight = Sight(message.sequence, from_stamp(message.header.stamp), at)
                if sight.time <= stop:
                    course.take_sight(sight)
            elif name == topics.BUCKETS:
                buckets = from_ros(message)
            elif name == topics.BOTS:
                _take_bots(course, from_ros(message), buckets, stop)
            else:
                event = _checked(from_ros(message), course.announcement.scenario)
                if event.time <= stop:
                    course.take_event(event)
        except MalformedMessage as error:
            if course is None:
                raise InputError(
                    bag.folder, name, f"a message that makes no sense ({error})", "a warehouse's bag"
                ) from error
            senseless[name] += 1
    if course is None:
        raise InputError(bag.folder, topics.SCENARIO, "no message", "a bag of a warehouse")
    course.choose_snapshots(bag)
    return course


def _runs(bag: Bag) -> set[int]:
    """All runs of a world that the bag tells of: one more each time that it was started again."""
    found = set()
    for _, _, cdr in bag.messages([topics.SCENARIO]):
        with suppress(MalformedMessage):
            found.add(read_cdr(cdr, msg.Scenario).run)
    return found


def _take_bots(course: Course, bots: Bots, buckets: Buckets | None, stop: float) -> None:
    if len(bots.x) != course.announcement.scenario.bots:
        raise MalformedMessage(f"places of {len(bots.x)} bots")
    if bots.time > stop:
        return
    course.places.append((bots.time, np.column_stack([bots.x, bots.y]), bots.state))
    due = not course.poses or bots.time >= course.poses[-1][0].time + POSES_EVERY_S
    if buckets is not None and due and buckets.time == bots.time:
        course.poses.append((bots, buckets))


def _checked(event: Event, scenario: Scenario) -> Event:
    """An event, unless it names a bot or a station that the warehouse has not."""
    stations = scenario.word_station_count + scenario.letter_station_count
    if not (event.bot < scenario.bots and event.station < stations):
        raise MalformedMessage(f"bot {event.bot} at station {event.station}: there is none")
    return event


def _note_parts(course: Course, report: DiagnosticArray) -> None:
    for status in report.status:
        if status.level == status.OK:
            # the newest last: of two that followed each other in a role, it is the one that counts
            course.parts.pop(status.name, None)
            course.parts[status.name] = {pair.key: pair.value for pair in status.values}


_OF_A_RUN = frozenset({topics.EVENTS, topics.SNAPSHOT, topics.BOTS, topics.BUCKETS})
_KINDS: dict[str, Any] = {
    topics.SCENARIO: msg.Scenario,
    topics.SNAPSHOT: msg.Snapshot,
    topics.EVENTS: msg.Event,
    topics.BOTS: msg.Bots,
    topics.BUCKETS: msg.Buckets,
    topics.STATISTICS: msg.Statistics,
    topics.CLOCK: Clock,
    topics.DIAGNOSTICS: DiagnosticArray,
}
