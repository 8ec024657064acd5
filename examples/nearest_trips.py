"""A fleet policy of one's own that plans whole trips: the nearest bucket, fetched by the nearest bot.

Its bots know nothing of reserved traffic, so they have to evade:

python3 scripts/run_headless.py --fleet-policy examples/nearest_trips.py:NearestTrips --bot-policy evade
"""

from __future__ import annotations

from soup_managers.fleets.minimal.plans import PlannedVisit, TripPlan
from soup_managers.fleets.minimal.policies import FleetPolicy
from soup_managers.kernels.bitset import members
from soup_msgs_py.messages import STORE


class NearestTrips(FleetPolicy):
    """One letter a trip, as in the paper's minimal policy, but nobody drives farther than needed."""

    def plan(self, fleet):
        """Trips to start now; see `FleetPolicy.plan`."""
        view = fleet.view

        def away(place, x, y):
            return abs(place[0] - x) + abs(place[1] - y)

        for letter in fleet.letters():
            if not fleet.free_bots:
                return
            able = view.with_room if letter.key[0] == STORE else view.holders(letter.tile)
            trips = []
            for bucket in members(able & fleet.free_buckets):
                x, y = float(view.bucket_x[bucket]), float(view.bucket_y[bucket])
                under = fleet.bot_under(bucket)  # nobody else gets to a bucket that a bot stands under
                bots = list(members(fleet.free_bots)) if under < 0 else [under] if fleet.free_bots >> under & 1 else []
                trips += [(away((view.bot_x[bot], view.bot_y[bot]), x, y), bot, bucket) for bot in bots]
            if not trips:
                fleet.defer(letter)
                continue
            _, bot, bucket = min(trips)
            yield TripPlan(bot, bucket, (PlannedVisit(letter.station, (letter,)),), int(view.spot_of[bucket]))
