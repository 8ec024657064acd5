"""The waypoint graph (nav graph) as arrays for kernels: edges, what goes straight on, what is held, who may pass."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soup_managers.traffic.footprint import Edges, Hold, Motion, find_holds
from soup_managers.traffic.queue_lanes import Line
from soup_msgs_py.kernel import maker
from soup_msgs_py.kinematics import heading_of
from soup_msgs_py.warehouse.layout import Floats, Ints, Layout

Bytes = NDArray[np.uint8]
Mask = NDArray[np.bool_]

AT_END_M = 1e-9  # what is held up to here before the end of an edge is held at its end
_STRAIGHT = 1.0 - 1e-9

# What an edge leads to.
LANE = 0  # a public lane: for everybody
SPOT = 1  # a storage spot: for those who go there, and in deep layouts for those who fit
FORWARD = 2  # the next place in a station's line: for those in the line
ENTRY = 3  # the last place of a line: for those who go to that line
NEVER = 4


class Roads(NamedTuple):
    """Edges are sorted by the waypoint they leave; those of waypoint w are `out[w]` to `out[w + 1]`.

    Attributes:
        points: Waypoints (m), shape (n, 2).
        out: Where the edges of each waypoint begin, shape (n + 1,).
        tail: Where each edge begins, shape (e,).
        head: Where it ends.
        length: In metres.
        pace: Seconds that it costs at full speed, times its weight.
        straight: The edge that goes straight on after it, -1 for none.
        heading: Its direction (rad).
        kind: What it leads to.
        into: Where the list of edges into each waypoint begins in `into_edge`, shape (n + 1,).
        into_edge: Edges sorted by the waypoint they lead to.
        hold: Where the holds of each edge begin in the three arrays that follow, shape (e + 1,).
        hold_at: A waypoint that is held.
        hold_from: From where on the edge (m).
        hold_to: Up to where.
        line: Which station's line a waypoint belongs to, -1 for none, shape (n,).
        line_place: 0 is the dock, 1 the place behind it.
        spot: Which waypoints are storage spots.
        crowded: Which waypoints one cannot stand on without holding others too.
        apart: How far from each other the middles of bots have to be (m).
        max_speed: V (m/s).
        max_acceleration: A (m/s2).
        turn_rate: In rad/s; 0: turning takes no time.
    """

    points: Floats
    out: Ints
    tail: Ints
    head: Ints
    length: Floats
    pace: Floats
    straight: Ints
    heading: Floats
    kind: Bytes
    into: Ints
    into_edge: Ints
    hold: Ints
    hold_at: Ints
    hold_from: Floats
    hold_to: Floats
    line: Ints
    line_place: Ints
    spot: Mask
    crowded: Mask
    apart: float
    max_speed: float
    max_acceleration: float
    turn_rate: float


def make_roads(layout: Layout, lines: list[Line], motion: Motion, turn_rate: float) -> Roads:
    """The graph of a layout with these station lines."""
    count = len(layout.waypoints)
    order = np.lexsort((layout.edges[:, 1], layout.edges[:, 0]))
    edges = layout.edges[order]
    tail, head = edges[:, 0].astype(np.int32), edges[:, 1].astype(np.int32)
    steps = layout.waypoints[head] - layout.waypoints[tail]
    length = np.sqrt(steps[:, 0] * steps[:, 0] + steps[:, 1] * steps[:, 1])
    straight_lines = Edges(layout, motion.body_m)
    all_holds = find_holds(straight_lines, lines, motion)
    holds = [all_holds[e] for e in order.tolist()]
    flat = [hold for of_edge in holds for hold in of_edge]

    # station lines and storage spots
    line, place = np.full(count, -1, np.int32), np.full(count, -1, np.int32)
    for number, waypoints in enumerate(lines):
        line[list(waypoints)] = number
        place[list(waypoints)] = np.arange(len(waypoints))
    last = np.zeros(count, dtype=bool)
    last[[waypoints[-1] for waypoints in lines]] = True
    spot = np.zeros(count, dtype=bool)
    spot[layout.storage_spots] = True

    out, into = _starts(tail, count), _starts(head, count)
    roads = Roads(
        points=np.ascontiguousarray(layout.waypoints, dtype=np.float64),
        out=out,
        tail=tail,
        head=head,
        length=length,
        pace=length * layout.edge_weights[order] / motion.max_speed_mps,
        straight=_straight_on(out, tail, head, steps / length[:, None]),
        heading=np.array([heading_of(dx, dy) for dx, dy in steps.tolist()]),
        kind=np.zeros(len(head), np.uint8),
        into=into,
        into_edge=np.argsort(head, kind="stable").astype(np.int32),
        hold=np.concatenate([[0], np.cumsum([len(of_edge) for of_edge in holds])]).astype(np.int32),
        hold_at=np.array([at for at, _, _ in flat], np.int32),
        hold_from=np.array([low for _, low, _ in flat], np.float64),
        hold_to=np.array([high for _, _, high in flat], np.float64),
        line=line,
        line_place=place,
        spot=spot,
        crowded=_crowded(head, length, holds, count),
        apart=straight_lines.apart,
        max_speed=motion.max_speed_mps,
        max_acceleration=motion.max_acceleration_mps2,
        turn_rate=turn_rate,
    )
    # what each edge leads to; the later line wins
    same_line = (line[tail] == line[head]) & (line[head] >= 0)
    forward = same_line & (place[tail] == place[head] + 1)
    roads.kind[spot[head]] = SPOT
    roads.kind[line[head] >= 0] = NEVER
    roads.kind[last[head] & ~same_line] = ENTRY
    roads.kind[forward] = FORWARD
    return roads


def _starts(ends: Ints, count: int) -> Ints:
    return np.concatenate([[0], np.cumsum(np.bincount(ends, minlength=count))]).astype(np.int32)


def _crowded(head: Ints, length: Floats, holds: list[list[Hold]], count: int) -> Mask:
    crowded = np.zeros(count, dtype=bool)
    for end, whole, of_edge in zip(head.tolist(), length.tolist(), holds, strict=True):
        crowded[end] |= any(at != end and high >= whole - AT_END_M for at, _, high in of_edge)
    return crowded


@maker
def _straight_on(out, tail, head, ahead):
    straight = np.full(len(head), -1, np.int32)
    for edge in range(len(head)):
        end = head[edge]
        best = _STRAIGHT
        for following in range(out[end], out[end + 1]):
            along = ahead[following, 0] * ahead[edge, 0] + ahead[following, 1] * ahead[edge, 1]
            if along > best:
                straight[edge], best = following, along
    return straight
