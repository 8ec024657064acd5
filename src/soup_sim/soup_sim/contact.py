"""The collision test: when two discs touch, by continuous collision detection that cannot tunnel.

Between two events every bot moves with constant acceleration, so the squared distance of two bots is a polynomial of
degree four in time; its first root is the instant of contact. Pairs are found through a grid of cells.
"""

from __future__ import annotations

import numpy as np

from soup_msgs_py.kernel import kernel, maker
from soup_sim.motion import piece_at

TOUCH = 1e-9  # m2, on the squared distance: closer than this counts as touching
_LEAST_S = 1e-12  # from one piece of motion to the next; after some hours the clock is coarser than that
_LEAST = 2.3e-16  # of the time, a little more than the distance of two numbers


@kernel
def _value(c, s):
    return (((c[4] * s + c[3]) * s + c[2]) * s + c[1]) * s + c[0]


@kernel
def _bisect(c, low, high):
    """The root between low and high, where the polynomial changes its sign."""
    sign_low = _value(c, low) > 0.0
    for _ in range(70):
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        if (_value(c, middle) > 0.0) == sign_low:
            low = middle
        else:
            high = middle
    return low


@kernel
def _turning_points(c, h):
    """Times within (0, h) at which the quartic turns: roots of its derivative, in order; how many, and three places."""
    d = (c[1], 2.0 * c[2], 3.0 * c[3], 4.0 * c[4], 0.0)
    # the derivative is monotone between the roots of its own derivative
    q0, q1, q2 = d[1], 2.0 * d[2], 3.0 * d[3]
    first, second = h, h
    if abs(q2) > 0.0:
        disc = q1 * q1 - 4.0 * q2 * q0
        if disc > 0.0:
            root = np.sqrt(disc)
            half = -0.5 * (q1 + root) if q1 >= 0.0 else -0.5 * (q1 - root)
            a = half / q2
            b = q0 / half if half != 0.0 else a
            if a > b:
                a, b = b, a
            if 0.0 < a < h:
                first = a
            if 0.0 < b < h and b != a:
                if first < h:
                    second = b
                else:
                    first = b
    elif q1 != 0.0 and 0.0 < -q0 / q1 < h:
        first = -q0 / q1
    knots = (0.0, first, second, h)
    n, one, two, three = 0, 0.0, 0.0, 0.0
    for m in range(3):
        if (_value(d, knots[m]) > 0.0) != (_value(d, knots[m + 1]) > 0.0):
            turn = _bisect(d, knots[m], knots[m + 1])
            if n == 0:
                one = turn
            elif n == 1:
                two = turn
            else:
                three = turn
            n += 1
    return n, one, two, three


@kernel
def first_touch(px, py, vx, vy, ax, ay, radii, h):
    """The first time in [0, h] at which a relative motion brings two discs into contact; infinity if none does.

    Discs that touch already count only when they come closer still.
    """
    c0 = px * px + py * py - radii * radii
    c1 = 2.0 * (px * vx + py * vy)
    c2 = vx * vx + vy * vy + px * ax + py * ay
    if c0 <= TOUCH:
        closing = c1 < -1e-9 or (c1 <= 1e-9 and c2 < -1e-9)
        if closing:
            return 0.0
        c0 = TOUCH  # they part now, but may come back within this piece
    c = (c0, c1, c2, vx * ax + vy * ay, 0.25 * (ax * ax + ay * ay))
    if c[3] == 0.0 and c[4] == 0.0:
        disc = c1 * c1 - 4.0 * c2 * c0
        if c1 >= 0.0 or disc <= 0.0:
            return np.inf
        s = 2.0 * c0 / (-c1 + np.sqrt(disc))
        return s if s <= h else np.inf
    n, one, two, three = _turning_points(c, h)
    turns = (one, two, three)
    low = 0.0
    for k in range(n + 1):
        high = turns[k] if k < n else h
        if _value(c, high) <= 0.0:
            return _bisect(c, low, high)
        low = high
    return np.inf


@kernel
def after(t, end):
    """The end of a piece of motion, in any case later than t (s)."""
    return max(end, t + max(_LEAST_S, t * _LEAST))


@kernel
def contact_with_bot(state, segments, count, i, j, t0, t1, radii):
    """The first time in [t0, t1] at which bots i and j come into contact at a distance of `radii`; else infinity."""
    t = t0
    while t < t1:
        xi, yi, vxi, vyi, axi, ayi, _, _, end_i = piece_at(state, segments, count, i, t)
        xj, yj, vxj, vyj, axj, ayj, _, _, end_j = piece_at(state, segments, count, j, t)
        end = after(t, min(end_i, end_j, t1))
        s = first_touch(xj - xi, yj - yi, vxj - vxi, vyj - vyi, axj - axi, ayj - ayi, radii, end - t)
        if s < np.inf:
            return t + s
        t = end
    return np.inf


