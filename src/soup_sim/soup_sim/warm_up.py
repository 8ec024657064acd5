"""Moves a world about for a moment, so that compiled code is there before the real one runs at a pace."""

from __future__ import annotations

import numpy as np

from soup_msgs_py.messages import FollowPath, SetVelocities
from soup_sim.world import World

LASTS_S = 2.0


def rehearse(world: World) -> None:
    """Let all bots drive for some simulated seconds; the world is of no use afterwards."""
    bots = np.arange(world.scenario.bots, dtype=np.int32)
    middle = (world.layout.width_m / 2, world.layout.height_m / 2)
    for bot in bots.tolist():
        world.handle(FollowPath(bot, 0, (middle,)))
    world.advance(LASTS_S / 2)
    speed = np.full(len(bots), 0.1)
    world.handle(SetVelocities(bots, speed, -speed))
    world.advance(LASTS_S)
    world.snapshot()
