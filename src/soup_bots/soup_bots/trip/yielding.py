"""Where an idle bot goes that stands on another one's goal."""

from __future__ import annotations

import numpy as np

from soup_bots.steering.base import Limits
from soup_msgs_py.messages import Bots, Point

AWAY = 6.0  # bot radii
ENOUGH = 10.0  # bot radii: more room than this is no better


def free_place(bot: int, bots: Bots, limits: Limits) -> Point:
    """The place with most room around it, of eight around a bot; its own if none is on the floor."""
    x, y, radius = float(bots.x[bot]), float(bots.y[bot]), limits.bot_radius_m
    best, best_room = (x, y), -1.0
    for dx, dy in ((1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)):
        at_x, at_y = x + AWAY * radius * dx, y + AWAY * radius * dy
        if not (radius <= at_x <= limits.width_m - radius and radius <= at_y <= limits.height_m - radius):
            continue
        apart = (bots.x - at_x) ** 2 + (bots.y - at_y) ** 2
        apart[bot] = np.inf
        room = min(float(apart.min()), (ENOUGH * radius) ** 2)
        if room > best_room:
            best, best_room = (at_x, at_y), room
    return best
