"""Which corner of its route a bot has behind it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from soup_msgs_py.kernel import kernel, maker
from soup_msgs_py.messages import Floats, Ints, Point

# all in radii of a bot
THERE = 0.05  # this near to a corner is at it
BESIDE = 0.2  # this far off a leg of the route is still on it
NEAR = 0.55  # looking once a radius, an evading bot is seen within half a radius of a corner that it drives over
DIRECT = 12.0  # how far from the end of its route an evading bot may drive straight to it
START = 2.9  # a bot that has just started is less than 0.9 from where it was, until it is looked at
CUT = 3.2  # how far from a corner an evading bot may turn to the next one
ON_LEG_M = 1e-3  # a bot that never evades is on its route but for rounding


@kernel
def distance_to_segment(px: float, py: float, ax: float, ay: float, bx: float, by: float) -> float:
    """Distance (m) of a point from the segment a b."""
    sx, sy = bx - ax, by - ay
    length2 = sx * sx + sy * sy
    share = 0.0
    if length2 > 0.0:
        share = min(1.0, max(0.0, ((px - ax) * sx + (py - ay) * sy) / length2))
    dx, dy = ax + share * sx - px, ay + share * sy - py
    return math.sqrt(dx * dx + dy * dy)


def corner_ahead(route: Sequence[Point], corner: int, place: Point) -> int:
    """The next corner of a bot that never leaves its route, and had `corner` of them behind it some time ago."""
    for ahead in range(corner + 1, len(route)):
        if distance_to_segment(*place, *route[ahead - 1], *route[ahead]) < ON_LEG_M:
            return ahead
    return corner


@maker
def corners_passed(
    rows: NDArray[np.int64],
    course: Floats,
    left: Ints,
    mode: NDArray[np.int8],
    x: Floats,
    y: Floats,
    vx: Floats,
    vy: Floats,
    radius: float,
) -> NDArray[np.int64]:
    """Those of the bots `rows` that have passed their next corner; the end of a route is never passed.

    A bot on its path passes a corner by being there. One that evades need not touch it: it may be beyond it, or
    another bot may stand there.

    Args:
        rows: Bots to look at.
        course: x, y of the corner behind, the next one, the one after and the end, shape (bots, 8). Where nan stands
            for the corner behind, the bot's place is entered.
        left: Corners left, shape (bots,).
        mode: 0 for a bot on its path, shape (bots,).
        x: Positions of all bots.
        y: As above.
        vx: Velocities of all bots.
        vy: As above.
        radius: Radius of a bot (m).
    """
    passed = np.zeros(len(rows), np.bool_)
    for r in range(len(rows)):
        i = int(rows[r])
        px, py = float(x[i]), float(y[i])
        if math.isnan(course[i, 0]):
            course[i, 0], course[i, 1] = px, py
        if left[i] <= 1:
            continue
        back_x, back_y = float(course[i, 0]), float(course[i, 1])
        at_x, at_y = float(course[i, 2]), float(course[i, 3])
        dx, dy = at_x - px, at_y - py
        dist = math.sqrt(dx * dx + dy * dy)
        if mode[i] == 0:
            here = distance_to_segment(px, py, back_x, back_y, at_x, at_y)
            ahead = distance_to_segment(px, py, at_x, at_y, float(course[i, 4]), float(course[i, 5]))
            leaves = dx * vx[i] + dy * vy[i] < 0.0
            passed[r] = dist < THERE * radius or (ahead < BESIDE * radius and (ahead < here - 1e-6 or leaves))
        elif dist < NEAR * radius or is_detour(px, py, course[i], radius):
            passed[r] = True
        elif dist < CUT * radius:
            beyond = dx * (at_x - back_x) + dy * (at_y - back_y) < 0.0
            passed[r] = beyond or occupied(i, at_x, at_y, x, y, vx, vy, radius)
    return rows[passed]


@kernel
def is_detour(px: float, py: float, course: Floats, radius: float) -> bool:
    """Whether a bot, after waiting near the end of its route, would turn back to get to the next corner."""
    dx, dy = course[6] - px, course[7] - py
    left2 = dx * dx + dy * dy
    dx, dy = course[6] - course[2], course[7] - course[3]
    return left2 < DIRECT * DIRECT * radius * radius and left2 < dx * dx + dy * dy


@kernel
def occupied(me: int, at_x: float, at_y: float, x: Floats, y: Floats, vx: Floats, vy: Floats, radius: float) -> bool:
    """Whether a bot other than `me` stands so that no bot can be at a point."""
    for j in range(len(x)):
        dx, dy = x[j] - at_x, y[j] - at_y
        if j != me and vx[j] == 0.0 and vy[j] == 0.0 and dx * dx + dy * dy < 4.0 * radius * radius:
            return True
    return False


@kernel
def room_to_start(me: int, x: Floats, y: Floats, vx: Floats, vy: Floats, radius: float, ahead_s: float) -> bool:
    """Whether a standing bot can set off anywhere without coming near another one within `ahead_s` seconds."""
    for j in range(len(x)):
        dx, dy = x[j] - x[me], y[j] - y[me]
        reach = START * radius + ahead_s * math.sqrt(vx[j] * vx[j] + vy[j] * vy[j])
        if j != me and dx * dx + dy * dy < reach * reach:
            return False
    return True
