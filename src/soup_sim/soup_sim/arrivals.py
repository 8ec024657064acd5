"""When orders and bundles arrive: at random through the day, or as a file says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np

from soup_msgs_py.errors import InputError
from soup_msgs_py.reading.files import read_text
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.scenario.demand import BundleFile, OrderFile, PoissonBundles, PoissonOrders
from soup_msgs_py.warehouse.tiles import parse_tile

HOUR_S = 3600.0
_LARGEST_FILE_BYTES = 50_000_000


def exponential(rng: np.random.Generator) -> float:
    """An exponential draw of mean 1, by comparisons alone (von Neumann, 1951): the same bits on any machine."""
    whole = 0
    while True:
        first = last = rng.random()
        run = 1
        while (draw := rng.random()) < last:
            last = draw
            run += 1
        if run % 2 == 1:
            return whole + first
        whole += 1


class PoissonArrivals:
    """Arrivals at random, with a rate that follows the hour of the day (thinning of a faster stream).

    Args:
        per_hour: Mean arrivals an hour, before the profile.
        daily_profile: Factor for each of the 24 hours; simulated time 0 is midnight.
        rng: Where randomness comes from.
    """

    def __init__(self, per_hour: float, daily_profile: Sequence[float], rng: np.random.Generator) -> None:
        self._profile = list(daily_profile)
        self._highest = max(self._profile)
        self._gap_s = HOUR_S / (per_hour * self._highest) if self._highest > 0.0 else float("inf")
        self._rng = rng

    def after(self, time: float) -> float:
        """The first arrival after a time (s); infinity for never."""
        if self._highest <= 0.0:
            return float("inf")
        while True:
            time += self._gap_s * exponential(self._rng)
            hour = int(time // HOUR_S) % 24
            if self._rng.random() * self._highest < self._profile[hour]:
                return time


@dataclass(frozen=True, slots=True)
class TimedWord:
    """A line of an order file: letters whose colours are drawn, or tile kinds."""

    time: float
    letters: str
    tiles: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class TimedBundle:
    """A line of a bundle file."""

    time: float
    tile: int


Timed = TypeVar("Timed", TimedWord, TimedBundle)


class Arrivals(Generic[Timed]):
    """When words or bundles arrive by themselves, and which ones where a file says so.

    Args:
        plan: The orders or bundles of a scenario.
        timed: The lines of its file, if it has one.
        rng: Where randomness comes from.
    """

    def __init__(self, plan: object, timed: Sequence[Timed], rng: np.random.Generator) -> None:
        self._timed = timed
        self._told = 0
        self._coming: Timed | None = None
        self._random: PoissonArrivals | None = None
        if isinstance(plan, (PoissonOrders, PoissonBundles)):
            self._random = PoissonArrivals(plan.per_hour, plan.daily_profile, rng)

    def next_time(self, now: float) -> float:
        """When the next one arrives by itself; infinity for never. Asked once after each arrival."""
        if self._random is not None:
            return self._random.after(now)
        self._coming = self._timed[self._told] if self._told < len(self._timed) else None
        self._told += 1
        return self._coming.time if self._coming is not None else float("inf")

    def take(self) -> Timed | None:
        """The line of the file that arrives now; None for one that has to be drawn."""
        coming, self._coming = self._coming, None
        return coming

    def capture(self) -> dict[str, Any]:
        """Everything that changes, for a checkpoint."""
        return {"told": self._told, "is_coming": self._coming is not None}

    def restore(self, state: dict[str, Any]) -> None:
        """The opposite of `capture`."""
        self._told = state["told"]
        self._coming = self._timed[self._told - 1] if state["is_coming"] else None


def read_timed_words(scenario: Scenario, source: object) -> tuple[TimedWord, ...]:
    """The orders of a scenario whose orders come from a file; empty for other scenarios.

    Raises:
        InputError: The file is missing or a line is wrong.
    """
    if not isinstance(scenario.orders, OrderFile):
        return ()
    path = Path(scenario.orders.path)
    allowed = "seconds,word or seconds,E0 T1 A0"
    found = []
    for line, time, text in _lines(path, source, "orders.path", allowed):
        if text.isascii() and text.isalpha():
            found.append(TimedWord(time, text.upper()))
        else:
            tiles = tuple(_tile(name, scenario, path, line, allowed) for name in text.split())
            found.append(TimedWord(time, "", tiles))
    return tuple(found)


def read_timed_bundles(scenario: Scenario, source: object) -> tuple[TimedBundle, ...]:
    """The bundles of a scenario whose bundles come from a file; empty for other scenarios.

    Raises:
        InputError: The file is missing or a line is wrong.
    """
    if not isinstance(scenario.bundles, BundleFile):
        return ()
    path = Path(scenario.bundles.path)
    allowed = "seconds,E0"
    return tuple(
        TimedBundle(time, _tile(text, scenario, path, line, allowed))
        for line, time, text in _lines(path, source, "bundles.path", allowed)
    )


def _lines(path: Path, source: object, key: str, allowed: str) -> list[tuple[int, float, str]]:
    """Line number, time and text of each line; empty lines and comments (#) are left out."""
    text = read_text(path, _LARGEST_FILE_BYTES, f"a file of lines {allowed}", (source, key))
    lines: list[tuple[int, float, str]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        line = line.partition("#")[0].strip()
        if not line:
            continue
        when, comma, what = line.partition(",")
        try:
            time = float(when)
        except ValueError:
            time = -1.0
        if not comma or not what.strip() or not 0.0 <= time < float("inf"):
            raise InputError(path, f"line {number}", repr(line), f"{allowed}, seconds from 0")
        if lines and time < lines[-1][1]:
            raise InputError(path, f"line {number}", f"{time:g} s after {lines[-1][1]:g} s", "lines in order of time")
        lines.append((number, time, what.strip()))
    if not lines:
        raise InputError(path, "", "no line", f"lines {allowed}")
    return lines


def _tile(name: str, scenario: Scenario, path: Path, line: int, allowed: str) -> int:
    try:
        tile = parse_tile(name)
    except ValueError:
        tile = -1
    if not 0 <= tile < scenario.tile_kinds:
        colours = len(scenario.colours.shares)
        raise InputError(path, f"line {line}", repr(name), f"{allowed}, colours 0 to {colours - 1}")
    return tile
