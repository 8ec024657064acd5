"""Measure speeds; see --help."""

import _environment

_environment.enter()

import sys

from soup_lab.benchmark_cli import main

if __name__ == "__main__":
    sys.exit(main())
