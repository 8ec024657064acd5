"""Run the world: physics, stations, orders. Needs nothing else to be running yet."""

import _environment

_environment.enter()

import sys

from _command_line import SCENARIO, start
from soup_msgs_py.command_line.part_arguments import parse_world

if __name__ == "__main__":
    sys.exit(start("soup_sim.world_program", parse_world, scenario=SCENARIO))
