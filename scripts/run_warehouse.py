"""Run a live warehouse: every part a process of its own, every bot its own ROS node; see --help."""

import _environment

_environment.enter()

import sys

from _command_line import POLICIES, SCENARIO
from soup_lab.processes import load_ahead

if __name__ == "__main__":
    load_ahead()  # while this process loads its own

from soup_lab.warehouse_node import main

if __name__ == "__main__":
    sys.exit(main(scenario=SCENARIO, policies=POLICIES))
