"""Safe-interval path planning (SIPP): the earliest arrival at a goal through what others have left free.

Between the holds of other bots in the reservation table each waypoint has gaps: its safe intervals. A label is a bot
that stands on a waypoint within one of them. From it, straight runs lead to all waypoints ahead; each departs as early
as everything that it holds on its way is free (Phillips and Likhachev 2011, in continuous time and with the physics of
`kinematics`). Labels are looked at in the order of f = g + h: when a bot is there, what wrong ways cost, and at least
so long it takes from there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from soup_managers.kernels.heap import drop_first, push
from soup_managers.traffic.nav_graph import AT_END_M, Roads
from soup_managers.traffic.reservations import SAME_S, Reservations, gap_after, in_the_way
from soup_managers.traffic.run_footprint import begin_run, extend_run, number_of, times_held
from soup_managers.traffic.search_buffers import LONGEST_RUN, Desk
from soup_managers.traffic.ways import Errand, stop_time, usable
from soup_msgs_py.kernel import inlined, kernel, maker
from soup_msgs_py.kinematics import run_time, turn_time
from soup_msgs_py.warehouse.layout import Floats, Ints


class Query(NamedTuple):
    """What a search is asked.

    Attributes:
        bot: Who drives; its own holds do not hinder it.
        start: Where it stands.
        errand: Where it goes, to stand there for good, and which edges it may use.
        ready: When it may depart (s).
        heading: Where it faces (rad).
        rest: h: at least so long it takes from each waypoint to the goal (s), shape (n,); read only.
        on_way: Whether to use only the edges that `rest_of_way` has marked.
        worst: Arrivals after this do not count (s).
        most: After how many labels to give up.
    """

    bot: int
    start: int
    errand: Errand
    ready: float
    heading: float
    rest: Floats
    on_way: bool
    worst: float
    most: int


class Found(NamedTuple):
    """A drive that has been found, not yet in the reservation table.

    Attributes:
        stops: Waypoints where it stops, its start and its goal included, shape (runs + 1,).
        edges: The first edge of each run, shape (runs,).
        leaves: When each run departs (s).
        arrives: When it arrives (s).
    """

    stops: Ints
    edges: Ints
    leaves: Floats
    arrives: Floats


class _Run(NamedTuple):
    """Where a run begins: a label and an edge.

    Attributes:
        label: The label.
        v: Its waypoint.
        edge: The first edge.
        lead: How long the bot turns before it moves (s).
        stood: g: since when it stands on v (s).
        gap_end: Until when it may: the end of the safe interval (s).
        extra: What wrong ways cost up to there (s).
        bot: Who it is.
    """

    label: int
    v: int
    edge: int
    lead: float
    stood: float
    gap_end: float
    extra: float
    bot: int


def find(roads: Roads, table: Reservations, desk: Desk, query: Query) -> Found | None:
    """The drive that arrives first; None where there is none, or none was found in time."""
    label = _search(roads, table, desk, query)
    return _read(desk, label, table.begin.shape[1] + 1) if label >= 0 else None


# ---- the search ------------------------------------------------------------------------------------------------


@kernel
def _fit(roads, table, desk, run, i, m, t, length, final):
    """The earliest departure, not before t, at which all that a run holds is free; infinite if there is none.

    Notes the first hold that was not free at t in `desk.hindered`.

    Args:
        roads: The graph.
        table: The reservation table.
        desk: The run's holds.
        run: Where it begins.
        i: Those before this one are free at t.
        m: How many there are.
        t: Earliest departure.
        length: How long it is.
        final: Whether the bot stands for good where it ends.
    """
    V, A, lead = roads.max_speed, roads.max_acceleration, run.lead
    desk.hindered[0] = -1
    while i < m:
        w = desk.at[i]
        enter, leave = times_held(desk, i, length, V, A)
        # until when somebody else has w: never, if it is where the bot stands and it is gone before its gap ends
        if w == run.v:
            busy_until = np.inf if t + lead + leave > run.gap_end + SAME_S else -np.inf
        else:
            begin = run.stood if desk.since[i] < 0.0 else t + lead + enter
            end = np.inf if final and desk.until[i] >= length - AT_END_M else t + lead + leave
            busy_until = in_the_way(table, w, begin, end, run.bot)
        if busy_until == -np.inf:
            i += 1
            continue
        if desk.hindered[0] < 0:
            desk.hindered[0] = i
        if busy_until == np.inf or desk.since[i] < 0.0:
            return np.inf
        # depart so much later that it gets there when the other one has gone; then what was free may not be
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
def _search(roads, table, desk, query):
    """Fill the desk with labels up to the goal's, the return value; -1 where none is found."""
    if not query.on_way:
        desk.round[0] += 1
    gaps = table.begin.shape[1] + 1
    rest, heading, bot, most = query.rest, query.heading, query.bot, query.most

    # the root: the bot stands where it is
    gap, gap_end, _ = gap_after(table, query.start, query.ready, bot)
    root = query.start * gaps + gap
    desk.seen[root], desk.time[root], desk.extra[root] = desk.round[0], query.ready, 0.0
    desk.parent[root], desk.last[root] = -1, -1
    desk.keys[0], desk.items[0], size = query.ready + rest[query.start], root, 1

    while size > 0 and most > 0:
        # the open label with the least f = g + h, unless a better one has been written over it
        key, label = desk.keys[0], desk.items[0]
        drop_first(desk.keys, desk.items, size)
        size -= 1
        v = label // gaps
        if v == query.errand.goal:
            return label
        stood, extra = desk.time[label], desk.extra[label]
        if key > stood + extra + rest[v] + SAME_S:
            continue
        most -= 1
        desk.looked[0] += 1

        # expand it: runs along each edge
        _, gap_end, _ = gap_after(table, v, stood, bot)
        for edge in range(roads.out[v], roads.out[v + 1]):
            if not _open(roads, desk, query, edge):
                continue
            faced = heading if label == root else roads.heading[desk.last[label]]
            lead = turn_time(faced, roads.heading[edge], roads.turn_rate)
            size = _expand(roads, table, desk, query, _Run(label, v, edge, lead, stood, gap_end, extra, bot), size)
            if size < 0:
                return -1
    return -1


