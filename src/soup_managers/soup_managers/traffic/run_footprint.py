"""The footprint of one run: which waypoints a bot holds on its way along several edges, and from when to when.

It is written on the desk: `begin_run`, then `extend_run` for each edge.
"""

from __future__ import annotations

import numpy as np

from soup_managers.traffic.nav_graph import AT_END_M
from soup_managers.traffic.reservations import stands_on
from soup_msgs_py.kernel import kernel
from soup_msgs_py.kinematics import time_at

_LOOK_BACK = 8  # an edge holds what one of the last few edges holds, or something new


@kernel
def begin_run(roads, table, desk, v, arrived_by, bot):
    """Note what a bot that stands on v holds besides v; how many waypoints there are.

    `arrived_by`: the edge by which it came; -1 for where it stood all the time.
    """
    m = 0
    if not roads.crowded[v]:
        return m
    for k in range(roads.into[v], roads.into[v + 1]):
        edge = roads.into_edge[k]
        if arrived_by >= 0 and edge != arrived_by:
            continue
        for h in range(roads.hold[edge], roads.hold[edge + 1]):
            w = roads.hold_at[h]
            if w == v or roads.hold_to[h] < roads.length[edge] - AT_END_M:
                continue
            if arrived_by < 0 and not stands_on(table, w, bot):
                continue
            new = True
            for i in range(m):
                new = new and desk.at[i] != w
            if new:
                desk.at[m], desk.since[m], desk.until[m], desk.enter[m], desk.leave[m] = w, -1.0, 0.0, 0.0, 0.0
                desk.made[m] = 0
                m += 1
    return m


@kernel
def extend_run(roads, desk, edge, step, offset, m):
    """Add the `step`-th edge of a run, `offset` metres after its start; how many holds there are, the first changed."""
    V, A = roads.max_speed, roads.max_acceleration
    changed = m
    for h in range(roads.hold[edge], roads.hold[edge + 1]):
        w, low, high = roads.hold_at[h], roads.hold_from[h] + offset, roads.hold_to[h] + offset
        i = m - 1
        while i >= 0 and i >= m - _LOOK_BACK and desk.at[i] != w:
            i -= 1
        if i >= 0 and i >= m - _LOOK_BACK:
            if high > desk.until[i]:
                desk.until[i], desk.leave[i] = high, _passing(high, V, A)
                changed = min(changed, i)
            continue
        desk.at[m], desk.since[m], desk.until[m] = w, low, high
        desk.enter[m], desk.leave[m], desk.made[m] = _passing(low, V, A), _passing(high, V, A), step
        m += 1
    return m, changed


@kernel
def _passing(x, V, A):
    """How long after the start of a run that does not end it is at x metres."""
    ramp = 0.5 * V * V / A
    return np.sqrt(2.0 * x / A) if x <= ramp else V / A + (x - ramp) / V


@kernel
def times_held(desk, i, length, V, A):
    """When, after its start, a run of some length begins and ends to hold its i-th waypoint."""
    ramp = 0.5 * V * V / A
    if desk.until[i] <= length - ramp and length >= 2.0 * ramp:
        return desk.enter[i], desk.leave[i]
    return time_at(desk.since[i], length, V, A), time_at(desk.until[i], length, V, A)


@kernel
def number_of(desk, x, m):
    """The number of a waypoint among those that a run holds."""
    i = m - 1
    while desk.at[i] != x:
        i -= 1
    return i
