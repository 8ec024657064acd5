"""The figures of a run from its bag; see --help."""

import _environment

_environment.enter()

import sys

from _command_line import start
from soup_lab.bags.arguments import parse_summary

if __name__ == "__main__":
    sys.exit(start("soup_lab.bags.summary_program", parse_summary))
