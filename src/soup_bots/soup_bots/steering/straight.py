"""A steering that never evades: what collisions cost, measured."""

from __future__ import annotations

from soup_bots.steering.base import Steer, Steering, SteerView, follow_all


class Straight(Steering):
    """Follow the path whatever is in the way."""

    def steer(self, view: SteerView) -> Steer:
        """Let every row follow its path."""
        return follow_all(len(view.bot))
