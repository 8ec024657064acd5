"""Broken laws: which there are, and where they are written down."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

EPSILON = 1e-6  # metres, seconds or metres a second: what rounding may cost


class Law(StrEnum):
    """The laws of the warehouse."""

    SEQUENCE = "sequence"  # events are numbered without gaps
    CLOCK = "clock"  # time never goes back
    NUMBERS = "numbers"  # bots, buckets and stations that exist; finite values; arrays of the right shape
    TILES = "tiles"  # no tile lost, made or in two places
    CAPACITY = "capacity"  # buckets and stations hold what they may hold
    WORDS = "words"  # assigned once, completed when the last letter is in, cleared after that
    BUNDLES = "bundles"  # of one size, staged once, emptied when the last tile is out
    STATIONS = "stations"  # a station does one thing at a time
    OPERATIONS = "operations"  # so does a bot
    TOLERANCE = "tolerance"  # a grab, a release or a transfer happens where it may
    CARRYING = "carrying"  # a bucket on at most one bot, a bot under at most one bucket, both at one place
    STORAGE = "storage"  # buckets rest on storage spots, one on each, and do not move
    COLLISIONS = "collisions"  # all involved stand for the penalty time
    FLOOR = "floor"  # nothing leaves it
    OVERLAP = "overlap"  # nothing runs into anything else of its layer
    SPEED = "speed"  # nothing is faster than it can be
    SNAPSHOT = "snapshot"  # the world tells the same as its events


@dataclass(frozen=True, slots=True)
class Violation:
    """One broken law: when (simulated seconds), which, and what happened in one sentence."""

    time: float
    law: Law
    sentence: str


class Record:
    """All violations are counted, the first `limit` are kept."""

    def __init__(self, limit: int) -> None:
        """Start with none."""
        self.limit = limit
        self.count = 0
        self.violations: list[Violation] = []

    def add(self, time: float, law: Law, sentence: str) -> None:
        """Write down one violation."""
        self.count += 1
        if len(self.violations) < self.limit:
            self.violations.append(Violation(float(time), law, sentence))
