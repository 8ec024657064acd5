"""The minimal evading of the paper, section "Bucketbot Sensing and Control": drive straight, turn only to evade."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from soup_bots.steering.base import Limits, Steer, Steering, SteerView, follow_all
from soup_bots.steering.rows import Desk, make_desk, steer_rows
from soup_msgs_py.parameters import NotNegative, Positive


@dataclass(frozen=True, slots=True)
class _Memory:
    """What is remembered of each bot, shape (bots,)."""

    evading: np.ndarray  # takes velocities at present
    command: np.ndarray  # (bots, 2): the velocity that it was told last
    travels: np.ndarray  # for how many seconds it will keep this velocity
    decided: np.ndarray  # the call at which it was told
    planned: np.ndarray  # (bots, 2): where it seems to start, nan: follows from its present velocity
    nearest: np.ndarray  # smallest distance to the goal so far
    since: np.ndarray  # the call at which it came that near
    goal: np.ndarray  # (bots, 2): the goal that `nearest` belongs to
    aside: np.ndarray  # the call until which it steps aside
    end: np.ndarray  # (bots, 2): the end of its route
    came: np.ndarray  # the call at which it came near that end


class Evade(Steering):
    """Follow the path while it is clear for some seconds; otherwise take the best velocity that keeps clear.

    Candidates are the wanted direction turned by a table of angles, at full and at half speed, and standing. The
    best one is late to touch anything, close to the wanted velocity and to the last one. A bot gives way to
    loaded bots when it is empty, and to lower numbers among equals, so two bots never both give way for ever; what
    stands is always evaded. A bot whose goal is occupied waits beside it until it is free. One that gets nowhere
    steps aside for a moment, in a direction drawn from its number and the count of calls.

    Args:
        look_ahead_s: How far ahead a path has to be clear.
        give_way_s: How late a bot that has priority gives way nevertheless.
        margin: Distance kept from bots, in bot radii.
        bucket_margin: Distance that a loaded bot keeps from resting buckets, in bucket radii.
        patience_s: Time without progress after which a bot steps aside.
    """

    def __init__(
        self,
        *,
        look_ahead_s: Positive = 1.5,
        give_way_s: Positive = 0.8,
        margin: NotNegative = 0.25,
        bucket_margin: NotNegative = 0.03,
        patience_s: Positive = 12.0,
    ) -> None:
        """Set the options; see the class."""
        self._options = np.array([look_ahead_s, give_way_s, margin, bucket_margin, patience_s])
        self._memory: _Memory | None = None
        self._limits: np.ndarray | None = None
        self._desk: Desk | None = None
        self._calls = 0

    def steer(self, view: SteerView) -> Steer:
        """Decide for all rows at once, in compiled code."""
        out = follow_all(len(view.bot))
        if self._memory is None or self._desk is None or len(self._memory.evading) != len(view.x):
            self._memory = _memory(len(view.x))
            self._limits = _as_array(view.limits)
            self._desk = make_desk(len(view.x), len(view.bucket_x), view.limits.width_m, view.limits.height_m)
        memory = self._memory
        self._calls += 1
        steer_rows(
            view.bot, view.goal_x, view.goal_y, view.next_x, view.next_y, view.end_x, view.end_y,
            view.x, view.y, view.vx, view.vy, view.bucket, view.state,
            view.bucket_x, view.bucket_y, view.bucket_bot,
            self._limits, self._options, self._calls,
            memory.evading, memory.command, memory.travels, memory.decided, memory.planned,
            memory.nearest, memory.since, memory.goal, memory.aside, memory.end, memory.came,
            out.mode, out.vx, out.vy, out.reason, out.other, self._desk,
        )  # fmt: skip
        return out


def _memory(bots: int) -> _Memory:
    return _Memory(
        np.zeros(bots, np.bool_),
        np.zeros((bots, 2)),
        np.zeros(bots),
        np.full(bots, -2, np.int64),
        np.full((bots, 2), np.nan),
        np.zeros(bots),
        np.zeros(bots, np.int64),
        np.full((bots, 2), np.nan),
        np.zeros(bots, np.int64),
        np.full((bots, 2), np.nan),
        np.zeros(bots, np.int64),
    )


def _as_array(limits: Limits) -> np.ndarray:
    return np.array(
        [
            limits.bot_radius_m,
            limits.bucket_radius_m,
            limits.max_speed_mps,
            limits.max_acceleration_mps2,
            limits.sensing_radius_m,
            limits.period_s,
            limits.width_m,
            limits.height_m,
        ]
    )
