"""Blocks of storage spots between aisles: rows, dense blocks, hexagonal packing."""

from __future__ import annotations

import numpy as np

from soup_msgs_py.errors import InputError
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.scenario.floor_plan import DenseLayout, HexagonalLayout, RowsLayout
from soup_msgs_py.warehouse.layout import Floats
from soup_sim.layouts.draft import BOTH_WAYS, Draft, Indices, Mask
from soup_sim.layouts.place_stations import place_stations

_FREE = 2  # in patterns of lanes: -1 and 1 are one-way lanes, 2 goes both ways, 0 are storage spots


def rows(scenario: Scenario, plan: RowsLayout, source: object) -> Draft:
    """Rows of storage spots between aisles, over the whole floor.

    Every waypoint is on a square grid. `S` is a storage spot, `v` and `^` are the lanes of an aisle, `>` and
    `<` those of a cross aisle (traffic keeps right; the wrong way costs more), `L` and `W` are stations in the
    free margins::

        . . . v ^ S S v ^ S S v ^ . . .
        L . . < < < < < < < < < < . . W
        . . . > > > > > > > > > > . . .
        . . . v ^ S S v ^ S S v ^ . . .
        L . . v ^ S S v ^ S S v ^ . . W

    Letter stations stand along the left edge, word stations along the right one.
    """
    if plan.block_columns > 2:
        allowed = "at most 2, so that every storage spot is next to an aisle; kind: dense has deeper blocks"
        raise InputError(source, "layout.block_columns", plan.block_columns, allowed)
    return _square(scenario, plan, source)


def dense(scenario: Scenario, plan: DenseLayout, source: object) -> Draft:
    """Deep blocks of storage spots with few aisles: inner buckets must be dug out (the tile problem).

    As `rows`, but all neighbours in a block are joined, and its outer spots to the aisles on all sides
    (paper, "Research Challenges": Gue 2006)::

        . . . < < < < < < < < < < < . . .
        . . . > > > > > > > > > > > . . .
        L . . v ^ S-S-S v ^ S-S-S v ^ . W
                  | | |     | | |
        . . . v ^ S-S-S v ^ S-S-S v ^ . .
                  | | |     | | |
        . . . v ^ S-S-S v ^ S-S-S v ^ . .

    A bucket that comes out on the near lane may cross to the far one.
    """
    return _square(scenario, plan, source)


def hexagonal(scenario: Scenario, plan: HexagonalLayout, source: object) -> Draft:
    """Blocks of two columns of round buckets, packed like a honeycomb; every spot is next to an aisle.

    In a block the columns are pitch x sqrt(3)/2 apart and one is shifted by half a pitch, and so are the
    aisle next to it and the near column of the next block::

        . . < <   <   < <   <   < < . .
        . . > >   >   > >   >   > > . .
                    S v ^ S
        L . v ^ S               S v ^ . W
                    S v ^ S
        . . v ^ S               S v ^ . .
                    S v ^ S
        . . v ^ S               S v ^ . .

    A cross aisle has one waypoint in the middle of a block, so that no two waypoints are nearer than a pitch.
    Neighbours in a block are not joined: a bucket that moved between them would brush the next one.
    """
    pitch, lanes = plan.pitch_m, plan.aisle_lanes
    narrow = pitch * np.sqrt(3.0) / 2.0
    width, height = scenario.floor.width_m - pitch, scenario.floor.height_m - pitch
    column_lane = _fill(width - 2 * plan.margin_columns * pitch, pitch, lanes, 2, 2.0 * pitch + narrow)
    line_lane = _fill(height, pitch, lanes, plan.block_rows, (plan.block_rows + 1.5) * pitch)
    if not (column_lane == 0).any() or not (line_lane == 0).any():
        raise _no_room(scenario, source)
    column_lane = _with_margins(column_lane, plan.margin_columns)
    line_lane = _rightwards(line_lane)

    second = np.zeros(len(column_lane), dtype=bool)  # the second column of a block
    second[1:] = (column_lane[1:] == 0) & (column_lane[:-1] == 0)
    first = np.roll(second, -1)
    last_row = np.zeros(len(line_lane), dtype=bool)
    last_row[:-1] = (line_lane[:-1] == 0) & (line_lane[1:] != 0)
    x = _middle(np.where(second[1:], narrow, pitch), scenario.floor.width_m)
    y = _middle(np.where(last_row[:-1], 1.5 * pitch, pitch), scenario.floor.height_m)

    shifted = np.cumsum(second) % 2 == 1
    grid_x, grid_y = np.meshgrid(x, y, indexing="ij")
    grid_y = grid_y + 0.5 * pitch * (shifted[:, None] & (line_lane == 0))
    crossing = line_lane != 0
    grid_x = np.where(first[:, None] & crossing, grid_x + 0.5 * narrow, grid_x)
    exists = ~(second[:, None] & crossing)
    draft = _grid(grid_x, grid_y, exists, column_lane, line_lane, joined_spots=False)
    return _with_stations(draft, exists, scenario, source)


