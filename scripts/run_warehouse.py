"""Run a live warehouse: every part a process of its own, every bot its own ROS node; see --help."""

import _environment

_environment.enter()

import sys
from typing import Any

from _command_line import POLICIES, SCENARIO, start
from soup_lab.launch.warehouse_arguments import parse


def prepare(argv: None, **usual: Any) -> None:
    """Read the command line, then let the parts load what they need while this process loads its own."""
    parse(argv, **usual)
    from soup_lab.launch.processes import load_ahead

    load_ahead()


if __name__ == "__main__":
    sys.exit(start("soup_lab.launch.warehouse_node", prepare, scenario=SCENARIO, policies=POLICIES))
