"""The scratch of searches: arrays that are used again and again, so that none need be made for each plan."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from soup_managers.traffic.footprint import Indices
from soup_managers.traffic.nav_graph import Roads
from soup_msgs_py.warehouse.layout import Floats, Ints

LONGEST_RUN = 2048  # holds in one run


class Desk(NamedTuple):
    """Labels of a search, its heap, the holds of one run, and the edges of a way.

    A label is a waypoint and a safe interval there, numbered waypoint x (capacity + 1) + interval. It counts only if
    `seen` says that it is of the present `round`.

    Attributes:
        round: How many searches there have been, shape (1,).
        seen: The search that wrote a label last.
        time: When a bot can be there at the earliest (s); g is this and `extra`.
        extra: What the way there costs beyond its time (s): wrong ways.
        depart: When the last run there departs.
        parent: The label that it departs from.
        first: Its first edge.
        last: Its last edge.
        keys: The heap's keys: f = g + h.
        items: The heap's labels.
        at: Waypoints that a run holds.
        since: From where on it (m); -1: since the bot stands where it begins.
        until: Up to where.
        enter: When it would be at `since` if it went on for ever (s).
        leave: When it would be at `until`.
        made: The edge of the run (0 is its first) on which it begins to hold it.
        run_edge: The edges of a run.
        run_length: How long the run is up to the end of each (m).
        run_holds: How many holds it has up to there.
        hindered: The first hold that kept a run from departing earlier, -1 for none, shape (1,).
        mark: The search that may use an edge, shape (e,).
        rest: What is left to the goal from each waypoint of a given way (s), shape (n,).
        way: Edges of a way.
        looked: How many labels searches have looked at since that was set to 0, shape (1,).
    """

    round: Ints
    seen: Ints
    time: Floats
    extra: Floats
    depart: Floats
    parent: Ints
    first: Ints
    last: Ints
    keys: Floats
    items: Ints
    at: Ints
    since: Floats
    until: Floats
    enter: Floats
    leave: Floats
    made: Ints
    run_edge: Indices
    run_length: Floats
    run_holds: Indices
    hindered: Ints
    mark: Ints
    rest: Floats
    way: Ints
    looked: Ints


def make_desk(roads: Roads, capacity: int) -> Desk:
    """A desk for searches with a reservation table of some capacity."""
    waypoints, edges = len(roads.line), len(roads.head)
    labels = waypoints * (capacity + 1)

    def ints(count: int) -> Ints:
        return np.zeros(count, np.int32)

    return Desk(
        round=ints(1),
        seen=ints(labels),
        time=np.zeros(labels),
        extra=np.zeros(labels),
        depart=np.zeros(labels),
        parent=ints(labels),
        first=ints(labels),
        last=ints(labels),
        keys=np.zeros(4 * edges + 64),
        items=ints(4 * edges + 64),
        at=ints(LONGEST_RUN),
        since=np.zeros(LONGEST_RUN),
        until=np.zeros(LONGEST_RUN),
        enter=np.zeros(LONGEST_RUN),
        leave=np.zeros(LONGEST_RUN),
        made=ints(LONGEST_RUN),
        run_edge=np.zeros(LONGEST_RUN, np.int64),
        run_length=np.zeros(LONGEST_RUN),
        run_holds=np.zeros(LONGEST_RUN, np.int64),
        hindered=ints(1),
        mark=ints(edges),
        rest=np.zeros(waypoints),
        way=ints(edges),
        looked=ints(1),
    )
