"""Write docs/reference from the code; see --help."""

import _environment

_environment.enter()

import sys

from _command_line import start
from soup_lab.lab_arguments import parse_reference

if __name__ == "__main__":
    sys.exit(start("soup_lab.reference.program", parse_reference, folder=_environment.ROOT / "docs" / "reference"))
