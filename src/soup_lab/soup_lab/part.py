"""Runs one part of a warehouse as a child of the program that started it.

`python -m soup_lab.part MODULE ARGUMENT...`: the part ends with its starter, even when that one is killed.
"""

from __future__ import annotations

import ctypes
import os
import runpy
import signal
import sys

PR_SET_PDEATHSIG = 1
STARTER = "SOUP_STARTER"  # environment variable: process number of the starter


def main() -> None:
    """Bind this process to its starter, then become the part."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != int(os.environ[STARTER]):  # it was gone before
        sys.exit(1)
    module, *arguments = sys.argv[1:]
    sys.argv = [module, *arguments]
    runpy.run_module(module, run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()
