"""What the parts of a world's state may hold in a checkpoint: every number within the world that it is for.

It looks at the plain values before the world does, and shares nothing with the code that writes them but the names.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence, Sized
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, model_validator

from soup_msgs_py.codes import Code
from soup_msgs_py.messages import Floats
from soup_sim.motion import MAX_SEGMENTS
from soup_sim.world import World

LARGEST, LONGEST = 2**62, 1e12
SLACK = 1.001  # for rounding
Time = Annotated[float, Field(ge=0, le=LONGEST, allow_inf_nan=False)]
Finite = Annotated[float, Field(ge=-LONGEST, le=LONGEST, allow_inf_nan=False)]
Amount = Annotated[int, Field(ge=0, le=LARGEST)]
Number = Annotated[int, Field(ge=-LARGEST, le=LARGEST)]
Pair = tuple[Number, Number]
Bundle = tuple[Amount, Amount, Amount]


class Part(BaseModel):
    """Common rules: no key too many, and no guessing."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


@dataclass(frozen=True)
class Frame:
    """What a state is held against: the world it is for, and the state that this world has now."""

    world: World
    own: Mapping[str, Any]


class Agenda(Part):
    """What is due, in order."""

    now: Time
    sequence: Amount
    entries: Amount
    due: list[tuple[Time, Amount, str, list[Any]]]

    @model_validator(mode="after")
    def _fit(self, info: ValidationInfo) -> Agenda:
        world = frame(info).world
        bots, buckets = world.scenario.bots, world.scenario.buckets
        bot, bucket, other = between(0, bots), between(0, buckets), between(-buckets, bots)
        station, spot = between(0, len(world.layout.stations)), between(0, len(world.layout.waypoints))
        number = between(-LARGEST, LARGEST)
        arguments: dict[str, tuple[Callable[[Any], bool], ...]] = {
            "motion_ends": (bot, number), "window": (), "contact": (bot, other, number), "resume": (bot, is_time),
            "grabbed": (bot, number, bucket), "released": (bot, number, spot), "transferred": (station,),
            "cleared": (station, number), "warmed_up": (), "word_arrives": (), "bundle_arrives": (),
        }  # fmt: skip
        for time, entry, action, given in self.due:
            fits = arguments.get(action)
            if fits is None or len(given) != len(fits) or not all(map(lambda fit, value: fit(value), fits, given)):
                raise ValueError(f"{action[:40]!r} with {str(given)[:80]} on the agenda")
            if time < self.now or entry > self.entries:
                raise ValueError(f"{action} at {time:g} s on the agenda, and it is {self.now:g} s")
        if any(former[:2] >= later[:2] for former, later in pairwise(self.due)):
            raise ValueError("an agenda out of order")
        return self


