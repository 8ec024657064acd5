"""Bot physics: exact constant-acceleration motion between events (paper, "Bucketbot Movement").

A motion is a short list of segments, each with a duration (s), an acceleration (m/s2) and a turn rate (rad/s), and it
always ends at rest: a target velocity that nobody changes ends with a stop in front of the edge of the floor. Only
+ - * / and square roots are used, so that the same inputs give the same bits on any machine.

Arrays: `state[i]` = start time, x, y, vx, vy, heading of bot i's motion; `segments[i, k]` = duration, ax, ay, turn
rate; `count[i]` = number of segments. Limits: V is the maximum speed, A the maximum acceleration (equations 1 and 2).
"""

from __future__ import annotations

import numpy as np

from soup_msgs_py.kernel import kernel
from soup_msgs_py.kinematics import heading_of

MAX_SEGMENTS = 7
STILL = 1e-12
_ALIGNED = 1e-9
_PI = 3.141592653589793


@kernel
def piece_at(state, segments, count, i, t):
    """Position, velocity, acceleration, heading, turn rate of bot i at time t, and when this piece of motion ends."""
    rest = t - state[i, 0]
    x, y, vx, vy, heading = state[i, 1], state[i, 2], state[i, 3], state[i, 4], state[i, 5]
    for k in range(count[i]):
        duration, ax, ay, turn = segments[i, k, 0], segments[i, k, 1], segments[i, k, 2], segments[i, k, 3]
        s = min(rest, duration)
        x += s * (vx + 0.5 * ax * s)
        y += s * (vy + 0.5 * ay * s)
        vx += ax * s
        vy += ay * s
        heading += turn * s
        if rest < duration:
            return x, y, vx, vy, ax, ay, heading, turn, t + (duration - rest)
        rest -= duration
    return x, y, 0.0, 0.0, 0.0, 0.0, heading, 0.0, np.inf


@kernel
def stop_point_inside(x, y, vx, vy, A, edges):
    """Whether a bot that brakes now comes to rest on the floor; `edges` = x and y range of its centre."""
    reach = np.sqrt(vx * vx + vy * vy) / (2.0 * A)
    sx, sy = x + vx * reach, y + vy * reach
    slack = 1e-9
    return sx >= edges[0] - slack and sx <= edges[1] + slack and sy >= edges[2] - slack and sy <= edges[3] + slack


@kernel
def _add(segments, i, n, duration, ax, ay, turn):
    """Append a segment, unless it is empty; the new number of segments."""
    if duration <= 0.0:
        return n
    segments[i, n, 0] = duration
    segments[i, n, 1] = ax
    segments[i, n, 2] = ay
    segments[i, n, 3] = turn
    return n + 1


@kernel
def _add_brake(segments, i, n, vx, vy, A):
    """Append the shortest stop."""
    speed = np.sqrt(vx * vx + vy * vy)
    if speed <= STILL:
        return n
    return _add(segments, i, n, speed / A, -A * vx / speed, -A * vy / speed, 0.0)


@kernel
def _add_turn(segments, i, n, heading, ux, uy, turn_rate):
    """Append the turn on the spot that faces direction u; the new heading and number of segments."""
    wanted = heading_of(ux, uy)
    angle = wanted - heading
    if abs(angle) > 4.0 * _PI:  # it has turned round and round
        angle -= 2.0 * _PI * np.floor(angle / (2.0 * _PI))
    while angle > _PI:
        angle -= 2.0 * _PI
    while angle <= -_PI:
        angle += 2.0 * _PI
    if abs(angle) > _ALIGNED:
        n = _add(segments, i, n, abs(angle) / turn_rate, 0.0, 0.0, turn_rate if angle > 0.0 else -turn_rate)
    return wanted, n


@kernel
def _safe_share_of_ramp(x, y, vx, vy, ax, ay, duration, A, edges):
    """How long a ramp may last so that the bot can always still stop on the floor."""
    steps = 16
    safe = 0.0
    for k in range(1, steps + 1):
        s = duration * k / steps
        px, py = x + s * (vx + 0.5 * ax * s), y + s * (vy + 0.5 * ay * s)
        if not stop_point_inside(px, py, vx + ax * s, vy + ay * s, A, edges):
            low, high = safe, s
            for _ in range(50):
                s = 0.5 * (low + high)
                px, py = x + s * (vx + 0.5 * ax * s), y + s * (vy + 0.5 * ay * s)
                if stop_point_inside(px, py, vx + ax * s, vy + ay * s, A, edges):
                    low = s
                else:
                    high = s
            return low
        safe = s
    return duration


