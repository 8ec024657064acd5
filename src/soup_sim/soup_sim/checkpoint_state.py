"""What a checkpoint may hold, besides the parts of a world: the books of a run, figures, orders that wait."""

from __future__ import annotations

import json
from typing import Annotated, Any

from pydantic import Field, ValidationInfo, field_validator, model_validator

from soup_msgs_py.codes import BotState
from soup_msgs_py.command_line.output_files import Written
from soup_sim.checkpoint_parts import (
    Agenda,
    Amount,
    Bodies,
    Bundle,
    Coming,
    Driving,
    Frame,
    Number,
    Part,
    Serving,
    Storage,
    Time,
    are_numbers,
    as_many,
    frame,
    within,
)
from soup_sim.world import World

OF_BOTS = ("_state", "_idle_since", "_last_visit", "_driven_start")  # the figures that each bot has


class Books(Part):
    """What the record of a run needs to go on, besides the world.

    Attributes:
        violations: Broken conservation laws.
        log: How much of the event log counts, if there is one.
        wall_seconds: What the run has taken (s).
        parts: The names of those who follow the world.
    """

    violations: Amount = 0
    log: Written | None = None
    wall_seconds: Time = 0.0
    parts: tuple[Annotated[str, Field(max_length=200)], ...] = ()


def check_state(state: object, world: World) -> None:
    """Check the state of a world before it is restored.

    Args:
        state: What `World.capture` gave, from JSON.
        world: Another world of the same scenario.

    Raises:
        ValidationError: It is none, or not one of such a world.
    """
    WorldState.model_validate_json(json.dumps(state), context=Frame(world, world.capture()))


class WorldState(Part):
    """All of it."""

    agenda: Agenda
    bodies: Bodies
    statistics: dict[str, Any]
    driving: Driving
    lifting: Storage
    serving: Serving
    orders: Coming
    supply: Coming
    penalised_until: list[Time]
    operation: list[BotState | None]
    waiting_words: list[tuple[Amount, str, list[Number]]]
    waiting_bundles: list[Bundle]

    @field_validator("statistics")
    @classmethod
    def _are_figures(cls, figures: dict[str, Any], info: ValidationInfo) -> dict[str, Any]:
        """Numbers, by the names that the world has for them."""
        own = frame(info).own["statistics"]
        if figures.keys() != own.keys():
            raise ValueError(f"figures {sorted(figures.keys() ^ own.keys())}"[:80])
        for key, value in figures.items():
            if isinstance(value, list) != isinstance(own[key], list):
                raise ValueError(f"{key}: no number, or no list of them")
            if key in OF_BOTS:
                as_many(value, own[key], key)
            if not are_numbers(value):
                raise ValueError(f"{key}: no number")
        within(figures["_state"], 0, len(BotState), "_state")
        return figures

    @model_validator(mode="after")
    def _fit(self, info: ValidationInfo) -> WorldState:
        own, kinds = frame(info).own, len(frame(info).world.tile_profile)
        as_many(self.penalised_until, own["penalised_until"], "penalised_until")
        as_many(self.operation, own["operation"], "operation")
        within([tile for _, _, tiles in self.waiting_words for tile in tiles], 0, kinds, "waiting_words")
        within([tile for _, tile, _ in self.waiting_bundles], 0, kinds, "waiting_bundles")
        return self
