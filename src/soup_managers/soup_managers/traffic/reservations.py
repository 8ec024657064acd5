"""The reservation table: who holds which waypoint when, and the kernels that read and change it.

The gaps between the holds of other bots are the safe intervals of a waypoint.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from soup_msgs_py.kernel import inlined, kernel
from soup_msgs_py.warehouse.layout import Floats, Ints

SAME_S = 1e-9  # moments that are closer are one: sums of times differ in their last digits


class Reservations(NamedTuple):
    """Holds of each waypoint in order of their beginnings.

    Attributes:
        filled: How many holds each waypoint has, shape (n,).
        begin: When each begins (s), shape (n, capacity).
        end: When it ends; infinite while a bot stands there with no plan to leave.
        bot: Whose it is.
    """

    filled: Ints
    begin: Floats
    end: Floats
    bot: Ints


def no_reservations(waypoints: int, capacity: int) -> Reservations:
    """A table in which nobody holds anything."""
    shape = (waypoints, capacity)
    return Reservations(np.zeros(waypoints, np.int32), np.zeros(shape), np.zeros(shape), np.zeros(shape, np.int32))


def larger(table: Reservations) -> Reservations:
    """The same table with room for twice as many holds."""
    waypoints, capacity = table.begin.shape
    new = no_reservations(waypoints, 2 * capacity)
    new.filled[:] = table.filled
    for old, wide in ((table.begin, new.begin), (table.end, new.end), (table.bot, new.bot)):
        wide[:, :capacity] = old
    return new


def conflicts(table: Reservations, bot: int, now: float) -> list[int]:
    """The bots that hold what a bot holds, at the same time, from now on."""
    there = np.arange(table.begin.shape[1]) < table.filled[:, None]
    rows, columns = (there & (table.bot == bot)).nonzero()
    begin = np.maximum(table.begin[rows, columns], now)[:, None]
    end = table.end[rows, columns][:, None]
    bots = table.bot[rows]
    meet = there[rows] & (bots != bot) & (np.maximum(table.begin[rows], begin) < np.minimum(table.end[rows], end))
    return sorted(set(bots[meet].tolist()))


@inlined
def _shift(table, w, k, to):
    """Write a hold of one waypoint over another."""
    table.begin[w, to], table.end[w, to], table.bot[w, to] = table.begin[w, k], table.end[w, k], table.bot[w, k]


@inlined
def _take_out(table, w, k):
    """Take a hold of one waypoint away."""
    table.filled[w] -= 1
    for m in range(k, table.filled[w]):
        _shift(table, w, m + 1, m)


@kernel
def forget(table, w, before):
    """Drop what ended before a time from one waypoint."""
    kept = 0
    for k in range(table.filled[w]):
        if table.end[w, k] >= before:
            _shift(table, w, k, kept)
            kept += 1
    table.filled[w] = kept


@kernel
def add(table, w, begin, end, bot):
    """Let a bot hold a waypoint; joined to what it holds there already. There must be room."""
    for k in range(table.filled[w]):
        if table.bot[w, k] == bot and table.begin[w, k] <= end + SAME_S and table.end[w, k] >= begin - SAME_S:
            end = max(end, table.end[w, k])
            begin = min(begin, table.begin[w, k])
            _take_out(table, w, k)
            break
    # put it where it belongs: begins ascend
    k = table.filled[w]
    while k > 0 and table.begin[w, k - 1] > begin:
        _shift(table, w, k - 1, k)
        k -= 1
    table.begin[w, k], table.end[w, k], table.bot[w, k] = begin, end, bot
    table.filled[w] += 1


@kernel
def cut_standing(table, w, bot):
    """Take away the endless hold of a bot on a waypoint; when it began, infinite if there is none."""
    for k in range(table.filled[w]):
        if table.bot[w, k] == bot and table.end[w, k] == np.inf:
            begin = table.begin[w, k]
            _take_out(table, w, k)
            return begin
    return np.inf


@kernel
def forget_bot(table, bot, after):
    """Take away all holds of a bot that end after a time."""
    for w in range(len(table.filled)):
        kept = 0
        for k in range(table.filled[w]):
            if table.bot[w, k] != bot or table.end[w, k] <= after:
                _shift(table, w, k, kept)
                kept += 1
        table.filled[w] = kept


@kernel
def free_from(table, w, bot):
    """When nobody but one bot holds a waypoint any more."""
    latest = -np.inf
    for k in range(table.filled[w]):
        if table.bot[w, k] != bot:
            latest = max(latest, table.end[w, k])
    return latest


@kernel
def gap_after(table, w, time, bot):
    """The safe interval that a time lies in: its number, its end, and the end of the hold that follows."""
    before = 0
    end, reopens = np.inf, np.inf
    for k in range(table.filled[w]):
        if table.bot[w, k] == bot:
            continue
        if table.end[w, k] <= time + SAME_S:
            before += 1
        elif table.begin[w, k] < end:
            end, reopens = table.begin[w, k], table.end[w, k]
    return before, end, reopens


@kernel
def in_the_way(table, w, begin, end, bot):
    """When the first hold of another bot that overlaps a time interval ends; minus infinity if there is none."""
    for k in range(table.filled[w]):
        if table.begin[w, k] >= end - SAME_S:
            break
        if table.end[w, k] > begin + SAME_S and table.bot[w, k] != bot:
            return table.end[w, k]
    return -np.inf


@kernel
def stands_on(table, w, bot):
    """Whether a bot holds a waypoint without an end."""
    for k in range(table.filled[w]):  # noqa: SIM110 - compiled code knows no generators
        if table.bot[w, k] == bot and table.end[w, k] == np.inf:
            return True
    return False
