"""The compiled heart of `Evade`: is the way clear for a bot, and if not, which velocity is best.

Velocities are sampled and judged by when they would touch something: velocity obstacles, with the accelerations of
equations 2 to 5 taken as a lag. What a bot has in its way is held in `near`, one row a disc: where it is (as if it had
its new velocity already, see `lag`), its velocity, for how many seconds it keeps it, the distance of the centres at
which the two touch, the distance that should be kept, and where it really is, as seen from the bot.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from soup_bots.steering.geometry import FAR, TURNS, time_to_touch_until
from soup_msgs_py.kernel import inlined, kernel
from soup_msgs_py.messages import Floats

X, Y, VX, VY, KEEPS, TOUCH, KEPT, DX, DY = range(9)
COLUMNS = 9
LINGER_S = 0.4  # how long a corner has to stay clear after arrival
TOUCH_COST = 1.0  # s: weighs 1 / time to touch against deviation in maximum speeds
NEAR_COST = 0.4  # s: the same for coming nearer than the kept distance
SOON_S = 0.05  # touching earlier than this is no worse
SWERVE_S = 0.4  # in which a bot can look again and turn away
CHANGE_COST = 0.15
LEFT_COST = 0.06


class Mover(NamedTuple):
    """A bot's place (m) and velocity (m/s)."""

    x: float
    y: float
    vx: float
    vy: float


class Way(NamedTuple):
    """Driving somewhere as one constant velocity: where it seems to start, see `lag`, and for how many seconds."""

    x: float
    y: float
    vx: float
    vy: float
    keeps_s: float


class Wish(NamedTuple):
    """The velocity that is wanted (m/s), and its direction, which it has even if it is 0."""

    vx: float
    vy: float
    dir_x: float
    dir_y: float


class Discs(NamedTuple):
    """What is in a bot's way: the first rows of `near`, and how far ahead each is minded (s)."""

    near: Floats
    horizon: Floats
    rows: int


@inlined
def lag(vx, vy, wx, wy, A):
    """How far a bot falls behind a constant (wx, wy) while it accelerates to it (equations 3 to 5)."""
    ax, ay = wx - vx, wy - vy
    share = 0.5 * math.sqrt(ax * ax + ay * ay) / A
    return -ax * share, -ay * share


@kernel
def way_to(me, gx, gy, dir_x, dir_y, speed, A):
    """The way to (gx, gy), for a bot that sets out in a direction."""
    lag_x, lag_y = lag(me.vx, me.vy, dir_x * speed, dir_y * speed, A)
    sx, sy = me.x + lag_x, me.y + lag_y
    dx, dy = gx - sx, gy - sy
    dist = math.sqrt(dx * dx + dy * dy)
    if dist < 1e-9:
        return Way(sx, sy, 0.0, 0.0, 0.0)
    return Way(sx, sy, dx / dist * speed, dy / dist * speed, dist / speed)


@kernel
def short_way(me, gx, gy, way, V, A, slow):
    """The same for a way too short to bend into: the bot brakes first where it moves elsewhere, and starts anew.

    Returns:
        Whether that is the case, and the way; the given one if the bot is on it already.
    """
    speed = math.sqrt(me.vx * me.vx + me.vy * me.vy)
    dx, dy = gx - me.x, gy - me.y
    dist = math.sqrt(dx * dx + dy * dy)
    if speed > slow and me.vx * dx + me.vy * dy > 0.999 * speed * dist:
        return False, way
    # where it stands when it has braked, and the run from there (equation 6)
    px, py = me.x + me.vx * speed / (2.0 * A), me.y + me.vy * speed / (2.0 * A)
    dx, dy = gx - px, gy - py
    dist = math.sqrt(dx * dx + dy * dy)
    if dist < 1e-6:
        return True, Way(px, py, 0.0, 0.0, 0.0)
    if dist < V * V / A:
        rest_to_rest = 2.0 * math.sqrt(dist / A)
    else:
        rest_to_rest = dist / V + V / A
    wx, wy = dx / rest_to_rest, dy / rest_to_rest
    brakes = speed / A
    return True, Way(px - wx * brakes, py - wy * brakes, wx, wy, rest_to_rest + brakes)


@inlined
def leaves_floor(px, py, vx, vy, floor):
    """Whether a velocity leads off the floor (least and greatest x, and y) before it can be changed."""
    x, y = px + SWERVE_S * vx, py + SWERVE_S * vy
    return (
        (vx < 0.0 and x < floor[0])
        or (vx > 0.0 and x > floor[1])
        or (vy < 0.0 and y < floor[2])
        or (vy > 0.0 and y > floor[3])
    )


@inlined
def closing_speed(near, k, wx, wy):
    """How fast (m/s) a bot that drives at (wx, wy) presses on a disc that it touches already; 0: it does not."""
    dx, dy, touch = near[k, DX], near[k, DY], near[k, TOUCH]
    apart = dx * dx + dy * dy
    if apart > touch * touch * 1.001:
        return 0.0
    closing = dx * (wx - near[k, VX]) + dy * (wy - near[k, VY])
    return closing / math.sqrt(apart + 1e-12) if closing > 1e-9 else 0.0


@kernel
def clear_for(discs, way):
    """Seconds until a bot on a way comes too near to a disc, FAR: not within its horizon; and which one.

    At the end of the way it stands.
    """
    near = discs.near
    worst, which = FAR, -1
    for k in range(discs.rows):
        if closing_speed(near, k, way.vx, way.vy) > 0.0:
            return 0.0, k
        t = time_to_touch_until(
            near[k, X] - way.x, near[k, Y] - way.y, way.vx, way.vy, way.keeps_s,
            near[k, VX], near[k, VY], near[k, KEEPS], near[k, KEPT], LINGER_S,
        )  # fmt: skip
        if t < discs.horizon[k] and t < worst:
            worst, which = t, k
    return worst, which


