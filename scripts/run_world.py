"""Run the world: physics, stations, orders. Needs nothing else to be running yet."""

import _environment

_environment.enter()

import sys

from _command_line import SCENARIO
from soup_sim.world_node import main

if __name__ == "__main__":
    sys.exit(main(scenario=SCENARIO))
