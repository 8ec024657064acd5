"""The figures of a run, computed anew from the messages of its bag."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from soup_lab.bags.course import Course
from soup_lab.bags.judge import Verdict, judge_course
from soup_msgs_py import topics
from soup_msgs_py.codes import BotState, EventType
from soup_msgs_py.errors import InputError
from soup_msgs_py.messages import Event
from soup_msgs_py.policies import policies_of
from soup_sim.bounds import Bounds, crossing_s
from soup_sim.statistics import Statistics
from soup_sim.summary import make_summary

# Figures that events do not tell. They come from places and states, which a bag holds several times a second.
MEASURED = (
    "wall_seconds", "real_time_factor", "distance_total_m", "distance_mean_m", "bot_idle_fraction",
    "word_station_idle_fraction", "letter_station_idle_fraction", "latency_s",
)  # fmt: skip
BOUNDS = ("word_rate_bound", "fraction_of_bound", "fleet_rate_bound", "fraction_of_fleet_bound")
WORD_TIMES = ("word_time_mean_s", "word_time_p95_s", "oldest_waiting_word_s")


def summarize(course: Course, warmup_s: float | None = None, verdict: Verdict | None = None) -> dict[str, Any]:
    """The summary of a run that a bag holds.

    Args:
        course: What the bag tells.
        warmup_s: Rates and counts cover what comes after this simulated time; without: as the run itself said.
        verdict: What the judge says of it; without: he is asked.
    """
    announcement = course.announcement
    scenario = announcement.scenario
    warmup = announcement.warmup_s if warmup_s is None else warmup_s
    events = [event for _, event in sorted(course.events.items())]
    if course.start is None:
        raise InputError("bag", topics.SNAPSHOT, "no message", "a bag of a warehouse")
    known = course.start.sequence
    inventory = sum(sum(content.values()) for content in course.start.contents)
    inventory -= sum(_change(event, scenario.word_station_count) for event in events if event.sequence <= known)
    told = course.bounds or (math.inf, math.inf)
    figures = Statistics(scenario, Bounds(*told, crossing_s(scenario, announcement.layout)), inventory)
    figures.ordered(_words_at_start(course, events), 0.0)
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
        **({} if _is_whole(course, events) else dict.fromkeys(WORD_TIMES)),
        "bot_idle_fraction": idle,
        "word_station_idle_fraction": _idle(busy[0], stations[0], seconds),
        "letter_station_idle_fraction": _idle(busy[1], stations[1], seconds),
        "wall_seconds": course.wall_seconds,
        "latency_s": course.latency_s,
        "real_time_factor": course.last / course.wall_seconds if course.wall_seconds > 0 else 0.0,
    }
    if course.bounds is None:
        values |= dict.fromkeys(BOUNDS)
    policies = policies_of(course.parts)
    verdict = verdict or judge_course(course)
    return make_summary(values, scenario, policies, announcement.seed, verdict.violations)


def _is_whole(course: Course, events: list[Event]) -> bool:
    """Whether a bag holds all that happened from the start of the run on, so that it tells when words were ordered."""
    assert course.start is not None
    return not course.missing and (events[0].sequence == 1 if events else course.start.sequence == 0)


def _words_at_start(course: Course, events: list[Event]) -> list[int]:
    """The words that were on order when the run began: those that are there, or are opened, without having arrived."""
    assert course.start is not None
    arrived = {event.job for event in events if event.type is EventType.WORD_ARRIVED}
    opened = {event.job for event in events if event.type is EventType.WORD_ASSIGNED}
    return sorted(opened.union(word.word for word in course.start.waiting_words) - arrived)


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
