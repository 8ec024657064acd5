"""Run a warehouse in one process, deterministic and as fast as the machine can; see --help."""

import _environment

_environment.enter()

import sys

from _command_line import start
from soup_lab.headless.arguments import parse

if __name__ == "__main__":
    sys.exit(start("soup_lab.headless.program", parse))
