"""Run a Fast DDS discovery server, by which the parts of a warehouse on several machines find each other."""

import _environment

_environment.enter()

import sys

from _command_line import start

if __name__ == "__main__":
    sys.exit(start("soup_lab.launch.discovery_program"))
