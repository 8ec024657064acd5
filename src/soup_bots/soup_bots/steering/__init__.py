"""How bots avoid each other on their way: local collision avoidance. Extend `Steering` for your own.

| module | holds |
|---|---|
| `base` | `Steering`, the class to extend, and what it is shown and says |
| `straight` | `Straight`: never evades |
| `evade` | `Evade`: the minimal evading of the paper; the other modules are its compiled kernels |
| `rows` | the loop over bots: look around, choose where to go, give way |
| `look` | what is around one bot, and what it is about to do |
| `choose` | is a way clear, and if not, which of some sampled velocities is best (velocity obstacles) |
| `yield_way` | who is on the end of a route, and where to wait for it |
| `geometry`, `cells`, `scene` | when discs touch; discs sorted into cells; the tuples of arrays that kernels share |
"""

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
