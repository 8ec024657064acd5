"""The compiled loop of `Evade` over all bots that are steered: what is around, what is wanted, what is chosen."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soup_bots.steering.base import BOT_ON_GOAL, BUCKET_IN_WAY, BUCKET_ON_GOAL, EVADES, VELOCITY
from soup_bots.steering.cells import cell_of, fill_cells
from soup_bots.steering.choice import (
    COLUMNS,
    DX,
    DY,
    KEEPS,
    KEPT,
    TOUCH,
    VX,
    VY,
    X,
    Y,
    best_velocity,
    clear_after,
    clear_for,
    keep_reachable,
    lag,
    leaves_floor,
    short_way,
    stays_clear,
    way_to,
)
from soup_bots.steering.geometry import FAR, TURNS, kept_distance
from soup_bots.steering.waiting import occupier, waiting_point
from soup_msgs_py.codes import BotState
from soup_msgs_py.kernel import inlined, kernel
from soup_msgs_py.messages import Floats

Ints = NDArray[np.int32]
Flags = NDArray[np.bool_]

MOST_NEAR = 96  # discs that one bot minds
CELL_M = 12.0  # m: much smaller or larger cells cost time
SLOW = 0.05  # share of the maximum speed below which a bot counts as standing
BUCKET_LOOK_S = 1.2
TURN_MPS = 0.15  # how much nearer waiting for a second makes a bot, when it is about whose turn it is
FOREIGN = 5.0  # how many times the margin is kept from moving bots whose intentions are not known
STAY = 2.0  # how many times as far ahead they must be clear before a bot stops to evade
STEP_ASIDE = 6  # calls
CHOOSES = 3  # calls: so often a bot that evades looks for a better velocity than one that stays clear
FREE, MOVING = int(BotState.FREE), int(BotState.MOVING)


@inlined
def note_bots(
    i, start, member, columns, lines, reach_m, all_of_them, x, y, vx, vy, bucket, state, touch_empty, touch_loaded,
    margin, max_v, max_a, period, look, give_way, calls, command, travels, decided, planned, near, who, horizon, evades,
):  # fmt: skip
    """Enter the bots around bot `i` into `near`; how many there are. Unless all are wanted, only those in reach.

    What a bot of the same crew is about to do is known; of any other bot, that it keeps its velocity.
    """
    px, py = x[i], y[i]
    loaded = bucket[i] >= 0
    count = 0
    left, right = cell_of(px - reach_m, CELL_M, columns), cell_of(px + reach_m, CELL_M, columns)
    for line in range(cell_of(py - reach_m, CELL_M, lines), cell_of(py + reach_m, CELL_M, lines) + 1):
        for m in range(start[line * columns + left], start[line * columns + right + 1]):
            j = member[m]
            dx, dy = x[j] - px, y[j] - py
            apart2 = dx * dx + dy * dy
            if apart2 > reach_m * reach_m or j == i or count == MOST_NEAR:
                continue
            drives = decided[j] >= calls - 1 and state[j] <= MOVING
            stands = vx[j] * vx[j] + vy[j] * vy[j] <= SLOW * SLOW * max_v * max_v
            first = loaded if loaded != (bucket[j] >= 0) else i < j
            mind_s = give_way if first and not stands and state[j] <= MOVING else look
            touch = touch_loaded if loaded and bucket[j] >= 0 else touch_empty
            if not all_of_them:
                reach = touch + margin + mind_s * (max_v if stands and not drives else 2.0 * max_v)
                if apart2 > reach * reach:
                    continue
            near[count, X], near[count, Y] = x[j], y[j]
            near[count, VX], near[count, VY], near[count, KEEPS] = vx[j], vy[j], FAR
            if drives and planned[j, 0] == planned[j, 0]:
                gone_s = min(period, travels[j]) if decided[j] < calls else 0.0
                near[count, X] = planned[j, 0] + command[j, 0] * gone_s
                near[count, Y] = planned[j, 1] + command[j, 1] * gone_s
                near[count, VX], near[count, VY] = command[j, 0], command[j, 1]
                near[count, KEEPS] = travels[j] - gone_s
            elif drives:
                lag_x, lag_y = lag(vx[j], vy[j], command[j, 0], command[j, 1], max_a)
                near[count, X] += lag_x
                near[count, Y] += lag_y
                near[count, VX], near[count, VY] = command[j, 0], command[j, 1]
                keeps_s = travels[j] - (period if decided[j] < calls else 0.0)
                if keeps_s < look:
                    near[count, KEEPS] = max(0.0, keeps_s)
            near[count, TOUCH], near[count, DX], near[count, DY] = touch, dx, dy
            room = margin
            if not drives and not stands and state[j] <= MOVING:
                room *= FOREIGN
                if evades:
                    mind_s *= STAY
            near[count, KEPT] = kept_distance(dx, dy, touch, room)
            who[count] = j
            horizon[count] = mind_s
            count += 1
    return count


@inlined
def note_buckets(
    px, py, start, member, columns, lines, reach_m, bucket_x, bucket_y, touch, margin, count, near, who, horizon
):  # fmt: skip
    """Enter the resting buckets around a loaded bot into `near`, after its first `count` rows; how many rows now."""
    left, right = cell_of(px - reach_m, CELL_M, columns), cell_of(px + reach_m, CELL_M, columns)
    for line in range(cell_of(py - reach_m, CELL_M, lines), cell_of(py + reach_m, CELL_M, lines) + 1):
        for m in range(start[line * columns + left], start[line * columns + right + 1]):
            j = member[m]
            dx, dy = bucket_x[j] - px, bucket_y[j] - py
            if dx * dx + dy * dy > reach_m * reach_m or count == MOST_NEAR:
                continue
            near[count, X], near[count, Y] = bucket_x[j], bucket_y[j]
            near[count, VX] = near[count, VY] = 0.0
            near[count, KEEPS] = FAR
            near[count, TOUCH], near[count, DX], near[count, DY] = touch, dx, dy
            near[count, KEPT] = kept_distance(dx, dy, touch, margin)
            who[count] = j
            horizon[count] = BUCKET_LOOK_S
            count += 1
    return count


class Desk(NamedTuple):
    """Room for what `steer_rows` needs beside its results: discs by cells, and what is around one bot."""

    start: Ints
    member: Ints
    place: Ints
    every_bot: Flags
    bucket_start: Ints
    bucket_member: Ints
    bucket_place: Ints
    rests: Flags
    near: Floats
    who: NDArray[np.int64]
    horizon: Floats
    floor: Floats


def make_desk(bots: int, buckets: int, width: float, height: float) -> Desk:
    """Room for so many bots and buckets on a floor of so many metres."""
    cells = max(1, math.ceil(width / CELL_M)) * max(1, math.ceil(height / CELL_M))

    def ints(count: int) -> Ints:
        return np.empty(count, np.int32)

    return Desk(
        ints(cells + 2), ints(bots), ints(bots), np.ones(bots, np.bool_),
        ints(cells + 2), ints(buckets), ints(buckets), np.empty(buckets, np.bool_),
        np.empty((MOST_NEAR + 1, COLUMNS)), np.empty(MOST_NEAR + 1, np.int64), np.empty(MOST_NEAR + 1), np.empty(4),
    )  # fmt: skip


@kernel
def steer_rows(
    bot, goal_x, goal_y, next_x, next_y, end_x, end_y,
    x, y, vx, vy, bucket, state,
    bucket_x, bucket_y, bucket_bot,
    lim, options, calls,
    evading, command, travels, decided, planned, nearest, since, goal, aside, end, came,
    out_mode, out_vx, out_vy, out_reason, out_other, desk,
):  # fmt: skip
    """Decide for all rows; arguments as in `SteerView`, `Limits`, `Evade` and `Desk`."""
    radius, bucket_radius, max_v, max_a, sensing, period = lim[0], lim[1], lim[2], lim[3], lim[4], lim[5]
    width, height = lim[6], lim[7]
    look, give_way, margin, bucket_margin, patience = options[0], options[1], options[2], options[3], options[4]
    touch_empty = 2.0 * radius
    touch_loaded = 2.0 * max(radius, bucket_radius)
    touch_bucket = 2.0 * bucket_radius
    hold_m = 1.5 * touch_loaded + 0.2 * radius
    hold_range = hold_m + max_v * look
    reach_m = min(sensing, 2.0 * max_v * look + touch_loaded)
    bucket_reach_m = min(sensing, max_v * BUCKET_LOOK_S + touch_bucket)
    slow = SLOW * max_v

    columns = max(1, math.ceil(width / CELL_M))
    lines = max(1, math.ceil(height / CELL_M))
    start, member, b_start, b_member = desk.start, desk.member, desk.bucket_start, desk.bucket_member
    near, who, horizon, floor = desk.near, desk.who, desk.horizon, desk.floor
    fill_cells(x, y, desk.every_bot, CELL_M, columns, lines, start, member, desk.place)
    buckets_sorted = False

    # loaded bots first, then by number: who comes later knows what those before it are about to do
    for q in range(2 * len(bot)):
        r = q if q < len(bot) else q - len(bot)
        i = bot[r]
        loaded = bucket[i] >= 0
        if loaded != (q < len(bot)):
            continue
        px, py, pvx, pvy = x[i], y[i], vx[i], vy[i]
        end_dx, end_dy = end_x[r] - px, end_y[r] - py
        end_m = math.sqrt(end_dx * end_dx + end_dy * end_dy)
        arrives = end_m < hold_range
        bots = note_bots(
            i, start, member, columns, lines, reach_m, arrives, x, y, vx, vy, bucket, state, touch_empty,
            touch_loaded, margin * radius, max_v, max_a, period, look, give_way, calls, command, travels, decided,
            planned, near, who, horizon, evading[i],
        )  # fmt: skip
        count = bots
        if loaded:
            if not buckets_sorted:
                for b in range(len(bucket_bot)):
                    desk.rests[b] = bucket_bot[b] < 0
                fill_cells(bucket_x, bucket_y, desk.rests, CELL_M, columns, lines, b_start, b_member, desk.bucket_place)
                buckets_sorted = True
            count = note_buckets(
                px, py, b_start, b_member, columns, lines, bucket_reach_m + (hold_m if arrives else 0.0),
                bucket_x, bucket_y, touch_bucket, bucket_margin * bucket_radius, count, near, who, horizon,
            )  # fmt: skip

        # is the end of the route free?
        blocker, reason = -1, 0
        if not arrives or end[i, 0] != end_x[r] or end[i, 1] != end_y[r] or decided[i] < calls - 1:
            came[i] = calls
        end[i, 0], end[i, 1] = end_x[r], end_y[r]
        if arrives:
            blocker = occupier(
                i, bots, near, who, state, x, y, end_x[r], end_y[r], end_m, touch_empty + 0.1 * radius,
                touch_empty + 0.5 * hold_m, slow, calls, decided, end, came, TURN_MPS * period,
            )  # fmt: skip
            if blocker >= 0:
                reason = BOT_ON_GOAL
            for k in range(bots, count):
                dx, dy = near[k, X] - end_x[r], near[k, Y] - end_y[r]
                if blocker < 0 and dx * dx + dy * dy < touch_bucket * touch_bucket * 0.998:
                    blocker, reason = who[k], BUCKET_ON_GOAL
        gx, gy = goal_x[r], goal_y[r]
        holding = blocker >= 0
        if holding:
            gx, gy = waiting_point(
                px, py, end_x[r], end_y[r], hold_m, touch_loaded if loaded else touch_empty, bots, count, near,
                slow, radius, width, height,
            )  # fmt: skip

        # a bot that gets nowhere steps aside
        dx, dy = goal_x[r] - px, goal_y[r] - py
        to_go = math.sqrt(dx * dx + dy * dy)
        if goal[i, 0] != goal_x[r] or goal[i, 1] != goal_y[r] or to_go < nearest[i] - 0.5 * radius:
            goal[i, 0], goal[i, 1], nearest[i], since[i] = goal_x[r], goal_y[r], to_go, calls
        elif reason == BUCKET_ON_GOAL or (reason == BOT_ON_GOAL and state[blocker] != FREE):
            since[i] = calls
        elif (calls - since[i]) * period > patience:
            aside[i] = calls + STEP_ASIDE
            since[i] = calls
        steps_aside = aside[i] > calls

        # the wanted velocity, from where the bot seems to start
        dx, dy = gx - px, gy - py
        dist = math.sqrt(dx * dx + dy * dy)
        if dist > 0.02 * radius:
            dir_x, dir_y = dx / dist, dy / dist
        elif end_m > 0.02 * radius:
            dir_x, dir_y = end_dx / end_m, end_dy / end_m
        else:
            dir_x, dir_y = 1.0, 0.0
        want = min(max_v, dist / period)  # not beyond the goal by the next call
        full = max_v
        # no further off the floor than the bot or its goal is
        floor[0], floor[1] = min(radius, gx, px), max(width - radius, gx, px)
        floor[2], floor[3] = min(radius, gy, py), max(height - radius, gy, py)
        if steps_aside:
            # a small hash: the same run makes the same draw, two bots hardly ever the same one
            turn = ((i * 7919 + (calls // STEP_ASIDE) * 104729) >> 3) % (len(TURNS) - 3) + 3
            co, si = TURNS[turn, 0], TURNS[turn, 1]
            dir_x, dir_y = dir_x * co - dir_y * si, dir_x * si + dir_y * co
            want = full = 0.5 * max_v
            if leaves_floor(px, py, dir_x * want, dir_y * want, floor):
                dir_x, dir_y = -dir_x, -dir_y
        elif holding:
            want = 0.0 if dist < 0.1 * radius else min(max_v, dist / (1.2 * period))
            full = want
        wx, wy = dir_x * want, dir_y * want
        sx, sy = px, py
        fx, fy, keeps_s = 0.0, 0.0, 0.0
        if steps_aside:
            fx, fy, keeps_s = wx, wy, FAR
        elif full > 0.0:
            sx, sy, fx, fy, keeps_s = way_to(px, py, pvx, pvy, gx, gy, dir_x, dir_y, full, max_a)
        is_short = False
        if not holding and not steps_aside and 0.0 < dist <= 2.0 * max_v * max_v / max_a:
            is_short, sx, sy, fx, fy, keeps_s = short_way(
                px, py, pvx, pvy, gx, gy, sx, sy, fx, fy, keeps_s, max_v, max_a, slow
            )

        clear_s, first = clear_for(near, horizon, count, sx, sy, fx, fy, keeps_s)
        if clear_s == FAR and not holding and not steps_aside and keeps_s < 2.0 * period:
            clear_s = clear_after(near, horizon, count, gx, gy, next_x[r], next_y[r], max_v, keeps_s + max_v / max_a)
        decided[i] = calls
        planned[i, 0] = math.nan
        if clear_s == FAR and not holding and not steps_aside:
            evading[i] = False
            command[i, 0], command[i, 1], travels[i] = fx, fy, keeps_s
            if is_short:
                planned[i, 0], planned[i, 1] = sx, sy
            continue
        out_mode[r] = VELOCITY
        if not holding:
            reason = EVADES
            if first >= 0:
                blocker = who[first]
                if first >= bots:
                    reason = BUCKET_IN_WAY
        if clear_s < FAR:
            cx, cy = command[i, 0], command[i, 1]
            keeps_on = (
                evading[i]
                and not holding
                and not steps_aside
                and (i + calls) % CHOOSES != 0
                and stays_clear(count, near, horizon, px, py, pvx, pvy, cx, cy, max_a, floor)
            )
            if not keeps_on:
                if not evading[i]:
                    cx, cy = fx, fy
                count = keep_reachable(near, horizon, count, first, max_v)
                cx, cy = best_velocity(
                    count, near, horizon, px, py, pvx, pvy, wx, wy, dir_x, dir_y, cx, cy, max_v, max_a, floor
                )
            if cx != wx or cy != wy or steps_aside:
                keeps_s = FAR
            wx, wy = cx, cy
        evading[i] = True
        command[i, 0], command[i, 1], travels[i] = wx, wy, keeps_s
        out_vx[r], out_vy[r] = wx, wy
        out_reason[r] = reason
        out_other[r] = blocker
