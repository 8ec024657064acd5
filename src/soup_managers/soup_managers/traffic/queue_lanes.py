"""The line (queue) in front of each station: waypoints where the next bots wait, one way through."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from soup_msgs_py.warehouse.layout import Layout

Line = tuple[int, ...]

_STRAIGHT = 1.0 - 1e-6  # cosine
_SQUARE = 1e-6


def find_lines(layout: Layout) -> list[Line]:
    """The waypoints of each station's line, its dock first, in the order of the stations.

    A station D on the outermost column gets a line beside and behind it, its exit `x` stays public::

        . . . . .         . . . . .
        . . . . W         . . . x D      bots come in through 2, stand at 2, 1 and D, and leave inwards
        . . . . .         . . . 2 1
        . . . . .         . . . . .

    The line is shorter (down to the dock alone) where waypoints are missing or belong to other lines, where an aisle
    begins, and where it would cut off other places; longer by one where more than two free columns are left.
    """
    finder = _Finder(layout)
    lines = [finder.line_of(station) for station in layout.stations.tolist()]
    return _keep_open(layout, finder, lines)


class _Finder:
    def __init__(self, layout: Layout) -> None:
        self._points = layout.waypoints
        count = len(layout.waypoints)
        weight = {(int(a), int(b)): float(w) for (a, b), w in zip(layout.edges, layout.edge_weights, strict=True)}
        self.neighbours: list[list[int]] = [[] for _ in range(count)]
        # a waypoint of a free column: nothing about it is dearer one way than the other
        self._free = np.ones(count, dtype=bool)
        for (a, b), there in weight.items():
            back = weight.get((b, a))
            if back is not None:
                self.neighbours[a].append(b)
            if back != there:
                self._free[[a, b]] = False
        self.is_spot = np.zeros(count, dtype=bool)
        self.is_spot[layout.storage_spots] = True
        self._taken = self.is_spot.copy()
        self._taken[layout.stations] = True
        self._docks = {int(dock): self._inward(int(dock)) for dock in layout.stations}
        # what lies inwards of a dock is its exit: no other line may stand there
        self._taken[[exit_ for exit_ in self._docks.values() if exit_ >= 0]] = True

    def line_of(self, dock: int) -> Line:
        exit_ = self._docks[dock]
        if exit_ < 0:
            return (dock,)
        inwards = self._direction(dock, exit_)
        beside = [n for n in self.neighbours[dock] if abs(self._direction(dock, n) @ inwards) < _SQUARE]
        beside.sort(key=lambda n: (self._points[n, 1], self._points[n, 0]))
        lines = [self._grow(dock, n, inwards) for n in beside]
        line = max(lines, key=len, default=(dock,))
        self._taken[list(line)] = True
        return line

    def _grow(self, dock: int, first: int, inwards: NDArray[np.float64]) -> Line:
        line = [dock]
        place = first
        for left_over in (0, 1, 2):
            following = self._step(place, inwards)
            if self._taken[place] or not self._free[place] or following < 0 or self.is_spot[following]:
                break
            ahead = place
            for _ in range(left_over):  # free columns that stay free
                ahead = self._step(ahead, inwards)
                if ahead < 0 or not self._free[ahead] or self.is_spot[ahead]:
                    return tuple(line)
            line.append(place)
            place = following
        return tuple(line)

    def _inward(self, dock: int) -> int:
        """The neighbour of a dock that has no opposite, -1 if there is not exactly one beside a column."""
        neighbours = self.neighbours[dock]
        directions = [self._direction(dock, n) for n in neighbours]
        inward = [
            n
            for n, d in zip(neighbours, directions, strict=True)
            if not any(d @ other < -_STRAIGHT for other in directions)
            and any(abs(d @ other) < _SQUARE for other in directions)
        ]
        # at a corner of the floor, along the row
        inward.sort(key=lambda n: abs(self._points[n, 1] - self._points[dock, 1]))
        return inward[0] if inward else -1

    def _step(self, place: int, direction: NDArray[np.float64]) -> int:
        for n in self.neighbours[place]:
            if self._direction(place, n) @ direction > _STRAIGHT:
                return n
        return -1

    def _direction(self, a: int, b: int) -> NDArray[np.float64]:
        step = self._points[b] - self._points[a]
        return step / np.sqrt(step[0] * step[0] + step[1] * step[1])


def _keep_open(layout: Layout, finder: _Finder, lines: list[Line]) -> list[Line]:
    """Shorten lines until all other lanes are joined, and every line and storage spot to them."""
    while True:
        private = np.zeros(len(layout.waypoints), dtype=bool)
        private[[w for line in lines for w in line]] = True
        cut_off = _cut_off(layout, finder.is_spot, private)
        shorter = [
            line[:-1] if len(line) > 1 and any(cut_off[n] for w in line for n in (w, *finder.neighbours[w])) else line
            for line in lines
        ]
        if shorter == lines:
            return lines
        lines = shorter


def _cut_off(layout: Layout, is_spot: NDArray[np.bool_], private: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which waypoints are not in, or not joined both ways to, the largest part of the public lanes."""
    public = ~is_spot & ~private
    tails, heads = layout.edges[:, 0], layout.edges[:, 1]
    used = public[tails] & public[heads]
    shape = (len(public), len(public))
    graph = coo_matrix((np.ones(int(used.sum())), (tails[used], heads[used])), shape=shape)
    part = connected_components(graph, directed=True, connection="strong")[1]
    if not public.any():
        return np.zeros(len(public), dtype=bool)
    main = public & (part == np.bincount(part[public]).argmax())
    joined_from, joined_to = main.copy(), main.copy()
    joined_from[heads[main[tails]]] = True
    joined_to[tails[main[heads]]] = True
    return public & ~main | is_spot & ~(joined_from & joined_to)
