"""What the page shows: the newest that the world has told, kept for any thread, handed out as JSON."""

from __future__ import annotations

import json
import threading
from collections import deque
from typing import Any

from soup_msgs_py.codes import EventType
from soup_msgs_py.figures import rows
from soup_msgs_py.messages import Bots, Buckets, Event, Stations, Word
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Layout
from soup_msgs_py.warehouse.tiles import tile_name

LATEST_WORDS = 12  # completed words on the page
METRE_DIGITS = 2
RADIAN_DIGITS = 2


class Store:
    """The newest state of one warehouse.

    The node's thread puts in what it hears (`take_...`), the page's thread takes out `floor` and `frame`.
    A new scenario means a new world: everything that the old one said is forgotten.

    Attributes:
        run: Counts the worlds that have been heard of, 0 before the first.
        revision: Counts what has been put in.
    """

    def __init__(self) -> None:
        self.run = 0
        self.revision = 0
        self._lock = threading.Lock()
        self._floor = "null"
        self._frame = ""
        self._frame_revision = -1
        self._forget()

    def take_scenario(self, scenario: Scenario, layout: Layout) -> None:
        """Begin with a new world."""
        floor = json.dumps(_floor(scenario, layout))
        sizes = {
            "bots": scenario.bots,
            "buckets": scenario.buckets,
            "word_stations": len(layout.word_stations),
            "letter_stations": len(layout.letter_stations),
            "scenario": scenario.name,
        }
        with self._lock:
            self._forget()
            self._floor, self._sizes = floor, sizes
            self.run += 1
            self.revision += 1

    def take_bots(self, bots: Bots) -> None:
        """Keep the newest bodies of the bots."""
        with self._lock:
            self._bots = bots
            self.revision += 1

    def take_buckets(self, buckets: Buckets) -> None:
        """Keep the newest places and fills of the buckets."""
        with self._lock:
            self._buckets = buckets
            self.revision += 1

    def take_stations(self, stations: Stations) -> None:
        """Keep the newest state of the stations, and how their open words read."""
        with self._lock:
            self._stations = stations
            for station in stations.word_stations:
                self._texts.update((word.word, word.text) for word in station.open_words)
            self.revision += 1

    def take_figures(self, figures: dict[str, float | int]) -> None:
        """Keep the newest figures of the run."""
        with self._lock:
            self._figures = figures
            self.revision += 1

    def take_notice(self, notice: str) -> None:
        """Keep what whoever looks on should know: whom the warehouse lacks; empty for nothing."""
        with self._lock:
            if notice != self._notice:
                self._notice = notice
                self.revision += 1

    def take_event(self, event: Event) -> None:
        """Keep what concerns words: how one that arrived reads, and that one was completed."""
        if event.type is EventType.WORD_ARRIVED:
            with self._lock:
                self._texts[event.job] = event.text
        elif event.type is EventType.WORD_COMPLETED:
            with self._lock:
                text = self._texts.pop(event.job, f"word {event.job}")
                self._completed.appendleft([round(event.time, 1), event.station, text])
                self.revision += 1

    def floor(self) -> str:
        """What never moves, as JSON: size, radii, storage spots, stations; `null` before a world is heard of."""
        with self._lock:
            return self._floor

    def frame(self) -> str:
        """What changes, as JSON with one array a quantity."""
        with self._lock:
            if self._frame_revision != self.revision:
                self._frame_revision = self.revision
                self._frame = json.dumps(self._contents(), separators=(",", ":"))
            return self._frame

    def _forget(self) -> None:
        self._sizes: dict[str, int | str] = {}
        self._bots: Bots | None = None
        self._buckets: Buckets | None = None
        self._stations: Stations | None = None
        self._figures: dict[str, float | int] = {}
        self._texts: dict[int, str] = {}  # of words that have arrived and are not completed
        self._notice = ""
        self._completed: deque[list[float | int | str]] = deque(maxlen=LATEST_WORDS)

    def _contents(self) -> dict[str, Any]:
        return {
            "time": self._bots.time if self._bots else 0.0,
            "bots": _bots(self._bots) if self._bots else None,
            "buckets": _buckets(self._buckets) if self._buckets else None,
            "stations": _stations(self._stations) if self._stations else [],
            "figures": [list(row) for row in rows({**self._figures, **self._sizes})],
            "completed": list(self._completed),
            "notice": self._notice,
        }


def _floor(scenario: Scenario, layout: Layout) -> dict[str, Any]:
    spots = layout.waypoints[layout.storage_spots].round(METRE_DIGITS)
    stations = layout.waypoints[layout.stations].round(METRE_DIGITS)
    return {
        "name": scenario.name,
        "width": layout.width_m,
        "height": layout.height_m,
        "bot_radius": scenario.bot.radius_m,
        "bucket_radius": scenario.bucket.radius_m,
        "capacity": scenario.bucket.capacity,
        "word_stations": len(layout.word_stations),
        "spots": {"x": spots[:, 0].tolist(), "y": spots[:, 1].tolist()},
        "stations": {"x": stations[:, 0].tolist(), "y": stations[:, 1].tolist()},
    }


def _bots(bots: Bots) -> dict[str, list[Any]]:
    return {
        "x": bots.x.round(METRE_DIGITS).tolist(),
        "y": bots.y.round(METRE_DIGITS).tolist(),
        "heading": bots.heading.round(RADIAN_DIGITS).tolist(),
        "bucket": bots.bucket.tolist(),
        "state": bots.state.tolist(),
    }


def _buckets(buckets: Buckets) -> dict[str, list[Any]]:
    return {
        "x": buckets.x.round(METRE_DIGITS).tolist(),
        "y": buckets.y.round(METRE_DIGITS).tolist(),
        "bot": buckets.bot.tolist(),
        "tiles": buckets.tiles.tolist(),
    }


def _stations(stations: Stations) -> list[dict[str, Any]]:
    words = [
        {"station": s.station, "bot": s.bot, "words": [[word.text, _marks(word)] for word in s.open_words]}
        for s in stations.word_stations
    ]
    letters = [
        {"station": s.station, "bot": s.bot, "bundles": [[tile_name(b.tile), b.count] for b in s.staged_bundles]}
        for s in stations.letter_stations
    ]
    return words + letters


def _marks(word: Word) -> list[int]:
    """For each letter 1 where it is in place."""
    return [int(there) for there in word.filled] or [0] * len(word.tiles)
