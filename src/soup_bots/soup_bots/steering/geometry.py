"""Discs that move: when they touch, and the table of directions. Only + - * / and square roots decide."""

from __future__ import annotations

import math

import numpy as np

from soup_msgs_py.kernel import inlined

_H = math.sqrt(0.5)
_C15 = math.sqrt((1.0 + math.sqrt(0.75)) / 2.0)
_S15 = math.sqrt((1.0 - math.sqrt(0.75)) / 2.0)
_C30 = math.sqrt(0.75)

# cosine and sine of turns to the right (negative sine) and to the left by 0, 15, ... degrees, in turn
TURNS = np.array(
    [
        (1.0, 0.0),
        (_C15, -_S15), (_C15, _S15),
        (_C30, -0.5), (_C30, 0.5),
        (_H, -_H), (_H, _H),
        (0.5, -_C30), (0.5, _C30),
        (_S15, -_C15), (_S15, _C15),
        (0.0, -1.0), (0.0, 1.0),
        (-0.5, -_C30), (-0.5, _C30),
        (-_C30, -0.5), (-_C30, 0.5),
        (-1.0, 0.0),
    ]
)  # fmt: skip
FAR = 1e9  # s: never


@inlined
def time_to_touch(dx: float, dy: float, ux: float, uy: float, reach: float) -> float:
    """When two discs touch.

    Args:
        dx: The other's position as seen from the first one (m).
        dy: As above.
        ux: The first one's velocity as seen from the other (m/s).
        uy: As above.
        reach: Distance (m) of the centres at which they touch.

    Returns:
        Seconds, 0 if they touch and come closer, FAR if they never will.
    """
    closing = dx * ux + dy * uy
    if closing <= 1e-9:
        return FAR
    gap = dx * dx + dy * dy - reach * reach
    if gap <= 0.0:
        return 0.0
    root = closing * closing - (ux * ux + uy * uy) * gap
    if root < 0.0:
        return FAR
    return gap / (closing + math.sqrt(root))


@inlined
def kept_distance(dx: float, dy: float, touch: float, margin: float) -> float:
    """Distance of the centres to keep: with margin, but inside the margin only as much as is left of it.

    Without this a bot beside another one could not even drive past it.
    """
    left = 0.5 * (math.sqrt(dx * dx + dy * dy) - touch)
    if left >= margin:
        return touch + margin
    return touch + left if left > 0.0 else touch


@inlined
def time_to_touch_until(
    dx: float,
    dy: float,
    wx: float,
    wy: float,
    mine: float,
    ox: float,
    oy: float,
    others: float,
    reach: float,
    linger: float,
) -> float:
    """When two discs touch that move for a known time each and stand then.

    Args:
        dx: The other's position as seen from the first one (m).
        dy: As above.
        wx: The first one's velocity (m/s), for `mine` seconds.
        wy: As above.
        mine: See above.
        ox: The other's velocity, for `others` seconds.
        oy: As above.
        others: See above.
        reach: Distance (m) of the centres at which they touch.
        linger: What touches the first one later than this (s) after it has come to stand does not count.
    """
    first = mine if mine < others else others
    t = time_to_touch(dx, dy, wx - ox, wy - oy, reach)
    if t <= first:
        return t
    if first >= FAR:
        return FAR
    dx += (ox - wx) * first
    dy += (oy - wy) * first
    if others < mine:
        t = time_to_touch(dx, dy, wx, wy, reach)
        return first + t if t <= mine - others else FAR
    t = time_to_touch(dx, dy, -ox, -oy, reach)
    return first + t if t <= linger and t <= others - mine else FAR
