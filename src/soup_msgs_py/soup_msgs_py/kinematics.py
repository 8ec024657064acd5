"""The speed profile of a run: a straight move from rest to rest (equation 6), and when it is where.

The same numbers as the world's physics: accelerate with A to at most V, cruise, brake with A. Only + - * / and square
roots, so that the same inputs give the same bits on any machine.
"""

from __future__ import annotations

import numpy as np

from soup_msgs_py.kernel import kernel

_PI = 3.141592653589793


@kernel
def run_time(length, V, A):
    """How long a run takes (s): equation 6, and where it is too short to reach V, without the cruise."""
    if length * A >= V * V:
        return length / V + V / A
    return 2.0 * np.sqrt(length / A)


@kernel
def time_at(x, length, V, A):
    """How long after its start a run of some length is at x metres."""
    if x <= 0.0:
        return 0.0
    if x >= length:
        return run_time(length, V, A)
    ramp = min(0.5 * V * V / A, 0.5 * length)
    if x <= ramp:
        return np.sqrt(2.0 * x / A)
    if length - x < ramp:
        return run_time(length, V, A) - np.sqrt(2.0 * (length - x) / A)
    return V / A + (x - ramp) / V


@kernel
def place_at(time, length, V, A):
    """How many metres a run of some length has come after a time; the opposite of `time_at`."""
    total = run_time(length, V, A)
    if time <= 0.0:
        return 0.0
    if time >= total:
        return length
    ramp = min(V / A, 0.5 * total)
    if time <= ramp:
        return 0.5 * A * time * time
    if total - time < ramp:
        return length - 0.5 * A * (total - time) * (total - time)
    return 0.5 * A * ramp * ramp + V * (time - ramp)


@kernel
def heading_of(dx, dy):
    """The angle of a direction in radians, within (-pi, pi]; like atan2, but the same bits everywhere."""
    if dx == 0.0 and dy == 0.0:
        return 0.0
    ax, ay = abs(dx), abs(dy)
    z = min(ax, ay) / max(ax, ay)
    # three half-angle steps make the argument small enough for a short series
    for _ in range(3):
        z = z / (1.0 + np.sqrt(1.0 + z * z))
    z2 = z * z
    series = 1.0 / 15.0
    for k in range(13, 0, -2):
        series = 1.0 / k - z2 * series
    angle = 8.0 * z * series
    if ay > ax:
        angle = _PI / 2.0 - angle
    if dx < 0.0:
        angle = _PI - angle
    return angle if dy >= 0.0 else -angle


@kernel
def turn_time(heading, wanted, turn_rate):
    """How long a turn on the spot takes (s); no time where `turn_rate` is 0."""
    if turn_rate <= 0.0:
        return 0.0
    angle = abs(wanted - heading)
    while angle > _PI:
        angle = abs(angle - 2.0 * _PI)
    return angle / turn_rate if angle > 1e-9 else 0.0
