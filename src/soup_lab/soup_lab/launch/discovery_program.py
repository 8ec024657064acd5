"""The discovery server of a warehouse that is spread over machines."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

from soup_msgs_py.command_line.arguments import Parser, port
from soup_msgs_py.command_line.display import on_display

PROGRAM = "fast-discovery-server"
PORT = 11811  # that of Fast DDS


@on_display
def main(argv: Sequence[str] | None = None) -> int:
    """Become the discovery server; returns only where there is none: the exit status."""
    parser = Parser(
        "Run a discovery server. Start every part of the warehouse, on all machines, with the environment variable "
        "ROS_DISCOVERY_SERVER=ADDRESS:PORT, where ADDRESS is the address of this machine."
    )
    parser.add_argument("--address", default="0.0.0.0", help="address to listen on (default: all of this machine)")
    parser.add_argument("--port", type=port, default=PORT, metavar="N", help=f"UDP port to listen on (default: {PORT})")
    options = parser.parse_args(argv)
    beside = Path(sys.executable).with_name(PROGRAM)
    program = str(beside) if beside.exists() else shutil.which(PROGRAM)
    if program is None:
        parser.error(f"found no {PROGRAM}; it comes with rmw_fastrtps (sudo apt install ros-jazzy-rmw-fastrtps-cpp)")
    print(f"discovery server: {options.address}:{options.port}", flush=True)
    os.execv(program, [program, "-i", "0", "-l", options.address, "-p", str(options.port)])


if __name__ == "__main__":
    sys.exit(main())
