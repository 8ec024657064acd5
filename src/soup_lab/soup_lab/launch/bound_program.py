"""Runs a program that ends when its starter does.

`python3 -m soup_lab.launch.bound_program STARTER SIGNAL PROGRAM ...`
"""

from __future__ import annotations

import os
import signal
import sys

from soup_lab.launch.part import end_with


def bound(command: list[str], number: signal.Signals) -> list[str]:
    """A command as it is to be started by this process so that the program does not outlive it.

    The thread that starts the program has to last, too. The program keeps the number of the process.

    Args:
        command: The program and its arguments.
        number: The signal that the program gets when this process has ended, however that ends.
    """
    return [sys.executable, "-m", "soup_lab.launch.bound_program", str(os.getpid()), str(int(number)), *command]


if __name__ == "__main__":
    end_with(int(sys.argv[1]), signal.Signals(int(sys.argv[2])))
    os.execvp(sys.argv[3], sys.argv[3:])