@inlined
def _open(roads, desk, query, edge):
    """Whether a search may use an edge."""
    return (not query.on_way or desk.mark[edge] == desk.round[0]) and usable(roads, edge, query.errand)


@kernel
def _expand(roads, table, desk, query, run, size):
    """Put labels at the ends of all runs that begin along an edge into the heap; its size, -1 for too large."""
    V, A = roads.max_speed, roads.max_acceleration
    ramp = 0.5 * V * V / A
    # holds before `done` are free from `soonest` on, if the run only passes
    m = begin_run(roads, table, desk, run.v, desk.last[run.label], run.bot)
    step, done, soonest, length, cost, last = 0, 0, run.stood, 0.0, run.extra, run.edge
    while True:
        # one more edge
        m, changed = extend_run(roads, desk, last, step, length, m)
        done = min(done, changed)
        length += roads.length[last]
        if not query.on_way:
            cost += roads.pace[last] - roads.length[last] / V
        desk.run_edge[step], desk.run_length[step], desk.run_holds[step] = last, length, m
        x = roads.head[last]
        final = x == query.errand.goal
        following = -1 if final or m > LONGEST_RUN - 32 or roads.line[x] >= 0 else roads.straight[last]
        if following >= 0 and not _open(roads, desk, query, following):
            following = -1

        # when it can pass all that is behind it before it would have to brake here
        passed = done
        while passed < m and desk.until[passed] <= length - ramp:
            passed += 1
        hindered, before = -1, soonest
        if length >= 2.0 * ramp and passed > done:
            soonest = _fit(roads, table, desk, run, done, passed, soonest, length, final)
            hindered, done = desk.hindered[0], passed

        # when it can end here, where it may turn
        t = soonest
        turning = following < 0 or (not query.on_way and _crossing(roads, last, query.errand))
        if turning:
            t = _fit(roads, table, desk, run, done, m, t, length, final)
            if hindered < 0:
                hindered = desk.hindered[0]
        if hindered >= 0 and desk.made[hindered] > 0:
            size = _wait_before(roads, table, desk, query, run, hindered, before, size)
        if turning:
            size = _arrive(roads, table, desk, query, run, m, t, length, cost, last, size)
        if size < 0 or following < 0 or soonest == np.inf:
            break
        last = following
        step += 1
    return size


