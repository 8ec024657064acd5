"""A program that starts one part which never ends by itself, says its number, and waits."""

from __future__ import annotations

import signal
import sys
import tempfile
from pathlib import Path

from soup_lab.launch.processes import Part, Processes

if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        processes = Processes(Path(folder))
        processes.start(Part("spinner", "spinning_part", tuple(sys.argv[1:])))
        print(processes.number("spinner"), flush=True)
        signal.pause()
