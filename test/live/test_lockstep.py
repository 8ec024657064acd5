"""A live run gives what a headless run gives, however fast it goes: time waits for every message on its way."""

from __future__ import annotations

import json
from typing import Any

import pytest

from .conftest import Parts

pytestmark = [pytest.mark.live, pytest.mark.timeout(600)]
SECONDS = 600
RUN = ("--duration", str(SECONDS), "--seed", "2", "--summary", "out.json")


def summary(parts: Parts, script: str, *arguments: str) -> dict[str, Any]:
    """The figures of a run."""
    status, _, err = parts.run(script, *RUN, *arguments)
    assert status == 0, err
    return json.loads((parts.folder / "out.json").read_text())


def test_at_any_speed_as_many_letters_arrive_as_in_one_process(parts: Parts):
    alone = summary(parts, "run_headless.py")
    live = summary(parts, "run_warehouse.py", "--speed", "max", "--no-dashboard")
    assert live["latency_s"] == 0.0
    assert live["violations"] == 0
    assert live["letters_in_words"] == pytest.approx(alone["letters_in_words"], rel=0.1)
