"""Replay a bag as if the warehouse ran; see --help."""

import _environment

_environment.enter()

import sys

from _command_line import start

if __name__ == "__main__":
    sys.exit(start("soup_lab.bag_replay_node"))
