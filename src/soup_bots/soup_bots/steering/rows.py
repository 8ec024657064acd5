"""The compiled loop of `Evade` over all bots that are steered: look around, choose where to go, give way.

Each bot looks at what is near (`look`). It chooses where to drive now: to the next corner of its route; to a place
beside the end of the route while another bot is there; or aside, for a moment, where it gets nowhere. Where that way is
clear it follows its path, and otherwise it gives way with the best velocity (`choose`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from soup_bots.steering.base import BOT_ON_GOAL, BUCKET_IN_WAY, BUCKET_ON_GOAL, EVADES, VELOCITY
from soup_bots.steering.cells import CELL_M, fill_cells
from soup_bots.steering.choose import (
    Discs,
    Mover,
    Way,
    Wish,
    X,
    Y,
    best_velocity,
    clear_after,
    clear_for,
    keep_reachable,
    leaves_floor,
    short_way,
    stays_clear,
    way_to,
)
from soup_bots.steering.geometry import FAR, TURNS
from soup_bots.steering.look import Seen, note_bots, note_buckets
from soup_bots.steering.yield_way import occupier, waiting_point
from soup_msgs_py.codes import BotState
from soup_msgs_py.kernel import inlined, kernel

STEP_ASIDE = 6  # calls
CHOOSES = 3  # calls: so often a bot that evades looks for a better velocity than one that stays clear
FREE = int(BotState.FREE)


class Goal(NamedTuple):
    """Where a bot drives now.

    Attributes:
        x: In metres.
        y: As above.
        holding: Whether it waits there because the end of its route is not free.
        blocker: Who is there, -1 for nobody.
        reason: As in `Steer`, 0 for none.
    """

    x: float
    y: float
    holding: bool
    blocker: int
    reason: int


class Choice(NamedTuple):
    """How a bot would like to drive there.

    Attributes:
        wish: Its velocity.
        way: The way that it drives if that is clear.
        is_short: Whether it brakes first, see `short_way`.
        free: Whether it may follow its path: it neither waits nor steps aside.
        aside: Whether it steps aside.
        floor: The least and the greatest x, and y, that it may get to (m).
    """

    wish: Wish
    way: Way
    is_short: bool
    free: bool
    aside: bool
    floor: tuple[float, float, float, float]


@kernel
def steer_rows(rows, bots, buckets, norms, memory, told, desk, calls):
    """Decide for all rows; `calls` counts how often that has been done."""
    fill_cells(
        bots.x, bots.y, desk.every_bot, CELL_M, norms.columns, norms.lines, desk.start, desk.member, desk.place
    )  # fmt: skip
    buckets_sorted = False

    # loaded bots first, then by number: who comes later knows what those before it are about to do
    for q in range(2 * len(rows.bot)):
        r = q if q < len(rows.bot) else q - len(rows.bot)
        i = rows.bot[r]
        loaded = bots.bucket[i] >= 0
        if loaded != (q < len(rows.bot)):
            continue
        if loaded and not buckets_sorted:
            for b in range(len(buckets.bot)):
                desk.rests[b] = buckets.bot[b] < 0
            fill_cells(
                buckets.x, buckets.y, desk.rests, CELL_M, norms.columns, norms.lines, desk.bucket_start,
                desk.bucket_member, desk.bucket_place,
            )  # fmt: skip
            buckets_sorted = True
        seen = _look(i, r, rows, bots, buckets, norms, memory, desk, calls)
        goal = _goal(i, r, rows, bots, norms, memory, desk, seen, calls)
        aside = _steps_aside(i, r, rows, bots, norms, memory, goal, calls)
        choice = _choose(i, bots, norms, seen, goal, aside, calls)
        _drive_or_give_way(i, r, rows, bots, norms, memory, told, desk, seen, goal, choice, calls)


@inlined
def _look(i, r, rows, bots, buckets, norms, memory, desk, calls):
    """Note what is around a bot on the desk."""
    px, py = bots.x[i], bots.y[i]
    loaded = bots.bucket[i] >= 0
    end_dx, end_dy = rows.end_x[r] - px, rows.end_y[r] - py
    end_m = math.sqrt(end_dx * end_dx + end_dy * end_dy)
    arrives = end_m < norms.hold_range
    bots_near = note_bots(i, bots, norms, memory, desk, calls, arrives)
    count = bots_near
    if loaded:
        reach = norms.bucket_reach + (norms.hold if arrives else 0.0)
        count = note_buckets(px, py, buckets, norms, desk, reach, count)
    return Seen(loaded, bots_near, count, end_dx, end_dy, end_m, arrives)


@inlined
def _goal(i, r, rows, bots, norms, memory, desk, seen, calls):
    """The next corner of a bot's route, or a place to wait while the end of its route is not free."""
    end_x, end_y = rows.end_x[r], rows.end_y[r]
    known = memory.end[i, 0] == end_x and memory.end[i, 1] == end_y and memory.decided[i] >= calls - 1
    if not seen.arrives or not known:
        memory.came[i] = calls
    memory.end[i, 0], memory.end[i, 1] = end_x, end_y

    # who is on the end of its route?
    blocker, reason = -1, 0
    if seen.arrives:
        blocker = occupier(i, end_x, end_y, bots, norms, memory, desk, seen, calls)
        if blocker >= 0:
            reason = BOT_ON_GOAL
        for k in range(seen.bots, seen.discs):
            dx, dy = desk.near[k, X] - end_x, desk.near[k, Y] - end_y
            if blocker < 0 and dx * dx + dy * dy < norms.touch_bucket * norms.touch_bucket * 0.998:
                blocker, reason = desk.who[k], BUCKET_ON_GOAL

    gx, gy = rows.goal_x[r], rows.goal_y[r]
    if blocker >= 0:
        gx, gy = waiting_point(bots.x[i], bots.y[i], end_x, end_y, norms, desk.near, seen)
    return Goal(gx, gy, blocker >= 0, blocker, reason)


