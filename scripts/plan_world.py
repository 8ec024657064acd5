"""Plan for several robots in a world of cells; see --help."""

import _environment

_environment.enter()

import sys

from soup_lab.plan_cli import main

if __name__ == "__main__":
    sys.exit(main())
