"""A leg: a drive from rest to rest with a time for each stop, and where a bot on it is when."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from soup_msgs_py.kinematics import heading_of, place_at, run_time, time_at
from soup_msgs_py.messages import Point

NOWHERE = -1  # the "waypoint" of a place beside the graph
_PIECE_M = 3.0


@dataclass(frozen=True, slots=True)
class Leg:
    """A drive from one waypoint to another, at rest at both ends.

    Attributes:
        bot: Who drives.
        waypoints: Where it stops or waits, as in `points`; `NOWHERE` for a start beside the graph.
        points: The same in metres; the first is where it stands, twice the same point is a wait.
        stamps: When to be at each point (s); the first is the departure.
        depart: The same.
        arrive: When it stands on the last one.
    """

    bot: int
    waypoints: tuple[int, ...]
    points: tuple[Point, ...]
    stamps: tuple[float, ...]
    depart: float
    arrive: float


def heading_after(points: tuple[Point, ...]) -> float:
    """Where a bot faces that has driven along some points (rad)."""
    steps = [(bx - ax, by - ay) for (ax, ay), (bx, by) in pairwise(points) if (ax, ay) != (bx, by)]
    return heading_of(*steps[-1]) if steps else 0.0


def pieces_of(
    points: tuple[Point, ...], stamps: tuple[float, ...], V: float, A: float
) -> Iterator[tuple[Point, Point, float, float]]:
    """A drive in short straight pieces: where each begins and ends, and when; turns and waits belong to them."""
    for k, ((ax, ay), (bx, by)) in enumerate(pairwise(points)):
        length = math.sqrt((bx - ax) * (bx - ax) + (by - ay) * (by - ay))
        if length == 0.0:
            yield points[k], points[k], stamps[k], stamps[k + 1]
            continue
        runs_from = stamps[k + 1] - run_time(length, V, A)
        pieces = math.ceil(length / _PIECE_M)
        for piece in range(pieces):
            ends = [length * piece / pieces, length * (piece + 1) / pieces]
            start, end = ((ax + (bx - ax) * x / length, ay + (by - ay) * x / length) for x in ends)
            begin, until = (runs_from + time_at(x, length, V, A) for x in ends)
            yield start, end, min(begin, stamps[k]) if piece == 0 else begin, until


def braking_places(leg: Leg, begin: float, end: float, V: float, A: float) -> list[tuple[Point, Point]]:
    """Straight ways on which a bot on a leg may come to stand if it begins to brake between two times (s)."""
    ways = [(leg.points[-1], leg.points[-1])] if end >= leg.arrive else []
    for k in range(len(leg.points) - 1):
        (ax, ay), (bx, by) = leg.points[k], leg.points[k + 1]
        if leg.stamps[k] > end or leg.stamps[k + 1] < begin:
            continue
        length = math.sqrt((bx - ax) * (bx - ax) + (by - ay) * (by - ay))
        if length == 0.0:
            ways.append((leg.points[k], leg.points[k]))
            continue
        # a turn comes first; the rest is the run
        runs_from = leg.stamps[k + 1] - run_time(length, V, A)
        first = place_at(begin - runs_from, length, V, A) / length
        last = min((place_at(end - runs_from, length, V, A) + 0.5 * V * V / A) / length, 1.0)
        ways.append(((ax + (bx - ax) * first, ay + (by - ay) * first), (ax + (bx - ax) * last, ay + (by - ay) * last)))
    return ways
