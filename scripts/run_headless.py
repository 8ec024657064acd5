"""Run a warehouse in one process, deterministic and as fast as the machine can; see --help."""

import _environment

_environment.enter()

import sys

from soup_lab.headless_cli import main

if __name__ == "__main__":
    sys.exit(main())
