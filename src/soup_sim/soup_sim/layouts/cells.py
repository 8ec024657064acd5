"""A floor of cells, from a world file of the 2023 paper."""

from __future__ import annotations

import math

import numpy as np

from soup_msgs_py.errors import InputError
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.scenario.floor_plan import CellsLayout
from soup_sim.layouts.checks import check_waypoints
from soup_sim.layouts.draft import Draft, Indices, body_m

BESIDE = math.sqrt(2.0)  # two bots that turn the same corner at once are this much nearer than two cells


def cells(scenario: Scenario, plan: CellsLayout, source: object) -> Draft:
    """One waypoint a cell that is no wall, in the order of reading; after them a word and a letter station.

    Boxes and shelves are storage spots. Both stations stand in a row of their own below the cells, for a scenario
    has some; each is joined to the cell that is nearest to it.

    Raises:
        InputError: Numbers of the scenario are not those of the world, or its floor is too small.
    """
    world, pitch, body = plan.world, plan.pitch_m, body_m(scenario)
    check_waypoints(world.cells, "a world of", source, "layout")
    if pitch <= BESIDE * body:
        raise InputError(source, "layout.pitch_m", pitch, f"more than {BESIDE * body:g} m, for bodies of {body:g} m")
    for key, found, drawn in (
        ("bots", scenario.bots, len(world.robots)),
        ("buckets", scenario.buckets, len(world.boxes)),
        ("word_stations", scenario.word_stations, 1),
        ("letter_stations", scenario.letter_stations, 1),
    ):
        if found != drawn:
            raise InputError(source, key, found, f"{drawn}, as the world of cells has it")
    width, height = max(world.width, 2), world.height
    floor = scenario.floor
    if floor.width_m < (width + 1) * pitch or floor.height_m < (height + 2) * pitch:
        needed = f"at least {(width + 1) * pitch:g} by {(height + 2) * pitch:g} m"
        raise InputError(source, "floor", f"{floor.width_m:g} by {floor.height_m:g} m", needed)

    open_cells = np.array(world.open_cells)
    rows, columns = open_cells // world.width, open_cells % world.width
    places = np.stack([(columns + 1) * pitch, (height + 1 - rows) * pitch], axis=1)
    stations = np.array([[pitch, pitch], [width * pitch, pitch]])
    is_spot = np.isin(open_cells, [*world.boxes, *world.shelves])
    count = len(open_cells)
    draft = Draft(
        np.concatenate([places, stations]),
        np.concatenate([is_spot, [False, False]]),
        words=[count],
        letters=[count + 1],
        drawn_at=[f"line {row + 1}, column {column + 1}" for row, column in zip(rows, columns, strict=True)]
        + ["the word station", "the letter station"],
    )
    number = np.full(world.cells, -1)
    number[open_cells] = np.arange(count)
    pairs = [(number[cell], number[there]) for cell in world.open_cells for _, there in world.moves[cell]]
    for station in range(2):
        nearest = int(np.hypot(*(places - stations[station]).T).argmin())
        pairs += [(nearest, count + station), (count + station, nearest)]
    tails, heads = np.array(pairs, np.int64).reshape(-1, 2).T
    draft.add_edges(tails, heads, np.ones(len(pairs)))
    return draft


def start_places(plan: CellsLayout) -> tuple[Indices, Indices]:
    """The waypoints where bots begin, and those where buckets rest at the start."""
    world = plan.world
    return np.searchsorted(world.open_cells, world.robots), np.searchsorted(world.open_cells, world.boxes)
