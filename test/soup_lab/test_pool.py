"""Processes that share work end with their starter, and what happens to one is told."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import psutil
import pytest

from soup_lab.headless.pool import share_out
from soup_msgs_py.errors import RunError

PATIENCE_S = 60.0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL], ids=["Ctrl-C", "killed"])
def test_replications_that_are_stopped_leave_no_process(number: signal.Signals):
    program = "import sys; from soup_lab.headless.program import main; sys.exit(main(sys.argv[1:]))"
    run = ["--duration", "500000", "--replications", "2", "--processes", "2"]
    process = subprocess.Popen([sys.executable, "-c", program, *run], stderr=subprocess.PIPE, text=True)
    workers: list[psutil.Process] = []
    try:
        starter = psutil.Process(process.pid)
        deadline = time.monotonic() + PATIENCE_S
        while process.poll() is None and len(workers := starter.children(recursive=True)) < 3:  # one tracks resources
            assert time.monotonic() < deadline, "the replications do not start"
            time.sleep(0.1)
        assert process.poll() is None, process.communicate()[1]
        process.send_signal(number)
        process.communicate(timeout=PATIENCE_S)
    finally:
        process.kill()
        process.wait()
    _, alive = psutil.wait_procs(workers, timeout=PATIENCE_S)
    assert alive == []


def test_a_process_that_is_killed_at_its_work_is_told_in_a_sentence():
    with pytest.raises(RunError, match="one of the processes was killed"):
        list(share_out(os._exit, [(9,), (9,)], 1))


def test_outcomes_say_to_which_task_they_belong():
    assert sorted(share_out(divmod, [(7, 2), (9, 4)], 2)) == [(0, (3, 1)), (1, (2, 1))]
