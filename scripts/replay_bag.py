"""Replay a bag as if the warehouse ran; see --help."""

import _environment

_environment.enter()

import sys

from soup_lab.bag_replay_node import main

if __name__ == "__main__":
    sys.exit(main())