@kernel
def _add_ramp_and_cruise(segments, i, n, x, y, vx, vy, tx, ty, A, edges):
    """Append the change from v to the target velocity t (equations 3 to 5), the cruise, the stop at the edge."""
    dvx, dvy = tx - vx, ty - vy
    change = np.sqrt(dvx * dvx + dvy * dvy)
    if change > STILL:
        duration = change / A
        ax, ay = dvx / duration, dvy / duration
        s = _safe_share_of_ramp(x, y, vx, vy, ax, ay, duration, A, edges)
        n = _add(segments, i, n, s, ax, ay, 0.0)
        x, y = x + s * (vx + 0.5 * ax * s), y + s * (vy + 0.5 * ay * s)
        if s < duration:
            return _add_brake(segments, i, n, vx + ax * s, vy + ay * s, A)
    speed = np.sqrt(tx * tx + ty * ty)
    if speed <= STILL:
        return n
    reach = speed / (2.0 * A)
    cruise = np.inf
    if tx != 0.0:
        gap = edges[1] - (x + tx * reach) if tx > 0.0 else edges[0] - (x + tx * reach)
        cruise = min(cruise, gap / tx)
    if ty != 0.0:
        gap = edges[3] - (y + ty * reach) if ty > 0.0 else edges[2] - (y + ty * reach)
        cruise = min(cruise, gap / ty)
    n = _add(segments, i, n, cruise, 0.0, 0.0, 0.0)
    return _add_brake(segments, i, n, tx, ty, A)


@kernel
def settle(state, segments, count, i, t):
    """Make time t the start of bot i's motion and forget its segments."""
    x, y, vx, vy, _, _, heading, _, _ = piece_at(state, segments, count, i, t)
    state[i, 0], state[i, 1], state[i, 2], state[i, 3], state[i, 4] = t, x, y, vx, vy
    state[i, 5] = heading
    count[i] = 0


@kernel
def duration_of(segments, count, i):
    """How long the motion of bot i lasts, from its start to rest."""
    total = 0.0
    for k in range(count[i]):
        total += segments[i, k, 0]
    return total


@kernel
def length_of(state, segments, count, i, until):
    """Distance driven from the start of bot i's motion to time `until` (Simpson's rule on the speed)."""
    total = 0.0
    rest = until - state[i, 0]
    vx, vy = state[i, 3], state[i, 4]
    for k in range(count[i]):
        if rest <= 0.0:
            break
        s, ax, ay = min(rest, segments[i, k, 0]), segments[i, k, 1], segments[i, k, 2]
        # the speed is linear in time, and Simpson's rule exact, unless the velocity bends or reverses
        straight = vx * ay == vy * ax and vx * (vx + ax * s) + vy * (vy + ay * s) >= 0.0
        parts = 1 if straight else 8
        h = s / parts
        for _ in range(parts):
            mx, my = vx + 0.5 * ax * h, vy + 0.5 * ay * h
            ex, ey = vx + ax * h, vy + ay * h
            total += (
                h / 6.0 * (np.sqrt(vx * vx + vy * vy) + 4.0 * np.sqrt(mx * mx + my * my) + np.sqrt(ex * ex + ey * ey))
            )
            vx, vy = ex, ey
        rest -= segments[i, k, 0]
    return total


@kernel
def plan_velocity(state, segments, count, i, t, tx, ty, V, A, turn_rate, edges):
    """Plan bot i's motion from time t towards a target velocity (equations 1 to 5).

    `turn_rate` > 0: a bot drives only where it faces, so it stops and turns first; 0: turning takes no time.
    """
    settle(state, segments, count, i, t)
    x, y, vx, vy, heading = state[i, 1], state[i, 2], state[i, 3], state[i, 4], state[i, 5]
    speed = np.sqrt(tx * tx + ty * ty)
    if speed == np.inf:  # its square is no number: only its direction counts
        size = max(abs(tx), abs(ty))
        tx, ty = 2.0 * V * (tx / size), 2.0 * V * (ty / size)
        speed = np.sqrt(tx * tx + ty * ty)
    if speed > V:
        tx, ty, speed = tx * V / speed, ty * V / speed, V
    n = 0
    if speed > STILL:
        ux, uy = tx / speed, ty / speed
        if turn_rate > 0.0:
            moving = vx * vx + vy * vy > STILL
            if moving and (abs(vx * uy - vy * ux) > _ALIGNED or vx * ux + vy * uy < 0.0):
                n = _add_brake(segments, i, n, vx, vy, A)
                reach = np.sqrt(vx * vx + vy * vy) / (2.0 * A)
                x, y, vx, vy = x + vx * reach, y + vy * reach, 0.0, 0.0
            _, n = _add_turn(segments, i, n, heading, ux, uy, turn_rate)
        else:
            state[i, 5] = heading_of(ux, uy)
    count[i] = _add_ramp_and_cruise(segments, i, n, x, y, vx, vy, tx, ty, A, edges)


