"""Race two bots along the floor: both drive at once, and the first that is there has won.

python3 examples/race.py
"""

import _checkout

_checkout.enter()

import sys

from soup_live.warehouse import Warehouse, run

BOTS = (0, 1)
APART_M = 4.0


def main() -> None:
    """Line up, race, and say who has won and by how much."""
    with Warehouse() as warehouse:
        left, right = 0.25 * warehouse.layout.width_m, 0.75 * warehouse.layout.width_m
        lanes = [warehouse.layout.height_m / 2 + APART_M * (bot - 0.5) for bot in BOTS]
        warehouse.wait(*(warehouse.drive(bot, (left, y)) for bot, y in zip(BOTS, lanes, strict=True)))
        began = warehouse.time
        drives = {bot: warehouse.drive(bot, (right, y)) for bot, y in zip(BOTS, lanes, strict=True)}
        first = warehouse.first(*drives.values())
        won, took = next(bot for bot in BOTS if drives[bot] is first), warehouse.time - began
        warehouse.wait(*drives.values())
        later = warehouse.time - began - took
        print(f"bot {won} has won: {right - left:.1f} m in {took:.1f} s, the other {later:.1f} s later")


if __name__ == "__main__":
    sys.exit(run(main))
