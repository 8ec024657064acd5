"""The parameters of bodies and stations, and what all parts of a scenario have in common."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, field_validator

from soup_msgs_py.policies import PolicyChoice, name_alone

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Share = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
Count = Annotated[int, Field(ge=1, le=100_000)]
Position = tuple[NotNegative, NotNegative]
Place = Annotated[Position, BeforeValidator(lambda value: tuple(value) if isinstance(value, list) else value)]


class Part(BaseModel):
    """Common rules: no unknown key, no guessing of types, no change after loading."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class Floor(Part):
    """Size of the floor: x from 0 to width, y from 0 to height."""

    width_m: Positive
    height_m: Positive


class Sensing(Part):
    """What a bot is told of what lies within its sensing radius: everything, or less to blind it for an experiment.

    Source: the paper, section "Bucketbot Sensing and Control". A bot that is blinded in any other way than `contents`
    thinks for itself: it hears of nobody's intentions either.
    """

    velocities: bool = True  # of other bots; without, they all seem to stand
    contents: bool = True  # of buckets: the letter tiles inside
    intentions: bool = True  # what other bots of its process are about to do
    view_angle_rad: Annotated[float, Field(gt=0, le=2 * math.pi)] | None = None  # ahead; None: all around
    nearest: Count | None = None  # so many bots and so many resting buckets; None: all

    @property
    def is_alone(self) -> bool:
        """Whether each bot has to think for itself, because no two are told the same."""
        everything = self.velocities and self.intentions and self.view_angle_rad is None and self.nearest is None
        return not everything


class BotParameters(Part):
    """One bucketbot: size, equations 1 and 2, the times of its actions, what it senses."""

    radius_m: Positive = 1.0
    max_speed_mps: Positive = 4.0
    max_acceleration_mps2: Positive = 20.0
    turn_rate_radps: Positive | None = None  # None: turning takes no time
    grab_s: NotNegative = 0.5
    release_s: NotNegative = 0.5
    tolerance_m: Positive = 0.1  # for grabbing a bucket and for releasing it on a storage spot
    collision_penalty_s: Positive = 5.0
    sensing_radius_m: NotNegative = 20.0
    sensing: Sensing = Sensing()


class BucketParameters(Part):
    """One bucket."""

    radius_m: Positive = 1.0
    capacity: Count = 40  # letter tiles


class _Station(Part):
    """A station, and how it decides by itself."""

    # a name, or FILE.py:Class relative to the scenario file; with options as in a policies file: {name, options}
    policy: PolicyChoice = PolicyChoice(name="as_asked")

    @field_validator("policy", mode="before")
    @classmethod
    def _name_alone(cls, value: object) -> object:
        return name_alone(value)


class WordStationParameters(_Station):
    """One word station."""

    open_words: Count = 4
    transfer_s: NotNegative = 5.0  # to take one tile out of a bucket and put it into its word
    clear_s: NotNegative = 0.0  # to move a finished word out and prepare for the next one
    tolerance_m: Positive = 0.1


class LetterStationParameters(_Station):
    """One letter station."""

    staged_bundles: Count = 4
    transfer_s: NotNegative = 5.0  # to put one tile into a bucket
    tolerance_m: Positive = 0.1
