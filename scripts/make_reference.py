"""Write docs/reference from the code; see --help."""

import _environment

_environment.enter()

import sys

from soup_lab.reference_cli import main

if __name__ == "__main__":
    sys.exit(main(_environment.ROOT / "docs" / "reference", sys.argv[1:]))
