"""Have a new manager, or a new mind for some bots, take over from the one that runs; see --help."""

import _environment

_environment.enter()

import sys

from _command_line import POLICIES, start
from soup_lab.lab_arguments import parse_swap

if __name__ == "__main__":
    sys.exit(start("soup_lab.launch.swap_program", parse_swap, policies=POLICIES))
