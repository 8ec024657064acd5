"""What the world and others have to be told after a look around: only what has changed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from soup_bots.steering.base import BOT_ON_GOAL, EVADES, FOLLOW, VELOCITY
from soup_msgs_py.kernel import maker
from soup_msgs_py.messages import Floats, Ints

# what to do about a bot; they add up
BACK = 1  # tell the world the path that is left
WHEEL = 2  # the velocity replaces a path
TELL = 4  # tell the world the velocity
SAY = 8  # say why the bot stands
SILENT = 16  # say that it drives again
ASK = 32  # ask the other bot to make way

OTHERS = 1 << 20  # more than there are bots or buckets


@maker
def what_changes(
    rows: NDArray[np.int64],
    new_mode: NDArray[np.int8],
    new_vx: Floats,
    new_vy: Floats,
    reason: NDArray[np.int8],
    other: Ints,
    mode: NDArray[np.int8],
    command: Floats,
    stands: Ints,
    told: Ints,
    vx: Floats,
    vy: Floats,
    same: float,
    slow: float,
    say_calls: int,
    ask_calls: int,
) -> NDArray[np.uint8]:
    """Compare what the steering wants with what was told before, and note the new state.

    Args:
        rows: The bots that were steered.
        new_mode: What the steering decided; with the next four, one element a row.
        new_vx: See `Steer`.
        new_vy: See `Steer`.
        reason: See `Steer`.
        other: See `Steer`.
        mode: What each bot was told, shape (bots,); updated.
        command: Which velocity it was told, (bots, 2); updated.
        stands: For how many calls it has stood, (bots,); updated.
        told: What was said about its standing, -1 for nothing, (bots,); updated.
        vx: Velocities of all bots.
        vy: As above.
        same: A velocity that differs less (m/s) is not told again.
        slow: A slower bot (m/s) stands.
        say_calls: Calls after which standing is explained.
        ask_calls: Calls after which a bot is asked to make way.

    Returns:
        What to do about each row, shape (rows,).
    """
    todo = np.zeros(len(rows), np.uint8)
    for r in range(len(rows)):
        i = rows[r]
        if new_mode[r] == FOLLOW:
            if mode[i] != FOLLOW:
                mode[i] = FOLLOW
                todo[r] = BACK
                if told[i] >= 0:
                    todo[r] |= SILENT
                told[i] = -1
                stands[i] = 0
            continue
        dx, dy = new_vx[r] - command[i, 0], new_vy[r] - command[i, 1]
        stops = new_vx[r] == 0.0 and new_vy[r] == 0.0 and (dx != 0.0 or dy != 0.0)
        if mode[i] == FOLLOW:
            mode[i] = VELOCITY
            todo[r] = WHEEL | TELL
        elif stops or dx * dx + dy * dy > same * same:
            todo[r] = TELL
        if todo[r] & TELL:
            command[i, 0], command[i, 1] = new_vx[r], new_vy[r]
        if vx[i] * vx[i] + vy[i] * vy[i] >= slow * slow:
            stands[i] = 0
            if told[i] >= 0:
                told[i] = -1
                todo[r] |= SILENT
            continue
        stands[i] += 1
        if stands[i] >= say_calls:
            saying = reason[r] * OTHERS + other[r] + 1
            if told[i] != saying:
                told[i] = saying
                todo[r] |= SAY
            if (reason[r] == BOT_ON_GOAL or reason[r] == EVADES) and other[r] >= 0 and stands[i] % ask_calls == 0:
                todo[r] |= ASK
    return todo
