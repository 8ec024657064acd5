"""What the world tells about its run: the scenario, the floor, the figures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import ValidationError
from soup_msgs import msg

from soup_msgs_py.scenario import Scenario, scenario_from_json
from soup_msgs_py.warehouse.layout import Layout
from soup_msgs_py.wire.basics import MalformedMessage, header_at, pack, unpack
from soup_msgs_py.wire.codec import Way, row


@dataclass(frozen=True, slots=True)
class Announcement:
    """What the world latches about its run: the scenario, the floor, the expected share of each tile kind.

    `run` is drawn when a world starts, so that all others notice a new one. `seed` is that of its random numbers;
    its rates and counts leave the first `warmup_s` simulated seconds out.
    """

    time: float
    scenario: Scenario
    layout: Layout
    tile_profile: tuple[float, ...]
    run: int = 0
    seed: int = 0
    warmup_s: float = 0.0


def _columns(typecode: str, dtype: type, *names: str) -> Way:
    """An array of shape (n, 2), as two lists."""

    def back(first: Any, second: Any) -> Any:
        column = unpack(first, dtype)
        return np.column_stack([column, unpack(second, dtype, len(column))])

    return Way(*names, out=lambda rows: (pack(typecode, rows[:, 0]), pack(typecode, rows[:, 1])), back=back)


def _check_layout(layout: Layout) -> None:
    if len(layout.edge_weights) != len(layout.edges):
        raise MalformedMessage(f"{len(layout.edges)} edges and {len(layout.edge_weights)} weights")
    waypoints = np.concatenate([layout.edges.ravel(), layout.storage_spots, layout.stations])
    if not np.isin(waypoints, np.arange(len(layout.waypoints))).all():
        raise MalformedMessage(f"a waypoint that is not among the {len(layout.waypoints)} of the floor")


def _to_scenario(json: str) -> Scenario:
    try:
        return scenario_from_json(json)
    except ValidationError as error:
        raise MalformedMessage("a scenario of another version") from error


_WAYPOINTS = Way(back=lambda waypoints: unpack(waypoints, np.int32))
row(
    Layout, msg.Layout, check=_check_layout,
    ways={
        "waypoints": _columns("d", np.float64, "waypoint_x", "waypoint_y"),
        "edges": _columns("i", np.int32, "edge_from", "edge_to"),
        "edge_weights": Way("edge_weight", back=lambda weights: unpack(weights, np.float64)),
        "storage_spots": _WAYPOINTS, "word_stations": _WAYPOINTS, "letter_stations": _WAYPOINTS,
    },
)  # fmt: skip
row(Announcement, msg.Scenario, ways={"scenario": Way("json", out=Scenario.model_dump_json, back=_to_scenario)})


def to_statistics(time: float, figures: dict[str, Any]) -> msg.Statistics:
    """The figures of a run that the message has a field for."""
    message = msg.Statistics(header=header_at(time))
    for name, kind in message.get_fields_and_field_types().items():
        if name in figures:
            setattr(message, name, float(figures[name]) if kind == "double" else int(figures[name]))
    return message


def from_statistics(message: msg.Statistics) -> dict[str, float | int]:
    """The figures of a run, by name."""
    return {name: getattr(message, name) for name in message.get_fields_and_field_types() if name != "header"}
