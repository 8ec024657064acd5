"""The parameters of bodies and stations, and what all parts of a scenario have in common."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, field_validator

from soup_msgs_py.policies import PolicyChoice, name_alone

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
# What a warehouse may have. Beyond it a run would need more steps, or more memory, than anybody has; sizes of floor and
# bodies also stay where a float tells places and times apart.
Metres = Annotated[Positive, Field(ge=1.0, le=20_000.0)]  # of the floor
Spacing = Annotated[Positive, Field(ge=0.1, le=1_000.0)]  # between waypoints (m)
Radius = Annotated[Positive, Field(ge=0.05, le=100.0)]  # of a body (m)
Tolerance = Annotated[Positive, Field(ge=1e-6, le=100.0)]  # how near is there (m)
Speed = Annotated[Positive, Field(ge=0.01, le=50.0)]  # m/s
Acceleration = Annotated[Positive, Field(ge=0.01, le=1_000.0)]  # m/s2
TurnRate = Annotated[Positive, Field(ge=0.01, le=1_000.0)]  # rad/s
Seconds = Annotated[NotNegative, Field(le=86_400.0)]  # that something takes: up to a day
Penalty = Annotated[Positive, Field(ge=0.001, le=86_400.0)]  # s
Cost = Annotated[Positive, Field(ge=0.001, le=1e6)]  # of a metre; 1 is normal
Share = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
Count = Annotated[int, Field(ge=1, le=100_000)]
Position = tuple[NotNegative, NotNegative]
Place = Annotated[Position, BeforeValidator(lambda value: tuple(value) if isinstance(value, list) else value)]


class Part(BaseModel):
    """Common rules: no unknown key, no guessing of types, no change after loading."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class Floor(Part):
    """Size of the floor: x from 0 to width, y from 0 to height."""

    width_m: Metres = Field(description="from left to right")
    height_m: Metres = Field(description="from bottom to top")


class Sensing(Part):
    """What a bot is told of what lies within its sensing radius: everything, or less to blind it for an experiment.

    Source: the paper, section "Bucketbot Sensing and Control". A bot that is blinded in any other way than `contents`
    thinks for itself: it hears of nobody's intentions either.
    """

    velocities: bool = Field(default=True, description="of other bots; without, they all seem to stand")
    contents: bool = Field(default=True, description="the letter tiles in buckets")
    intentions: bool = Field(default=True, description="what other bots of the same process are about to do")
    view_angle_rad: Annotated[float, Field(gt=0, le=2 * math.pi)] | None = Field(
        default=None, description="only what lies ahead within this angle; null: all around"
    )
    nearest: Count | None = Field(default=None, description="only so many bots and so many resting buckets; null: all")

    @property
    def is_alone(self) -> bool:
        """Whether each bot has to think for itself, because no two are told the same."""
        everything = self.velocities and self.intentions and self.view_angle_rad is None and self.nearest is None
        return not everything


class BotParameters(Part):
    """One bucketbot: size, equations 1 and 2, the times of its actions, what it senses."""

    radius_m: Radius = Field(default=1.0, description="of the disc that a bot is")
    max_speed_mps: Speed = Field(default=4.0, description="top speed (equation 1 of the paper)")
    max_acceleration_mps2: Acceleration = Field(
        default=20.0, description="when a bot speeds up and when it brakes (equation 2 of the paper)"
    )
    turn_rate_radps: TurnRate | None = Field(
        default=None, description="how fast a bot turns; null: turning takes no time"
    )
    grab_s: Seconds = Field(default=0.5, description="time to lift a bucket")
    release_s: Seconds = Field(default=0.5, description="time to set a bucket down")
    tolerance_m: Tolerance = Field(
        default=0.1,
        description="how close a bot must be to a bucket to grab it, and to a storage spot to release on it",
    )
    collision_penalty_s: Penalty = Field(default=5.0, description="how long all who are involved in a collision stand")
    sensing_radius_m: Annotated[NotNegative, Field(le=20_000.0)] = Field(
        default=20.0, description="how far a bot senses"
    )
    sensing: Sensing = Field(
        default=Sensing(),
        description="blinds bots for an experiment; without it they sense everything within the radius",
    )


class BucketParameters(Part):
    """One bucket."""

    radius_m: Radius = Field(default=1.0, description="of the disc that a bucket is")
    capacity: Annotated[int, Field(ge=1, le=10_000)] = Field(default=40, description="letter tiles that fit into it")


class _Station(Part):
    """A station, and how it decides by itself."""

    policy: PolicyChoice = Field(
        default=PolicyChoice(name="as_asked"), description="what the station does next by itself"
    )

    @field_validator("policy", mode="before")
    @classmethod
    def _name_alone(cls, value: object) -> object:
        return name_alone(value)


class WordStationParameters(_Station):
    """One word station."""

    open_words: Count = Field(default=4, description="words that can be open at a station at the same time")
    transfer_s: Seconds = Field(
        default=5.0, description="time to take one tile out of a bucket and put it into its word"
    )
    clear_s: Seconds = Field(default=0.0, description="time to move a finished word out and prepare for the next one")
    tolerance_m: Tolerance = Field(default=0.1, description="how close the carried bucket must be to the station")


class LetterStationParameters(_Station):
    """One letter station."""

    staged_bundles: Count = Field(default=4, description="bundles that can be staged at a station at the same time")
    transfer_s: Seconds = Field(default=5.0, description="time to put one tile into a bucket")
    tolerance_m: Tolerance = Field(default=0.1, description="how close the carried bucket must be to the station")
