"""Safe-interval search: the earliest arrival at a goal through the gaps that the holds of all others leave.

A label is a bot that stands on a waypoint within a gap between the holds of others there. From it, straight runs lead
to all waypoints ahead; each departs as early as everything that it holds on its way is free (Phillips and Likhachev
2011, in continuous time and with the physics of `runs`).
"""

from __future__ import annotations

import numpy as np

from soup_managers.heap import drop_first, push
from soup_managers.traffic.desk import LONGEST_RUN
from soup_managers.traffic.roads import AT_END_M
from soup_managers.traffic.runs import run_time, time_at, turn_time
from soup_managers.traffic.timetable import SAME_S, gap_after, in_the_way, stands_on
from soup_managers.traffic.ways import stop_time, usable
from soup_msgs_py.kernel import kernel

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
def _fit(roads, table, desk, i, m, t, lead, length, v, stood, gap_end, passing, final, bot):
    """The earliest departure, not before t, at which all that a run holds is free; infinite if there is none.

    Notes the first hold that was not free at t in `desk.hindered`.

    Args:
        roads: The graph.
        table: The timetable.
        desk: Its holds.
        i: Those before this one are free at t.
        m: How many there are.
        t: Earliest departure.
        lead: Time to turn before it moves.
        length: How long it is.
        v: Where it begins.
        stood: Since when the bot stands there.
        gap_end: Until when it may.
        passing: Whether to regard only what is left behind before the bot brakes.
        final: Whether the bot stands for good where it ends.
        bot: Whose run it is.
    """
    V, A = roads.max_speed, roads.max_acceleration
    desk.hindered[0] = -1
    while i < m:
        w = desk.at[i]
        if passing:
            enter, leave = desk.enter[i], desk.leave[i]
        else:
            enter, leave = times_held(desk, i, length, V, A)
        if w == v:
            busy_until = np.inf if t + lead + leave > gap_end + SAME_S else -np.inf
        else:
            begin = stood if desk.since[i] < 0.0 else t + lead + enter
            end = np.inf if final and desk.until[i] >= length - AT_END_M else t + lead + leave
            busy_until = in_the_way(table, w, begin, end, bot)
        if busy_until == -np.inf:
            i += 1
            continue
        if desk.hindered[0] < 0:
            desk.hindered[0] = i
        if busy_until == np.inf or desk.since[i] < 0.0:
            return np.inf
        t, i = busy_until - lead - enter, 0
    return t


@kernel
def rest_of_way(roads, desk, count):
    """Mark the edges of the way on the desk for the next search; note what is left from each of its waypoints."""
    V, A, turn_rate = roads.max_speed, roads.max_acceleration, roads.turn_rate
    desk.round[0] += 1
    rest, length = 0.0, 0.0
    desk.rest[roads.head[desk.way[count - 1]]] = 0.0
    for k in range(count - 1, -1, -1):
        edge = desk.way[k]
        desk.mark[edge] = desk.round[0]
        if k + 1 < count and stop_time(roads, edge, desk.way[k + 1]) > 0.0:
            rest += run_time(length, V, A)
            rest += turn_time(roads.heading[edge], roads.heading[desk.way[k + 1]], turn_rate)
            length = 0.0
        length += roads.length[edge]
        desk.rest[roads.tail[edge]] = rest + run_time(length, V, A)