class Bodies(Part):
    """Where everything is, and how it moves."""

    state: Any = Field(alias="_state")
    segments: Any = Field(alias="_segments")
    count: Any = Field(alias="_count")
    odometer: Any = Field(alias="_odometer")
    bucket_xy: Any = Field(alias="_bucket_xy")
    loose: Any = Field(alias="_loose")
    places: Any = Field(alias="_places")
    moving: list[bool]
    bucket: list[Number]
    carrier: list[Number]
    grids: tuple[list[Number], list[Number], list[Number], list[Number]]
    loose_count: Amount

    @model_validator(mode="after")
    def _fit(self, info: ValidationInfo) -> Bodies:
        world, own = frame(info).world, frame(info).own["bodies"]
        bots, buckets = world.scenario.bots, world.scenario.buckets
        arrays = {key: like(getattr(self, key[1:]), value, key) for key, value in own.items() if key.startswith("_")}
        self._check_motion(world, arrays)
        within(arrays["_loose"], -1, buckets, "_loose")
        within([self.loose_count], 0, len(own["_loose"]) + 1, "loose_count")
        for key, values, below in (("bucket", self.bucket, buckets), ("carrier", self.carrier, bots)):
            as_many(values, own[key], key)
            within(values, -1, below, key)
        as_many(self.moving, own["moving"], "moving")
        carried = {(bot, bucket) for bot, bucket in enumerate(self.bucket) if bucket >= 0}
        if carried != {(bot, bucket) for bucket, bot in enumerate(self.carrier) if bot >= 0}:
            raise ValueError("a bucket on another bot than the one that carries it")
        for first, below in ((0, bots), (2, buckets)):
            self._check_cells(self.grids[first : first + 2], own["grids"][first : first + 2], below)
        return self

    @staticmethod
    def _check_motion(world: World, arrays: Mapping[str, Floats]) -> None:
        """Nothing is beside the floor, nobody is faster than bots are."""
        limits, state, segments = world.scenario.bot, arrays["_state"], arrays["_segments"]
        size = np.array([world.layout.width_m, world.layout.height_m])
        for key, places in (("_state", state[:, 1:3]), ("_bucket_xy", arrays["_bucket_xy"])):
            if ((places < 0.0) | (places > size)).any():
                raise ValueError(f"{key}: a place beside the floor")
        fast = np.hypot(state[:, 3], state[:, 4]) > SLACK * limits.max_speed_mps
        hard = np.hypot(segments[:, :, 1], segments[:, :, 2]) > SLACK * limits.max_acceleration_mps2
        if fast.any() or hard.any() or (segments[:, :, 0] < 0.0).any():
            raise ValueError("a motion that no bot can do")
        within(arrays["_count"], 0, MAX_SEGMENTS + 1, "_count")

    @staticmethod
    def _check_cells(grid: Sequence[Sequence[int]], own: Sequence[Sized], below: int) -> None:
        """A cell's first one, and each one's follower: nobody is in two places, so every list has an end."""
        for values, mine in zip(grid, own, strict=True):
            as_many(values, mine, "grids")
            within(values, -1, below, "grids")
        heads, following = grid
        seen: set[int] = set()
        for each in heads:
            while each >= 0:
                if each in seen:
                    raise ValueError("grids: somebody in two cells")
                seen.add(each)
                each = following[each]


class Path(Part):
    """A path under way."""

    request: Number
    points: Annotated[list[tuple[Finite, Finite]], Field(min_length=1)]
    stamps: list[Time]
    index: Amount

    @model_validator(mode="after")
    def _fit(self, info: ValidationInfo) -> Path:
        layout = frame(info).world.layout
        inside = all(0.0 <= x <= layout.width_m and 0.0 <= y <= layout.height_m for x, y in self.points)
        in_order = all(early <= late for early, late in pairwise(self.stamps))
        matches = len(self.stamps) in (0, len(self.points)) and self.index < len(self.points)
        if not (inside and in_order and matches):
            raise ValueError("a path that nobody can drive")
        return self


class Driving(Part):
    """Who is under way."""

    paths: list[Path | None]
    changed: list[Amount]
    ends: list[Time | None]
    changes: Amount
    window_end: Finite
    stirred: list[Number]

    @model_validator(mode="after")
    def _fit(self, info: ValidationInfo) -> Driving:
        own = frame(info).own["driving"]
        for key in ("paths", "changed", "ends"):
            as_many(getattr(self, key), own[key], key)
        within(self.stirred, 0, len(own["paths"]), "stirred")
        return self


class Storage(Part):
    """What rests where."""

    bucket_on: list[Pair]
    spot_of: list[Number]

    @model_validator(mode="after")
    def _fit(self, info: ValidationInfo) -> Storage:
        world = frame(info).world
        buckets, waypoints = world.scenario.buckets, len(world.layout.waypoints)
        on = dict(self.bucket_on)
        as_many(self.spot_of, range(buckets), "spot_of")
        as_many(on, self.bucket_on, "bucket_on")
        within(self.spot_of, -1, waypoints, "spot_of")
        within(on, 0, waypoints, "bucket_on")
        within(on.values(), -1, buckets, "bucket_on")
        if any(spot >= 0 and on.get(spot) != bucket for bucket, spot in enumerate(self.spot_of)):
            raise ValueError("a bucket that rests where there is another one, or none")
        return self


