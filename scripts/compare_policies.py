"""Compare policies on one scenario: a sweep with intervals and a report; see --help."""

import _environment

_environment.enter()

import sys

from soup_lab.compare_cli import main

if __name__ == "__main__":
    sys.exit(main())
