"""The ledger of bots: where each was seen, when it last did something, whether a collision holds it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from soup_msgs_py.codes import BotState
from soup_msgs_py.messages import Bots, Event, Snapshot
from soup_msgs_py.scenario import Scenario
from soup_sim.validate.violations import EPSILON, Law, Record

_DOING_NOTHING = (BotState.FREE, BotState.MOVING)


@dataclass(slots=True)
class _Stand:
    """A bot stands since one time; its last collision was at another.

    That is NaN where the collision was before the start, infinite where it stood too long and that is known.
    """

    since: float
    collided_at: float


class BotLedger:
    """What events and poses say about bots. Bots are handed in checked: they exist."""

    def __init__(self, scenario: Scenario, start: Snapshot, record: Record) -> None:
        """Begin with the bots of a snapshot."""
        self._max_speed = scenario.bot.max_speed_mps
        self._penalty_s = scenario.bot.collision_penalty_s
        self._record = record
        bots = start.bots
        self._start = start.time
        self._x: list[float] = bots.x.tolist()
        self._y: list[float] = bots.y.tolist()
        # moved on by the time that a bot stood since, so that all time after it is time to drive
        self._seen_at = [start.time] * len(self._x)
        self._free_at = [start.time if state in _DOING_NOTHING else -math.inf for state in bots.state]
        self._standing = {
            bot: _Stand(start.time, math.nan) for bot, state in enumerate(bots.state) if state == BotState.PENALISED
        }

    def operated(self, event: Event, duration_s: float) -> None:
        """A bot has finished a grab, a release or a transfer at a place."""
        bot, time = event.bot, event.time
        since = self._free_at[bot]
        if not time >= since + duration_s - EPSILON:
            self._record.add(
                time,
                Law.OPERATIONS,
                f"bot {bot} {event.type} {time - since:g} s after its last operation, not {duration_s:g} s",
            )
        self._free_at[bot] = time
        seen_at = self._seen_at[bot]
        if time < seen_at:
            return
        stand = self._standing.get(bot)
        driving_s = time - seen_at if stand is None else max(0.0, stand.since - seen_at)
        distance = math.hypot(event.x - self._x[bot], event.y - self._y[bot])
        if not distance <= self._max_speed * driving_s + EPSILON:
            self._too_far(time, bot, distance, driving_s)
        self._x[bot], self._y[bot], self._seen_at[bot] = event.x, event.y, time

    def collided(self, event: Event) -> None:
        """Bots stop dead."""
        for bot in event.bots:
            if not 0 <= bot < len(self._x):
                self._record.add(event.time, Law.NUMBERS, f"there is no bot {bot}, it cannot collide")
            elif bot in self._standing:
                self._standing[bot].collided_at = event.time
            else:
                self._standing[bot] = _Stand(event.time, event.time)

    def resumed(self, event: Event) -> None:
        """The penalty of a bot is over."""
        bot, time = event.bot, event.time
        stand = self._standing.pop(bot, None)
        if stand is None:
            self._record.add(time, Law.COLLISIONS, f"bot {bot} resumed without a collision")
            return
        if math.isnan(stand.collided_at):
            on_time = time <= self._start + self._penalty_s + EPSILON
        else:
            stood_s = time - stand.collided_at
            on_time = stood_s == -math.inf or abs(stood_s - self._penalty_s) <= EPSILON
        if not on_time:
            self._record.add(
                time,
                Law.COLLISIONS,
                f"bot {bot} resumed {time - stand.collided_at:g} s after its last collision "
                f"instead of {self._penalty_s:g} s",
            )
        self._seen_at[bot] += max(0.0, time - max(stand.since, self._seen_at[bot]))

    def sighted(self, bots: Bots) -> None:
        """All bots are seen at one instant: none was faster than it can be, none that stands has moved."""
        time = bots.time
        seen_at = np.array(self._seen_at)
        until = np.full(len(seen_at), time)
        standing = np.fromiter(self._standing, np.intp, len(self._standing))
        until[standing] = [min(time, stand.since) for stand in self._standing.values()]
        driving_s = np.maximum(until - seen_at, 0.0)
        distance = np.hypot(bots.x - np.array(self._x), bots.y - np.array(self._y))
        too_far = ~(distance <= self._max_speed * driving_s + EPSILON) & (seen_at <= time)
        for bot in np.flatnonzero(too_far).tolist():
            self._too_far(time, bot, float(distance[bot]), float(driving_s[bot]))
        for bot, stand in self._standing.items():
            speed = math.hypot(bots.vx[bot], bots.vy[bot])
            if time >= stand.since and not speed <= EPSILON:
                self._record.add(
                    time,
                    Law.COLLISIONS,
                    f"bot {bot} drives at {speed:g} m/s and must stand after a collision",
                )
        if (seen_at <= time).all():
            self._x, self._y = bots.x.tolist(), bots.y.tolist()
            self._seen_at = [time] * len(seen_at)
        self.check_standing(time)

    def check_standing(self, time: float) -> None:
        """Nobody stands longer than the penalty; who does is written down once and let go."""
        for bot, stand in list(self._standing.items()):
            since = self._start if math.isnan(stand.collided_at) else stand.collided_at
            if time > since + self._penalty_s + EPSILON:
                self._record.add(
                    time,
                    Law.COLLISIONS,
                    f"bot {bot} has not resumed, {time - since:g} s after its last collision",
                )
                stand.collided_at = math.inf

    def _too_far(self, time: float, bot: int, distance: float, driving_s: float) -> None:
        """Write down a bot that is where it cannot be."""
        if bot in self._standing and time >= self._standing[bot].since:
            law, sentence = Law.COLLISIONS, f"bot {bot} moved {distance:g} m and must stand after a collision"
        else:
            law, sentence = Law.SPEED, f"bot {bot} moved {distance:g} m in {driving_s:g} s"
        self._record.add(time, law, sentence)
