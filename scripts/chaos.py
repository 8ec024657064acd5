"""Run a warehouse and kill, stop and swap its parts at random; see --help."""

import _environment

_environment.enter()

import sys
from pathlib import Path

from _command_line import start
from soup_lab.lab_arguments import parse_chaos

if __name__ == "__main__":
    sys.exit(start("soup_lab.launch.chaos_node", parse_chaos, scripts=Path(__file__).resolve().parent))