@inlined
def _wait_before(roads, table, desk, query, run, hindered, before, size):
    """A label just before what is in the way: it may be better to go at once and to wait there."""
    V, A = roads.max_speed, roads.max_acceleration
    ramp = 0.5 * V * V / A
    stop = desk.made[hindered] - 1
    held, short, last = desk.run_holds[stop], desk.run_length[stop], desk.run_edge[stop]
    first = held
    while first > 0 and desk.until[first - 1] > short - ramp:
        first -= 1
    if short < 2.0 * ramp:
        first = 0
    y = roads.head[last]
    go = _fit(roads, table, desk, run, first, held, before, short, y == query.errand.goal)
    come = go + run.lead + run_time(short, V, A)
    if come + query.rest[y] <= query.worst:
        there = y * (table.begin.shape[1] + 1) + gap_after(table, y, come, run.bot)[0]
        size = _put(desk, run, last, there, go, come, run.extra, query.rest[y], size)
    return size


@inlined
def _arrive(roads, table, desk, query, run, m, t, length, cost, last, size):
    """Labels where a run ends that departs at t or later: one in each safe interval that it can get into."""
    V, A, x = roads.max_speed, roads.max_acceleration, roads.head[last]
    takes = run.lead + run_time(length, V, A)
    entry = times_held(desk, number_of(desk, x, m), length, V, A)[0]
    final = x == query.errand.goal
    while t + takes + query.rest[x] <= query.worst:
        gap, _, reopens = gap_after(table, x, t + takes, run.bot)
        there = x * (table.begin.shape[1] + 1) + gap
        size = _put(desk, run, last, there, t, t + takes, cost, query.rest[x], size)
        if final or reopens - run.lead - entry <= t or reopens == np.inf:
            break
        t = reopens - run.lead - entry
        t = _fit(roads, table, desk, run, 0, m, t, length, final)
    return size


@kernel
def _put(desk, run, last, there, depart, arrive, cost, rest, size):
    """Write a label and put it into the heap, if it is better than what is there; the heap's size, -1 for too large."""
    now = desk.round[0]
    if arrive == np.inf or (desk.seen[there] == now and arrive + cost >= desk.time[there] + desk.extra[there] - SAME_S):
        return size
    if size < 0 or size == len(desk.keys):
        return -1
    desk.seen[there], desk.time[there], desk.extra[there], desk.depart[there] = now, arrive, cost, depart
    desk.parent[there], desk.first[there], desk.last[there] = run.label, run.edge, last
    push(desk.keys, desk.items, size, arrive + cost + rest, there)
    return size + 1


@kernel
def _crossing(roads, last, errand):
    """Whether a bot may turn at the end of an edge."""
    x = roads.head[last]
    for edge in range(roads.out[x], roads.out[x + 1]):
        onward = edge != roads.straight[last] and roads.head[edge] != roads.tail[last]
        if onward and usable(roads, edge, errand):
            return True
    return False


@maker
def _read(desk, label, gaps):
    """Copy the runs that lead to a label from the desk."""
    runs, node = 0, label
    while desk.parent[node] >= 0:
        runs += 1
        node = desk.parent[node]
    stops, edges = np.empty(runs + 1, np.int32), np.empty(runs, np.int32)
    leaves, arrives = np.empty(runs), np.empty(runs)
    node = label
    for k in range(runs - 1, -1, -1):
        stops[k + 1], edges[k] = node // gaps, desk.first[node]
        leaves[k], arrives[k] = desk.depart[node], desk.time[node]
        node = desk.parent[node]
    stops[0] = node // gaps
    return Found(stops, edges, leaves, arrives)
