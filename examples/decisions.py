"""Decisions of one's own for the coordinated fleet, one of each kind; `decisions.yaml` beside this file names them.

python3 scripts/run_headless.py --policies examples/decisions.yaml

Each has one method that scores what there is to choose from, all at once, with numpy. What it may look at is in
`soup_managers.state.planning_state.PlanningState`.
"""

from __future__ import annotations

import numpy as np

from soup_managers.decisions.bots import BotChoice
from soup_managers.decisions.buckets import BucketChoice
from soup_managers.decisions.fills import FillChoice
from soup_managers.decisions.onward import OnwardChoice
from soup_managers.decisions.storage import StorageChoice


class Fullest(BucketChoice):
    """For a word station: of the buckets that hold a tile that it needs the fullest; it may serve more words."""

    def score(self, state, want):
        """The highest is fetched, none that is not above 0."""
        return np.where(want.tiles > 0, state.stock.total, 0.0)


class Mixed(FillChoice):
    """At a letter station: the bucket that holds the fewest of the kinds that are staged there, to mix them."""

    def score(self, state, fill):
        """The highest is fetched, none that is not above 0."""
        there = state.stock.tiles[fill.tiles].sum(axis=0) if len(fill.tiles) else 0
        return fill.room / (1.0 + there)


class Rested(BotChoice):
    """The bot that has stood longest, as far as its last drive tells."""

    def cost(self, state, bots, place):
        """The least fetches the bucket."""
        return np.array([state.robots[bot].arrives for bot in bots.tolist()])


class BesideTheDock(StorageChoice):
    """Where the bucket is near to all word stations together."""

    def cost(self, state, bucket, spots, travel_s):
        """The least is taken."""
        stations = range(state.word_stations)
        ways = [state.traffic.times_to(state.docks[station])[spots] for station in stations]
        return travel_s + np.mean(ways, axis=0)


class OneMore(OnwardChoice):
    """From a letter station to the word station that the bucket serves best; from a word station into storage."""

    def score(self, state, robot):
        """The highest above 0 that has room is next; none: into storage."""
        scores = np.zeros(len(state.docks))
        if robot.station >= state.word_stations:
            for station in state.short_word_stations():
                scores[station] = state.serves(robot.bucket, station)
        return scores
