"""A floor drawn in a text file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from soup_msgs_py.errors import InputError
from soup_msgs_py.reading.files import read_text
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.scenario.floor_plan import MapLayout
from soup_sim.layouts.checks import check_waypoints
from soup_sim.layouts.draft import Draft, Indices, body_m

CHARACTERS = ".><^vSLW#"
_ALLOWED = "lanes . > < ^ v, storage spots S, letter stations L, word stations W, # for nothing"
_LARGEST_FILE_BYTES = 1_000_000
_ARROWS = {">": (1, 0), "<": (-1, 0), "^": (0, 1), "v": (0, -1)}


def drawn_map(scenario: Scenario, plan: MapLayout, source: object) -> Draft:
    """The floor of a map file, one character a waypoint, `pitch_m` apart, in the middle of the floor.

    `.` is a lane both ways, `>` `<` `^` `v` are one-way lanes, `S` a storage spot, `L` a letter station, `W` a
    word station, `#` nothing::

        L.<<<<<<<<.W
        #.vSS^^SSv.#
        L.vSS^^SSv.W
        #.>>>>>>>>.#

    Neighbours are joined, stations with each other excepted. To leave or enter a one-way lane against its arrow
    costs `wrong_way` times as much, or is forbidden. Draw `#` beside a station to keep ways from leading through
    it. Stations of each kind are numbered as one reads: line by line from the top, each from the left.

    Raises:
        InputError: The file is missing or is no such map, or the scenario asks for other stations.
    """
    path = Path(plan.path)
    drawn = _read(path, source)
    height, width = drawn.shape
    check_waypoints(drawn.size, "a map of", path, "")
    body = body_m(scenario)
    needed = (width - 1) * plan.pitch_m + body, (height - 1) * plan.pitch_m + body
    if needed[0] > scenario.floor.width_m or needed[1] > scenario.floor.height_m:
        found = f"{width} by {height} waypoints, which need {needed[0]:g} by {needed[1]:g} m"
        floor = f"{scenario.floor.width_m:g} by {scenario.floor.height_m:g} m"
        allowed = f"at most the floor of {source}, {floor}"
        raise InputError(path, "", found, allowed)

    lines, columns = np.nonzero(drawn != "#")
    number = np.full(drawn.shape, -1)
    number[lines, columns] = np.arange(len(lines))
    x = scenario.floor.width_m / 2.0 + (columns - (width - 1) / 2.0) * plan.pitch_m
    y = scenario.floor.height_m / 2.0 - (lines - (height - 1) / 2.0) * plan.pitch_m
    draft = Draft(
        np.stack([x, y], axis=1),
        drawn[lines, columns] == "S",
        words=number[drawn == "W"].tolist(),
        letters=number[drawn == "L"].tolist(),
        drawn_at=[f"line {y + 1}, column {x + 1}" for y, x in zip(lines, columns, strict=True)],
    )
    _check_stations(draft, scenario, path, source)

    characters = drawn[lines, columns]
    is_station = np.isin(characters, ["W", "L"])
    for step, a, b in (
        ((1, 0), number[:, :-1], number[:, 1:]),
        ((-1, 0), number[:, 1:], number[:, :-1]),
        ((0, -1), number[:-1], number[1:]),
        ((0, 1), number[1:], number[:-1]),
    ):
        there = (a >= 0) & (b >= 0)
        tails, heads = a[there], b[there]
        joined = ~(is_station[tails] & is_station[heads])
        _join(draft, tails[joined], heads[joined], characters, step, plan.wrong_way)
    return draft


def _join(
    draft: Draft,
    tails: Indices,
    heads: Indices,
    characters: np.ndarray,
    step: tuple[int, int],
    wrong: float | None,
) -> None:
    """Edges in one direction between neighbours, dearer or none against an arrow."""
    against = [arrow for arrow, (x, y) in _ARROWS.items() if (-x, -y) == step]
    is_wrong = np.isin(characters[tails], against) | np.isin(characters[heads], against)
    if wrong is None:
        tails, heads, is_wrong, wrong = tails[~is_wrong], heads[~is_wrong], is_wrong[~is_wrong], 1.0
    draft.add_edges(tails, heads, np.where(is_wrong, wrong, 1.0))


def _check_stations(draft: Draft, scenario: Scenario, path: Path, source: object) -> None:
    if not draft.is_spot.any():
        raise InputError(path, "", "no storage spot (S)", "at least one storage spot")
    kinds = (("word_stations", "W", draft.words), ("letter_stations", "L", draft.letters))
    for key, character, drawn in kinds:
        if not drawn:
            missing = key.removesuffix("s").replace("_", " ")
            raise InputError(path, "", f"no {missing} ({character})", "at least one of each kind")
        wanted = getattr(scenario, key)
        if not isinstance(wanted, int):
            raise InputError(source, key, "positions", f"{len(drawn)}, as many as {path} draws ({character})")
        if wanted != len(drawn):
            raise InputError(source, key, wanted, f"{len(drawn)}, as many as {path} draws ({character})")


def _read(path: Path, source: object) -> np.ndarray:
    """The characters of a map, shape (lines, columns)."""
    text = read_text(path, _LARGEST_FILE_BYTES, "a map file", (source, "layout.path"))
    lines = text.rstrip("\r\n").splitlines()
    if not lines:
        raise InputError(path, "", "no line", _ALLOWED)
    for line, characters in enumerate(lines, start=1):
        for column, character in enumerate(characters, start=1):
            if character not in CHARACTERS:
                raise InputError(path, f"line {line}, column {column}", repr(character), _ALLOWED)
        if len(characters) != len(lines[0]):
            allowed = f"{len(lines[0])}, as in line 1; # draws nothing"
            raise InputError(path, f"line {line}", f"{len(characters)} characters", allowed)
    return np.array([list(line) for line in lines])
