"""Makes a crew look around once, so that compiled code is there before anybody relies on its speed."""

from __future__ import annotations

import numpy as np

from soup_bots.crew import Crew
from soup_bots.steering.base import Steering
from soup_msgs_py.messages import Bots, Buckets, DriveGoal
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Layout


def rehearse(scenario: Scenario, layout: Layout, steering: Steering, rng: np.random.Generator) -> None:
    """Let bots on neighbouring waypoints drive through each other's places for one sensing period.

    Args:
        scenario: How many bots and buckets there are, and their sizes.
        layout: The floor.
        steering: One that is used for nothing else.
        rng: For the steering's random draws.
    """
    bots, buckets = scenario.bots, scenario.buckets
    x, y = layout.waypoints[np.arange(bots) % len(layout.waypoints)].T.copy()
    still, empty = np.zeros(bots), np.full(bots, -1, dtype=np.int32)
    crew = Crew(scenario, layout, range(bots), steering, rng)
    for bot in range(bots):
        other = bots - 1 - bot
        crew.handle(DriveGoal(bot, 0, ((float(x[other]), float(y[other])),)), 0.0)
    bucket_x, bucket_y = layout.waypoints[layout.storage_spots[:buckets]].T.copy()
    resting = np.full(buckets, -1, dtype=np.int32)
    seen = Buckets(0.0, bucket_x, bucket_y, resting, np.zeros(buckets, dtype=np.uint16))
    for period in range(2):
        now = period * crew.sense_period_s
        crew.sense(Bots(now, x, y, still, still, still, empty, np.zeros(bots, dtype=np.uint8)), seen, now)
