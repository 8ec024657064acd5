"""Run some bucketbots, for instance: run_bots.py 0-19. Needs nothing else to be running yet."""

import _environment

_environment.enter()

import sys

from _command_line import POLICIES
from soup_bots.bot_node import main

if __name__ == "__main__":
    sys.exit(main(policies=POLICIES))
