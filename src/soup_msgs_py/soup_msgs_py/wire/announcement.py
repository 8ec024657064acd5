"""What the world tells about its run: the scenario, the floor, the figures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import ValidationError
from soup_msgs import msg

from soup_msgs_py.layout import Layout
from soup_msgs_py.scenario import Scenario, scenario_from_json
from soup_msgs_py.wire.basics import (
    MalformedMessage,
    check_finite,
    from_ros,
    from_stamp,
    header_at,
    pack,
    to_ros,
    unpack,
)


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


@to_ros.register
def _(layout: Layout) -> msg.Layout:
    message = msg.Layout(width=float(layout.width_m), height=float(layout.height_m))
    message.waypoint_x, message.waypoint_y = (
        pack("d", layout.waypoints[:, 0]),
        pack("d", layout.waypoints[:, 1]),
    )
    message.edge_from, message.edge_to = pack("i", layout.edges[:, 0]), pack("i", layout.edges[:, 1])
    message.edge_weight = pack("d", layout.edge_weights)
    message.storage_spots = pack("i", layout.storage_spots)
    message.word_stations = pack("i", layout.word_stations)
    message.letter_stations = pack("i", layout.letter_stations)
    return message


@from_ros.register
def _(layout: msg.Layout) -> Layout:
    x = unpack(layout.waypoint_x, np.float64)
    start = unpack(layout.edge_from, np.int32)
    edges = np.column_stack([start, unpack(layout.edge_to, np.int32, len(start))])
    places = [
        unpack(numbers, np.int32) for numbers in (layout.storage_spots, layout.word_stations, layout.letter_stations)
    ]
    check_finite(layout.width, layout.height)
    for numbers in (edges.ravel(), *places):
        if len(numbers) and not (numbers.min() >= 0 and numbers.max() < len(x)):
            raise MalformedMessage(f"a waypoint that is not among the {len(x)} of the floor")
    return Layout(
        layout.width,
        layout.height,
        np.column_stack([x, unpack(layout.waypoint_y, np.float64, len(x))]),
        edges,
        unpack(layout.edge_weight, np.float64, len(start)),
        *places,
    )


@to_ros.register
def _(announcement: Announcement) -> msg.Scenario:
    return msg.Scenario(
        header=header_at(announcement.time),
        run=announcement.run,
        json=announcement.scenario.model_dump_json(),
        layout=to_ros(announcement.layout),
        tile_profile=announcement.tile_profile,
        seed=announcement.seed,
        warmup=announcement.warmup_s,
    )


@from_ros.register
def _(announcement: msg.Scenario) -> Announcement:
    check_finite(announcement.warmup)
    try:
        scenario = scenario_from_json(announcement.json)
    except ValidationError as error:
        raise MalformedMessage("a scenario of another version") from error
    return Announcement(
        from_stamp(announcement.header.stamp),
        scenario,
        from_ros(announcement.layout),
        tuple(unpack(announcement.tile_profile, np.float64).tolist()),
        announcement.run,
        announcement.seed,
        announcement.warmup,
    )


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
