"""Tests that get killed: they start a part as live tests do, and wait."""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path

if __name__ == "__main__":
    if sys.argv[1:] != ["part"]:
        sys.path.insert(0, str(Path(__file__).parents[2] / "scripts"))
        from conftest import MARK, Parts

        parts = Parts(Path.cwd())
        parts.mark = os.environ[MARK]
        parts.run_file(Path(__file__), "part")
    signal.pause()
