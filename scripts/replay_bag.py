"""Replay a bag as if the warehouse ran; see --help."""

import _environment

_environment.enter()

import sys

from _command_line import start
from soup_lab.bags.arguments import parse_replay

if __name__ == "__main__":
    sys.exit(start("soup_lab.bags.replay_node", parse_replay))
