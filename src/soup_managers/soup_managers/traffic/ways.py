"""Ways without regard to traffic: who may use an edge, trees of quickest ways (Dijkstra), and single ways by A*."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from soup_managers.kernels.heap import drop_first, push
from soup_managers.traffic.nav_graph import ENTRY, FORWARD, LANE, SPOT, Mask
from soup_msgs_py.kernel import kernel, maker
from soup_msgs_py.kinematics import turn_time


class Errand(NamedTuple):
    """What decides which edges a bot may use.

    Attributes:
        goal: Where it goes, -1 for anywhere.
        start_line: The station line in which it starts, -1 for none.
        deep: Whether bots may pass through storage spots.
        blocked: The spots through which this one may not, shape (n,).
    """

    goal: int
    start_line: int
    deep: bool
    blocked: Mask


@kernel
def usable(roads, edge, errand):
    """Whether a bot on an errand may drive along an edge."""
    kind, head, goal = roads.kind[edge], roads.head[edge], errand.goal
    if kind == LANE:
        return True
    if kind == SPOT:
        return head == goal or (errand.deep and not errand.blocked[head])
    line = roads.line[head]
    if kind == FORWARD:
        if line == errand.start_line:
            return True
        return goal >= 0 and line == roads.line[goal] and roads.line_place[head] >= roads.line_place[goal]
    return kind == ENTRY and goal >= 0 and line == roads.line[goal]


@kernel
def stop_time(roads, edge, following):
    """What a bot loses between two edges, because it must stop and turn (s)."""
    if roads.straight[edge] == following and roads.line[roads.head[edge]] < 0:
        return 0.0
    V, A, turn_rate = roads.max_speed, roads.max_acceleration, roads.turn_rate
    return V / A + turn_time(roads.heading[edge], roads.heading[following], turn_rate)


@maker
def tree_to(roads, goal, deep, blocked):
    """Quickest ways from everywhere to a goal.

    Returns:
        Seconds, shape (n,), infinite where no way leads; and the first edge of each way, -1 for none.
    """
    return _tree(roads, goal, False, deep, blocked)


@maker
def tree_from(roads, start, deep, blocked):
    """Quickest ways from a place to all lanes and storage spots.

    Returns:
        Seconds, shape (n,), infinite where no way leads; and the last edge of each way, -1 for none.
    """
    return _tree(roads, start, True, deep, blocked)


@maker
def _tree(roads, root, outward, deep, blocked):
    """Quickest ways to a root or, outward, from it: seconds, and the edge at the other end of each way."""
    n = len(roads.line)
    time, edges = np.full(n, np.inf), np.full(n, -1, np.int32)
    keys, nodes = np.empty(len(roads.head) + 1), np.empty(len(roads.head) + 1, np.int32)
    time[root], keys[0], nodes[0], size = 0.0, 0.0, root, 1
    starts = roads.out if outward else roads.into
    while size > 0:
        key, node = keys[0], nodes[0]
        drop_first(keys, nodes, size)
        size -= 1
        if key > time[node]:
            continue
        if outward and node != root and roads.spot[node] and (not deep or blocked[node]):
            continue
        for k in range(starts[node], starts[node + 1]):
            edge = k if outward else roads.into_edge[k]
            other = roads.head[edge] if outward else roads.tail[edge]
            spot = other if roads.kind[edge] == SPOT else -1
            goal, start = (spot, root) if outward else (root, other)
            if usable(roads, edge, Errand(goal, roads.line[start], deep, blocked)):
                there = key + roads.pace[edge]
                if node != root:
                    before, after = (edges[node], edge) if outward else (edge, edges[node])
                    there += stop_time(roads, before, after)
                if there < time[other]:
                    time[other], edges[other] = there, edge
                    push(keys, nodes, size, there, other)
                    size += 1
    time += roads.max_speed / roads.max_acceleration  # to get going, and to stop at the end
    time[root] = 0.0
    return time, edges


@kernel
def follow(roads, start, goal, first, way):
    """Write the edges of the way down a `tree_to` into `way`; how many there are, 0 for no way."""
    count, node = 0, start
    while node != goal:
        edge = first[node]
        if edge < 0:
            return 0
        way[count] = edge
        count += 1
        node = roads.head[edge]
    return count


@kernel
def follow_back(roads, start, goal, last, way):
    """Write the edges of the way up a `tree_from` into `way`; how many there are, 0 for no way."""
    count, node = 0, goal
    while node != start:
        edge = last[node]
        if edge < 0:
            return 0
        way[count] = edge
        count += 1
        node = roads.tail[edge]
    for k in range(count // 2):
        way[k], way[count - 1 - k] = way[count - 1 - k], way[k]
    return count


@kernel
def least_time(roads, place, goal, square):
    """No way between two places takes less (s), the h of A*; `square`: all edges run along x or y (Manhattan)."""
    dx, dy = roads.points[place, 0] - roads.points[goal, 0], roads.points[place, 1] - roads.points[goal, 1]
    length = abs(dx) + abs(dy) if square else np.sqrt(dx * dx + dy * dy)
    return length / roads.max_speed


@kernel
def find_way(roads, start, errand, square, desk):
    """Write the edges of a quickest way (A*) into `desk.way`; how many there are, 0 for no way."""
    desk.round[0] += 1
    now = desk.round[0]
    seen, time, last, keys, nodes = desk.seen, desk.time, desk.parent, desk.keys, desk.items
    goal = errand.goal
    seen[start], time[start], last[start] = now, 0.0, -1
    keys[0], nodes[0], size = 0.0, start, 1
    while size > 0:
        key, node = keys[0], nodes[0]
        drop_first(keys, nodes, size)
        size -= 1
        if node == goal:
            return follow_back(roads, start, goal, last, desk.way)
        if key > time[node] + least_time(roads, node, goal, square) + 1e-9:
            continue
        for edge in range(roads.out[node], roads.out[node + 1]):
            if not usable(roads, edge, errand):
                continue
            head = roads.head[edge]
            there = time[node] + roads.pace[edge]
            if node != start:
                there += stop_time(roads, last[node], edge)
            if seen[head] != now or there < time[head]:
                seen[head], time[head], last[head] = now, there, edge
                push(keys, nodes, size, there + least_time(roads, head, goal, square), head)
                size += 1
    return 0
