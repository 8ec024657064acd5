"""Run some bucketbots, for instance: run_bots.py 0-19. Needs nothing else to be running yet."""

import _environment

_environment.enter()

import sys

from _command_line import POLICIES, start
from soup_msgs_py.command_line.part_arguments import parse_bots

if __name__ == "__main__":
    sys.exit(start("soup_bots.bots_program", parse_bots, policies=POLICIES))
