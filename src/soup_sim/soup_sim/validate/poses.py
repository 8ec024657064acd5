"""The laws of space: what must hold between all discs at one instant."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from soup_msgs_py.messages import Bots, Buckets
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Layout
from soup_sim.validate.buckets import BucketLedger
from soup_sim.validate.violations import EPSILON, Law, Record

Places = NDArray[np.float64]  # shape (n, 2)


class PoseLaws:
    """Looks at one instant after another. What stays wrong from one look to the next is written down once."""

    def __init__(
        self, scenario: Scenario, layout: Layout, buckets: BucketLedger, record: Record, rounding_m: float
    ) -> None:
        """Prepare for looking; places of buckets are told to within `rounding_m`."""
        self._rounding = rounding_m
        self._width, self._height = layout.width_m, layout.height_m
        self._max_speed = scenario.bot.max_speed_mps
        self._bot_reach = 2 * scenario.bot.radius_m - EPSILON
        self._bucket_reach = 2 * scenario.bucket.radius_m - rounding_m
        self._tolerance = scenario.bot.tolerance_m + rounding_m
        self._spots = cKDTree(_places(buckets.spot_xy))
        self._spot_changes = buckets.spot_changes
        self._ledger = buckets
        self._record = record
        self._known: set[tuple[str, Any]] = set()
        self._found: set[tuple[str, Any]] = set()
        self._time = 0.0

    def check(self, bots: Bots, buckets: Buckets, current: bool) -> bool:
        """Judge one instant.

        Args:
            bots: All bots.
            buckets: All buckets, at the same instant.
            current: Whether the ledger of buckets is true at this instant.

        Returns:
            Whether the numbers could be judged at all: arrays of the right shape, finite values.
        """
        self._time, self._found = bots.time, set()
        if buckets.time != bots.time:
            self._record.add(
                bots.time, Law.CLOCK, f"poses of buckets at {buckets.time:g} s, of bots at {bots.time:g} s"
            )
        readable = self._shapes(bots, buckets) and self._finite(bots, buckets)
        if readable:
            at_bots, at_buckets = np.column_stack([bots.x, bots.y]), np.column_stack([buckets.x, buckets.y])
            self._on_floor("bot", at_bots)
            self._on_floor("bucket", at_buckets)
            self._speed(bots)
            self._apart(at_bots, at_buckets, buckets)
            self._carried(bots, buckets, at_bots, at_buckets)
            if buckets.time >= self._ledger.spots_changed_at:
                self._stored(buckets, at_buckets)
            if current:
                self._as_in_ledger(bots, buckets)
        self._known = self._found
        return readable

    def _report(self, law: Law, what: str, which: Iterable[Any], sentence: Callable[[Any], str]) -> None:
        """Write down what was not wrong before; `what` and one of `which` say what it is."""
        for one in which:
            self._found.add((what, one))
            if (what, one) not in self._known:
                self._record.add(self._time, law, sentence(one))

    def _shapes(self, bots: Bots, buckets: Buckets) -> bool:
        bot_arrays = (bots.x, bots.y, bots.heading, bots.vx, bots.vy, bots.bucket, bots.state)
        bucket_arrays = (buckets.x, buckets.y, buckets.bot, buckets.tiles)
        wrong = [
            name
            for name, arrays, count in (
                ("bots", bot_arrays, len(self._ledger.carried)),
                ("buckets", bucket_arrays, len(self._ledger.bot)),
            )
            if any(array.shape != (count,) for array in arrays)
        ]
        self._report(Law.NUMBERS, "shape", wrong, lambda name: f"the poses show too few or too many {name}")
        return not wrong

    def _finite(self, bots: Bots, buckets: Buckets) -> bool:
        arrays = {
            "bot": (bots.x, bots.y, bots.heading, bots.vx, bots.vy),
            "bucket": (buckets.x, buckets.y),
        }
        finite = True
        for name, values in arrays.items():
            wrong = np.flatnonzero(~np.isfinite(np.array(values)).all(axis=0)).tolist()
            finite = finite and not wrong
            self._report(
                Law.NUMBERS,
                f"finite {name}",
                wrong,
                lambda n, name=name: f"{name} {n} has a place, heading or speed that is no number",
            )
        return finite

    def _on_floor(self, name: str, at: Places) -> None:
        size = np.array([self._width, self._height])
        wrong = ((at < -self._rounding) | (at > size + self._rounding)).any(axis=1)
        self._report(
            Law.FLOOR,
            f"floor {name}",
            np.flatnonzero(wrong).tolist(),
            lambda n: f"{name} {n} is off the floor, at {_written(at[n])}",
        )

    def _speed(self, bots: Bots) -> None:
        speed = np.hypot(bots.vx, bots.vy)
        self._report(
            Law.SPEED,
            "speed",
            np.flatnonzero(speed > self._max_speed + EPSILON).tolist(),
            lambda n: f"bot {n} drives at {speed[n]:g} m/s, its maximum is {self._max_speed:g} m/s",
        )

    def _apart(self, at_bots: Places, at_buckets: Places, buckets: Buckets) -> None:
        close = cKDTree(at_bots).query_pairs(self._bot_reach, output_type="ndarray")
        self._report(
            Law.OVERLAP,
            "bots",
            map(tuple, close.tolist()),
            lambda pair: f"bots {pair[0]} and {pair[1]} overlap, {_distance(at_bots, pair):g} m apart",
        )
        close = cKDTree(at_buckets).query_pairs(self._bucket_reach, output_type="ndarray")
        close = close[(buckets.bot[close] >= 0).any(axis=1)]
        self._report(
            Law.OVERLAP,
            "buckets",
            map(tuple, close.tolist()),
            lambda pair: (
                f"buckets {pair[0]} and {pair[1]} overlap, {_distance(at_buckets, pair):g} m apart, "
                "and one of them is carried"
            ),
        )

    def _carried(self, bots: Bots, buckets: Buckets, at_bots: Places, at_buckets: Places) -> None:
        holders = np.flatnonzero(bots.bucket >= 0)
        held = np.flatnonzero(buckets.bot >= 0)
        wrong_bots = holders[bots.bucket[holders] >= len(at_buckets)].tolist()
        wrong_buckets = held[buckets.bot[held] >= len(at_bots)].tolist()
        self._report(
            Law.NUMBERS,
            "holder",
            wrong_bots,
            lambda n: f"bot {n} carries bucket {bots.bucket[n]}, which is none",
        )
        self._report(
            Law.NUMBERS,
            "held",
            wrong_buckets,
            lambda n: f"bucket {n} is on bot {buckets.bot[n]}, which is none",
        )
        if wrong_bots or wrong_buckets:
            return
        self._report(
            Law.CARRYING,
            "one bucket",
            holders[buckets.bot[bots.bucket[holders]] != holders].tolist(),
            lambda n: f"bot {n} carries bucket {bots.bucket[n]}, that is on bot {buckets.bot[bots.bucket[n]]}",
        )
        self._report(
            Law.CARRYING,
            "one bot",
            held[bots.bucket[buckets.bot[held]] != held].tolist(),
            lambda n: f"bucket {n} is on bot {buckets.bot[n]}, that has bucket {bots.bucket[buckets.bot[n]]}",
        )
        away = np.hypot(*(at_buckets[held] - at_bots[buckets.bot[held]]).T)
        self._report(
            Law.CARRYING,
            "together",
            held[away > self._rounding].tolist(),
            lambda n: f"bucket {n} is not where bot {buckets.bot[n]} is, which carries it",
        )

    def _stored(self, buckets: Buckets, at_buckets: Places) -> None:
        if self._spot_changes != self._ledger.spot_changes:
            self._spots, self._spot_changes = cKDTree(_places(self._ledger.spot_xy)), self._ledger.spot_changes
        resting = np.flatnonzero(buckets.bot < 0)
        distance, _ = self._spots.query(at_buckets[resting], distance_upper_bound=self._tolerance)
        self._report(
            Law.STORAGE,
            "spot",
            resting[np.isinf(distance)].tolist(),
            lambda n: f"bucket {n} rests at {_written(at_buckets[n])}, where no storage spot is",
        )

    def _as_in_ledger(self, bots: Bots, buckets: Buckets) -> None:
        ledger = self._ledger
        carried, bot = np.array(ledger.carried), np.array(ledger.bot)
        self._report(
            Law.SNAPSHOT,
            "carried",
            np.flatnonzero(bots.bucket != carried).tolist(),
            lambda n: f"bot {n} carries bucket {bots.bucket[n]} in the poses, {carried[n]} by the events",
        )
        self._report(
            Law.SNAPSHOT,
            "bot",
            np.flatnonzero(buckets.bot != bot).tolist(),
            lambda n: f"bucket {n} is on bot {buckets.bot[n]} in the poses, {bot[n]} by the events",
        )
        fill = np.array(ledger.fill)
        self._report(
            Law.TILES,
            "fill",
            np.flatnonzero(buckets.tiles != fill).tolist(),
            lambda n: f"bucket {n} holds {buckets.tiles[n]} tiles in the poses, {fill[n]} by the events",
        )
        moved = np.hypot(buckets.x - np.array(ledger.x), buckets.y - np.array(ledger.y))
        self._report(
            Law.STORAGE,
            "moved",
            np.flatnonzero((moved > self._rounding) & (buckets.bot < 0) & (bot < 0)).tolist(),
            lambda n: f"bucket {n} moved {moved[n]:g} m from where it rests",
        )


def _places(spot_xy: dict[int, tuple[float, float]]) -> Places:
    """The places of storage spots."""
    return np.array(list(spot_xy.values())).reshape(-1, 2)


def _written(place: Places) -> str:
    """A place as text."""
    return f"({place[0]:g}, {place[1]:g})"


def _distance(at: Places, pair: tuple[int, int]) -> float:
    """How far apart two things are (m)."""
    return float(np.hypot(*(at[pair[0]] - at[pair[1]])))