@kernel
def plan_turn(state, segments, count, i, t, turn_radps, seconds):
    """Plan a turn on the spot at a given rate."""
    settle(state, segments, count, i, t)
    count[i] = _add(segments, i, 0, seconds, 0.0, 0.0, turn_radps)


@kernel
def _add_straight(segments, i, n, ux, uy, distance, v0, V, A, duration):
    """Append accelerating from v0 along u, cruising, stopping after `distance` (equation 6 and its cruise).

    `duration` > 0 asks for a stop-to-stop move that takes exactly so long, where that is longer than needed.
    """
    if distance <= 0.0:
        return n
    peak = min(V, np.sqrt(A * distance + 0.5 * v0 * v0))
    if duration > 0.0 and v0 == 0.0:
        rest = duration * duration - 4.0 * distance / A
        if rest > 0.0:
            # the smaller root of p * duration = distance + p^2 / A, in the form that cancels at no size
            peak = min(peak, 2.0 * distance / (duration + np.sqrt(rest)))
    n = _add(segments, i, n, (peak - v0) / A, A * ux, A * uy, 0.0)
    cruise = distance - (2.0 * peak * peak - v0 * v0) / (2.0 * A)
    n = _add(segments, i, n, cruise / peak, 0.0, 0.0, 0.0)
    return _add(segments, i, n, peak / A, -A * ux, -A * uy, 0.0)


@kernel
def plan_leg(state, segments, count, i, t, gx, gy, V, A, turn_rate, edges, duration):
    """Plan bot i's motion from time t straight to a goal, at rest there.

    A bot that moves elsewhere bends its velocity towards the goal first where that is possible, else it stops first.
    """
    settle(state, segments, count, i, t)
    x, y, vx, vy, heading = state[i, 1], state[i, 2], state[i, 3], state[i, 4], state[i, 5]
    dx, dy = gx - x, gy - y
    distance = np.sqrt(dx * dx + dy * dy)
    speed = np.sqrt(vx * vx + vy * vy)
    n = 0
    if speed > STILL:
        on_line = distance > STILL and abs(vx * dy - vy * dx) <= _ALIGNED * speed * distance
        if on_line and vx * dx + vy * dy > 0.0 and speed * speed <= 2.0 * A * distance * (1.0 + 1e-12):
            count[i] = _add_straight(segments, i, n, dx / distance, dy / distance, distance, speed, V, A, 0.0)
            return
        if turn_rate <= 0.0 and distance > 2.0 * V * V / A:
            # the velocity after the bend must point from where the bend ends to the goal: a fixed point
            ux, uy = dx / distance, dy / distance
            w = max(speed, 0.5 * V)
            bend, px, py = 0.0, x, y
            for _ in range(60):
                bx, by = w * ux - vx, w * uy - vy
                bend = np.sqrt(bx * bx + by * by) / A
                px, py = x + 0.5 * (vx + w * ux) * bend, y + 0.5 * (vy + w * uy) * bend
                rx, ry = gx - px, gy - py
                rest = np.sqrt(rx * rx + ry * ry)
                ux, uy = rx / rest, ry / rest
            rest = np.sqrt((gx - px) * (gx - px) + (gy - py) * (gy - py))
            ax, ay = (w * ux - vx) / bend, (w * uy - vy) / bend
            if 2.0 * A * rest > w * w and _safe_share_of_ramp(x, y, vx, vy, ax, ay, bend, A, edges) == bend:
                n = _add(segments, i, n, bend, ax, ay, 0.0)
                state[i, 5] = heading_of(ux, uy)
                count[i] = _add_straight(segments, i, n, ux, uy, rest, w, V, A, 0.0)
                return
        n = _add_brake(segments, i, n, vx, vy, A)
        reach = speed / (2.0 * A)
        x, y = x + vx * reach, y + vy * reach
        dx, dy = gx - x, gy - y
        distance = np.sqrt(dx * dx + dy * dy)
    if distance > STILL:
        ux, uy = dx / distance, dy / distance
        if turn_rate > 0.0:
            _, n = _add_turn(segments, i, n, heading, ux, uy, turn_rate)
        else:
            state[i, 5] = heading_of(ux, uy)
        n = _add_straight(segments, i, n, ux, uy, distance, 0.0, V, A, duration if n == 0 else 0.0)
    count[i] = n
