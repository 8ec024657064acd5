"""What the programs in this folder have in common: usual files, a quiet end, and help that waits for nothing."""

from __future__ import annotations

import importlib
import os
import signal
import sys
from collections.abc import Callable
from typing import Any

import _environment

CONFIG = _environment.ROOT / "config"
SCENARIO = CONFIG / "scenarios" / "demo.yaml"
POLICIES = CONFIG / "policies" / "best.yaml"

INTERRUPTED = 128 + signal.SIGINT
NOBODY_READS = 128 + signal.SIGPIPE

signal.signal(signal.SIGINT, signal.SIG_DFL)  # while modules are loaded nothing has begun: Ctrl-C ends at once


def start(module: str, parse: Callable[..., object] | None = None, **usual: Any) -> int:
    """Load a program and run it to its end; its exit status.

    Args:
        module: Where its function `main` is; may take seconds to load.
        parse: Reads the command line and can be had at once: help, and what is wrong, are told before all is loaded.
        usual: What `main` and `parse` are told besides the command line.
    """

    def program() -> int:
        if parse is not None:
            parse(None, **usual)
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        main = importlib.import_module(module).main
        signal.signal(signal.SIGINT, signal.default_int_handler)
        return main(**usual)

    return carry_out(program)


def carry_out(program: Callable[[], int]) -> int:
    """Run a program to its end; its exit status, also where it is interrupted or nobody reads what it prints."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        try:
            return program()
        finally:
            sys.stdout.flush()
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        # what Python itself writes at its end goes nowhere, too
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return NOBODY_READS
