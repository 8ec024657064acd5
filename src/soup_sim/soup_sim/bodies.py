"""The bodies of all bots and buckets: where they are, how they move, when they touch."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from soup_msgs_py.kernel import kernel
from soup_msgs_py.messages import Floats, Ints, Point
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Layout
from soup_sim import motion
from soup_sim.contact import begin_window, contacts_of_some

Contact = tuple[float, int, int]  # time, bot, other: a bot, or -1 - b for resting bucket b
_AT_MOST = 20_000  # contacts found at once
_LOOSE = 256  # buckets released within one window


@kernel
def _positions(state, segments, count, t, out):
    """Position, velocity, heading of all bots at time t, shape (5, bots)."""
    for i in range(len(count)):
        x, y, vx, vy, _, _, heading, _, _ = motion.piece_at(state, segments, count, i, t)
        out[0, i], out[1, i], out[2, i], out[3, i], out[4, i] = x, y, vx, vy, heading


@kernel
def _bucket_positions(state, segments, count, bucket_xy, carrier, t, out):
    """Positions of all buckets at time t, shape (2, buckets)."""
    for b in range(len(carrier)):
        x, y = bucket_xy[b, 0], bucket_xy[b, 1]
        if carrier[b] >= 0:
            x, y, _, _, _, _, _, _, _ = motion.piece_at(state, segments, count, carrier[b], t)
        out[0, b], out[1, b] = x, y


@kernel
def _change_velocities(bots, state, segments, count, t, vx, vy, V, A, turn_rate, edges, odometer, moving, ends):
    """Give many bots target velocities; `ends` receives when each will stand."""
    for k in range(len(bots)):
        i = bots[k]
        odometer[i] += motion.length_of(state, segments, count, i, t)
        motion.plan_velocity(state, segments, count, i, t, vx[k], vy[k], V, A, turn_rate, edges)
        ends[k] = t + motion.duration_of(segments, count, i)
        moving[i] = ends[k] > t


@kernel
def _change_leg(i, state, segments, count, t, gx, gy, V, A, turn_rate, edges, duration, odometer, moving):
    """Send one bot straight to a goal; returns when it will be there."""
    odometer[i] += motion.length_of(state, segments, count, i, t)
    motion.plan_leg(state, segments, count, i, t, gx, gy, V, A, turn_rate, edges, duration)
    end = t + motion.duration_of(segments, count, i)
    moving[i] = end > t
    return end


@kernel
def _stand(i, state, segments, count, t, odometer, moving):
    """Stop one bot dead where it is at time t."""
    odometer[i] += motion.length_of(state, segments, count, i, t)
    motion.settle(state, segments, count, i, t)
    state[i, 3], state[i, 4] = 0.0, 0.0
    moving[i] = False


@kernel
def _arrive(i, state, segments, count, t, odometer, moving, x, y):
    """The same at the end of a leg: exactly on its goal, free of rounding."""
    _stand(i, state, segments, count, t, odometer, moving)
    state[i, 1], state[i, 2] = x, y


@kernel
def _driven(state, segments, count, t, odometer, out):
    """Distance that each bot has driven until time t."""
    for i in range(len(count)):
        out[i] = odometer[i] + motion.length_of(state, segments, count, i, t)


@kernel
def _fits(bucket, x, y, bucket_xy, carrier, apart):
    """Whether no resting bucket but `bucket` is nearer than `apart` to a place."""
    for b in range(len(carrier)):
        dx, dy = bucket_xy[b, 0] - x, bucket_xy[b, 1] - y
        if dx * dx + dy * dy < apart * apart and carrier[b] < 0 and b != bucket:
            return False
    return True


class Bodies:
    """Struct of arrays of everything that has a place on the floor.

    Attributes:
        bucket: The bucket that each bot carries, -1 for none.
        carrier: The bot that carries each bucket, -1 for none.
        moving: Whether a motion of the bot is under way.
        max_speed: Of the bots (m/s).
        turn_rate: Of the bots (rad/s); 0: turning takes no time.
        window_s: Contacts are looked for in windows of this length: the time that a bot needs for its own diameter
            at full speed. Longer ones are opened less often, but hold more pairs that may meet.
    """

    def __init__(self, scenario: Scenario, layout: Layout, bot_xy: Floats, bucket_xy: Floats) -> None:
        bots, buckets = len(bot_xy), len(bucket_xy)
        limits = scenario.bot
        self.max_speed = self._v = limits.max_speed_mps
        self._a = limits.max_acceleration_mps2
        self.turn_rate = limits.turn_rate_radps or 0.0
        self._r_bot, self._r_bucket = limits.radius_m, scenario.bucket.radius_m
        margin = max(self._r_bot, self._r_bucket)
        self.edges = np.array([margin, layout.width_m - margin, margin, layout.height_m - margin])
        self.window_s = 2.0 * self._r_bot / self._v

        self._state = np.zeros((bots, 6))
        self._state[:, 1:3] = bot_xy
        self._segments = np.zeros((bots, motion.MAX_SEGMENTS, 4))
        self._count = np.zeros(bots, dtype=np.int64)
        self._odometer = np.zeros(bots)
        self.moving = np.zeros(bots, dtype=np.bool_)
        self.bucket: Ints = np.full(bots, -1, dtype=np.int32)
        self._bucket_xy = np.array(bucket_xy, dtype=np.float64).reshape(buckets, 2)
        self.carrier: Ints = np.full(buckets, -1, dtype=np.int32)

        # two discs that can meet within a window are in neighbouring cells
        self._reach = 2.0 * self._v * self.window_s + 0.01
        self._cell = 2.0 * margin + self._reach
        self._places = np.zeros((bots, 2))
        self._nx = int(layout.width_m / self._cell) + 1
        self._ny = int(layout.height_m / self._cell) + 1
        cells = self._nx * self._ny
        self._grids = (
            np.full(cells, -1, dtype=np.int64),
            np.full(bots, -1, dtype=np.int64),
            np.full(cells, -1, dtype=np.int64),
            np.full(buckets, -1, dtype=np.int64),
        )
        self._loose = np.full(_LOOSE, -1, dtype=np.int64)
        self._loose_count = 0
        self._when = np.zeros(_AT_MOST)
        self._who = np.zeros(_AT_MOST, dtype=np.int64)
        self._other = np.zeros(_AT_MOST, dtype=np.int64)

    # ---- looking --------------------------------------------------------------------------------------------

    def table(self, t: float) -> Floats:
        """x, y, vx, vy, heading of every bot at time t, shape (5, bots)."""
        out = np.empty((5, len(self._count)))
        _positions(self._state, self._segments, self._count, t, out)
        return out

    def place(self, bot: int, t: float) -> Point:
        """Where a bot is at time t."""
        piece = motion.piece_at(self._state, self._segments, self._count, bot, t)
        return piece[0], piece[1]

    def bucket_place(self, bucket: int, t: float) -> Point:
        """Where a bucket is at time t."""
        bot = int(self.carrier[bucket])
        if bot >= 0:
            return self.place(bot, t)
        x, y = self._bucket_xy[bucket]
        return float(x), float(y)

    def bucket_places(self, t: float) -> Floats:
        """x, y of all buckets at time t, shape (2, buckets)."""
        out = np.empty((2, len(self.carrier)))
        _bucket_positions(self._state, self._segments, self._count, self._bucket_xy, self.carrier, t, out)
        return out

    def nearest_resting_bucket(self, x: float, y: float) -> tuple[int, float]:
        """The resting bucket that is nearest to a place, and its distance in metres; (-1, inf) if none rests."""
        resting = self.carrier < 0
        if not resting.any():
            return -1, np.inf
        d = self._bucket_xy - (x, y)
        squares = np.where(resting, d[:, 0] * d[:, 0] + d[:, 1] * d[:, 1], np.inf)
        nearest = int(squares.argmin())
        return nearest, float(np.sqrt(squares[nearest]))

    def bucket_fits(self, bucket: int, x: float, y: float) -> bool:
        """Whether a bucket, centred at a place, would overlap no other resting bucket."""
        return _fits(bucket, x, y, self._bucket_xy, self.carrier, 2.0 * self._r_bucket)

    def driven(self, t: float) -> Floats:
        """Distance that each bot has driven until time t, in metres."""
        out = np.zeros(len(self._count))
        _driven(self._state, self._segments, self._count, t, self._odometer, out)
        return out

    # ---- moving ---------------------------------------------------------------------------------------------

    def set_velocities(self, bots: Ints, vx: Floats, vy: Floats, t: float) -> Floats:
        """Give bots target velocities at time t; when each will stand if nothing else comes."""
        ends = np.zeros(len(bots))
        _change_velocities(
            bots, self._state, self._segments, self._count, t, vx, vy, self._v, self._a, self.turn_rate,
            self.edges, self._odometer, self.moving, ends,
        )  # fmt: skip
        return ends

    def turn(self, bot: int, turn_radps: float, seconds: float, t: float) -> float:
        """Turn a bot on the spot; when it will have finished."""
        _stand(bot, self._state, self._segments, self._count, t, self._odometer, self.moving)
        motion.plan_turn(self._state, self._segments, self._count, bot, t, turn_radps, seconds)
        self.moving[bot] = True
        return t + seconds

    def drive(self, bot: int, goal: Point, duration: float, t: float) -> float:
        """Send a bot straight to a goal, in `duration` if that is longer than needed; when it will be there."""
        return _change_leg(
            bot, self._state, self._segments, self._count, t, goal[0], goal[1], self._v, self._a, self.turn_rate,
            self.edges, duration, self._odometer, self.moving,
        )  # fmt: skip

    def stand(self, bot: int, t: float) -> None:
        """Stop a bot dead at time t."""
        _stand(bot, self._state, self._segments, self._count, t, self._odometer, self.moving)

    def arrive(self, bot: int, t: float, goal: Point) -> None:
        """Have a bot stand at the end of its leg at time t."""
        _arrive(bot, self._state, self._segments, self._count, t, self._odometer, self.moving, goal[0], goal[1])

    def speed(self, bot: int, t: float) -> float:
        """How fast a bot is at time t, in m/s."""
        piece = motion.piece_at(self._state, self._segments, self._count, bot, t)
        return float(np.sqrt(piece[2] * piece[2] + piece[3] * piece[3]))

    # ---- lifting --------------------------------------------------------------------------------------------

    def lift(self, bot: int, bucket: int) -> None:
        """Put a bucket on a standing bot, centred."""
        self.bucket[bot] = bucket
        self.carrier[bucket] = bot

    def set_down(self, bot: int, t: float) -> int:
        """Take the bucket off a standing bot; which one it was."""
        bucket = int(self.bucket[bot])
        self._bucket_xy[bucket] = self.place(bot, t)
        self.bucket[bot] = -1
        self.carrier[bucket] = -1
        self._loose[self._loose_count] = bucket
        self._loose_count = min(self._loose_count + 1, _LOOSE - 1)
        return bucket

    # ---- touching -------------------------------------------------------------------------------------------

    def contacts(self, t0: float, t1: float) -> list[Contact]:
        """All contacts within a new window."""
        self._loose[:] = -1
        self._loose_count = 0
        begin_window(
            self._state, self._segments, self._count, self._bucket_xy, self.carrier, t0,
            self._cell, self._nx, self._ny, *self._grids, self._places,
        )  # fmt: skip
        return self.contacts_of(self.moving.nonzero()[0], t0, t1, True)

    def contacts_of(self, bots: NDArray[np.int64], t0: float, t1: float, ordered: bool = False) -> list[Contact]:
        """The contacts of some bots within (the rest of) the window; `ordered`: each pair of moving bots once."""
        n: int = contacts_of_some(
            bots, ordered, self._state, self._segments, self._count, self.moving, self.bucket, self._bucket_xy,
            self.carrier, self._loose, t0, t1, self._r_bot, self._r_bucket, self._cell, self._nx, self._ny,
            *self._grids, self._places, self._reach, self._when, self._who, self._other,
        )  # fmt: skip
        if n == 0:
            return []
        return list(zip(self._when[:n].tolist(), self._who[:n].tolist(), self._other[:n].tolist(), strict=True))

    def touch_kind(self, bot: int, other: int) -> bool:
        """Whether a contact between two bots is one of their buckets (True) or of the bots themselves (False)."""
        return bool(self.bucket[bot] >= 0 and self.bucket[other] >= 0 and self._r_bucket > self._r_bot)

    # ---- checkpoint -----------------------------------------------------------------------------------------

    _KEPT = (
        "_state", "_segments", "_count", "_odometer", "moving", "bucket", "_bucket_xy", "carrier", "_loose",
        "_places",
    )  # fmt: skip

    def capture(self) -> dict[str, Any]:
        """Everything that moves, and the cells of the present window, for a checkpoint."""
        state = {name: getattr(self, name).tolist() for name in self._KEPT}
        return {**state, "grids": [grid.tolist() for grid in self._grids], "loose_count": self._loose_count}

    def restore(self, state: dict[str, Any]) -> None:
        """The opposite of `capture`."""
        for name in self._KEPT:
            array = getattr(self, name)
            array[...] = np.array(state[name], dtype=array.dtype).reshape(array.shape)
        for grid, captured in zip(self._grids, state["grids"], strict=True):
            grid[:] = captured
        self._loose_count = state["loose_count"]
