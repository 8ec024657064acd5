"""The figures of a run, computed anew from the messages of its bag."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from rosgraph_msgs.msg import Clock
from soup_msgs import msg

from soup_lab.bag_reader import Bag
from soup_msgs_py import topics
from soup_msgs_py.codes import BotState, EventType
from soup_msgs_py.errors import InputError
from soup_msgs_py.messages import Bots, Buckets, Event, Snapshot
from soup_msgs_py.policies import policies_of
from soup_msgs_py.wire import Announcement, MalformedMessage, from_ros, from_stamp, read_cdr
from soup_sim.statistics import Statistics
from soup_sim.summary import make_summary
from soup_sim.validate import EPSILON, Judge

JUDGED_EVERY_S = 1.0  # simulated seconds between two looks of the judge at all places
# Figures that events do not tell. They come from places and states, which a bag holds several times a second.
MEASURED = (
    "wall_seconds", "real_time_factor", "distance_total_m", "distance_mean_m", "bot_idle_fraction",
    "word_station_idle_fraction", "letter_station_idle_fraction",
)  # fmt: skip


@dataclass
class Course:
    """What a bag tells about one run: where it began, all events since, where everything was meanwhile.

    A world that was killed and restored goes on from an earlier moment: what had happened after that, did not happen.
    """

    announcement: Announcement
    start: Snapshot | None = None
    end: Snapshot | None = None
    events: dict[int, Event] = field(default_factory=dict)
    poses: list[tuple[Bots, Buckets]] = field(default_factory=list)
    places: list[tuple[float, Any, Any]] = field(default_factory=list)  # time, (bots, 2) places (m), (bots,) states
    last: float = 0.0
    wall_seconds: float = 0.0
    bound: float = math.inf
    parts: dict[str, dict[str, str]] = field(default_factory=dict)  # what processes at work last reported, by name
    restarts: int = 0

    @property
    def missing(self) -> int:
        """Events that the bag lacks, of those between its beginning and its last one."""
        if not self.events:
            return 0
        first = min(self.events) if self.start is None else self.start.sequence + 1
        return max(self.events) - first + 1 - sum(number >= first for number in self.events)

    def goes_on_from(self, announcement: Announcement) -> None:
        """The world was started again."""
        self.announcement, self.restarts = announcement, self.restarts + 1
        time = announcement.time
        self.events = {number: event for number, event in self.events.items() if event.time <= time}
        self.poses = [pose for pose in self.poses if pose[0].time <= time]
        self.places = [place for place in self.places if place[0] <= time]
        self.last = time


def read_course(bag: Bag, stop: float = math.inf) -> Course:
    """Read a run from a bag.

    Args:
        bag: The bag.
        stop: The simulated time to end at (s).

    Raises:
        InputError: The bag is not one of a warehouse.
    """
    for name in (topics.SCENARIO, topics.EVENTS):
        if name not in bag.kinds:
            raise InputError(bag.folder, "", f"a bag without {name}", "a bag of a warehouse")
    course: Course | None = None
    buckets: Buckets | None = None
    names = [name for name in _KINDS if name in bag.kinds]
    for name, _, cdr in bag.messages(names):
        try:
            message = read_cdr(cdr, _KINDS[name])
            if name == topics.SCENARIO:
                announcement = from_ros(message)
                if course is None:
                    course = Course(announcement)
                elif announcement.run != course.announcement.run:
                    course.goes_on_from(announcement)
                continue
            if course is None:
                continue
            if name == topics.DIAGNOSTICS:
                _note_parts(course, message)
            elif name == topics.CLOCK:
                course.last = max(course.last, min(from_stamp(message.clock), stop))
            elif name == topics.STATISTICS:
                course.wall_seconds, course.bound = message.wall_seconds, message.word_rate_bound
                course.last = max(course.last, min(message.sim_seconds, stop))
            elif name == topics.BUCKETS:
                buckets = from_ros(message)
            else:
                _take(course, from_ros(message), buckets, stop)
        except MalformedMessage as error:
            raise InputError(
                bag.folder, name, f"a message that makes no sense ({error})", "a warehouse's bag"
            ) from error
    if course is None:
        raise InputError(bag.folder, topics.SCENARIO, "no message", "a bag of a warehouse")
    return course


def _take(course: Course, message: Any, buckets: Buckets | None, stop: float) -> None:
    if message.time > stop:
        return
    if isinstance(message, Event):
        course.events[message.sequence] = message
        course.last = max(course.last, message.time)
    elif isinstance(message, Snapshot):
        # a recorder that began while events happened may lack some between its first snapshot and its first event
        if course.start is None or course.start.sequence < next(iter(course.events), 0) - 1:
            course.start = message
        course.end = message
    elif isinstance(message, Bots):
        course.places.append((message.time, np.column_stack([message.x, message.y]), message.state))
        due = not course.poses or message.time >= course.poses[-1][0].time + JUDGED_EVERY_S
        if buckets is not None and due and buckets.time == message.time:
            course.poses.append((message, buckets))


def _note_parts(course: Course, report: DiagnosticArray) -> None:
    for status in report.status:
        if status.level == status.OK:
            # the newest last: of two that followed each other in a role, it is the one that counts
            course.parts.pop(status.name, None)
            course.parts[status.name] = {pair.key: pair.value for pair in status.values}


def summarize(course: Course, warmup_s: float | None = None) -> dict[str, Any]:
    """The summary of a run that a bag holds.

    Args:
        course: What the bag tells.
        warmup_s: Rates and counts cover what comes after this simulated time; without: as the run itself said.
    """
    announcement = course.announcement
    scenario = announcement.scenario
    warmup = announcement.warmup_s if warmup_s is None else warmup_s
    events = [event for _, event in sorted(course.events.items())]
    if course.start is None or course.end is None:
        raise InputError("bag", topics.SNAPSHOT, "no message", "a bag of a warehouse")
    known = course.start.sequence
    inventory = sum(sum(content.values()) for content in course.start.contents)
    inventory -= sum(_change(event, scenario.word_station_count) for event in events if event.sequence <= known)
    figures = Statistics(scenario, 1.0, inventory)
    figures.bound = course.bound
    nowhere = np.zeros(scenario.bots)
    begun = warmup <= 0.0
    for event in events:
        if not begun and event.time >= warmup:  # the world begins to count before all else at that instant
            figures.begin_window(warmup, nowhere)
            begun = True
        figures.count(event)
    if not begun:
        figures.begin_window(min(warmup, course.last), nowhere)
    driven, idle = _driven(course, warmup)
    values = figures.figures(course.last, np.full(scenario.bots, driven / scenario.bots))
    seconds = course.last - warmup
    stations = scenario.word_station_count, scenario.letter_station_count
    busy = _busy(events, course, warmup)
    values |= {
        "bot_idle_fraction": idle,
        "word_station_idle_fraction": _idle(busy[0], stations[0], seconds),
        "letter_station_idle_fraction": _idle(busy[1], stations[1], seconds),
        "wall_seconds": course.wall_seconds,
        "real_time_factor": course.last / course.wall_seconds if course.wall_seconds > 0 else 0.0,
    }
    policies = policies_of(course.parts)
    return make_summary(values, scenario, policies, announcement.seed, _violations(course, events))


def _change(event: Event, word_stations: int) -> int:
    """By how much an event changes what all buckets hold together (tiles)."""
    if event.type is not EventType.TRANSFERRED:
        return 0
    return -1 if event.station < word_stations else 1


def _driven(course: Course, warmup: float) -> tuple[float, float]:
    """How far all bots drove after the warm-up (m), and for what share of that time they were idle."""
    distance = idle = seconds = 0.0
    before: tuple[float, Any, Any] | None = None
    for time, places, states in course.places:
        if time >= warmup and before is not None and len(before[1]) == len(places):
            lasted = time - before[0]
            distance += float(np.hypot(*(places - before[1]).T).sum())
            idle += float((before[2] == BotState.FREE).mean()) * lasted
            seconds += lasted
        before = (time, places, states)
    return distance, idle / seconds if seconds > 0 else 0.0


def _busy(events: Iterable[Event], course: Course, warmup: float) -> list[float]:
    """How long all word and all letter stations were at work after the warm-up (s)."""
    scenario = course.announcement.scenario
    words = scenario.word_station
    busy = [0.0, 0.0]
    for event in events:
        at_letters = event.station >= scenario.word_station_count
        took = 0.0
        if event.type is EventType.TRANSFERRED:
            took = scenario.letter_station.transfer_s if at_letters else words.transfer_s
        elif event.type is EventType.WORD_CLEARED:
            took = words.clear_s
        busy[at_letters] += min(took, max(0.0, event.time - warmup))
    return busy


def _idle(busy: float, stations: int, seconds: float) -> float:
    return 1.0 - busy / seconds / stations if seconds > 0 else 1.0


def _violations(course: Course, events: list[Event]) -> int:
    """What the judge says of the run."""
    announcement, start, end = course.announcement, course.start, course.end
    assert start is not None and end is not None
    # places of buckets travel as 32-bit numbers
    layout = announcement.layout
    rounding = float(2.0 * np.spacing(np.float32(max(layout.width_m, layout.height_m))))
    judge = Judge(announcement.scenario, layout, start, rounding_m=max(rounding, EPSILON))
    # of several things at one instant, a bag does not tell which came before the places were told
    instants = {event.time for event in course.events.values()}
    poses = iter([pose for pose in course.poses if pose[0].time >= start.time and pose[0].time not in instants])
    pose = next(poses, None)
    for event in events:
        while pose is not None and pose[0].time < event.time:
            judge.poses(*pose)
            pose = next(poses, None)
        if start.sequence < event.sequence <= end.sequence:
            judge.event(event)
    while pose is not None and pose[0].time <= end.time:
        judge.poses(*pose)
        pose = next(poses, None)
    judge.finish(end)
    return judge.count


def differences(ours: dict[str, Any], theirs: dict[str, Any]) -> list[tuple[str, Any, Any, bool]]:
    """Where two summaries differ.

    Returns:
        Key, value here, value there, and whether the key is one that both count from the same events.
    """
    found = []
    for key, value in ours.items():
        other = theirs.get(key)
        if not _alike(value, other):
            found.append((key, value, other, key not in MEASURED))
    return found


def _alike(value: Any, other: Any) -> bool:
    if isinstance(value, int | float) and isinstance(other, int | float):
        return math.isclose(value, other, rel_tol=1e-9)
    return value == other


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
