"""What the compiled kernels of `Evade` read and write, as tuples of arrays: what is sensed, remembered and told."""

from __future__ import annotations

import math
from dataclasses import astuple
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soup_bots.steering.base import Limits, Steer, SteerView
from soup_bots.steering.cells import CELL_M
from soup_msgs_py.messages import Floats, Ints

Calls = NDArray[np.int64]
Flags = NDArray[np.bool_]

SLOW = 0.05  # share of the maximum speed below which a bot counts as standing
BUCKET_LOOK_S = 1.2


class Rows(NamedTuple):
    """The bots to steer and the corners of their routes, as in `SteerView`, shape (rows,)."""

    bot: NDArray[np.int64]
    goal_x: Floats
    goal_y: Floats
    next_x: Floats
    next_y: Floats
    end_x: Floats
    end_y: Floats


class Bots(NamedTuple):
    """All bots, as in `SteerView`, shape (bots,)."""

    x: Floats
    y: Floats
    vx: Floats
    vy: Floats
    bucket: Ints
    state: NDArray[np.uint8]


class Buckets(NamedTuple):
    """All buckets, as in `SteerView`, shape (buckets,)."""

    x: Floats
    y: Floats
    bot: Ints


class Told(NamedTuple):
    """What rows are told, as in `Steer`, shape (rows,)."""

    mode: NDArray[np.int8]
    vx: Floats
    vy: Floats
    reason: NDArray[np.int8]
    other: Ints


class Memory(NamedTuple):
    """What is remembered of each bot, shape (bots,) or, of places and velocities, (bots, 2).

    Attributes:
        evading: Whether it takes velocities at present.
        command: The velocity that it was told last (m/s).
        travels: For how many seconds it will keep this velocity.
        decided: The call at which it was told.
        planned: Where it seems to start (m); nan: follows from its present velocity.
        nearest: Smallest distance to the goal so far (m).
        since: The call at which it came that near.
        goal: The goal that `nearest` belongs to.
        aside: The call until which it steps aside.
        end: The end of its route.
        came: The call at which it came near that end.
    """

    evading: Flags
    command: Floats
    travels: Floats
    decided: Calls
    planned: Floats
    nearest: Floats
    since: Calls
    goal: Floats
    aside: Calls
    end: Floats
    came: Calls


class Norms(NamedTuple):
    """Sizes, limits and options, the same for all bots.

    Attributes:
        radius: Of a bot (m).
        V: Maximum speed (m/s).
        A: Maximum acceleration (m/s2).
        period: Between two calls (s).
        width: Of the floor (m).
        height: As above.
        look: How far ahead a path has to be clear (s).
        give_way: How late a bot that has priority gives way nevertheless (s).
        patience: Time without progress after which a bot steps aside (s).
        margin: What is kept from bots (m).
        bucket_margin: What a loaded bot keeps from resting buckets (m).
        touch_empty: Distance of the centres at which two bots touch (m).
        touch_loaded: The same where both carry buckets.
        touch_bucket: The same of two buckets.
        hold: How far from an occupied end of a route bots wait (m).
        hold_range: How near the end of its route a bot looks whether that is free (m).
        reach: How far bots are seen that matter (m).
        bucket_reach: The same for buckets.
        slow: Below this speed a bot counts as standing (m/s).
        columns: Of cells.
        lines: Of cells.
    """

    radius: float
    V: float
    A: float
    period: float
    width: float
    height: float
    look: float
    give_way: float
    patience: float
    margin: float
    bucket_margin: float
    touch_empty: float
    touch_loaded: float
    touch_bucket: float
    hold: float
    hold_range: float
    reach: float
    bucket_reach: float
    slow: float
    columns: int
    lines: int


def make_norms(
    limits: Limits, look_s: float, give_way_s: float, patience_s: float, margin: float, bucket_margin: float
) -> Norms:
    """Norms from limits and from the options of `Evade`; margins are in radii."""
    limits = Limits(*map(float, astuple(limits)))  # one type, so that kernels need be compiled only once
    look_s, give_way_s, patience_s = float(look_s), float(give_way_s), float(patience_s)
    radius, V = limits.bot_radius_m, limits.max_speed_mps
    touch_loaded = 2.0 * max(radius, limits.bucket_radius_m)
    touch_bucket = 2.0 * limits.bucket_radius_m
    hold = 1.5 * touch_loaded + 0.2 * radius
    return Norms(
        radius=radius,
        V=V,
        A=limits.max_acceleration_mps2,
        period=limits.period_s,
        width=limits.width_m,
        height=limits.height_m,
        look=look_s,
        give_way=give_way_s,
        patience=patience_s,
        margin=margin * radius,
        bucket_margin=bucket_margin * limits.bucket_radius_m,
        touch_empty=2.0 * radius,
        touch_loaded=touch_loaded,
        touch_bucket=touch_bucket,
        hold=hold,
        hold_range=hold + V * look_s,
        reach=min(limits.sensing_radius_m, 2.0 * V * look_s + touch_loaded),
        bucket_reach=min(limits.sensing_radius_m, V * BUCKET_LOOK_S + touch_bucket),
        slow=SLOW * V,
        columns=max(1, math.ceil(limits.width_m / CELL_M)),
        lines=max(1, math.ceil(limits.height_m / CELL_M)),
    )


def make_memory(bots: int) -> Memory:
    """The memory of bots of which nothing is known."""
    return Memory(
        evading=np.zeros(bots, np.bool_),
        command=np.zeros((bots, 2)),
        travels=np.zeros(bots),
        decided=np.full(bots, -2, np.int64),
        planned=np.full((bots, 2), np.nan),
        nearest=np.zeros(bots),
        since=np.zeros(bots, np.int64),
        goal=np.full((bots, 2), np.nan),
        aside=np.zeros(bots, np.int64),
        end=np.full((bots, 2), np.nan),
        came=np.zeros(bots, np.int64),
    )


def rows_of(view: SteerView) -> Rows:
    """The rows of a view."""
    return Rows(view.bot, view.goal_x, view.goal_y, view.next_x, view.next_y, view.end_x, view.end_y)


def bots_of(view: SteerView) -> Bots:
    """The bots of a view."""
    return Bots(view.x, view.y, view.vx, view.vy, view.bucket, view.state)


def buckets_of(view: SteerView) -> Buckets:
    """The buckets of a view."""
    return Buckets(view.bucket_x, view.bucket_y, view.bucket_bot)


def told_in(steer: Steer) -> Told:
    """The arrays of a decision, to be filled."""
    return Told(steer.mode, steer.vx, steer.vy, steer.reason, steer.other)
