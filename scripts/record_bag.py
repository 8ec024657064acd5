"""Record a live warehouse into a rosbag2 bag; see --help."""

import _environment

_environment.enter()

import sys

from _command_line import start
from soup_lab.bags.arguments import parse_record

if __name__ == "__main__":
    sys.exit(start("soup_lab.bags.record_node", parse_record))
