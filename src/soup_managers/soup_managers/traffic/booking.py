"""From the label at a goal to a schedule in the timetable."""

from __future__ import annotations

import numpy as np

from soup_managers.traffic.roads import AT_END_M
from soup_managers.traffic.runs import turn_time
from soup_managers.traffic.search import begin_run, extend_run, times_held
from soup_managers.traffic.timetable import SAME_S, add, cut_standing, forget, gap_after
from soup_msgs_py.kernel import kernel

TABLE_FULL = -1
_SPARE = 2  # holds that one schedule may add to a waypoint


@kernel
def read_schedule(desk, label, gaps):
    """Write the runs that lead to a label into `stop`, `run_first`, `leaves`, `arrives`; how many there are."""
    runs, node = 0, label
    while desk.parent[node] >= 0:
        runs += 1
        node = desk.parent[node]
    node = label
    for k in range(runs - 1, -1, -1):
        desk.stop[k + 1], desk.run_first[k] = node // gaps, desk.first[node]
        desk.leaves[k], desk.arrives[k] = desk.depart[node], desk.time[node]
        node = desk.parent[node]
    desk.stop[0] = node // gaps
    return runs


@kernel
def wait_early(roads, table, desk, runs, ready, heading, bot):
    """Wait as early on the way as possible: at storage spots rather than on lanes."""
    for k in range(runs - 2, -1, -1):
        latest = desk.leaves[k] + (desk.leaves[k + 1] - desk.arrives[k])
        if k == 0 and not roads.spot[desk.stop[0]]:
            return  # a place in a line or on a lane is for others
        if latest <= desk.leaves[k] + SAME_S:
            continue
        lead = _lead(roads, desk, k, heading)
        m, length, _ = _gather(roads, table, desk, k, bot)
        stood = desk.arrives[k - 1] if k else ready
        t = _fit_before(roads, table, desk, k, m, latest, lead, length, stood, bot)
        if t > desk.leaves[k]:
            desk.arrives[k] += t - desk.leaves[k]
            desk.leaves[k] = t


@kernel
def _fit_before(roads, table, desk, k, m, t, lead, length, stood, bot):
    """The latest departure of the k-th run, not after t, at which all that it leaves behind is free."""
    V, A = roads.max_speed, roads.max_acceleration
    v = desk.stop[k]
    _, gap_end, _ = gap_after(table, v, stood, bot)
    i = 0
    while i < m and t > desk.leaves[k]:
        w = desk.at[i]
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
def book(roads, table, desk, runs, ready, heading, forget_before, bot):
    """Write a schedule into the timetable; `TABLE_FULL`, and nothing is written, where it does not fit."""
    V, A = roads.max_speed, roads.max_acceleration
    for k in range(runs):
        m, _, _ = _gather(roads, table, desk, k, bot)
        for i in range(m):
            forget(table, desk.at[i], forget_before)
            if table.filled[desk.at[i]] + _SPARE > table.begin.shape[1]:
                return TABLE_FULL
    for k in range(runs):
        m, length, _ = _gather(roads, table, desk, k, bot)
        start = desk.leaves[k] + _lead(roads, desk, k, heading)
        stood = desk.arrives[k - 1] if k else ready
        for i in range(m):
            w = desk.at[i]
            enter, leave = times_held(desk, i, length, V, A)
            begin, end = start + enter, start + leave
            if w == desk.stop[k] or desk.since[i] < 0.0:
                begin = stood
            if desk.until[i] >= length - AT_END_M:
                end = desk.arrives[k] if k + 1 < runs else np.inf
            if k == 0 and (w == desk.stop[0] or desk.since[i] < 0.0):
                begin = min(begin, cut_standing(table, w, bot))
            add(table, w, begin, end, bot)
    return runs


@kernel
def _lead(roads, desk, k, heading):
    """How long a bot turns before the k-th run of a schedule."""
    if roads.turn_rate <= 0.0:
        return 0.0
    edge = desk.run_first[k - 1] if k else -1
    return turn_time(roads.heading[edge] if k else heading, roads.heading[desk.run_first[k]], roads.turn_rate)


@kernel
def _gather(roads, table, desk, k, bot):
    """What the k-th run of a schedule holds: how many waypoints, the run's length, its last edge."""
    arrived_by = -1
    if k and roads.crowded[desk.stop[k]]:
        arrived_by, x = desk.run_first[k - 1], desk.stop[k]
        while roads.head[arrived_by] != x:
            arrived_by = roads.straight[arrived_by]
    m = begin_run(roads, table, desk, desk.stop[k], arrived_by, bot)
    length, edge, step = 0.0, desk.run_first[k], 0
    while True:
        m, _ = extend_run(roads, desk, edge, step, length, m)
        length += roads.length[edge]
        if roads.head[edge] == desk.stop[k + 1]:
            return m, length, edge
        edge = roads.straight[edge]
        step += 1
