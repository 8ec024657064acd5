"""What the judge says of a recorded run, as far as its bag tells enough to judge it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from soup_lab.bags.course import Course
from soup_sim.validate import EPSILON, Judge, Violation


@dataclass(frozen=True)
class Verdict:
    """What came of judging.

    Attributes:
        violations: How many; None where too much is missing to judge.
        until: The simulated time up to which the run is judged (s).
        why: Why it is not judged, or not to its end; empty where it is.
        first: The first violations.
    """

    violations: int | None
    until: float
    why: str = ""
    first: tuple[Violation, ...] = ()


def judge_course(course: Course) -> Verdict:
    """Judge a run from its first snapshot to the last one up to which no event is missing.

    What was recorded after that is left out: some topics of a bag that ended abruptly are ahead of others, and a ledger
    that lacks the newest events would accuse whoever was seen after them.
    """
    start, end = course.start, course.end
    if start is None or end is None:
        return Verdict(None, 0.0, "not judged: the bag lacks a snapshot of the world")
    gap_at = course.gap_at
    if gap_at is not None:
        return Verdict(None, start.time, f"not judged: events before {gap_at:g} s are missing")
    if end.sequence == start.sequence and end.time <= start.time < course.last:
        return Verdict(None, start.time, f"not judged: no snapshot after {start.time:g} s has all events before it")
    layout = course.announcement.layout
    # places of buckets travel as 32-bit numbers
    rounding = float(2.0 * np.spacing(np.float32(max(layout.width_m, layout.height_m))))
    judge = Judge(course.announcement.scenario, layout, start, rounding_m=max(rounding, EPSILON))
    events = [course.events[number] for number in range(start.sequence + 1, end.sequence + 1)]
    # of several things at one instant, a bag does not tell which came before the places were told
    instants = {event.time for event in course.events.values()}
    poses = iter([pose for pose in course.poses if start.time < pose[0].time < end.time])
    pose = next(poses, None)
    for event in events:
        while pose is not None and pose[0].time <= event.time:
            if pose[0].time not in instants:
                judge.poses(*pose)
            pose = next(poses, None)
        judge.event(event)
    while pose is not None:
        if pose[0].time not in instants:
            judge.poses(*pose)
        pose = next(poses, None)
    judge.finish(end)
    why = f"judged up to {end.time:g} s, the last snapshot that all events are there for"
    why = why if end.time < course.last else ""
    return Verdict(judge.count, end.time, why, tuple(judge.violations))