@kernel
def contact_with_point(state, segments, count, i, x, y, t0, t1, radii):
    """The first time in [t0, t1] at which bot i comes within `radii` of a resting disc at (x, y); else infinity."""
    t = t0
    while t < t1:
        xi, yi, vxi, vyi, axi, ayi, _, _, end_i = piece_at(state, segments, count, i, t)
        end = after(t, min(end_i, t1))
        s = first_touch(x - xi, y - yi, -vxi, -vyi, -axi, -ayi, radii, end - t)
        if s < np.inf:
            return t + s
        t = end
    return np.inf


@kernel
def cell_of(v, cell, n):
    """The cell of a coordinate, kept within the grid."""
    k = int(v / cell)
    return 0 if k < 0 else (n - 1 if k >= n else k)


@kernel
def fill_cells(xy, use, cell, nx, ny, head, following):
    """Sort the points with use[k] into the cells: `head` of each cell, then `following` point by point; -1 ends."""
    head[:] = -1
    for k in range(len(xy) - 1, -1, -1):
        if use[k]:
            here = cell_of(xy[k, 0], cell, nx) * ny + cell_of(xy[k, 1], cell, ny)
            following[k] = head[here]
            head[here] = k


@kernel
def contacts_of_some(
    some, ordered, state, segments, count, moving, bucket, bucket_xy, carrier, loose, t0, t1, r_bot, r_bucket,
    cell, nx, ny, bot_head, bot_next, bucket_head, bucket_next, places, reach, when, who, other,
):  # fmt: skip
    """The contacts of some bots within [t0, t1], with the cells of the last window; returns how many there are.

    `ordered`: leave a pair of moving bots to the smaller number. `other` is a bot, or -1 - b for resting bucket b.
    `reach` is the way that two bots can drive within a window. One function, because handing many arrays to another
    for each bot costs more than all the rest.
    """
    n, most = 0, len(when)
    for i in some:
        x, y, _, _, _, _, _, _, _ = piece_at(state, segments, count, i, t0)
        cx, cy = cell_of(x, cell, nx), cell_of(y, cell, ny)
        loaded = bucket[i] >= 0
        seeks_buckets = loaded and moving[i]
        for kx in range(max(0, cx - 1), min(nx, cx + 2)):
            for ky in range(max(0, cy - 1), min(ny, cy + 2)):
                j = bot_head[kx * ny + ky]
                while j >= 0:
                    if j != i and (moving[i] or moving[j]) and not (ordered and moving[j] and j < i):
                        radii = 2.0 * r_bot
                        if loaded and bucket[j] >= 0:
                            radii = max(radii, 2.0 * r_bucket)
                        # the cells hold places of the window's start, at most `reach` away from any later ones
                        dx, dy = places[j, 0] - x, places[j, 1] - y
                        if dx * dx + dy * dy < (radii + reach) * (radii + reach):
                            t = contact_with_bot(state, segments, count, i, j, t0, t1, radii)
                            if t < np.inf and n < most:
                                when[n], who[n], other[n] = t, i, j
                                n += 1
                    j = bot_next[j]
                if seeks_buckets:
                    b = bucket_head[kx * ny + ky]
                    while b >= 0:
                        dx, dy = bucket_xy[b, 0] - x, bucket_xy[b, 1] - y
                        near = dx * dx + dy * dy < (2.0 * r_bucket + reach) * (2.0 * r_bucket + reach)
                        if near and carrier[b] < 0:
                            t = contact_with_point(
                                state, segments, count, i, bucket_xy[b, 0], bucket_xy[b, 1], t0, t1, 2.0 * r_bucket
                            )
                            if t < np.inf and n < most:
                                when[n], who[n], other[n] = t, i, -1 - b
                                n += 1
                        b = bucket_next[b]
        if seeks_buckets:
            # buckets released since the cells were filled
            for b in loose:
                if b < 0:
                    break
                if carrier[b] < 0:
                    t = contact_with_point(
                        state, segments, count, i, bucket_xy[b, 0], bucket_xy[b, 1], t0, t1, 2.0 * r_bucket
                    )
                    if t < np.inf and n < most:
                        when[n], who[n], other[n] = t, i, -1 - b
                        n += 1
    return n


@maker
def begin_window(
    state, segments, count, bucket_xy, carrier, t0, cell, nx, ny, bot_head, bot_next, bucket_head, bucket_next, places
):  # fmt: skip
    """Note all places at time t0 and sort bots and resting buckets into the cells."""
    bots = len(count)
    for i in range(bots):
        x, y, _, _, _, _, _, _, _ = piece_at(state, segments, count, i, t0)
        places[i, 0], places[i, 1] = x, y
    fill_cells(places, np.ones(bots, dtype=np.bool_), cell, nx, ny, bot_head, bot_next)
    fill_cells(bucket_xy, carrier < 0, cell, nx, ny, bucket_head, bucket_next)
