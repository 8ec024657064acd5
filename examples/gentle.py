"""A steering of one's own: as `evade`, with more room, and a loaded bot that evades is in no hurry.

python3 scripts/run_headless.py --policies config/policies/minimal.yaml --bot-policy examples/gentle.py:Gentle
"""

from __future__ import annotations

from soup_bots.steering import VELOCITY, Evade


class Gentle(Evade):
    """Changes what `Evade` decides for all bots at once; to decide for each bot alone, extend `Steering.steer_one`.

    Args:
        share: Of the velocity that `evade` would choose, for loaded bots.
    """

    def __init__(self, share: float = 0.8) -> None:
        """Options of the policies file come in as keyword arguments."""
        super().__init__(margin=0.4, look_ahead_s=2.0)
        self._share = share

    def steer(self, view):
        """Modes and velocities, one element a driving bot; see `Steering.steer`."""
        out = super().steer(view)
        slower = (view.bucket[view.bot] >= 0) & (out.mode == VELOCITY)
        out.vx[slower] *= self._share
        out.vy[slower] *= self._share
        return out
