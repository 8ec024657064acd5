"""What a fleet policy decides: trips, and the letters that they move."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

from soup_msgs_py.errors import RunError

Key = tuple[str, int]  # DELIVER and a word, or STORE and a bundle


class Place(Enum):
    """Where a letter that is to be moved is in the fleet's books."""

    QUEUED = "queued"
    DEFERRED = "deferred"
    PROMISED = "promised"
    GONE = "gone"


@dataclass(slots=True, eq=False)
class Letter:
    """One letter tile that a task still has to have moved.

    Attributes:
        order: Its place in the queue of all letters: the arrival of its task, and its place in it.
        key: What it is for: (DELIVER, word) or (STORE, bundle).
        station: Where its bucket has to go.
        tile: Its tile kind.
        place: Whether it waits or a trip has promised to move it.
        reason: Why it waits, where a policy deferred it.
    """

    order: tuple[int, int]
    key: Key
    station: int
    tile: int
    place: Place = field(default=Place.QUEUED)
    reason: str = ""


@dataclass(frozen=True, slots=True)
class PlannedVisit:
    """One visit of a trip: the letters to move there, all of that station."""

    station: int
    letters: tuple[Letter, ...]


@dataclass(frozen=True, slots=True)
class TripPlan:
    """A trip to start now: the bot fetches the bucket, visits stations and stores it on a spot (waypoint)."""

    bot: int
    bucket: int
    visits: tuple[PlannedVisit, ...]
    spot: int


class PlanError(RunError):
    """A fleet policy planned what cannot be."""
