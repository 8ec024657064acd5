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


def end_with(starter: int, number: signal.Signals) -> None:
    """Have this process get a signal when its starter, given by its process number, has ended, however that ends."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, number)
    if os.getppid() != starter:  # it was gone before
        os._exit(1)


def main() -> None:
    """Bind this process to its starter, then become the part."""
    end_with(int(os.environ[STARTER]), signal.SIGTERM)
    module, *arguments = sys.argv[1:]
    sys.argv = [module, *arguments]
    runpy.run_module(module, run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()
