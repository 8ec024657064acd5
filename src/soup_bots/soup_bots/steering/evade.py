"""The minimal evading of the paper, section "Bucketbot Sensing and Control": drive straight, turn only to evade."""

from __future__ import annotations

from soup_bots.steering.base import Steer, Steering, SteerView, follow_all
from soup_bots.steering.look import Desk, make_desk
from soup_bots.steering.rows import steer_rows
from soup_bots.steering.scene import Norms, bots_of, buckets_of, make_memory, make_norms, rows_of, told_in
from soup_msgs_py.scenario.parameters import NotNegative, Positive


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
        self._options = look_ahead_s, give_way_s, patience_s, margin, bucket_margin
        self._norms: Norms | None = None
        self._memory = make_memory(0)
        self._desk: Desk | None = None
        self._calls = 0

    def steer(self, view: SteerView) -> Steer:
        """Decide for all rows at once, in compiled code."""
        out = follow_all(len(view.bot))
        if self._norms is None or self._desk is None or len(self._memory.evading) != len(view.x):
            self._norms = make_norms(view.limits, *self._options)
            self._memory = make_memory(len(view.x))
            self._desk = make_desk(len(view.x), len(view.bucket_x), self._norms)
        self._calls += 1
        sensed = rows_of(view), bots_of(view), buckets_of(view)
        steer_rows(*sensed, self._norms, self._memory, told_in(out), self._desk, self._calls)
        return out
