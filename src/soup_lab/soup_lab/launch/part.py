"""One part of a warehouse as a child of the program that started it: it ends when that ends, however that is."""

from __future__ import annotations

import ctypes
import importlib
import multiprocessing
import os
import signal
import sys
import traceback
from pathlib import Path

from soup_lab.launch.guardian import be_guarded

PR_SET_PDEATHSIG = 1
PR_SET_NAME = 15


def end_with(starter: int, number: signal.Signals) -> None:
    """Have this process get a signal when its starter, given by its process number, has ended, however that ends."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, number)
    if os.getppid() != starter:  # it was gone before
        os._exit(1)


def become(name: str, module: str, arguments: tuple[str, ...], errors: Path, environment: dict[str, str]) -> None:
    """Bind this process, which was forked for a part, to its starter, then be the part.

    Args:
        name: Of the part; `ps` shows it.
        module: Its program: a module with a function `main`.
        arguments: Its command line.
        errors: Where its stderr goes.
        environment: Its environment variables.
    """
    os.setsid()  # a Ctrl-C reaches only the starter
    be_guarded()
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # which may end a part before it is one
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})  # it was forked from a process that waits with it
    end_with(os.getppid(), signal.SIGTERM)
    starter = multiprocessing.parent_process()
    if starter is None or not starter.is_alive():
        os._exit(1)
    ctypes.CDLL(None).prctl(PR_SET_NAME, name.encode()[:15], 0, 0, 0)
    nothing = os.open(os.devnull, os.O_WRONLY)
    try:
        words = os.open(errors, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o600)
    except OSError:  # no room: its reports have to do
        words = nothing
    os.dup2(nothing, 1)
    os.dup2(words, 2)
    os.environ.clear()
    os.environ.update(environment)
    sys.argv = [module, *arguments]
    try:
        status = importlib.import_module(module).main(arguments)
    except SystemExit as error:
        status = error.code if isinstance(error.code, int) else 1
    except BaseException:
        traceback.print_exc()
        status = 1
    # a child of multiprocessing would leave without DDS's own end
    ctypes.pythonapi.Py_Exit(status or 0)
