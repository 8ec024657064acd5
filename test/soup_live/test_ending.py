"""The very end of a process is watched where it is a part of a warehouse, and nobody else's."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from soup_live import ending


@pytest.mark.parametrize("to_the_last", [True, False])
def test_how_long_the_process_of_a_guest_takes_to_end_is_its_own_business(
    monkeypatch: pytest.MonkeyPatch, to_the_last: bool
):
    at_exit: list[Callable[[], None]] = []
    monkeypatch.setattr(ending.atexit, "register", at_exit.append)
    ending.Ending("part", lambda: 0, to_the_last=to_the_last)
    assert (ending.arm in at_exit) is to_the_last
