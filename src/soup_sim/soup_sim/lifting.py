"""Bots at work on buckets: grab and release, and the storage spots."""

from __future__ import annotations

from typing import Any

import numpy as np

from soup_msgs_py.codes import BotState, Code, EventType
from soup_msgs_py.messages import Grab, Release, Reply, SetStorageSpot
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Layout
from soup_sim.agenda import Common
from soup_sim.storage import Storage


class Lifting:
    """Carries out grabs and releases.

    Attributes:
        storage: The storage spots and the buckets on them.
    """

    def __init__(self, common: Common, scenario: Scenario, layout: Layout) -> None:
        """Begin with all buckets nowhere; `storage` has to be told."""
        self._common, self._agenda, self._bodies = common, common.agenda, common.bodies
        self._bot = scenario.bot
        self.storage = Storage(scenario, layout)
        self._agenda.can(grabbed=self._grabbed, released=self._released)

    def grab(self, request: Grab) -> None:
        """Lift a bucket that is within tolerance; takes `grab_s`."""
        bot, bucket = request.bot, request.bucket
        problem = self._common.stands_ready(bot) or self._grab_problem(bot, bucket)
        if problem is not None:
            self._common.answer(bot, request.request, *problem)
            return
        x, y = self._bodies.place(bot, self._agenda.now)
        if bucket == -1:
            bucket, _ = self._bodies.nearest_resting_bucket(x, y)
        self._common.begin(bot, BotState.GRABBING)
        self._agenda.at(self._agenda.now + self._bot.grab_s, "grabbed", bot, request.request, bucket)

    def _grab_problem(self, bot: int, bucket: int) -> tuple[Code, str] | None:
        bodies, now, tolerance = self._bodies, self._agenda.now, self._bot.tolerance_m
        carried = int(bodies.bucket[bot])
        if carried >= 0:
            return Code.ALREADY_CARRYING, f"bot {bot} carries bucket {carried}; release it first"
        if not -1 <= bucket < len(bodies.carrier):
            return Code.UNKNOWN, f"there is no bucket {bucket}; they are 0 to {len(bodies.carrier) - 1}"
        x, y = bodies.place(bot, now)
        if bucket == -1:
            bucket, away = bodies.nearest_resting_bucket(x, y)
            if away > tolerance:
                what = f"bucket {bucket} is nearest, {away:.3f} m away" if bucket >= 0 else "none rests anywhere"
                return Code.OUT_OF_TOLERANCE, f"no bucket within {tolerance:g} m of bot {bot}; {what}"
        else:
            if bodies.carrier[bucket] >= 0:
                return Code.BUCKET_TAKEN, f"bot {int(bodies.carrier[bucket])} carries bucket {bucket}"
            bx, by = bodies.bucket_place(bucket, now)
            away = float(np.sqrt((bx - x) ** 2 + (by - y) ** 2))
            if away > tolerance:
                return Code.OUT_OF_TOLERANCE, (
                    f"bucket {bucket} is {away:.3f} m from bot {bot}, at ({bx:.3f}, {by:.3f}); "
                    f"come within {tolerance:g} m"
                )
        if not bodies.bucket_fits(bucket, x, y):
            return Code.BLOCKED, f"bucket {bucket} would touch another one, lifted here; stand closer to its middle"
        return None

    def _grabbed(self, bot: int, request: int, bucket: int) -> None:
        self.storage.leave(bucket)
        self._bodies.lift(bot, bucket)
        self._common.end(bot)
        x, y = self._bodies.place(bot, self._agenda.now)
        self._common.emit(EventType.GRABBED, bot=bot, bucket=bucket, x=x, y=y)
        self._common.answer(bot, request, Code.DONE, f"bot {bot} carries bucket {bucket}")

    def release(self, request: Release) -> None:
        """Set the carried bucket down on a free storage spot within tolerance; takes `release_s`."""
        bot = request.bot
        problem = self._common.stands_ready(bot)
        spot = -1
        if problem is None:
            problem, spot = self._release_problem(bot)
        if problem is not None:
            self._common.answer(bot, request.request, *problem)
            return
        self.storage.reserve(spot, int(self._bodies.bucket[bot]))
        self._common.begin(bot, BotState.RELEASING)
        self._agenda.at(self._agenda.now + self._bot.release_s, "released", bot, request.request, spot)

    def _release_problem(self, bot: int) -> tuple[tuple[Code, str] | None, int]:
        if self._bodies.bucket[bot] < 0:
            return (Code.NOT_CARRYING, f"bot {bot} carries no bucket"), -1
        x, y = self._bodies.place(bot, self._agenda.now)
        spot = self.storage.at(x, y)
        if spot < 0:
            tolerance = self._bot.tolerance_m
            return (
                Code.OUT_OF_TOLERANCE,
                f"no storage spot within {tolerance:g} m of bot {bot} at ({x:.3f}, {y:.3f}); buckets rest on them only",
            ), -1
        there = self.storage.bucket_on[spot]
        if there >= 0:
            return (Code.SPOT_TAKEN, f"bucket {there} rests on this storage spot already"), -1
        return None, spot

    def _released(self, bot: int, request: int, spot: int) -> None:
        bucket = self._bodies.set_down(bot, self._agenda.now)
        self.storage.rest(bucket, spot)
        self._common.end(bot)
        x, y = self._bodies.place(bot, self._agenda.now)
        self._common.emit(EventType.RELEASED, bot=bot, bucket=bucket, x=x, y=y)
        self._common.answer(bot, request, Code.DONE, f"bucket {bucket} rests at ({x:.3f}, {y:.3f})")

    def set_storage_spot(self, request: SetStorageSpot) -> None:
        """Change which waypoints are storage spots."""
        waypoint = request.waypoint
        problem = self.storage.change(waypoint, request.storage)
        if problem is not None:
            self._agenda.say(Reply(*problem))
            return
        x, y = self.storage.place(waypoint)
        kind = EventType.SPOT_MADE if request.storage else EventType.SPOT_REMOVED
        self._common.emit(kind, waypoint=waypoint, x=x, y=y)
        what = "is a storage spot now" if request.storage else "is no storage spot any more"
        self._agenda.say(Reply(Code.DONE, f"waypoint {waypoint} at ({x:.3f}, {y:.3f}) {what}"))

    def capture(self) -> dict[str, Any]:
        """Everything that this part remembers, for a checkpoint."""
        return self.storage.capture()

    def restore(self, state: dict[str, Any]) -> None:
        """The opposite of `capture`."""
        self.storage.restore(state)
