"""Look: which bots and resting buckets are around one bot, and what they are about to do."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soup_bots.steering.cells import CELL_M, cell_of
from soup_bots.steering.choose import COLUMNS, DX, DY, KEEPS, KEPT, TOUCH, VX, VY, X, Y, lag
from soup_bots.steering.geometry import FAR, kept_distance
from soup_bots.steering.scene import BUCKET_LOOK_S, SLOW, Flags, Norms
from soup_msgs_py.codes import BotState
from soup_msgs_py.kernel import inlined
from soup_msgs_py.messages import Floats, Ints

MOST_NEAR = 96  # discs that one bot minds
FOREIGN = 5.0  # how many times the margin is kept from moving bots whose intentions are not known
STAY = 2.0  # how many times as far ahead they must be clear before a bot stops to evade
MOVING = int(BotState.MOVING)


class Desk(NamedTuple):
    """Room for discs sorted into cells, and for what is around one bot.

    Attributes:
        start: Where the bots of each cell begin, see `fill_cells`.
        member: Bots sorted by cells.
        place: The cell of each.
        every_bot: True for all.
        bucket_start: The same for resting buckets.
        bucket_member: As above.
        bucket_place: As above.
        rests: Which buckets rest.
        near: What is around a bot, bots first, one row a disc, see `choose`.
        who: The bot or bucket of each row.
        horizon: How far ahead it is minded (s).
    """

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


class Seen(NamedTuple):
    """What a bot sees.

    Attributes:
        loaded: Whether it carries a bucket.
        bots: How many rows of `Desk.near` are bots.
        discs: How many rows there are.
        end_dx: The end of its route, as seen from it (m).
        end_dy: As above.
        end_m: How far that is.
        arrives: Whether that is near enough to look whether it is free.
    """

    loaded: bool
    bots: int
    discs: int
    end_dx: float
    end_dy: float
    end_m: float
    arrives: bool


def make_desk(bots: int, buckets: int, norms: Norms) -> Desk:
    """Room for so many bots and buckets."""
    cells = norms.columns * norms.lines

    def ints(count: int) -> Ints:
        return np.empty(count, np.int32)

    return Desk(
        start=ints(cells + 2),
        member=ints(bots),
        place=ints(bots),
        every_bot=np.ones(bots, np.bool_),
        bucket_start=ints(cells + 2),
        bucket_member=ints(buckets),
        bucket_place=ints(buckets),
        rests=np.empty(buckets, np.bool_),
        near=np.empty((MOST_NEAR + 1, COLUMNS)),
        who=np.empty(MOST_NEAR + 1, np.int64),
        horizon=np.empty(MOST_NEAR + 1),
    )


@inlined
def note_bots(i, bots, norms, memory, desk, calls, all_of_them):
    """Enter the bots around bot `i` on the desk; how many there are. Unless all are wanted, only those in reach.

    What a bot of the same crew is about to do is known; of any other bot, that it keeps its velocity.
    """
    px, py, V, near = bots.x[i], bots.y[i], norms.V, desk.near
    loaded = bots.bucket[i] >= 0
    left, right = cell_of(px - norms.reach, CELL_M, norms.columns), cell_of(px + norms.reach, CELL_M, norms.columns)
    low, high = cell_of(py - norms.reach, CELL_M, norms.lines), cell_of(py + norms.reach, CELL_M, norms.lines)
    count = 0
    for line in range(low, high + 1):
        for m in range(desk.start[line * norms.columns + left], desk.start[line * norms.columns + right + 1]):
            j = desk.member[m]
            dx, dy = bots.x[j] - px, bots.y[j] - py
            apart2 = dx * dx + dy * dy
            if apart2 > norms.reach * norms.reach or j == i or count == MOST_NEAR:
                continue

            # who goes first, and how far ahead the other one is minded
            vx, vy = bots.vx[j], bots.vy[j]
            moving = bots.state[j] <= MOVING
            drives = memory.decided[j] >= calls - 1 and moving
            stands = vx * vx + vy * vy <= SLOW * SLOW * V * V
            first = loaded if loaded != (bots.bucket[j] >= 0) else i < j
            mind_s = norms.give_way if first and not stands and moving else norms.look
            touch = norms.touch_loaded if loaded and bots.bucket[j] >= 0 else norms.touch_empty
            if not all_of_them:
                reach = touch + norms.margin + mind_s * (V if stands and not drives else 2.0 * V)
                if apart2 > reach * reach:
                    continue

            # where it is, what its velocity is and how long it keeps that
            near[count, X], near[count, Y] = bots.x[j], bots.y[j]
            near[count, VX], near[count, VY], near[count, KEEPS] = vx, vy, FAR
            told_x, told_y, travels = memory.command[j, 0], memory.command[j, 1], memory.travels[j]
            if drives and memory.planned[j, 0] == memory.planned[j, 0]:
                gone_s = min(norms.period, travels) if memory.decided[j] < calls else 0.0
                near[count, X] = memory.planned[j, 0] + told_x * gone_s
                near[count, Y] = memory.planned[j, 1] + told_y * gone_s
                near[count, VX], near[count, VY] = told_x, told_y
                near[count, KEEPS] = travels - gone_s
            elif drives:
                lag_x, lag_y = lag(vx, vy, told_x, told_y, norms.A)
                near[count, X] += lag_x
                near[count, Y] += lag_y
                near[count, VX], near[count, VY] = told_x, told_y
                keeps_s = travels - (norms.period if memory.decided[j] < calls else 0.0)
                if keeps_s < norms.look:
                    near[count, KEEPS] = max(0.0, keeps_s)

            # how far it is, and how near it may come
            near[count, TOUCH], near[count, DX], near[count, DY] = touch, dx, dy
            room = norms.margin
            if not drives and not stands and moving:
                room *= FOREIGN
                if memory.evading[i]:
                    mind_s *= STAY
            near[count, KEPT] = kept_distance(dx, dy, touch, room)
            desk.who[count], desk.horizon[count] = j, mind_s
            count += 1
    return count


@inlined
def note_buckets(px, py, buckets, norms, desk, reach, count):
    """Enter the resting buckets around a loaded bot on the desk, after `count` rows; how many rows there are then."""
    near, touch = desk.near, norms.touch_bucket
    left, right = cell_of(px - reach, CELL_M, norms.columns), cell_of(px + reach, CELL_M, norms.columns)
    low, high = cell_of(py - reach, CELL_M, norms.lines), cell_of(py + reach, CELL_M, norms.lines)
    for line in range(low, high + 1):
        first, last = line * norms.columns + left, line * norms.columns + right + 1
        for m in range(desk.bucket_start[first], desk.bucket_start[last]):
            j = desk.bucket_member[m]
            dx, dy = buckets.x[j] - px, buckets.y[j] - py
            if dx * dx + dy * dy > reach * reach or count == MOST_NEAR:
                continue
            near[count, X], near[count, Y] = buckets.x[j], buckets.y[j]
            near[count, VX] = near[count, VY] = 0.0
            near[count, KEEPS] = FAR
            near[count, TOUCH], near[count, DX], near[count, DY] = touch, dx, dy
            near[count, KEPT] = kept_distance(dx, dy, touch, norms.bucket_margin)
            desk.who[count], desk.horizon[count] = j, BUCKET_LOOK_S
            count += 1
    return count
