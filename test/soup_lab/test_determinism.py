"""The same inputs give the same events, byte for byte, however often and on however many processors."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

import _environment

RUN = [sys.executable, str(_environment.ROOT / "scripts" / "run_headless.py")]
SCENARIOS = _environment.ROOT / "config" / "scenarios"
POLICIES = _environment.ROOT / "config" / "policies"


def events_of_a_run(log: Path, scenario: str, policies: str, duration_s: int, processors: set[int]) -> str:
    """Run in a process of its own; the digest of its event log."""
    subprocess.run(
        [
            *RUN, "--scenario", str(SCENARIOS / scenario), "--policies", str(POLICIES / policies),
            "--duration", str(duration_s), "--seed", "7", "--event-log", str(log),
        ],
        check=True,
        capture_output=True,
        preexec_fn=lambda: os.sched_setaffinity(0, processors),
    )  # fmt: skip
    lines = log.read_bytes()
    assert lines.count(b'"transferred"') > 0
    return hashlib.sha256(lines).hexdigest()


@pytest.mark.parametrize("policies", ["minimal.yaml", "best.yaml"])
@pytest.mark.parametrize(("scenario", "duration_s"), [("demo.yaml", 300), ("paper.yaml", 240)])
def test_a_run_can_be_repeated_on_one_processor_or_all(tmp_path: Path, scenario: str, duration_s: int, policies: str):
    everywhere = os.sched_getaffinity(0)
    first = events_of_a_run(tmp_path / "a.jsonl", scenario, policies, duration_s, everywhere)
    again = events_of_a_run(tmp_path / "b.jsonl", scenario, policies, duration_s, {min(everywhere)})
    assert first == again
