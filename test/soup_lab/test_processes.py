"""A Ctrl-C at the moment at which a process is started."""

from __future__ import annotations

import os
import signal
from multiprocessing import forkserver

import pytest

from soup_lab.launch.processes import load_ahead


def test_a_ctrl_c_while_the_process_to_fork_from_starts_is_acted_on_afterwards(monkeypatch: pytest.MonkeyPatch):
    begun = []

    def start() -> None:
        os.kill(os.getpid(), signal.SIGINT)
        begun.append(signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, ()))

    monkeypatch.setattr(forkserver, "ensure_running", start)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            load_ahead()
    finally:
        signal.signal(signal.SIGINT, before)
    assert begun == [True]
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, ())
