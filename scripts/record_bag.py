"""Record a live warehouse into a rosbag2 bag; see --help."""

import _environment

_environment.enter()

import sys

from soup_lab.bag_record_node import main

if __name__ == "__main__":
    sys.exit(main())
