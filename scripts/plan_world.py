"""Plan for several robots in a world of cells; see --help."""

import _environment

_environment.enter()

import sys

from _command_line import start
from soup_lab.lab_arguments import parse_plan

if __name__ == "__main__":
    sys.exit(start("soup_lab.planning.program", parse_plan))
