"""Compiled kernels of the router: Dijkstra's shortest-path trees and ways down them."""

from __future__ import annotations

import numpy as np

from soup_managers.kernels.heap import drop_first, push
from soup_msgs_py.kernel import kernel

_TIE_M = 1e-6  # ways that differ by less are equally long: sums of edges differ in their last digits
_STRAIGHT = 1.0 - 1e-9
NO_WAY = 255


@kernel
def grow(root, starts, ends, costs, through, distance, order, keys, nodes):
    """Cheapest cost from `root` to every waypoint (Dijkstra with a binary heap).

    Args:
        root: The waypoint where the tree starts.
        starts: Edges of waypoint w are `starts[w]` to `starts[w + 1]`, shape (n + 1,).
        ends: Where each edge leads, shape (e,).
        costs: Cost of each edge, shape (e,).
        through: Extra cost of driving on from a waypoint, the root left out; infinite: ways only end there.
        distance: Takes the costs, shape (n,), infinite where no way leads.
        order: Takes the waypoints that ways lead to, nearest first, shape (n,).
        keys: Room for the heap, shape (e + 1,).
        nodes: Room for the heap, shape (e + 1,).

    Returns:
        How many waypoints ways lead to.
    """
    distance[:] = np.inf
    distance[root], keys[0], nodes[0] = 0.0, 0.0, root
    size, reached = 1, 0
    while size > 0:
        key, node = keys[0], nodes[0]
        drop_first(keys, nodes, size)
        size -= 1
        if key > distance[node]:
            continue
        order[reached] = node
        reached += 1
        if node != root:
            key += through[node]
            if key == np.inf:
                continue
        for edge in range(starts[node], starts[node + 1]):
            end = ends[edge]
            cost = key + costs[edge]
            if cost < distance[end]:
                distance[end] = cost
                push(keys, nodes, size, cost, end)
                size += 1
    return reached


@kernel
def count_turns(root, starts, ends, costs, dx, dy, through, distance, order, reached, turns):
    """For each edge on a cheapest way down a tree, the fewest turns that are left after taking it.

    Args:
        root: The root of the tree.
        starts: As in `grow`, but for the edges in the direction of the ways down.
        ends: As in `grow`.
        costs: As in `grow`.
        dx: Direction of each edge, shape (e,).
        dy: Direction of each edge, shape (e,).
        through: As in `grow`.
        distance: The tree, shape (n,).
        order: As in `grow`.
        reached: How many waypoints are in it.
        turns: Takes the turns, shape (e,); `NO_WAY` for edges that are on no cheapest way.
    """
    turns[:] = NO_WAY
    for place in range(reached):
        node = order[place]
        for edge in range(starts[node], starts[node + 1]):
            end = ends[edge]
            if end == root:
                if costs[edge] <= distance[node] + _TIE_M:
                    turns[edge] = 0
            elif costs[edge] + distance[end] + through[end] <= distance[node] + _TIE_M:
                # as many turns as do not fit are as good as one less
                best = NO_WAY - 1
                for following in range(starts[end], starts[end + 1]):
                    if turns[following] < best:
                        straight = dx[edge] * dx[following] + dy[edge] * dy[following] > _STRAIGHT
                        best = min(best, turns[following] + (0 if straight else 1))
                turns[edge] = best


@kernel
def descend(start, goal, starts, ends, dx, dy, turns, found):
    """Walk down a tree from `start` to its root `goal`, with as few turns as there can be.

    Args:
        start: Where the walk begins.
        goal: The root of the tree.
        starts: As in `count_turns`.
        ends: As in `count_turns`.
        dx: As in `count_turns`.
        dy: As in `count_turns`.
        turns: What `count_turns` says.
        found: Takes the corners of the walk, start and goal included.

    Returns:
        How many corners there are; 0 where no way leads.
    """
    found[0] = start
    count = 1
    node = start
    last = -1
    while node != goal:
        chosen = -1
        chosen_turns = 2 * NO_WAY
        turned = False
        for edge in range(starts[node], starts[node + 1]):
            if turns[edge] == NO_WAY:
                continue
            turn = last >= 0 and dx[edge] * dx[last] + dy[edge] * dy[last] <= _STRAIGHT
            if turns[edge] + turn < chosen_turns:
                chosen, chosen_turns, turned = edge, turns[edge] + turn, turn
        if chosen < 0:
            return 0
        if turned:
            found[count] = node
            count += 1
        node = ends[chosen]
        last = chosen
    found[count] = goal
    return count + 1
