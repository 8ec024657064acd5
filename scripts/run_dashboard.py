"""Run the browser page. Needs nothing else to be running yet."""

import _environment

_environment.enter()

import sys

from _command_line import start
from soup_msgs_py.command_line.part_arguments import parse_dashboard

if __name__ == "__main__":
    sys.exit(start("soup_dashboard.dashboard_node", parse_dashboard))
