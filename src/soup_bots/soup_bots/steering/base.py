"""What a steering is: it looks at what a bot senses and says whether to follow the path or which velocity to take."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from soup_msgs_py.messages import Floats, Ints

FOLLOW = 0  # drive along the path as planned
VELOCITY = 1  # take the velocity (vx, vy)

# why a bot does not simply drive on; `Steer.other` names the bot or bucket
NONE = 0
EVADES = 1
BOT_ON_GOAL = 2
BUCKET_ON_GOAL = 3
BUCKET_IN_WAY = 4

Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Limits:
    """Sizes and limits, the same for all bots."""

    bot_radius_m: float
    bucket_radius_m: float
    max_speed_mps: float
    max_acceleration_mps2: float
    sensing_radius_m: float
    period_s: float  # between two calls of the steering
    width_m: float
    height_m: float


@dataclass(slots=True, eq=False)
class SteerView:
    """What is sensed at one instant. Do not change the arrays.

    Where the scenario blinds bots (`bot.sensing`) there is one row, and the arrays hold what that bot is told: what
    it does not see is far off the floor.

    Attributes:
        time: Simulated seconds.
        bot: The bots to steer, ascending, shape (rows,).
        goal_x: Next corner of each row's route, shape (rows,).
        goal_y: As above.
        next_x: The corner after that; the same one where there is none.
        next_y: As above.
        last: Whether the next corner is the end of the route, shape (rows,).
        end_x: The end of each row's route, shape (rows,).
        end_y: As above.
        x: Positions of all bots, shape (bots,). Row r is bot `bot[r]`.
        y: As above.
        vx: Velocities of all bots.
        vy: As above.
        bucket: The bucket each bot carries, -1 for none.
        state: `BotState` of each bot.
        bucket_x: Positions of all buckets, shape (buckets,).
        bucket_y: As above.
        bucket_bot: The bot that carries each bucket, -1 where it rests.
        limits: Sizes and limits.
        heading: Directions of all bots (rad).
        contents_of: What a bucket holds, as tile kind to count; None where bots are not told.
    """

    time: float
    bot: NDArray[np.int64]
    goal_x: Floats
    goal_y: Floats
    next_x: Floats
    next_y: Floats
    last: Flags
    end_x: Floats
    end_y: Floats
    x: Floats
    y: Floats
    vx: Floats
    vy: Floats
    bucket: Ints
    state: NDArray[np.uint8]
    bucket_x: Floats
    bucket_y: Floats
    bucket_bot: Ints
    limits: Limits
    heading: Floats
    contents_of: Callable[[int], Mapping[int, int]] | None

    def contents(self, bucket: int) -> Mapping[int, int] | None:
        """What a bucket holds; None where that is not told, and for no bucket (-1)."""
        return self.contents_of(bucket) if self.contents_of is not None and bucket >= 0 else None


@dataclass(slots=True, eq=False)
class Steer:
    """What to do, one element a row of the view.

    `mode` is FOLLOW or VELOCITY, `reason` one of NONE, EVADES, BOT_ON_GOAL, BUCKET_ON_GOAL,
    BUCKET_IN_WAY; `other` the bot or bucket that is the reason, -1 if it is none in particular.
    """

    mode: NDArray[np.int8]
    vx: Floats
    vy: Floats
    reason: NDArray[np.int8]
    other: Ints


@dataclass(frozen=True, slots=True)
class Me:
    """One bot that is steered. `last`: the goal, its next corner, is the end of its route."""

    bot: int
    x: float
    y: float
    vx: float
    vy: float
    goal_x: float
    goal_y: float
    last: bool
    loaded: bool
    heading: float


@dataclass(frozen=True, slots=True)
class Neighbour:
    """A bot or a resting bucket (`bot` is -1) that a bot senses.

    `contents` maps tile kind to count for the bucket that it is or carries; None: there is none, or it is not told.
    """

    bot: int
    x: float
    y: float
    vx: float
    vy: float
    loaded: bool
    heading: float = 0.0
    contents: Mapping[int, int] | None = None


class Steering:
    """How bots avoid each other. Extend it, and name your class with `--bot-policy FILE.py:Class`.

    Once every sensing period (the time a bot at full speed needs for its own radius) each driving bot is asked.
    Override `steer_one` in plain Python, or `steer` to decide for all rows with arrays. Keyword options of your
    `__init__` can be set in the policies file. Draw random numbers from `self.rng` only.

        class Slow(Steering):
            def steer_one(self, me, neighbours, limits):
                if not neighbours:
                    return None  # follow the path
                return 0.0, 0.0  # stand while anything is near

    Attributes:
        senses: Whether it looks around at all. Where it does not, it is never asked, and costs nothing: all bots
            follow their paths.
    """

    senses: bool = True
    rng: np.random.Generator  # set by the crew

    def steer_one(self, me: Me, neighbours: list[Neighbour], limits: Limits) -> tuple[float, float] | None:
        """Velocity (m/s) that one bot should take, or None to follow its path.

        Args:
            me: The bot. If it is loaded, resting buckets are in its way; otherwise it passes under them.
            neighbours: Everything within the sensing radius, bots before buckets.
            limits: Sizes and limits.
        """
        return None

    def steer(self, view: SteerView) -> Steer:
        """Decide for all rows; this one asks `steer_one` for each."""
        out = follow_all(len(view.bot))
        reach = view.limits.sensing_radius_m
        for row, bot in enumerate(view.bot.tolist()):
            x, y = float(view.x[bot]), float(view.y[bot])
            me = Me(
                bot,
                x,
                y,
                float(view.vx[bot]),
                float(view.vy[bot]),
                float(view.goal_x[row]),
                float(view.goal_y[row]),
                bool(view.last[row]),
                bool(view.bucket[bot] >= 0),
                float(view.heading[bot]),
            )
            near = (view.x - x) ** 2 + (view.y - y) ** 2 <= reach * reach
            near[bot] = False
            neighbours = [
                Neighbour(
                    other,
                    float(view.x[other]),
                    float(view.y[other]),
                    float(view.vx[other]),
                    float(view.vy[other]),
                    bool(view.bucket[other] >= 0),
                    float(view.heading[other]),
                    view.contents(int(view.bucket[other])),
                )
                for other in np.flatnonzero(near).tolist()
            ]
            near = ((view.bucket_x - x) ** 2 + (view.bucket_y - y) ** 2 <= reach * reach) & (view.bucket_bot < 0)
            neighbours += [
                Neighbour(-1, float(view.bucket_x[b]), float(view.bucket_y[b]), 0.0, 0.0, False, 0.0, view.contents(b))
                for b in np.flatnonzero(near).tolist()
            ]
            velocity = self.steer_one(me, neighbours, view.limits)
            if velocity is not None:
                out.mode[row] = VELOCITY
                out.reason[row] = EVADES
                out.vx[row], out.vy[row] = velocity
        return out


def follow_all(rows: int) -> Steer:
    """A decision that lets every row follow its path."""
    return Steer(
        np.zeros(rows, np.int8),
        np.zeros(rows),
        np.zeros(rows),
        np.zeros(rows, np.int8),
        np.full(rows, -1, np.int32),
    )
