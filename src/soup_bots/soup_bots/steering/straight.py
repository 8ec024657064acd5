"""A steering that never evades: what collisions cost, measured."""

from __future__ import annotations

from soup_bots.steering.base import Steering


class Straight(Steering):
    """Follow the path whatever is in the way."""

    senses = False
