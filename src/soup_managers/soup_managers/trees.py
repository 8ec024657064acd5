"""Compiled kernels of the router: Dijkstra's shortest-path trees and ways down them."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from soup_msgs_py.layout import Floats, Ints

_TIE_M = 1e-6  # ways that differ by less are equally long: sums of edges differ in their last digits
_STRAIGHT = 1.0 - 1e-9
NO_WAY = 255

Turns = NDArray[np.uint8]


@njit(cache=True)
def grow(root: int, starts: Ints, ends: Ints, costs: Floats, through: Floats) -> Floats:
    """Cheapest cost from `root` to every waypoint (Dijkstra with a binary heap).

    Args:
        root: The waypoint where the tree starts.
        starts: Edges of waypoint w are `starts[w]` to `starts[w + 1]`, shape (n + 1,).
        ends: Where each edge leads, shape (e,).
        costs: Cost of each edge, shape (e,).
        through: Extra cost of driving on from a waypoint, the root left out; infinite: ways only end there.

    Returns:
        Shape (n,), infinite where no way leads.
    """
    distance = np.full(len(starts) - 1, np.inf)
    distance[root] = 0.0
    keys = np.empty(len(ends) + 1)
    nodes = np.empty(len(ends) + 1, np.int32)
    keys[0], nodes[0] = 0.0, root
    size = 1
    while size > 0:
        key, node = keys[0], nodes[0]
        size -= 1
        _sift_down(keys, nodes, size, keys[size], nodes[size])
        if key > distance[node]:
            continue
        if node != root:
            key += through[node]
            if key == np.inf:
                continue
        for edge in range(starts[node], starts[node + 1]):
            end = ends[edge]
            cost = key + costs[edge]
            if cost < distance[end]:
                distance[end] = cost
                _sift_up(keys, nodes, size, cost, end)
                size += 1
    return distance


@njit(cache=True)
def _sift_up(keys: Floats, nodes: Ints, hole: int, key: float, node: int) -> None:
    while hole > 0:
        parent = (hole - 1) >> 1
        if keys[parent] <= key:
            break
        keys[hole], nodes[hole] = keys[parent], nodes[parent]
        hole = parent
    keys[hole], nodes[hole] = key, node


@njit(cache=True)
def _sift_down(keys: Floats, nodes: Ints, size: int, key: float, node: int) -> None:
    hole = 0
    while True:
        child = 2 * hole + 1
        if child >= size:
            break
        if child + 1 < size and keys[child + 1] < keys[child]:
            child += 1
        if keys[child] >= key:
            break
        keys[hole], nodes[hole] = keys[child], nodes[child]
        hole = child
    keys[hole], nodes[hole] = key, node


@njit(cache=True)
def count_turns(
    root: int,
    starts: Ints,
    ends: Ints,
    costs: Floats,
    dx: Floats,
    dy: Floats,
    through: Floats,
    distance: Floats,
) -> Turns:
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

    Returns:
        Shape (e,); `NO_WAY` for edges that are on no cheapest way.
    """
    turns = np.full(len(ends), NO_WAY, np.uint8)
    for node in np.argsort(distance):
        if distance[node] == np.inf:
            break
        for edge in range(starts[node], starts[node + 1]):
            end = ends[edge]
            if end == root:
                if costs[edge] <= distance[node] + _TIE_M:
                    turns[edge] = 0
            elif costs[edge] + distance[end] + through[end] <= distance[node] + _TIE_M:
                best = NO_WAY
                for following in range(starts[end], starts[end + 1]):
                    if turns[following] != NO_WAY:
                        straight = dx[edge] * dx[following] + dy[edge] * dy[following] > _STRAIGHT
                        best = min(best, turns[following] + (0 if straight else 1))
                # as many turns as do not fit are as good as one less
                turns[edge] = min(best, NO_WAY - 1)
    return turns


@njit(cache=True)
def descend(start: int, goal: int, starts: Ints, ends: Ints, dx: Floats, dy: Floats, turns: Turns, found: Ints) -> int:
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
