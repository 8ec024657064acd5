"""Drive one bot to a place, and say what it does meanwhile. The world and the bot run, no fleet manager.

python3 examples/drive.py
python3 examples/drive.py 1 10 20
"""

import _checkout

_checkout.enter()

import math
import sys

from soup_live.warehouse import Warehouse, run


def main() -> None:
    """Without arguments: bot 0, to the middle of the floor."""
    with Warehouse() as warehouse:
        bot = int(sys.argv[1]) if len(sys.argv) > 1 else 0
        middle = warehouse.layout.width_m / 2, warehouse.layout.height_m / 2
        goal = (float(sys.argv[2]), float(sys.argv[3])) if len(sys.argv) > 3 else middle
        x, y, _ = warehouse.pose(bot)
        began = warehouse.time
        drive = warehouse.drive(bot, goal)
        for feedback in warehouse.follow(drive):
            print(f"bot {bot} {feedback.message}")
        warehouse.wait(drive)  # raises unless it is there
        took = warehouse.time - began
        x_now, y_now, _ = warehouse.pose(bot)
        print(f"({x:.1f}, {y:.1f}) to ({x_now:.1f}, {y_now:.1f}): {math.dist((x, y), goal):.1f} m in {took:.1f} s")


if __name__ == "__main__":
    sys.exit(run(main))
