"""Importing this binds a process to its starter: the first thing that the process does from which parts are forked."""

from __future__ import annotations

import os
import signal

from soup_lab.part import end_with

end_with(os.getppid(), signal.SIGKILL)