def _square(scenario: Scenario, plan: RowsLayout | DenseLayout, source: object) -> Draft:
    """Rows or dense blocks, on a square grid."""
    columns = int(scenario.floor.width_m / plan.pitch_m)
    lines = int(scenario.floor.height_m / plan.pitch_m)
    lanes, block = plan.aisle_lanes, plan.block_columns
    inner = columns - 2 * plan.margin_columns
    if inner < 2 * lanes + block or lines < 2 * lanes + 1:
        raise _no_room(scenario, source)
    column_lane = _with_margins(_lanes(inner, lanes, block), plan.margin_columns)
    line_lane = _rightwards(_lanes(lines, lanes, plan.block_rows))
    if not (line_lane == 0).any():
        raise _no_room(scenario, source)
    x = _middle(np.full(columns - 1, plan.pitch_m), scenario.floor.width_m)
    y = _middle(np.full(lines - 1, plan.pitch_m), scenario.floor.height_m)
    grid_x, grid_y = np.meshgrid(x, y, indexing="ij")
    exists = np.ones((columns, lines), dtype=bool)
    draft = _grid(grid_x, grid_y, exists, column_lane, line_lane, joined_spots=True)
    if isinstance(plan, DenseLayout):
        draft.deep = True
        _join_up(draft, exists, (column_lane == 0)[:, None] & exists, np.full(columns, BOTH_WAYS))
    return _with_stations(draft, exists, scenario, source)


def _grid(x: Floats, y: Floats, exists: Mask, column_lane: Indices, line_lane: Indices, *, joined_spots: bool) -> Draft:
    """Waypoints in columns and lines, joined as their lanes say.

    Args:
        x: Of each place of the grid, shape (columns, lines).
        y: The same.
        exists: Which places of the grid are waypoints.
        column_lane: 1 leads up, -1 down.
        line_lane: 1 leads right, -1 left.
        joined_spots: Whether storage spots side by side are joined.
    """
    storage = (column_lane[:, None] == 0) & (line_lane[None, :] == 0)
    draft = Draft(np.stack([x[exists], y[exists]], axis=1), storage[exists])
    _join_up(draft, exists, (column_lane != 0)[:, None] & exists, column_lane)

    # along a line each waypoint is joined to the next one that exists
    line, column = np.nonzero(exists.T)
    number = _numbers(exists)[column, line]
    same = line[1:] == line[:-1]
    if not joined_spots:
        same &= ~(storage[column[1:], line[1:]] & storage[column[:-1], line[:-1]])
    a, b = number[:-1][same], number[1:][same]
    ca, cb, at = column[:-1][same], column[1:][same], line[:-1][same]
    free = (column_lane[ca] == _FREE) & (column_lane[cb] == _FREE)
    draft.join(a, b, np.where(free, BOTH_WAYS, line_lane[at]))
    return draft


def _join_up(draft: Draft, exists: Mask, wanted: Mask, column_lane: Indices) -> None:
    """Join neighbours along columns where both are wanted."""
    number = _numbers(exists)
    column, line = np.nonzero(wanted[:, :-1] & wanted[:, 1:])
    draft.join(number[column, line], number[column, line + 1], column_lane[column])


def _with_stations(draft: Draft, exists: Mask, scenario: Scenario, source: object) -> Draft:
    """Letter stations along the left edge, word stations along the right one, or where the scenario says."""
    number = _numbers(exists)
    place_stations(draft, scenario, number[0][exists[0]], number[-1][exists[-1]], source)
    return draft


def _numbers(exists: Mask) -> Indices:
    """The waypoint at each place of a grid, column by column."""
    return np.cumsum(exists.ravel()).reshape(exists.shape) - 1


def _lanes(n: int, lanes: int, block: int) -> Indices:
    """The pattern aisle, block, aisle, block, ..., aisle over n places.

    -1 and 1 are lanes, 2 goes both ways, 0 is storage; what is left over at the end becomes free lanes.
    """
    aisle = [-1, 1] if lanes == 2 else [_FREE]
    pattern = list(aisle)
    while len(pattern) + block + lanes <= n:
        pattern += [0] * block + aisle
    pattern += [_FREE] * (n - len(pattern))
    return np.array(pattern[:n], dtype=np.int64)


def _fill(length_m: float, pitch_m: float, lanes: int, block: int, across_m: float) -> Indices:
    """`_lanes` over a length, where blocks are `across_m` wide, from the lane before to the lane after."""
    aisle_m = (lanes - 1) * pitch_m
    blocks = max(int((length_m - aisle_m) / (across_m + aisle_m) + 1e-9), 0)
    left_over_m = length_m - aisle_m - blocks * (across_m + aisle_m)
    free = max(int(left_over_m / pitch_m + 1e-9), 0)
    return np.concatenate(
        [_lanes(lanes + blocks * (block + lanes), lanes, block), np.full(free, _FREE, dtype=np.int64)]
    )


def _with_margins(column_lane: Indices, margin: int) -> Indices:
    return np.pad(column_lane, margin, constant_values=_FREE)


def _rightwards(line_lane: Indices) -> Indices:
    """Traffic keeps right: the lower lane of a cross aisle leads right."""
    return np.where(line_lane == _FREE, _FREE, -line_lane)


def _middle(gaps: Floats, size: float) -> Floats:
    """Places with these gaps between them, in the middle of a length."""
    places = np.concatenate([[0.0], np.cumsum(gaps)])
    return (size - places[-1]) / 2.0 + places


def _no_room(scenario: Scenario, source: object) -> InputError:
    floor = f"{scenario.floor.width_m:g} by {scenario.floor.height_m:g} m"
    return InputError(source, "floor", floor, "room for the margins, two aisles and a block of this layout")
