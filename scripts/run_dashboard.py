"""Run the browser page. Needs nothing else to be running yet."""

import _environment

_environment.enter()

import sys

from soup_dashboard.dashboard_node import main

if __name__ == "__main__":
    sys.exit(main())
