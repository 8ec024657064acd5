"""Measure speeds; see --help."""

import _environment

_environment.enter()

import sys

from _command_line import start
from soup_lab.lab_arguments import parse_benchmark

if __name__ == "__main__":
    sys.exit(start("soup_lab.benchmarks.program", parse_benchmark))
