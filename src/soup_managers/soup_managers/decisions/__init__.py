"""The decisions of the coordinated fleet: each a small replaceable policy with one method, several of each.

A policies file names them as options of the fleet policy; a class of one's own goes in as `FILE.py:Class`::

    fleet:
      name: coordinated
      options:
        buckets: most_tiles_per_second
        bots: my_bots.py:Youngest
        storage: {name: near_words, options: {weight: 3.0}}
"""

from __future__ import annotations

from soup_managers.decisions.bots import Assignment, BotChoice, FirstBot, NearestBot
from soup_managers.decisions.buckets import (
    BucketChoice,
    FirstBucket,
    JointBuckets,
    MostTiles,
    MostTilesPerSecond,
    NearestBucket,
)
from soup_managers.decisions.fills import Association, Emptiest, FillChoice, NearestWithRoom, Popular, RandomFill
from soup_managers.decisions.onward import AlwaysStore, OnwardChoice, ServeOn, Sparing
from soup_managers.decisions.storage import (
    Fixed,
    NearestSpot,
    NearWords,
    PopularityZones,
    RandomSpot,
    StationCache,
    StorageChoice,
)

BUCKETS: dict[str, type[BucketChoice]] = {
    "first": FirstBucket,
    "nearest": NearestBucket,
    "most_tiles": MostTiles,
    "most_tiles_per_second": MostTilesPerSecond,
    "joint": JointBuckets,
}
FILLS: dict[str, type[FillChoice]] = {
    "random": RandomFill,
    "emptiest": Emptiest,
    "nearest": NearestWithRoom,
    "popular": Popular,
    "association": Association,
}
BOTS: dict[str, type[BotChoice]] = {"first": FirstBot, "nearest": NearestBot, "assignment": Assignment}
STORAGE: dict[str, type[StorageChoice]] = {
    "fixed": Fixed,
    "random": RandomSpot,
    "nearest": NearestSpot,
    "near_words": NearWords,
    "popularity_zones": PopularityZones,
    "station_cache": StationCache,
}
ONWARD: dict[str, type[OnwardChoice]] = {"store": AlwaysStore, "serve_on": ServeOn, "sparing": Sparing}
