"""A waypoint graph in the making."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from soup_msgs_py.scenario import Scenario
from soup_msgs_py.scenario.parameters import Floor
from soup_msgs_py.warehouse.layout import Floats, Layout

Indices = NDArray[np.integer[Any]]
Mask = NDArray[np.bool_]

WRONG_WAY = 5.0  # cost of driving against a lane's direction, per metre
BOTH_WAYS = 0


@dataclass
class Draft:
    """Waypoints and edges that may still change; `Layout` is what they become.

    Attributes:
        waypoints: Positions (m), shape (n, 2).
        is_spot: Which waypoints are storage spots, shape (n,).
        edges: Directed edges, shape (e, 2).
        weights: Cost of each edge per metre, shape (e,).
        words: Waypoints of the word stations.
        letters: Waypoints of the letter stations.
        deep: Whether loaded bots pass through storage spots on their way, so that buckets must be dug out.
        drawn_at: What a drawn waypoint is called, `line 3, column 7`; empty for computed layouts.
    """

    waypoints: Floats
    is_spot: Mask
    edges: Indices = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    weights: Floats = field(default_factory=lambda: np.zeros(0))
    words: list[int] = field(default_factory=list)
    letters: list[int] = field(default_factory=list)
    deep: bool = False
    drawn_at: list[str] = field(default_factory=list)

    @property
    def stations(self) -> list[int]:
        """Waypoints of all stations, word stations first."""
        return self.words + self.letters

    def name(self, waypoint: int) -> str:
        """Where a waypoint is, for people."""
        x, y = self.waypoints[waypoint]
        return self.drawn_at[waypoint] if self.drawn_at else f"({x:g}, {y:g})"

    def add_edges(self, tails: Indices, heads: Indices, weights: Floats) -> None:
        """Add directed edges."""
        self.edges = np.concatenate([self.edges, np.stack([tails, heads], axis=1)])
        self.weights = np.concatenate([self.weights, weights])

    def join(self, a: Indices, b: Indices, favoured: Indices) -> None:
        """Both directions between pairs; `favoured` 1: lane from a to b, -1: from b to a, else both ways."""
        self.add_edges(a, b, np.where(favoured == -1, WRONG_WAY, 1.0))
        self.add_edges(b, a, np.where(favoured == 1, WRONG_WAY, 1.0))

    def keep_edges(self, kept: Mask) -> None:
        """Leave out all other edges."""
        self.edges, self.weights = self.edges[kept], self.weights[kept]

    def keep_waypoints(self, kept: Mask) -> None:
        """Leave out all other waypoints, none of them a station, with their edges, and number anew."""
        number = np.cumsum(kept) - 1
        self.keep_edges(np.all(kept[self.edges], axis=1))
        self.edges = number[self.edges]
        self.waypoints, self.is_spot = self.waypoints[kept], self.is_spot[kept]
        self.words = number[self.words].tolist() if self.words else []
        self.letters = number[self.letters].tolist() if self.letters else []

    def parts(self, passable: Mask) -> Indices:
        """The strongly connected part of each waypoint, by edges between passable ones; -1 for the others."""
        n = len(self.waypoints)
        used = self.edges[passable[self.edges].all(axis=1)]
        graph = coo_matrix((np.ones(len(used)), (used[:, 0], used[:, 1])), shape=(n, n))
        part = connected_components(graph, directed=True, connection="strong")[1]
        return np.where(passable, part, -1)

    def main_part(self, passable: Mask) -> Mask:
        """Which waypoints belong to the largest of the `parts`."""
        part = self.parts(passable)
        if not passable.any():
            return passable
        return part == np.bincount(part[passable]).argmax()

    def layout(self, floor: Floor) -> Layout:
        """The finished layout."""
        return Layout(
            width_m=floor.width_m,
            height_m=floor.height_m,
            waypoints=np.array(self.waypoints, dtype=np.float64),
            edges=np.array(self.edges, dtype=np.int32).reshape(-1, 2),
            edge_weights=np.array(self.weights, dtype=np.float64),
            storage_spots=np.flatnonzero(self.is_spot).astype(np.int32),
            word_stations=np.array(self.words, dtype=np.int32),
            letter_stations=np.array(self.letters, dtype=np.int32),
        )


def body_m(scenario: Scenario) -> float:
    """The diameter of the largest bodies: nearer than this, bots or buckets at two places touch."""
    return 2.0 * max(scenario.bot.radius_m, scenario.bucket.radius_m)


def distances_to_segments(place: Floats, starts: Floats, ends: Floats) -> Floats:
    """How far a place is from straight ways, or how far places are from one way (m); shapes broadcast."""
    along = ends - starts
    squares = (along * along).sum(axis=-1)
    share = ((place - starts) * along).sum(axis=-1) / np.where(squares > 0.0, squares, 1.0)
    gap = place - starts - np.clip(share, 0.0, 1.0)[..., None] * along
    return np.sqrt((gap * gap).sum(axis=-1))
