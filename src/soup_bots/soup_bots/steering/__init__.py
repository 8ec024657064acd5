"""How bots avoid each other on their way. Extend `Steering` for your own."""

from soup_bots.steering.base import FOLLOW, VELOCITY, Limits, Me, Neighbour, Steer, Steering, SteerView
from soup_bots.steering.evade import Evade
from soup_bots.steering.straight import Straight

KNOWN: dict[str, type[Steering]] = {"evade": Evade, "straight": Straight}

__all__ = [
    "FOLLOW",
    "KNOWN",
    "VELOCITY",
    "Evade",
    "Limits",
    "Me",
    "Neighbour",
    "Steer",
    "SteerView",
    "Steering",
    "Straight",
]
