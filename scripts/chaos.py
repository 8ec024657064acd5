"""Run a warehouse and kill, stop and swap its parts at random; see --help."""

import _environment

_environment.enter()

import sys
from pathlib import Path

from _command_line import start

if __name__ == "__main__":
    sys.exit(start("soup_lab.chaos_node", scripts=Path(__file__).resolve().parent))
