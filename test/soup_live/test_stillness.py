"""A process that was stopped for a while notices it; one that was only busy is not taken for it."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator

import pytest

from soup_live import process


@pytest.fixture
def still() -> Iterator[process.Stillness]:
    before = signal.getsignal(signal.SIGCONT)
    yield process.Stillness()
    signal.signal(signal.SIGCONT, before)


@pytest.mark.parametrize(
    ("gap_s", "continued", "stopped"), [(20.0, True, True), (20.0, False, False), (1.0, True, False)]
)
def test_only_who_was_told_to_continue_after_long_was_stopped(
    still: process.Stillness, monkeypatch: pytest.MonkeyPatch, gap_s: float, continued: bool, stopped: bool
):
    now = process.time.monotonic()
    monkeypatch.setattr(process.time, "monotonic", lambda: now + gap_s)
    if continued:
        os.kill(os.getpid(), signal.SIGCONT)
    assert still.look() is stopped
    assert not still.look()


def test_what_a_process_hears_late_because_it_was_stopped_is_not_acted_upon(monkeypatch: pytest.MonkeyPatch):
    heard: list[str] = []
    before = signal.getsignal(signal.SIGCONT)
    try:
        with process.Live("bots", starts_again=True, guest=True) as live:
            take = live.guard(heard.append)
            take("in time")
            now = process.time.monotonic()
            monkeypatch.setattr(process.time, "monotonic", lambda: now + 20.0)
            os.kill(os.getpid(), signal.SIGCONT)
            take("late")
            with pytest.raises(process.StoodStill):
                live.spin()
            monkeypatch.undo()
    finally:
        signal.signal(signal.SIGCONT, before)
    assert heard == ["in time"]
