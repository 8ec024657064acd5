"""A letter station's policy of one's own: like goes to like, so that the popular kinds come together.

python3 scripts/run_headless.py --set letter_station.policy=examples/alike.py:Alike
"""

from __future__ import annotations

from soup_sim.station_policies import LetterStationPolicy


class Alike(LetterStationPolicy):
    """Fills a bucket from the bundle of whose kind it holds most already."""

    def choose(self, moves, station, contents, rng):
        """Of equals the oldest bundle; see `StationPolicy.choose`."""
        return max(range(len(moves)), key=lambda index: contents.get(moves[index].tile, 0))