@inlined
def _steps_aside(i, r, rows, bots, norms, memory, goal, calls):
    """Whether a bot steps aside, because it gets nowhere and does not just wait for one that works."""
    dx, dy = rows.goal_x[r] - bots.x[i], rows.goal_y[r] - bots.y[i]
    to_go = math.sqrt(dx * dx + dy * dy)
    same = memory.goal[i, 0] == rows.goal_x[r] and memory.goal[i, 1] == rows.goal_y[r]
    if not same or to_go < memory.nearest[i] - 0.5 * norms.radius:
        memory.goal[i, 0], memory.goal[i, 1] = rows.goal_x[r], rows.goal_y[r]
        memory.nearest[i], memory.since[i] = to_go, calls
    elif goal.reason == BUCKET_ON_GOAL or (goal.reason == BOT_ON_GOAL and bots.state[goal.blocker] != FREE):
        memory.since[i] = calls
    elif (calls - memory.since[i]) * norms.period > norms.patience:
        memory.aside[i] = calls + STEP_ASIDE
        memory.since[i] = calls
    return memory.aside[i] > calls


@inlined
def _choose(i, bots, norms, seen, goal, aside, calls):
    """The velocity that a bot wants, and its way as one constant velocity."""
    px, py, radius, V = bots.x[i], bots.y[i], norms.radius, norms.V
    me = Mover(px, py, bots.vx[i], bots.vy[i])
    gx, gy = goal.x, goal.y

    # which way: to its goal, or on to the end of its route from there
    dx, dy = gx - px, gy - py
    dist = math.sqrt(dx * dx + dy * dy)
    if dist > 0.02 * radius:
        dir_x, dir_y = dx / dist, dy / dist
    elif seen.end_m > 0.02 * radius:
        dir_x, dir_y = seen.end_dx / seen.end_m, seen.end_dy / seen.end_m
    else:
        dir_x, dir_y = 1.0, 0.0

    # no further off the floor than the bot or its goal is
    floor = (
        min(radius, gx, px),
        max(norms.width - radius, gx, px),
        min(radius, gy, py),
        max(norms.height - radius, gy, py),
    )

    # how fast: not beyond the goal by the next call
    want = min(V, dist / norms.period)
    full = V
    if aside:
        # a small hash: the same run makes the same draw, two bots hardly ever the same one
        turn = ((i * 7919 + (calls // STEP_ASIDE) * 104729) >> 3) % (len(TURNS) - 3) + 3
        co, si = TURNS[turn, 0], TURNS[turn, 1]
        dir_x, dir_y = dir_x * co - dir_y * si, dir_x * si + dir_y * co
        want = full = 0.5 * V
        if leaves_floor(px, py, dir_x * want, dir_y * want, floor):
            dir_x, dir_y = -dir_x, -dir_y
    elif goal.holding:
        want = 0.0 if dist < 0.1 * radius else min(V, dist / (1.2 * norms.period))
        full = want
    wish = Wish(dir_x * want, dir_y * want, dir_x, dir_y)

    # the way from where the bot seems to start
    free = not goal.holding and not aside
    way, is_short = Way(px, py, 0.0, 0.0, 0.0), False
    if aside:
        way = Way(px, py, wish.vx, wish.vy, FAR)
    elif full > 0.0:
        way = way_to(me, gx, gy, dir_x, dir_y, full, norms.A)
    if free and 0.0 < dist <= 2.0 * V * V / norms.A:
        is_short, way = short_way(me, gx, gy, way, V, norms.A, norms.slow)
    return Choice(wish, way, is_short, free, aside, floor)


@inlined
def _drive_or_give_way(i, r, rows, bots, norms, memory, told, desk, seen, goal, choice, calls):
    """Let a bot follow its path if that is clear; otherwise tell it a velocity, and why."""
    wish, way = choice.wish, choice.way
    discs = Discs(desk.near, desk.horizon, seen.discs)
    clear_s, first = clear_for(discs, way)
    if clear_s == FAR and choice.free and way.keeps_s < 2.0 * norms.period:
        turns_s = way.keeps_s + norms.V / norms.A
        clear_s = clear_after(discs, goal.x, goal.y, rows.next_x[r], rows.next_y[r], norms.V, turns_s)
    memory.decided[i] = calls
    memory.planned[i, 0] = math.nan
    if clear_s == FAR and choice.free:
        memory.evading[i] = False
        memory.command[i, 0], memory.command[i, 1], memory.travels[i] = way.vx, way.vy, way.keeps_s
        if choice.is_short:
            memory.planned[i, 0], memory.planned[i, 1] = way.x, way.y
    else:
        wx, wy, keeps_s = wish.vx, wish.vy, way.keeps_s
        if clear_s < FAR:
            wx, wy = _evade(i, bots, norms, memory, discs, first, choice, calls)
            if wx != wish.vx or wy != wish.vy or choice.aside:
                keeps_s = FAR
        memory.evading[i] = True
        memory.command[i, 0], memory.command[i, 1], memory.travels[i] = wx, wy, keeps_s
        told.mode[r], told.vx[r], told.vy[r] = VELOCITY, wx, wy
        told.reason[r], told.other[r] = goal.reason, goal.blocker
        if not goal.holding:
            told.reason[r] = EVADES
            if first >= 0:
                told.other[r] = desk.who[first]
                if first >= seen.bots:
                    told.reason[r] = BUCKET_IN_WAY


@inlined
def _evade(i, bots, norms, memory, discs, first, choice, calls):
    """The velocity that a bot takes: the last one while that stays clear, for some calls; or the best of all."""
    me = Mover(bots.x[i], bots.y[i], bots.vx[i], bots.vy[i])
    cx, cy = memory.command[i, 0], memory.command[i, 1]
    keeps_on = (
        memory.evading[i]
        and choice.free
        and (i + calls) % CHOOSES != 0
        and stays_clear(discs, me, cx, cy, norms.A, choice.floor)
    )
    if not keeps_on:
        if not memory.evading[i]:
            cx, cy = choice.way.vx, choice.way.vy
        reachable = Discs(discs.near, discs.horizon, keep_reachable(discs, first, norms.V))
        cx, cy = best_velocity(reachable, me, choice.wish, cx, cy, norms.V, norms.A, choice.floor)
    return cx, cy
