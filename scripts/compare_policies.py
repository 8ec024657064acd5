"""Compare policies on one scenario: a sweep with intervals and a report; see --help."""

import _environment

_environment.enter()

import sys

from _command_line import start
from soup_lab.lab_arguments import parse_compare

if __name__ == "__main__":
    sys.exit(start("soup_lab.experiments.program", parse_compare))
