"""A world just good enough to try bots in: Euler steps, discs that stop dead when they touch, slow operations."""

from __future__ import annotations

import numpy as np

from soup_bots.crew import Crew
from soup_bots.steering import KNOWN
from soup_msgs_py.codes import BotState, Code, EventType
from soup_msgs_py.messages import (
    BotReply,
    Bots,
    Buckets,
    Event,
    FollowPath,
    Grab,
    Release,
    SetVelocities,
    SetVelocity,
    Snapshot,
    Transfer,
)
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.scenario.parameters import BotParameters, BucketParameters, Floor
from soup_msgs_py.warehouse.layout import Layout

STEP_S = 0.025


def layout_of(width, height, word_stations=(), spots=()):
    """A floor with some word stations and storage spots."""
    points = [*word_stations, *spots] or [(1.0, 1.0)]
    stations = np.arange(len(word_stations), dtype=np.int32)
    return Layout(
        width,
        height,
        np.array(points, float),
        np.zeros((0, 2), np.int32),
        np.zeros(0),
        np.arange(len(word_stations), len(points), dtype=np.int32),
        stations,
        np.zeros(0, np.int32),
    )


class TinyWorld:
    """Bots at given places on a floor, their crew, and a log of what the crew said to others."""

    def __init__(
        self, bots, *, buckets=(), stations=(), width=60.0, height=60.0, steering="evade", carrying=None,
        penalty_s=5.0, transfer_s=5.0, crew=None, bucket_radius=1.0,
    ):  # fmt: skip
        self.now = 0.0
        self.x, self.y = (np.array(axis, float) for axis in zip(*bots, strict=True))
        n = len(bots)
        self.vx, self.vy = np.zeros(n), np.zeros(n)
        self.bucket = np.full(n, -1, np.int32)
        self.state = np.zeros(n, np.uint8)
        self.bucket_x = np.array([b[0] for b in buckets], float)
        self.bucket_y = np.array([b[1] for b in buckets], float)
        self.carrier = np.full(len(buckets), -1, np.int32)
        for bot, bucket in (carrying or {}).items():
            self.bucket[bot], self.carrier[bucket] = bucket, bot
        self.scenario = Scenario(
            name="tiny", floor=Floor(width_m=width, height_m=height), bots=n, buckets=max(1, len(buckets)),
            word_stations=1, letter_stations=1, words="none",
            bot=BotParameters(collision_penalty_s=penalty_s), bucket=BucketParameters(radius_m=bucket_radius),
        )  # fmt: skip
        self.layout = layout_of(width, height, stations)
        self.speed, self.acceleration, self.radius = 4.0, 20.0, 1.0
        self.bucket_radius, self.penalty_s, self.transfer_s = bucket_radius, penalty_s, transfer_s
        self.target = np.zeros((n, 2))
        self.paths: list[tuple[int, tuple, int] | None] = [None] * n  # (request, points, index)
        self.brakes = [False] * n  # it stops before it follows its path
        self.ends = {}  # bot -> (time, request, what)
        self.told, self.heard = [], []
        self.contacts = 0
        self.closest = np.inf
        self.refuse = {}  # (type of request) -> list of codes to answer first
        self._touching = set()
        self._inbox = []
        self._sense_at = 0.0
        steering = KNOWN[steering]() if isinstance(steering, str) else steering
        own = range(n) if crew is None else crew
        self.crew = Crew(self.scenario, self.layout, own, steering, np.random.default_rng(1))
        self.tell(self.snapshot())

    # ---- what the world shows

    def bots(self):
        return Bots(
            self.now, self.x.copy(), self.y.copy(), np.zeros(len(self.x)), self.vx.copy(), self.vy.copy(),
            self.bucket.copy(), self.state.copy(),
        )  # fmt: skip

    def buckets(self):
        return Buckets(
            self.now,
            self.bucket_x.copy(),
            self.bucket_y.copy(),
            self.carrier.copy(),
            np.zeros(len(self.bucket_x), np.uint16),
        )

    def snapshot(self):
        return Snapshot(self.now, 0, self.bots(), self.buckets(), (), (), (), (), (), 0)

    # ---- messages

    def tell(self, message):
        """Give a message to the crew, and its answers to the world."""
        queue = [message]
        while queue:
            for said in self.crew.handle(queue.pop(0), self.now):
                self._take(said)
            queue += self._inbox
            self._inbox = []

    def _take(self, said):
        self.told.append(said)
        match said:
            case FollowPath():
                self._replace(said.bot)
                if self.state[said.bot] > BotState.MOVING:
                    self._reply(said.bot, said.request, Code.PENALISED if self.state[said.bot] == 5 else Code.BUSY)
                else:
                    self.paths[said.bot] = (said.request, said.points, 0)
                    self.brakes[said.bot] = self._is_too_near_to_bend(said.bot, said.points[0])
            case SetVelocity():
                self._replace(said.bot)
                self.target[said.bot] = (said.vx, said.vy)
            case SetVelocities():
                for bot, vx, vy in zip(said.bots.tolist(), said.vx, said.vy, strict=True):
                    self._replace(bot)
                    self.target[bot] = (vx, vy)
            case Grab() | Release() | Transfer():
                self._operate(said)

    def _is_too_near_to_bend(self, bot, point):
        dx, dy, vx, vy = point[0] - self.x[bot], point[1] - self.y[bot], self.vx[bot], self.vy[bot]
        dist, speed = np.hypot(dx, dy), np.hypot(vx, vy)
        on_line = vx * dx + vy * dy > 0.9999 * dist * speed
        return bool(speed > 0.0 and not on_line and dist <= 2.0 * self.speed**2 / self.acceleration)

    def _replace(self, bot):
        self.target[bot] = 0.0
        if self.paths[bot] is not None:
            request, self.paths[bot] = self.paths[bot][0], None
            self._reply(bot, request, Code.REPLACED)

    def _reply(self, bot, request, code, message=""):
        self._inbox.append(
            BotReply(
                bot,
                request,
                code,
                message or f"so it is: {code}",
                self.now,
                float(self.x[bot]),
                float(self.y[bot]),
            )
        )

    def _operate(self, request):
        codes = self.refuse.get(type(request), [])
        if codes:
            self._reply(request.bot, request.request, codes.pop(0))
            return
        bot = request.bot
        if self.state[bot] > BotState.MOVING:
            self._reply(bot, request.request, Code.PENALISED)
            return
        state, seconds = {
            Grab: (BotState.GRABBING, 0.5),
            Release: (BotState.RELEASING, 0.5),
            Transfer: (BotState.TRANSFERRING, self.transfer_s * len(getattr(request, "moves", ()))),
        }[type(request)]
        self.state[bot] = state
        self.ends[bot] = (self.now + seconds, request.request, request)

    # ---- time

    def run(self, seconds, until=None):
        """Let simulated time pass, or until a condition holds; whether it came to hold."""
        end = self.now + seconds
        while self.now < end:
            self._step()
            if until is not None and until():
                return True
        return False

    def _step(self):
        self._finish_operations()
        while self.crew.next_wake <= self.now:
            for said in self.crew.wake(self.now):
                self._take(said)
        if self.crew.wants_to_sense and self.now >= self._sense_at:
            self._sense_at = self.now + self.crew.sense_period_s - 1e-9
            for said in self.crew.sense(self.bots(), self.buckets(), self.now):
                self._take(said)
        self._hand_out()
        self._move()
        self._collide()
        self._hand_out()
        self.now = round(self.now + STEP_S, 6)

    def _hand_out(self):
        while self._inbox:
            batch, self._inbox = self._inbox, []
            for message in batch:
                self.tell(message)

    def _finish_operations(self):
        for bot, (time, request, what) in list(self.ends.items()):
            if time > self.now + 1e-9:
                continue
            del self.ends[bot]
            if self.state[bot] == BotState.PENALISED:
                self.state[bot] = BotState.FREE
                self._inbox.append(Event(self.now, 0, EventType.RESUMED, bot=bot))
                continue
            self.state[bot] = BotState.FREE
            if isinstance(what, Grab):
                bucket = what.bucket
                self.bucket[bot], self.carrier[bucket] = bucket, bot
            elif isinstance(what, Release):
                self.carrier[self.bucket[bot]], self.bucket[bot] = -1, -1
            self._reply(bot, request, Code.DONE)

    def _move(self):
        target = self.target.copy()
        for bot, path in enumerate(self.paths):
            if path is None:
                continue
            self.brakes[bot] = self.brakes[bot] and bool(self.vx[bot] or self.vy[bot])
            if self.brakes[bot]:
                target[bot] = 0.0
                continue
            request, points, index = path
            dx, dy = points[index][0] - self.x[bot], points[index][1] - self.y[bot]
            dist = np.hypot(dx, dy)
            if dist < 0.03:
                self.x[bot], self.y[bot] = points[index]
                self.vx[bot] = self.vy[bot] = 0.0
                if index + 1 == len(points):
                    self.paths[bot] = None
                    self._reply(bot, request, Code.DONE)
                    target[bot] = 0.0
                    continue
                self.paths[bot] = (request, points, index + 1)
                dx, dy = points[index + 1][0] - self.x[bot], points[index + 1][1] - self.y[bot]
                dist = max(np.hypot(dx, dy), 1e-9)
            speed = min(self.speed, np.sqrt(1.6 * self.acceleration * dist), dist / STEP_S)
            target[bot] = dx / dist * speed, dy / dist * speed
        stuck = self.state > BotState.MOVING
        target[stuck] = 0.0
        dvx, dvy = target[:, 0] - self.vx, target[:, 1] - self.vy
        share = np.minimum(1.0, self.acceleration * STEP_S / np.maximum(np.hypot(dvx, dvy), 1e-12))
        self.vx += dvx * share
        self.vy += dvy * share
        self.x += self.vx * STEP_S
        self.y += self.vy * STEP_S
        moving = (self.vx != 0.0) | (self.vy != 0.0)
        self.state[~stuck] = np.where(moving, BotState.MOVING, BotState.FREE)[~stuck]
        carried = self.bucket >= 0
        self.bucket_x[self.bucket[carried]] = self.x[carried]
        self.bucket_y[self.bucket[carried]] = self.y[carried]

    def _collide(self):
        loaded = self.bucket >= 0
        dx, dy = self.x[:, None] - self.x, self.y[:, None] - self.y
        apart = np.sqrt(dx * dx + dy * dy)
        both = loaded[:, None] & loaded
        touch = np.where(both, 2.0 * max(self.radius, self.bucket_radius), 2.0 * self.radius)
        np.fill_diagonal(apart, np.inf)
        self.closest = min(self.closest, float((apart - touch).min(initial=np.inf)))
        nearer = (dx * (self.vx[:, None] - self.vx) + dy * (self.vy[:, None] - self.vy)) < -1e-9
        hits = [(int(a), int(b)) for a, b in np.argwhere((apart < touch) & nearer) if a < b]
        for bot in np.flatnonzero(loaded).tolist():
            bx, by = self.bucket_x - self.x[bot], self.bucket_y - self.y[bot]
            near = (self.carrier < 0) & (bx * bx + by * by < (2.0 * self.bucket_radius) ** 2)
            towards = bx * self.vx[bot] + by * self.vy[bot] > 1e-9
            hits += [(bot, -1) for _ in np.flatnonzero(near & towards)]
        for a, b in hits:
            self.contacts += 1
            for bot in (a, b):
                if bot >= 0:
                    self._penalise(bot)
            kind = EventType.BOT_COLLISION if b >= 0 else EventType.BUCKET_COLLISION
            self._inbox.append(Event(self.now, 0, kind, bot=a, bots=(a, b) if b >= 0 else (a,)))

    def _penalise(self, bot):
        self.vx[bot] = self.vy[bot] = 0.0
        self.target[bot] = 0.0
        if self.paths[bot] is not None:
            self._reply(bot, self.paths[bot][0], Code.COLLIDED)
            self.paths[bot] = None
        if bot in self.ends and self.state[bot] != BotState.PENALISED:
            self._reply(bot, self.ends[bot][1], Code.COLLIDED)
        self.state[bot] = BotState.PENALISED
        self.ends[bot] = (self.now + self.penalty_s, -1, None)
