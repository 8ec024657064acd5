"""Where a bot waits while another one stands on its goal."""

from __future__ import annotations

import math

from soup_bots.steering.choose import KEPT, VX, VY, X, Y
from soup_bots.steering.geometry import TURNS
from soup_msgs_py.codes import BotState
from soup_msgs_py.kernel import inlined, kernel

TURN_MPS = 0.15  # how much nearer waiting for a second makes a bot, when it is about whose turn it is
RINGS = 3
PLACES = (0, 3, 4, 7, 8, 11, 12)  # turns by 0, 30, 60 and 90 degrees
MOVING = int(BotState.MOVING)
FRONT = 0.85  # cosine: a wider angle than this off the way into the floor is not in front of a station


@inlined
def occupier(me, end_x, end_y, bots, norms, memory, desk, seen, calls):
    """The bot that keeps bot `me` from the end of its route; -1: none does.

    It stands there and works; or it is of the same crew, has the same end, and is nearer, where each
    call of waiting counts as `turn_m` metres; or, as nothing is known
    of other crews, it is nearer, and stands there or heads for it.
    """
    on_goal, contest = norms.touch_empty + 0.1 * norms.radius, norms.touch_empty + 0.5 * norms.hold
    slow, my_dist, turn_m = norms.slow, seen.end_m, TURN_MPS * norms.period
    found = -1
    for k in range(seen.bots):
        j = desk.who[k]
        dx, dy = end_x - bots.x[j], end_y - bots.y[j]
        dist2 = dx * dx + dy * dy
        on_it = dist2 < on_goal * on_goal
        if on_it and bots.state[j] > MOVING:
            found = j
            break
        # of the same crew and with the same end: whoever is nearer, or waits longer
        if memory.decided[j] >= calls - 1 and memory.end[j, 0] == end_x and memory.end[j, 1] == end_y:
            ahead = my_dist - math.sqrt(dist2) - turn_m * (memory.came[j] - memory.came[me])
            if ahead > 1e-6 or (ahead >= -1e-6 and j < me):
                found = j
            continue
        dist = math.sqrt(dist2)
        if dist > contest or dist > my_dist + 1e-6 or (dist >= my_dist - 1e-6 and j > me):
            continue
        nvx, nvy = desk.near[k, VX], desk.near[k, VY]
        speed2 = nvx * nvx + nvy * nvy
        towards = dx * nvx + dy * nvy
        heads_for = towards > 0.0 and towards * towards > 0.95 * dist2 * speed2
        if (on_it and (speed2 <= slow * slow or towards > 0.0)) or (speed2 > slow * slow and heads_for):
            found = j
    return found


@kernel
def waiting_point(px, py, goal_x, goal_y, norms, near, seen):
    """The best free place on rings around the goal: near the line to the bot, near the goal, not in front of a station.

    A place is on the line of approach if it can be, which makes a queue where stations are driven through; but a
    goal at the edge of the floor has its front towards the floor, where the bot that leaves has to come out.
    """
    touch = norms.touch_loaded if seen.loaded else norms.touch_empty
    hold_m, slow, radius, width, height = norms.hold, norms.slow, norms.radius, norms.width, norms.height
    ux, uy = px - goal_x, py - goal_y
    dist = math.sqrt(ux * ux + uy * uy)
    if dist < 1e-6:
        return px, py
    ux, uy = ux / dist, uy / dist
    front_x, front_y = 0.0, 0.0
    edge = 2.0 * hold_m
    if goal_x < edge and goal_x <= goal_y and goal_x <= height - goal_y:
        front_x = 1.0
    elif width - goal_x < edge and width - goal_x <= goal_y and width - goal_x <= height - goal_y:
        front_x = -1.0
    elif goal_y < edge:
        front_y = 1.0
    elif height - goal_y < edge:
        front_y = -1.0
    best_cost = 1e9
    best_x, best_y = px, py
    room = 1.45 * touch
    for ring in range(RINGS):
        at = hold_m + ring * 1.5 * touch
        for turn in PLACES:
            co, si = TURNS[turn, 0], TURNS[turn, 1]
            sx, sy = ux * co - uy * si, ux * si + uy * co
            if sx * front_x + sy * front_y > FRONT:
                continue
            wx, wy = goal_x + at * sx, goal_y + at * sy
            if wx < radius or wx > width - radius or wy < radius or wy > height - radius:
                continue
            cost = (1.0 - co) * 3.0 + abs(dist - at) / hold_m * 0.2 + ring * 1.0 + (0.01 if si > 0.0 else 0.0)
            if cost >= best_cost:
                continue
            free = True
            for k in range(seen.discs):
                ox, oy = near[k, X] - wx, near[k, Y] - wy
                if k < seen.bots:
                    moves = near[k, VX] * near[k, VX] + near[k, VY] * near[k, VY] > slow * slow
                    free = moves or ox * ox + oy * oy >= room * room
                else:
                    free = ox * ox + oy * oy >= near[k, KEPT] * near[k, KEPT]
                if not free:
                    break
            if free:
                best_cost, best_x, best_y = cost, wx, wy
    return best_x, best_y
