"""Bot physics of the world: target velocities, paths, collisions and their penalty."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from soup_msgs_py.codes import Code, EventType
from soup_msgs_py.messages import FollowPath, Point, SetVelocities, SetVelocity
from soup_sim.agenda import Common
from soup_sim.bodies import Contact

_LONGEST_PATH = 10_000
_LONGEST_TURN_S = 3600.0
_FASTEST_TURN_RADPS = 100.0  # where turning takes no time
_HERE = 1e-9  # m
_OWN_PLACE = 1e-3  # m: a path that begins so near begins where the bot stands
_IN_TIME = 1e-6  # s: stamps on the wire are whole nanoseconds
_RESOLVED = 1e-7  # m: no bot may get further than this between a time and the next one that a number can hold


@dataclass(slots=True)
class _Path:
    """A path under way: `index` is the point that the present leg leads to."""

    request: int
    points: tuple[Point, ...]
    stamps: tuple[float, ...]
    index: int = 0


class Driving:
    """Carries out what bots ask for their wheels."""

    def __init__(self, common: Common, penalty_s: float) -> None:
        self._common, self._agenda, self._bodies = common, common.agenda, common.bodies
        self._penalty_s = penalty_s
        bots = len(common.bodies.bucket)
        self._edges: list[float] = common.bodies.edges.tolist()
        self._last_time = latest_time(common.bodies.max_speed)
        self._paths: list[_Path | None] = [None] * bots
        self._changes = 0
        self._changed = np.zeros(bots, dtype=np.int64)  # the change that gave each bot its present motion
        self._ends = np.full(bots, np.inf)  # when each velocity comes to rest; put on the agenda shortly before
        self._window_end = -1.0
        self._stirred: dict[int, None] = {}  # bots whose motion changed at this instant, in order
        self._agenda.can(motion_ends=self._motion_ends, window=self._window, contact=self._contact, resume=self._resume)
        self._agenda.at_end_of_instant = self._look_for_contacts

    # ---- requests -------------------------------------------------------------------------------------------

    def on_paths(self) -> list[int]:
        """The bots that follow a path, or wait for the time of its beginning."""
        return [bot for bot, path in enumerate(self._paths) if path is not None]

    def timed_paths(self) -> tuple[FollowPath, ...]:
        """The paths with a timetable that bots follow or wait to begin, as they were asked for."""
        return tuple(
            FollowPath(bot, path.request, path.points, path.stamps)
            for bot, path in enumerate(self._paths)
            if path is not None and path.stamps
        )

    def set_velocity(self, request: SetVelocity) -> None:
        """Equations 1 to 5; nothing happens while the bot is busy or penalised."""
        values = (request.vx, request.vy, request.turn_radps)
        bot = request.bot
        if not np.isfinite(values).all() or self._common.hindrance(bot) is not None:
            return
        if request.vx == 0.0 and request.vy == 0.0 and request.turn_radps != 0.0 and not self._bodies.moving[bot]:
            self._drop_path(bot)
            limit = self._bodies.turn_rate or _FASTEST_TURN_RADPS
            turn = min(max(request.turn_radps, -limit), limit)
            end = self._bodies.turn(bot, turn, _LONGEST_TURN_S, self._agenda.now)
            self._motion_changed(bot, end)
            return
        self.set_velocities(
            SetVelocities(np.array([bot], dtype=np.int32), np.array([request.vx]), np.array([request.vy]))
        )

    def set_velocities(self, request: SetVelocities) -> None:
        """The same for many bots."""
        chosen, vx, vy = request.bots, request.vx, request.vy
        hindered = self._common.hindered(chosen)
        if np.count_nonzero(hindered):
            chosen, vx, vy = chosen[~hindered], vx[~hindered], vy[~hindered]
        ends = self._bodies.set_velocities(chosen, vx, vy, self._agenda.now)
        self._changes += 1
        self._changed[chosen] = self._changes
        self._ends[chosen] = ends
        paths, stirred, window_end = self._paths, self._stirred, self._window_end
        for bot, end in zip(chosen.tolist(), ends.tolist(), strict=True):
            if paths[bot] is not None:
                self._drop_path(bot)
            if end <= window_end:
                self._agenda.at(end, "motion_ends", bot, self._changes)
            stirred[bot] = None
        self._common.note_moving(chosen)

    def follow_path(self, request: FollowPath) -> None:
        """Drive through points; answered when the last one is reached."""
        bot, points, stamps = request.bot, request.points, request.stamps
        problem = (
            self._common.hindrance(bot) or self._path_problem(points, stamps) or self._lateness(bot, points, stamps)
        )
        if problem is not None:
            self._common.answer(bot, request.request, *problem)
            return
        self._drop_path(bot)
        self._paths[bot] = path = _Path(request.request, points, stamps)
        self._next_leg(bot, path, None)

    def _path_problem(self, points: tuple[Point, ...], stamps: tuple[float, ...]) -> tuple[Code, str] | None:
        if not 1 <= len(points) <= _LONGEST_PATH:
            return Code.INVALID, f"a path of {len(points)} points; it needs 1 to {_LONGEST_PATH}"
        if stamps and len(stamps) != len(points):
            return Code.INVALID, f"{len(stamps)} stamps for {len(points)} points; give one a point, or none"
        for stamp in stamps:
            if not -self._last_time <= stamp <= self._last_time:
                return Code.INVALID, (
                    f"a stamp of {stamp:g} s; stamps are simulated time, which is {self._agenda.now:.3f} s now, and at"
                    f" most {self._last_time:.0f} s: beyond that no number tells where a bot is (does the sender lack"
                    " use_sim_time?)"
                )
        if stamps and any(later < earlier for earlier, later in pairwise(stamps)):
            return Code.INVALID, "stamps that go back in time"
        left, right, bottom, top = self._edges
        for x, y in points:
            if not (left - x <= _HERE and x - right <= _HERE and bottom - y <= _HERE and y - top <= _HERE):
                return Code.OFF_FLOOR, (
                    f"no room for a bot at ({x:.3f}, {y:.3f}); x is {left:g} to {right:g} m, y {bottom:g} to {top:g} m"
                )
        return None

    def _lateness(self, bot: int, points: tuple[Point, ...], stamps: tuple[float, ...]) -> tuple[Code, str] | None:
        """Why a path that should have begun before now is refused."""
        now = self._agenda.now
        if not stamps or now <= stamps[0] + _IN_TIME:
            return None
        x, y = self._bodies.place(bot, now)
        if abs(points[0][0] - x) > _OWN_PLACE or abs(points[0][1] - y) > _OWN_PLACE:
            return None
        return Code.LATE, f"a path that departs at {stamps[0]:.3f} s came at {now:.3f} s"

    def _drop_path(self, bot: int, code: Code = Code.REPLACED, message: str = "another motion was asked for") -> None:
        path, self._paths[bot] = self._paths[bot], None
        if path is not None:
            self._common.answer(bot, path.request, code, message)

    # ---- legs -----------------------------------------------------------------------------------------------

    def _next_leg(self, bot: int, path: _Path, here: Point | None) -> None:
        """Start the leg to the point at the path's index, or to a later one straight behind it.

        `here` is where the bot stands, if that is known.
        """
        now, points, last = self._agenda.now, path.points, len(path.points) - 1
        if path.stamps:
            duration = path.stamps[path.index] - now
        else:
            duration = 0.0
            if path.index < last:
                here = here or self._bodies.place(bot, now)
                while path.index < last and _straight_on(here, points[path.index], points[path.index + 1]):
                    path.index += 1
        end = self._bodies.drive(bot, points[path.index], duration, now)
        self._motion_changed(bot, end)

    def _motion_ends(self, bot: int, change: int) -> None:
        """A leg or a velocity has come to rest, unless the motion has changed since."""
        if change != self._changed[bot]:
            return
        self._ends[bot] = np.inf
        path, now = self._paths[bot], self._agenda.now
        if path is None:
            self._bodies.stand(bot, now)
            self._common.note_state(bot)
            return
        here = path.points[path.index]
        self._bodies.arrive(bot, now, here)
        if path.stamps and now < path.stamps[path.index]:
            self._agenda.at(path.stamps[path.index], "motion_ends", bot, change)
        elif path.index + 1 < len(path.points):
            path.index += 1
            self._next_leg(bot, path, here)
            return
        else:
            self._paths[bot] = None
            self._common.answer(bot, path.request, Code.DONE, "there")
        self._common.note_state(bot)

    def _motion_changed(self, bot: int, end: float) -> None:
        """A bot has begun another motion that will come to rest at `end`."""
        self._note_change(bot)
        self._agenda.at(end, "motion_ends", bot, self._changes)
        self._common.note_state(bot)

    def _note_change(self, bot: int) -> None:
        self._changes += 1
        self._changed[bot] = self._changes
        self._ends[bot] = np.inf
        self._stirred[bot] = None

    # ---- collisions -----------------------------------------------------------------------------------------

    def _look_for_contacts(self) -> None:
        """Before time goes on: look for the contacts of all bots whose motion has changed at this instant."""
        if not self._stirred:
            return
        now = self._agenda.now
        if now >= self._window_end:
            self._window()
        else:
            self._expect(self._bodies.contacts_of(np.array(list(self._stirred)), now, self._window_end))
        self._stirred.clear()

    def _window(self) -> None:
        """Look for all contacts up to the end of the next window, for as long as anything moves."""
        now = self._agenda.now
        if now < self._window_end or not np.count_nonzero(self._bodies.moving):
            return
        self._window_end = now + self._bodies.window_s
        self._agenda.at(self._window_end, "window")
        for bot in (self._ends <= self._window_end).nonzero()[0].tolist():
            self._agenda.at(float(self._ends[bot]), "motion_ends", bot, int(self._changed[bot]))
        self._expect(self._bodies.contacts(now, self._window_end))
        self._stirred.clear()

    def _expect(self, contacts: list[Contact]) -> None:
        for time, bot, other in contacts:
            self._agenda.at(time, "contact", bot, other, self._changes)

    def _contact(self, bot: int, other: int, known: int) -> None:
        """Two discs touch, unless one of them has changed its motion since that was computed."""
        bucket = -1 - other if other < 0 else -1
        partner = int(self._bodies.carrier[bucket]) if other < 0 else other
        if self._changed[bot] > known or (partner >= 0 and self._changed[partner] > known):
            return
        mine = int(self._bodies.bucket[bot])
        if other < 0:
            kind, buckets = EventType.BUCKET_COLLISION, (mine, bucket)
        elif self._bodies.touch_kind(bot, other):
            kind, buckets = EventType.BUCKET_COLLISION, (mine, int(self._bodies.bucket[other]))
        else:
            kind, buckets = EventType.BOT_COLLISION, ()
        bots = (bot,) if partner < 0 else (bot, partner)
        for each in bots:
            self._bodies.stand(each, self._agenda.now)
        x, y = self._bodies.place(bot, self._agenda.now)
        self._common.emit(kind, bot=bot, bots=bots, buckets=buckets, x=x, y=y)
        for each in bots:
            self._penalise(each)

    def _penalise(self, bot: int) -> None:
        until = self._agenda.now + self._penalty_s
        self._common.penalised_until[bot] = until
        self._note_change(bot)
        self._agenda.at(until, "resume", bot, until)
        self._common.note_state(bot)
        self._drop_path(bot, Code.COLLIDED, f"bot {bot} collided and stands until {until:.3f} s")

    def _resume(self, bot: int, until: float) -> None:
        if self._common.penalised_until[bot] == until:  # no later collision has prolonged it
            self._common.penalised_until[bot] = 0.0
            x, y = self._bodies.place(bot, self._agenda.now)
            self._common.emit(EventType.RESUMED, bot=bot, x=x, y=y)
            self._common.note_state(bot)

    # ---- checkpoint -----------------------------------------------------------------------------------------

    def capture(self) -> dict[str, Any]:
        """Everything that this part remembers, for a checkpoint."""
        return {
            "paths": [None if path is None else asdict(path) for path in self._paths],
            "changed": self._changed.tolist(),
            "ends": [None if end == np.inf else end for end in self._ends.tolist()],
            "changes": self._changes,
            "window_end": self._window_end,
            "stirred": list(self._stirred),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """The opposite of `capture`."""
        self._paths = [None if path is None else _restored_path(path) for path in state["paths"]]
        self._changed = np.array(state["changed"])
        self._ends = np.array([np.inf if end is None else end for end in state["ends"]])
        self._changes, self._window_end = state["changes"], state["window_end"]
        self._stirred = dict.fromkeys(state["stirred"])


def latest_time(max_speed: float) -> float:
    """The last simulated time (s) whose neighbours are near enough to tell where a bot of a top speed (m/s) is.

    A power of two: the distance from one float to the next doubles there.
    """
    return float(2.0 ** (np.floor(np.log2(_RESOLVED / max_speed)) + np.finfo(np.float64).nmant + 1))


def _restored_path(state: dict[str, Any]) -> _Path:
    points = tuple((x, y) for x, y in state["points"])
    return _Path(state["request"], points, tuple(state["stamps"]), state["index"])


def _straight_on(here: Point, corner: Point, beyond: Point) -> bool:
    """Whether a point lies straight behind a corner, so that nobody needs to stop there."""
    ax, ay = corner[0] - here[0], corner[1] - here[1]
    bx, by = beyond[0] - corner[0], beyond[1] - corner[1]
    a, b = ax * ax + ay * ay, bx * bx + by * by
    if a <= _HERE * _HERE or b <= _HERE * _HERE:
        return a <= _HERE * _HERE
    cross, dot = ax * by - ay * bx, ax * bx + ay * by
    return dot > 0.0 and cross * cross <= 1e-18 * a * b
