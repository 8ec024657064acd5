"""From a drive that has been found to holds in the reservation table."""

from __future__ import annotations

import numpy as np

from soup_managers.traffic.nav_graph import AT_END_M
from soup_managers.traffic.reservations import SAME_S, add, cut_standing, forget, gap_after
from soup_managers.traffic.run_footprint import begin_run, extend_run, times_held
from soup_msgs_py.kernel import kernel
from soup_msgs_py.kinematics import turn_time

_SPARE = 2  # holds that one schedule may add to a waypoint


@kernel
def wait_early(roads, table, desk, query, found):
    """Wait as early on the way as possible: at storage spots rather than on lanes. Changes the times of the drive."""
    leaves, arrives = found.leaves, found.arrives
    for k in range(len(leaves) - 2, -1, -1):
        latest = leaves[k] + (leaves[k + 1] - arrives[k])
        if k == 0 and not roads.spot[found.stops[0]]:
            return  # a place in a line or on a lane is for others
        if latest <= leaves[k] + SAME_S:
            continue
        m, length = _gather(roads, table, desk, found, k, query.bot)
        t = _fit_before(roads, table, desk, query, found, k, m, latest, length)
        if t > leaves[k]:
            arrives[k] += t - leaves[k]
            leaves[k] = t


@kernel
def _fit_before(roads, table, desk, query, found, k, m, t, length):
    """The latest departure of the k-th run, not after t, at which all that it leaves behind is free."""
    V, A = roads.max_speed, roads.max_acceleration
    v, bot = found.stops[k], query.bot
    lead = _lead(roads, found, k, query.heading)
    stood = found.arrives[k - 1] if k else query.ready
    _, gap_end, _ = gap_after(table, v, stood, bot)
    i = 0
    while i < m and t > found.leaves[k]:
        w = desk.at[i]
        # what it leaves behind must be free until then; if it is not, depart before and look at all again
        enter, leave = times_held(desk, i, length, V, A)
        if w == v:
            t = min(t, gap_end - lead - leave)
        elif desk.until[i] < length - AT_END_M:
            begin = stood if desk.since[i] < 0.0 else t + lead + enter
            end = t + lead + leave
            for h in range(table.filled[w]):
                if table.bot[w, h] != bot and table.end[w, h] > begin + SAME_S and table.begin[w, h] < end - SAME_S:
                    t, i = table.begin[w, h] - lead - leave, -1
                    break
        i += 1
    return t


@kernel
def book(roads, table, desk, query, found, forget_before):
    """Write a drive into the reservation table; False, and nothing is written, where it does not fit."""
    V, A = roads.max_speed, roads.max_acceleration
    runs, bot = len(found.leaves), query.bot
    # is there room everywhere?
    for k in range(runs):
        m, _ = _gather(roads, table, desk, found, k, bot)
        for i in range(m):
            forget(table, desk.at[i], forget_before)
            if table.filled[desk.at[i]] + _SPARE > table.begin.shape[1]:
                return False
    # write, and join to it the endless holds of the place where the bot stands
    for k in range(runs):
        m, length = _gather(roads, table, desk, found, k, bot)
        start = found.leaves[k] + _lead(roads, found, k, query.heading)
        stood = found.arrives[k - 1] if k else query.ready
        for i in range(m):
            w = desk.at[i]
            enter, leave = times_held(desk, i, length, V, A)
            begin, end = start + enter, start + leave
            if w == found.stops[k] or desk.since[i] < 0.0:
                begin = stood
            if desk.until[i] >= length - AT_END_M:
                end = found.arrives[k] if k + 1 < runs else np.inf
            if k == 0 and (w == found.stops[0] or desk.since[i] < 0.0):
                begin = min(begin, cut_standing(table, w, bot))
            add(table, w, begin, end, bot)
    return True


@kernel
def _lead(roads, found, k, heading):
    """How long a bot turns before the k-th run of a drive."""
    if roads.turn_rate <= 0.0:
        return 0.0
    faced = roads.heading[found.edges[k - 1]] if k else heading
    return turn_time(faced, roads.heading[found.edges[k]], roads.turn_rate)


@kernel
def _gather(roads, table, desk, found, k, bot):
    """Note on the desk what the k-th run of a drive holds; how many waypoints, and the run's length."""
    arrived_by, v = -1, found.stops[k]
    if k and roads.crowded[v]:
        arrived_by = found.edges[k - 1]
        while roads.head[arrived_by] != v:
            arrived_by = roads.straight[arrived_by]
    m = begin_run(roads, table, desk, v, arrived_by, bot)
    length, edge, step = 0.0, found.edges[k], 0
    while True:
        m, _ = extend_run(roads, desk, edge, step, length, m)
        length += roads.length[edge]
        if roads.head[edge] == found.stops[k + 1]:
            return m, length
        edge = roads.straight[edge]
        step += 1
