"""The figures of a run from its bag; see --help."""

import _environment

_environment.enter()

import sys

from _command_line import start
from soup_lab.bag_arguments import parse_summary

if __name__ == "__main__":
    sys.exit(start("soup_lab.bag_summary_cli", parse_summary))
