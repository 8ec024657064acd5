"""Footprints: which waypoints a bot holds on each edge, so that bots of which no two hold the same can never touch.

On the edge from u to v a bot holds v all the way and u until it has left it by a little::

        u |- holds u -|
          |----------------- holds v -----------------| v

So nobody else comes towards v, not from ahead, not from behind, not from the sides, until the bot has left v by that
little in its turn: just as far that the next one, who may then begin an edge to v at full speed, never touches it.

Edges that cross, pass near each other or meet at a sharp angle hold one more waypoint in common on the parts that are
too near. A bot that stands holds what it held at the end of its edge.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from soup_managers.traffic.queue_lanes import Line
from soup_msgs_py.kernel import kernel
from soup_msgs_py.kinematics import place_at, run_time
from soup_msgs_py.warehouse.layout import Floats, Ints, Layout

Indices = NDArray[np.int64]

MARGIN_M = 0.01  # what lies between bodies at the least, where waypoints are far enough from each other
_WIDE = 1e-9  # cosine of the smallest angle at which edges meet without getting in each other's way
_LEFT_M = 1e-4  # the least, so that no two can change places at one instant
_STEP_S = 1e-4  # how finely motions are compared
_HALVINGS = 20
_CUTS = 256  # how finely the part of an edge that is near another is found

Hold = tuple[int, float, float]  # a waypoint, and the part of the edge (m from its tail) on which it is held


@dataclass(frozen=True)
class Motion:
    """How bots move: the diameter of bodies (m), maximum speed (m/s) and acceleration (m/s2)."""

    body_m: float
    max_speed_mps: float
    max_acceleration_mps2: float


class Edges:
    """The edges of a layout as straight lines.

    Attributes:
        tail: Where each begins, shape (e,).
        head: Where it ends.
        starts: The same in metres, shape (e, 2).
        ends: The same in metres.
        lengths: In metres, shape (e,).
        ahead: Its direction, shape (e, 2).
        apart: How far from each other the middles of bots have to be (m).
    """

    def __init__(self, layout: Layout, body_m: float) -> None:
        self.tail: Ints = layout.edges[:, 0]
        self.head: Ints = layout.edges[:, 1]
        self.starts, self.ends = layout.waypoints[self.tail], layout.waypoints[self.head]
        steps = self.ends - self.starts
        self.lengths: Floats = np.sqrt(steps[:, 0] * steps[:, 0] + steps[:, 1] * steps[:, 1])
        self.ahead = steps / self.lengths[:, None]
        room = float(self.lengths.min(initial=np.inf)) - body_m
        self.apart = body_m + min(MARGIN_M, max(room, 0.0) / 4.0)

    def cosines(self, e: Indices, f: Indices) -> Floats:
        """Cosines of the angles between the directions of edges e and f."""
        return self.ahead[e, 0] * self.ahead[f, 0] + self.ahead[e, 1] * self.ahead[f, 1]


def find_holds(edges: Edges, lines: list[Line], motion: Motion) -> list[list[Hold]]:
    """What is held on each edge, in the order of the layout."""
    left = _left_after(edges, lines, motion).tolist()
    tails, heads, lengths = edges.tail.tolist(), edges.head.tolist(), edges.lengths.tolist()
    holds: list[list[Hold]] = [
        [(tail, 0.0, least), (head, 0.0, length)]
        for tail, head, least, length in zip(tails, heads, left, lengths, strict=True)
    ]
    number = {ends: e for e, ends in enumerate(zip(tails, heads, strict=True))}
    for e, f in _close_pairs(edges):
        ends_e, ends_f = (tails[e], heads[e]), (tails[f], heads[f])
        waypoint = next((w for w in ends_e if w in ends_f), min(ends_e))
        for one, other in ((e, f), (f, e)):
            low, high = _near_part(edges, one, other)
            _hold(holds[one], waypoint, low, high)
            back = number.get((heads[one], tails[one]))
            if back is not None:
                _hold(holds[back], waypoint, lengths[one] - high, lengths[one] - low)
    return holds


def _hold(holds: list[Hold], waypoint: int, low: float, high: float) -> None:
    for index, (there, first, last) in enumerate(holds):
        if there == waypoint:
            holds[index] = waypoint, min(first, low), max(last, high)
            return
    holds.append((waypoint, low, high))


# ---- one after the other -------------------------------------------------------------------------------------


def _left_after(edges: Edges, lines: list[Line], motion: Motion) -> Floats:
    """How far on each edge one has left its tail, so that the next may come there (m), shape (e,)."""
    way_in, way_out = _successions(edges, lines)
    place = np.full(int(max(edges.tail.max(initial=0), edges.head.max(initial=0))) + 1, -1)
    for line in lines:
        place[list(line)] = 1
    # who comes along a line has stood at its last place
    from_rest = place[edges.tail[way_in]] >= 0
    cases = np.stack(
        [edges.lengths[way_in], edges.lengths[way_out], -edges.cosines(way_in, way_out), from_rest], axis=1
    )
    left = np.zeros(len(edges.lengths))
    if len(cases):
        kinds, kind = np.unique(np.round(cases, 9), axis=0, return_inverse=True)
        far = np.array([left_after(a, b, c, d, edges.apart, motion) for a, b, c, d in kinds.tolist()])
        np.maximum.at(left, way_out, far[kind.ravel()])
    return np.minimum(np.maximum(left, _LEFT_M), edges.lengths)


def _successions(edges: Edges, lines: list[Line]) -> tuple[Indices, Indices]:
    """Pairs of edges, one into a waypoint and one out of it, that two bots may use shortly after each other."""
    order = np.argsort(edges.tail, kind="stable")
    tails = edges.tail[order]
    first, last = np.searchsorted(tails, edges.head, "left"), np.searchsorted(tails, edges.head, "right")
    counts = last - first
    way_in = np.repeat(np.arange(len(edges.head)), counts)
    way_out = order[np.arange(len(way_in)) - np.repeat(np.cumsum(counts) - counts, counts) + np.repeat(first, counts)]
    # edges that meet at a sharp angle, and the two ways of one edge, exclude each other otherwise
    wide = edges.cosines(way_in, way_out) > -_WIDE
    # one comes to a place in a line from the place behind it, to the last one from outside
    behind = {place: after for line in lines for place, after in pairwise(line)}
    comes = np.array(
        [behind.get(head, tail) == tail for tail, head in zip(edges.tail.tolist(), edges.head.tolist(), strict=True)],
        dtype=bool,
    )
    chosen = wide & comes[way_in]
    return way_in[chosen], way_out[chosen]


def left_after(
    length_in: float, length_out: float, cosine: float, from_rest: float, apart: float, motion: Motion
) -> float:
    """How far one who leaves a place must be when the next begins its edge towards it (m).

    Args:
        length_in: Length of the edge by which the next one comes.
        length_out: Length of the edge by which the first one leaves, from rest.
        cosine: Of the angle between them, at most 0.
        from_rest: Whether the next one begins at rest; else it is at full speed all the time.
        apart: How far from each other they must always be (m).
        motion: How they move.
    """
    lag = swap_lag(length_in, length_out, cosine, bool(from_rest), apart, motion)
    return place_at(lag, length_out, motion.max_speed_mps, motion.max_acceleration_mps2)


def swap_lag(
    length_in: float, length_out: float, cosine: float, from_rest: bool, apart: float, motion: Motion
) -> float:
    """How long after the departure of the one who leaves the next one may begin, as in `left_after` (s)."""
    V, A = motion.max_speed_mps, motion.max_acceleration_mps2
    high = run_time(length_out, V, A)
    if not _touch(0.0, length_in, length_out, cosine, from_rest, apart, V, A):
        return 0.0
    # bisection: at `low` they touch, at `high` the first one is gone
    low = 0.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if _touch(middle, length_in, length_out, cosine, from_rest, apart, V, A):
            low = middle
        else:
            high = middle
    return high


@kernel
def _touch(lag, length_in, length_out, cosine, from_rest, apart, V, A):
    duration = run_time(length_in, V, A) if from_rest else length_in / V
    for step in range(int(duration / _STEP_S) + 2):
        time = step * _STEP_S
        to_go = length_in - (place_at(time, length_in, V, A) if from_rest else min(V * time, length_in))
        gone = place_at(lag + time, length_out, V, A)
        if to_go * to_go + gone * gone - 2.0 * cosine * to_go * gone < apart * apart:
            return True
    return False


# ---- edges that are in each other's way ----------------------------------------------------------------------


def _close_pairs(edges: Edges) -> list[tuple[int, int]]:
    """Pairs of edges that bring bodies too close together and do not simply meet in a wide angle."""
    both = set(zip(edges.tail.tolist(), edges.head.tolist(), strict=True))
    # of an edge and its opposite, one
    ends = zip(edges.tail.tolist(), edges.head.tolist(), strict=True)
    once = np.array([e for e, (a, b) in enumerate(ends) if a < b or (b, a) not in both])
    if len(once) < 2:
        return []
    middles = 0.5 * (edges.starts[once] + edges.ends[once])
    pairs = once[KDTree(middles).query_pairs(float(edges.lengths.max()) + edges.apart, output_type="ndarray")]
    e, f = pairs[:, 0], pairs[:, 1]
    simple = np.zeros(len(pairs), dtype=bool)
    for end_e, sign_e in ((edges.tail, 1.0), (edges.head, -1.0)):
        for end_f, sign_f in ((edges.tail, 1.0), (edges.head, -1.0)):
            simple |= (end_e[e] == end_f[f]) & (sign_e * sign_f * edges.cosines(e, f) < _WIDE)
    e, f = e[~simple], f[~simple]
    gaps = gaps_between(edges.starts[e], edges.ends[e], edges.starts[f], edges.ends[f])
    close = gaps < edges.apart - 1e-9
    return sorted((min(a, b), max(a, b)) for a, b in zip(e[close].tolist(), f[close].tolist(), strict=True))


def _near_part(edges: Edges, edge: int, other: int) -> tuple[float, float]:
    """The part of an edge on which a body is too close to some place on another."""
    length = float(edges.lengths[edge])
    along = np.linspace(0.0, length, _CUTS + 1)
    places = edges.starts[edge] + edges.ahead[edge] * along[:, None]
    near = np.flatnonzero(_gaps_of_places(places, edges.starts[other][None], edges.ends[other][None]) < edges.apart)
    step = length / _CUTS
    if not len(near):
        return 0.0, length
    return max(float(along[near[0]]) - step, 0.0), min(float(along[near[-1]]) + step, length)


def _gaps_of_places(places: Floats, a: Floats, b: Floats) -> Floats:
    """How far places are from straight lines from a to b."""
    along = b - a
    squares = (along * along).sum(axis=-1)
    share = np.clip(((places - a) * along).sum(axis=-1) / np.where(squares > 0.0, squares, 1.0), 0.0, 1.0)
    off = places - a - share[..., None] * along
    return np.sqrt((off * off).sum(axis=-1))


def gaps_between(a: Floats, b: Floats, c: Floats, d: Floats) -> Floats:
    """How far straight lines from a to b are from those from c to d."""
    ends = np.minimum(
        np.minimum(_gaps_of_places(a, c, d), _gaps_of_places(b, c, d)),
        np.minimum(_gaps_of_places(c, a, b), _gaps_of_places(d, a, b)),
    )
    crossing = (_side(a, b, c) * _side(a, b, d) < 0.0) & (_side(c, d, a) * _side(c, d, b) < 0.0)
    return np.where(crossing, 0.0, ends)


def _side(a: Floats, b: Floats, place: Floats) -> Floats:
    u, v = b - a, place - a
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
