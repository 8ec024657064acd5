"""Fetch a bucket by hand: drive below it, grab it, carry it to a word station, give a letter, bring it back.

The world and the bot run, no fleet manager.

python3 examples/fetch_bucket.py
"""

import _checkout

_checkout.enter()

import math
import sys

from soup_live.warehouse import Warehouse, run
from soup_managers.traffic.router import Router

BOT, STATION = 0, 0


def main() -> None:
    """The nearest bucket, to the first word station, where a word is opened that needs one of its letters."""
    with Warehouse() as warehouse:
        x, y, _ = warehouse.pose(BOT)
        buckets = warehouse.buckets()
        spots = list(zip(buckets.x.tolist(), buckets.y.tolist(), strict=True))
        bucket = min(range(len(spots)), key=lambda number: math.dist((x, y), spots[number]))
        warehouse.wait(warehouse.drive(BOT, spots[bucket]))  # an empty bot passes below all buckets
        warehouse.wait(warehouse.grab(BOT, bucket))
        snapshot = warehouse.snapshot()
        inside = snapshot.contents[bucket].keys()
        word = next(word for word in snapshot.waiting_words if inside & set(word.tiles))
        warehouse.wait(warehouse.open_word(word.word, STATION))
        print(f"bot {BOT} has bucket {bucket} with {buckets.tiles[bucket]} letters, {word.text} needs one of them")

        router = Router(warehouse.layout)  # ways through the aisles: buckets collide
        spot, station = router.nearest_waypoint(*spots[bucket]), router.station_waypoints[STATION]
        there, back = router.route(spot, station), router.route(station, spot)
        if there is None or back is None:
            sys.exit(f"no way from {spots[bucket]} to word station {STATION} and back")
        warehouse.wait(warehouse.drive(BOT, *there))
        letter = warehouse.transfer(BOT, job=word.word)
        warehouse.wait(letter)
        print(f"word station {STATION}: {letter.message}")
        warehouse.wait(warehouse.drive(BOT, *back))
        warehouse.wait(warehouse.release(BOT))
        print(f"bucket {bucket} is back, {warehouse.time:.1f} s after the run began")


if __name__ == "__main__":
    sys.exit(run(main))
