"""Patrol: a bot drives round through waypoints, says how far it still is, and is called back on its last round.

python3 examples/patrol.py
"""

import _checkout

_checkout.enter()

import sys

from soup_live.warehouse import Warehouse, run

BOT = 0
ROUNDS = 2


def main() -> None:
    """Two rounds around the middle; in a third it is cancelled as soon as it has set off."""
    with Warehouse() as warehouse:
        width, height = warehouse.layout.width_m, warehouse.layout.height_m
        corners = [(x * width, y * height) for x, y in ((0.3, 0.3), (0.7, 0.3), (0.7, 0.7), (0.3, 0.7))]
        for number in range(ROUNDS):
            tour = warehouse.drive(BOT, *corners)
            for feedback in warehouse.follow(tour):
                print(f"round {number + 1}: {feedback.message}, {feedback.distance:.0f} m to go")
            warehouse.wait(tour)
        tour = warehouse.drive(BOT, *corners)
        begin = warehouse.pose(BOT)
        while not tour.done and warehouse.pose(BOT) == begin:
            pass  # each look at the pose waits for the next message
        tour.cancel()
        warehouse.first(tour)
        x, y, _ = warehouse.pose(BOT)
        print(f"called back at ({x:.1f}, {y:.1f}): {tour.code}")


if __name__ == "__main__":
    sys.exit(run(main))
