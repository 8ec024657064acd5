"""The line that tells how a run goes: it fits into a terminal, and counts nothing before the run has begun."""

from __future__ import annotations

import io
import re

from rich.console import Console

from soup_lab.launch.warehouse_node import Progress

WAITS = "97 % of the time, most for bots 0-124,126-249"
FIGURES = {
    "sim_seconds": 123_456.0, "words_completed": 12_345, "letters_in_words": 123_456, "bot_collisions": 12,
    "bucket_collisions": 3, "real_time_factor": 4.98765,
}  # fmt: skip


def lines_on(width: int, figures: dict[str, float | int]) -> list[str]:
    """What a terminal has shown at the end, line by line."""
    screen = io.StringIO()
    progress = Progress(Console(file=screen, force_terminal=True, width=width, color_system=None), 360_000.0, 10.0)
    progress(figures, WAITS)
    progress.close()
    return re.split(r"[\r\n]+", re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", screen.getvalue()))


def test_the_line_of_a_slow_run_fits_into_eighty_columns():
    lines = lines_on(80, FIGURES)
    assert any("12,345 words · 15 collisions · 4.99 x real time" in line for line in lines)
    assert max(map(len, lines)) <= 80


def test_a_wide_terminal_shows_whom_the_world_waits_for():
    assert any(line.endswith(f"waits {WAITS}") for line in lines_on(200, FIGURES))


def test_nothing_is_counted_before_time_goes_on():
    lines = lines_on(80, {**FIGURES, "sim_seconds": 0.0, "real_time_factor": 0.0})
    assert any("the parts are starting" in line for line in lines)
    assert not any("waits" in line or "words" in line for line in lines)
