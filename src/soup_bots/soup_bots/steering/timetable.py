"""The steering for reserved traffic: the fleet has kept the way free, so nobody needs to look around."""

from __future__ import annotations

from soup_bots.steering.base import Steering


class Timetable(Steering):
    """Drive the path at its times. Only for fleets that reserve ways; others collide with it."""

    senses = False
