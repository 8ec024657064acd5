"""Traffic: routes and timetables on the waypoint graph that keep bots from touching each other."""

from soup_managers.traffic.legs import Leg
from soup_managers.traffic.traffic import Traffic

__all__ = ["Leg", "Traffic"]
