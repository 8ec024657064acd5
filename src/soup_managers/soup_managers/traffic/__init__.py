"""Traffic: drives on the waypoint graph that keep bots from touching each other, planned one after the other.

This is prioritized planning: who plans first goes first, and who plans later takes what is left. Where the field has a
name for it:

| module | holds | in the field |
|---|---|---|
| `traffic` | `Traffic`, what fleets use: who stands where, drives, estimates | prioritized planning |
| `legs` | a drive from rest to rest, and where a bot on it is | path |
| `reservations` | who holds which waypoint when | reservation table |
| `sipp` | the earliest arrival through what is left free | safe-interval path planning (SIPP) |
| `booking` | from a drive that has been found to the table | |
| `footprint`, `nearby` | which waypoints a bot holds on and beside the graph | footprint |
| `run_footprint` | what it holds on a run along several edges, and when | footprint in time |
| `nav_graph` | the waypoint graph as arrays | nav graph, roadmap |
| `queue_lanes` | which waypoints are the line of each station | dock queue |
| `router` | ways of whole trips, for fleets without reservations | Dijkstra trees |
| `ways`, `routes` | quickest ways without regard to traffic, the h of the search | Dijkstra trees, A* |
| `search_buffers` | arrays that the kernels write to | scratch |
"""

from soup_managers.traffic.legs import Leg
from soup_managers.traffic.traffic import Traffic

__all__ = ["Leg", "Traffic"]
