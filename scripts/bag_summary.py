"""The figures of a run from its bag; see --help."""

import _environment

_environment.enter()

import sys

from soup_lab.bag_summary_cli import main

if __name__ == "__main__":
    sys.exit(main())