class Station(Part):
    """What a station has in hand."""

    visits: list[tuple[Number, Number, list[Pair], Amount, Amount, tuple[Code, str] | None, bool]]
    policy: Any  # of a person's own, who reads it
    busy: bool
    move: Pair | None
    open_words: list[tuple[Amount, str, list[Number], list[bool]]] | None = None
    staged: list[Bundle] | None = None

    @model_validator(mode="after")
    def _fit(self, info: ValidationInfo) -> Station:
        world = frame(info).world
        kinds = len(world.tile_profile)
        within([visit[0] for visit in self.visits], 0, world.scenario.bots, "visits")
        within([tile for visit in self.visits for tile, _ in visit[2]], -1, kinds, "visits")
        within([self.move[0]] if self.move is not None else [], 0, kinds, "move")
        within([tile for _, tile, _ in self.staged or ()], 0, kinds, "staged")
        for _, _, tiles, filled in self.open_words or ():
            within(tiles, 0, kinds, "open_words")
            as_many(filled, tiles, "open_words")
        return self


class Pcg64(Part):
    """What it counts with."""

    state: Annotated[int, Field(ge=0, lt=2**128)]
    inc: Annotated[int, Field(ge=0, lt=2**128)]


class Randomness(Part):
    """The state of numpy's generator."""

    bit_generator: Literal["PCG64"]
    state: Pcg64
    has_uint32: Literal[0, 1]
    uinteger: Annotated[int, Field(ge=0, lt=2**32)]


class Serving(Part):
    """What is in buckets and stations."""

    contents: list[list[Pair]]
    words_completed: Amount
    stations: list[Station]
    rng: Randomness

    @model_validator(mode="after")
    def _fit(self, info: ValidationInfo) -> Serving:
        world, own = frame(info).world, frame(info).own["serving"]
        capacity = world.scenario.bucket.capacity
        as_many(self.contents, own["contents"], "contents")
        for content in self.contents:
            within([kind for kind, _ in content], 0, len(world.tile_profile), "contents")
            within([count for _, count in content], 0, capacity + 1, "contents")
            within([sum(count for _, count in content)], 0, capacity + 1, "contents")
        as_many(self.stations, own["stations"], "stations")
        for number, (station, mine) in enumerate(zip(self.stations, own["stations"], strict=True)):
            if ("staged" in mine) != (station.staged is not None) or ("open_words" in mine) != (
                station.open_words is not None
            ):
                raise ValueError(f"station {number} is of the other kind")
        return self


class Arrivals(Part):
    """How far the lines of a file have been read."""

    told: Amount
    is_coming: bool


class Coming(Part):
    """Orders or bundles that are still to come."""

    next: Amount
    arrivals: Arrivals
    rng: Randomness


def frame(info: ValidationInfo) -> Frame:
    """What a validator holds its part against."""
    assert isinstance(info.context, Frame)
    return info.context


def between(least: int, below: int) -> Callable[[Any], bool]:
    """What holds of whole numbers from `least` on and below `below`."""
    return lambda value: type(value) is int and least <= value < below


def is_time(value: Any) -> bool:
    """Whether something is a simulated time."""
    return type(value) in (int, float) and 0.0 <= value <= LONGEST


def are_numbers(value: Any) -> bool:
    """Whether something is a number, or made of lists of them."""
    if isinstance(value, list):
        return all(map(are_numbers, value))
    return type(value) in (int, float) and -LONGEST <= value <= LONGEST


def within(values: Iterable[Any], least: int, below: int, key: str) -> None:
    """Raise `ValueError` for a number that is none of those from `least` on and below `below`."""
    wrong = [value for value in values if not least <= value < below]
    if wrong:
        raise ValueError(f"{key}: {wrong[0]:g}; it is {least} to {below - 1}")


def as_many(values: Sized, own: Sized, key: str) -> None:
    """Raise `ValueError` where the world has more or fewer."""
    if len(values) != len(own):
        raise ValueError(f"{key}: {len(values)} entries; this world has {len(own)}")


def like(values: Any, own: Any, key: str) -> Floats:
    """An array of numbers, of the same shape as the world's own."""
    if not are_numbers(values):
        raise ValueError(f"{key}: no numbers")
    try:
        found = np.array(values, dtype=np.float64)
    except ValueError as error:
        raise ValueError(f"{key}: no array") from error
    if found.shape != np.shape(own):
        raise ValueError(f"{key}: an array of shape {found.shape}; this world has {np.shape(own)}")
    return found
