"""Run a warehouse and kill, stop and swap its parts at random; see --help."""

import _environment

_environment.enter()

import sys
from pathlib import Path

from soup_lab.chaos_node import main

if __name__ == "__main__":
    sys.exit(main(scripts=Path(__file__).resolve().parent))