@kernel
def search(
    roads, table, desk, bot, start, goal, ready, heading, rest, marked_only, deep, blocked, worst, most
):  # fmt: skip
    """Find the earliest arrival at a goal.

    Args:
        roads: The graph.
        table: The timetable; not changed.
        desk: Takes the labels.
        bot: Who drives; its own holds do not hinder it.
        start: Where it stands.
        goal: Where it goes, to stand for good.
        ready: When it may depart.
        heading: Where it faces (rad).
        rest: At least so long it takes from each waypoint to the goal (s).
        marked_only: Whether to use only the edges that `rest_of_way` has marked.
        deep: See `usable`.
        blocked: See `usable`.
        worst: Arrivals after this do not count.
        most: After how many labels to give up.

    Returns:
        The label at the goal, -1 for none.
    """
    if not marked_only:
        desk.round[0] += 1
    now = desk.round[0]
    V, A, turn_rate = roads.max_speed, roads.max_acceleration, roads.turn_rate
    ramp = 0.5 * V * V / A
    gaps = table.begin.shape[1] + 1
    start_line = roads.line[start]
    gap, gap_end, _ = gap_after(table, start, ready, bot)
    root = start * gaps + gap
    desk.seen[root], desk.time[root], desk.extra[root], desk.parent[root], desk.last[root] = now, ready, 0.0, -1, -1
    desk.keys[0], desk.items[0], size = ready + rest[start], root, 1
    while size > 0 and most > 0:
        key, label = desk.keys[0], desk.items[0]
        drop_first(desk.keys, desk.items, size)
        size -= 1
        v = label // gaps
        if v == goal:
            return label
        stood, extra = desk.time[label], desk.extra[label]
        if key > stood + extra + rest[v] + SAME_S:
            continue
        most -= 1
        desk.looked[0] += 1
        _, gap_end, _ = gap_after(table, v, stood, bot)
        for edge in range(roads.out[v], roads.out[v + 1]):
            if marked_only and desk.mark[edge] != now:
                continue
            if not usable(roads, edge, goal, start_line, deep, blocked):
                continue
            faced = heading if label == root else roads.heading[desk.last[label]]
            lead = turn_time(faced, roads.heading[edge], turn_rate)
            # a run along this edge, and on and on; holds before `done` are free from `soonest` on, if it only passes
            m = begin_run(roads, table, desk, v, desk.last[label], bot)
            step, done, soonest, length, cost, last = 0, 0, stood, 0.0, extra, edge
            while True:
                m, changed = extend_run(roads, desk, last, step, length, m)
                done = min(done, changed)
                length += roads.length[last]
                if not marked_only:
                    cost += roads.pace[last] - roads.length[last] / V
                desk.run_edge[step], desk.run_length[step], desk.run_holds[step] = last, length, m
                x = roads.head[last]
                final = x == goal
                following = -1 if final or m > LONGEST_RUN - 32 else roads.straight[last]
                if following >= 0 and (
                    (marked_only and desk.mark[following] != now)
                    or roads.line[x] >= 0
                    or not usable(roads, following, goal, start_line, deep, blocked)
                ):
                    following = -1
                passed = done
                while passed < m and desk.until[passed] <= length - ramp:
                    passed += 1
                hindered, before = -1, soonest
                if length >= 2.0 * ramp and passed > done:
                    soonest = _fit(
                        roads, table, desk, done, passed, soonest, lead, length, v, stood, gap_end, True, False, bot
                    )
                    hindered, done = desk.hindered[0], passed
                t = soonest
                turning = following < 0 or (not marked_only and _crossing(roads, last, goal, start_line, deep, blocked))
                if turning:
                    t = _fit(roads, table, desk, done, m, t, lead, length, v, stood, gap_end, False, final, bot)
                    if hindered < 0:
                        hindered = desk.hindered[0]
                if hindered >= 0 and desk.made[hindered] > 0:
                    # it may be better to go at once and to wait just before what is in the way
                    stop = desk.made[hindered] - 1
                    held, short = desk.run_holds[stop], desk.run_length[stop]
                    first = held
                    while first > 0 and desk.until[first - 1] > short - ramp:
                        first -= 1
                    y = roads.head[desk.run_edge[stop]]
                    if short < 2.0 * ramp:
                        first = 0
                    go = _fit(
                        roads, table, desk, first, held, before, lead, short, v, stood, gap_end, False, False, bot
                    )
                    come = go + lead + run_time(short, V, A)
                    if come + rest[y] <= worst:
                        there = y * gaps + gap_after(table, y, come, bot)[0]
                        size = _put(desk, there, come, extra, go, label, edge, desk.run_edge[stop], now, rest[y], size)
                if turning:
                    run = lead + run_time(length, V, A)
                    entry = times_held(desk, _held(desk, x, m), length, V, A)[0]
                    while t + run + rest[x] <= worst:
                        gap, _, reopens = gap_after(table, x, t + run, bot)
                        size = _put(desk, x * gaps + gap, t + run, cost, t, label, edge, last, now, rest[x], size)
                        if final or reopens - lead - entry <= t or reopens == np.inf:
                            break
                        t = reopens - lead - entry
                        t = _fit(roads, table, desk, 0, m, t, lead, length, v, stood, gap_end, False, final, bot)
                if size < 0:
                    return -1
                if following < 0 or soonest == np.inf:
                    break
                last = following
                step += 1
    return -1


@kernel
def _put(desk, there, arrive, cost, t, parent, first, last, now, rest, size):
    """Write a label and put it into the heap, if it is better than what is there; the heap's size, -1 for too large."""
    if arrive == np.inf or (desk.seen[there] == now and arrive + cost >= desk.time[there] + desk.extra[there] - SAME_S):
        return size
    if size < 0 or size == len(desk.keys):
        return -1
    desk.seen[there], desk.time[there], desk.extra[there], desk.depart[there] = now, arrive, cost, t
    desk.parent[there], desk.first[there], desk.last[there] = parent, first, last
    push(desk.keys, desk.items, size, arrive + cost + rest, there)
    return size + 1


@kernel
def _crossing(roads, last, goal, start_line, deep, blocked):
    """Whether a bot may turn at the end of an edge."""
    x = roads.head[last]
    for edge in range(roads.out[x], roads.out[x + 1]):
        onward = edge != roads.straight[last] and roads.head[edge] != roads.tail[last]
        if onward and usable(roads, edge, goal, start_line, deep, blocked):
            return True
    return False


@kernel
def _held(desk, x, m):
    """The number of a waypoint among those that a run holds."""
    i = m - 1
    while desk.at[i] != x:
        i -= 1
    return i
