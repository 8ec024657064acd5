"""The floor as every part knows it: waypoints, edges, storage spots and stations."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Layout:
    """A waypoint graph over the floor (paper, "Extendable Interfaces").

    Stations are numbered over both kinds: word stations first, letter stations after them.

    Attributes:
        width_m: Size along x.
        height_m: Size along y.
        waypoints: Positions in metres, shape (n, 2).
        edges: Directed edges between waypoints, shape (e, 2).
        edge_weights: Cost of each edge per metre, shape (e,): 1 is normal, more is the wrong way of a highway.
        storage_spots: Waypoints where a bucket may rest at the start, shape (s,); a `SetStorageSpot` changes it.
        word_stations: Waypoint of each word station.
        letter_stations: Waypoint of each letter station.
    """

    width_m: float
    height_m: float
    waypoints: Floats
    edges: Ints
    edge_weights: Floats
    storage_spots: Ints
    word_stations: Ints
    letter_stations: Ints

    def __eq__(self, other: object) -> bool:
        """Layouts are equal when all their numbers are."""
        if not isinstance(other, Layout):
            return NotImplemented
        return all(np.array_equal(getattr(self, f.name), getattr(other, f.name)) for f in fields(self))

    __hash__ = None  # type: ignore[assignment]

    @property
    def stations(self) -> Ints:
        """Waypoint of every station, word stations first."""
        return np.concatenate([self.word_stations, self.letter_stations])

    def station_xy(self, station: int) -> tuple[float, float]:
        """Position of a station in metres."""
        words = len(self.word_stations)
        waypoint = self.word_stations[station] if station < words else self.letter_stations[station - words]
        x, y = self.waypoints[waypoint]
        return float(x), float(y)

    def is_word_station(self, station: int) -> bool:
        """Whether the number belongs to a word station."""
        return 0 <= station < len(self.word_stations)

    def is_letter_station(self, station: int) -> bool:
        """Whether the number belongs to a letter station."""
        return 0 <= station - len(self.word_stations) < len(self.letter_stations)

    def station_name(self, station: int) -> str:
        """A station written out, for instance `word station 3`."""
        if self.is_word_station(station):
            return f"word station {station}"
        return f"letter station {station}"