@kernel
def clear_after(discs, px, py, to_x, to_y, speed, wait_s):
    """The same for the leg of a route that begins in `wait_s` seconds at (px, py) and leads to (to_x, to_y)."""
    near = discs.near
    dx, dy = to_x - px, to_y - py
    dist = math.sqrt(dx * dx + dy * dy)
    if dist < 1e-9:
        return FAR
    wx, wy = dx / dist * speed, dy / dist * speed
    worst = FAR
    for k in range(discs.rows):
        moves_s = min(wait_s, near[k, KEEPS])
        t = time_to_touch_until(
            near[k, X] + near[k, VX] * moves_s - px, near[k, Y] + near[k, VY] * moves_s - py, wx, wy, dist / speed,
            near[k, VX], near[k, VY], near[k, KEEPS] - moves_s, near[k, KEPT], LINGER_S,
        )  # fmt: skip
        if t + wait_s < discs.horizon[k] and t < worst:
            worst = t
    return worst


@kernel
def danger(discs, px, py, wx, wy, enough):
    """What a constant velocity (wx, wy) costs because of what it would touch, or nearly touch.

    No more than `enough` need be known. The bot seems to start at (px, py), see `lag`.
    """
    near, horizon = discs.near, discs.horizon
    touch_s, near_s, push = FAR, FAR, 0.0
    for k in range(discs.rows):
        pressed = closing_speed(near, k, wx, wy)
        if pressed > 0.0:
            touch_s = 0.0
            push = max(push, pressed)
            continue
        dx, dy = near[k, X] - px, near[k, Y] - py
        t = time_to_touch_until(dx, dy, wx, wy, FAR, near[k, VX], near[k, VY], near[k, KEEPS], near[k, KEPT], LINGER_S)
        if t >= horizon[k]:
            continue
        near_s = min(near_s, t)
        if enough * max(near_s, SOON_S) <= NEAR_COST:
            return enough
        t = time_to_touch_until(dx, dy, wx, wy, FAR, near[k, VX], near[k, VY], near[k, KEEPS], near[k, TOUCH], LINGER_S)
        if t < horizon[k]:
            touch_s = min(touch_s, t)
            if enough * max(touch_s, SOON_S) <= TOUCH_COST:
                return enough
    cost = push
    if near_s < FAR:
        cost += NEAR_COST / max(near_s, SOON_S)
    if touch_s < FAR:
        cost += TOUCH_COST / max(touch_s, SOON_S)
    return cost


@kernel
def stays_clear(discs, me, wx, wy, A, floor):
    """Whether a bot that keeps on driving at (wx, wy) comes too near to nothing, and stays on the floor."""
    if (wx == 0.0 and wy == 0.0) or leaves_floor(me.x, me.y, wx, wy, floor):
        return False
    lag_x, lag_y = lag(me.vx, me.vy, wx, wy, A)
    return clear_for(discs, Way(me.x + lag_x, me.y + lag_y, wx, wy, FAR))[0] == FAR


@kernel
def keep_reachable(discs, first, V):
    """Move the discs that could be touched within their horizon at all to the front; how many they are.

    Disc `first` comes first: it spoils most velocities, and the sooner that is known the better.
    """
    near, horizon = discs.near, discs.horizon
    if first > 0:
        for c in range(COLUMNS):
            near[0, c], near[first, c] = near[first, c], near[0, c]
        horizon[0], horizon[first] = horizon[first], horizon[0]
    kept = 0
    for k in range(discs.rows):
        other = math.sqrt(near[k, VX] * near[k, VX] + near[k, VY] * near[k, VY])
        reach = (V + other) * horizon[k] + near[k, KEPT]
        if near[k, DX] * near[k, DX] + near[k, DY] * near[k, DY] <= reach * reach:
            if kept != k:
                for c in range(COLUMNS):
                    near[kept, c] = near[k, c]
                horizon[kept] = horizon[k]
            kept += 1
    return kept


@kernel
def best_velocity(discs, me, wish, last_x, last_y, V, A, floor):
    """The candidate that costs least: what it may touch, and how far it is from what is wanted and from the last one.

    Candidates are the wanted direction turned by a table of angles, at full and at half speed; standing; and the
    wanted velocity itself.
    """
    best_cost = FAR
    best_x, best_y = 0.0, 0.0
    for c in range(2 * len(TURNS) + 2):
        side = 0.0
        if c == 2 * len(TURNS):
            cx, cy = 0.0, 0.0
        elif c > 2 * len(TURNS):
            cx, cy = wish.vx, wish.vy
        else:
            turn = c >> 1
            speed = V if c & 1 == 0 else 0.5 * V
            co, si = TURNS[turn, 0], TURNS[turn, 1]
            cx = (wish.dir_x * co - wish.dir_y * si) * speed
            cy = (wish.dir_x * si + wish.dir_y * co) * speed
            if si > 0.0:
                side = LEFT_COST
            if leaves_floor(me.x, me.y, cx, cy, floor):
                continue
        ex, ey = cx - wish.vx, cy - wish.vy
        hx, hy = cx - last_x, cy - last_y
        cost = side + (math.sqrt(ex * ex + ey * ey) + CHANGE_COST * math.sqrt(hx * hx + hy * hy)) / V
        if cost >= best_cost:
            continue
        lag_x, lag_y = lag(me.vx, me.vy, cx, cy, A)
        cost += danger(discs, me.x + lag_x, me.y + lag_y, cx, cy, FAR if best_cost == FAR else best_cost - cost)
        if cost < best_cost - 1e-9:
            best_cost, best_x, best_y = cost, cx, cy
    return best_x, best_y
