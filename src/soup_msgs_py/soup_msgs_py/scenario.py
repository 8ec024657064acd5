"""Scenarios: every configurable parameter of a warehouse, checked before anything starts.

A scenario file is YAML; its keys are the fields below, units are in the names. Source: the 2006 paper, section
"Simulation Parameters and Metrics".
"""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, field_validator, model_validator

from soup_msgs_py.errors import InputError
from soup_msgs_py.tiles import LETTERS
from soup_msgs_py.words import WordFileError, WordList, read_words
from soup_msgs_py.yaml_input import Overrides, apply_overrides, read_mapping, validate

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Share = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
Count = Annotated[int, Field(ge=1, le=100_000)]
Position = tuple[NotNegative, NotNegative]
Place = Annotated[Position, BeforeValidator(lambda value: tuple(value) if isinstance(value, list) else value)]


class _Part(BaseModel):
    """Common rules: no unknown key, no guessing of types, no change after loading."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class Floor(_Part):
    """Size of the floor: x from 0 to width, y from 0 to height."""

    width_m: Positive
    height_m: Positive


class BotParameters(_Part):
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


class BucketParameters(_Part):
    """One bucket."""

    radius_m: Positive = 1.0
    capacity: Count = 40  # letter tiles


class WordStationParameters(_Part):
    """One word station."""

    open_words: Count = 4
    transfer_s: NotNegative = 5.0  # to take one tile out of a bucket and put it into its word
    clear_s: NotNegative = 0.0  # to move a finished word out and prepare for the next one
    tolerance_m: Positive = 0.1


class LetterStationParameters(_Part):
    """One letter station."""

    staged_bundles: Count = 4
    transfer_s: NotNegative = 5.0  # to put one tile into a bucket
    tolerance_m: Positive = 0.1


class ExplicitColours(_Part):
    """The share of each colour."""

    kind: Literal["list"] = "list"
    shares: Annotated[list[NotNegative], Field(min_length=1, max_length=10_000)]

    @field_validator("shares")
    @classmethod
    def _add_up(cls, shares: list[float]) -> list[float]:
        if not math.isclose(sum(shares), 1.0, abs_tol=1e-6):
            raise ValueError(f"shares that add up to {sum(shares):g}|shares that add up to 1")
        return shares


class UniformColours(_Part):
    """All colours alike."""

    kind: Literal["uniform"]
    count: Annotated[int, Field(ge=1, le=10_000)]

    @property
    def shares(self) -> list[float]:
        """The share of each colour."""
        return [1.0 / self.count] * self.count


class ParetoColours(_Part):
    """Few colours are popular: a Pareto distribution, for `alpha` 1.16 the classic 80/20 curve."""

    kind: Literal["pareto"]
    count: Annotated[int, Field(ge=1, le=10_000)]
    alpha: Annotated[float, Field(gt=1, le=100)] = 1.16

    @property
    def shares(self) -> list[float]:
        """The share of each colour, the most popular first."""
        power = 1.0 - 1.0 / self.alpha
        # rounded, so that the last bits of a power function, which differ between machines, decide nothing
        curve = [round((k / self.count) ** power, 12) for k in range(self.count + 1)]
        return [after - before for before, after in pairwise(curve)]


Colours = Annotated[ExplicitColours | UniformColours | ParetoColours, Field(discriminator="kind")]
DailyProfile = Annotated[list[NotNegative], Field(min_length=24, max_length=24)]  # factor for each hour of the day


class Backlog(_Part):
    """Always `visible` waiting words to choose from: a customer whose demand never ends."""

    kind: Literal["backlog"] = "backlog"
    visible: Count = 200


class AllOrders(_Part):
    """All orders are known at the start, and no more come."""

    kind: Literal["all"]
    count: Count


class PoissonOrders(_Part):
    """Words arrive at random, `per_hour` on average, times the factor of the hour of the day."""

    kind: Literal["poisson"]
    per_hour: Positive
    daily_profile: DailyProfile = [1.0] * 24
    at_start: Annotated[int, Field(ge=0, le=100_000)] = 0


class OrderFile(_Part):
    """Words arrive as a file says: lines of `seconds,word` or `seconds,E0 T1 A0`, in order of time."""

    kind: Literal["file"]
    path: str  # relative to the scenario file


Orders = Annotated[Backlog | AllOrders | PoissonOrders | OrderFile, Field(discriminator="kind")]


class ChosenBundles(_Part):
    """The letter manager decides which letters come in; any kind can be had at any time."""

    kind: Literal["chosen"] = "chosen"


class PoissonBundles(_Part):
    """Bundles of kinds that follow the letters of words arrive at random, `per_hour` on average."""

    kind: Literal["poisson"]
    per_hour: Positive
    daily_profile: DailyProfile = [1.0] * 24
    at_start: Annotated[int, Field(ge=0, le=100_000)] = 0


class BundleFile(_Part):
    """Bundles arrive as a file says: lines of `seconds,E0`, in order of time."""

    kind: Literal["file"]
    path: str  # relative to the scenario file


Bundles = Annotated[ChosenBundles | PoissonBundles | BundleFile, Field(discriminator="kind")]


class Edge(_Part):
    """One more directed edge between two waypoints, or another weight for one that is there."""

    start: Place
    end: Place
    weight: Positive = 1.0  # cost per metre; 1 is normal


class Highway(_Part):
    """Edges along a straight line cost `weight` times as much in its direction; below 1 attracts traffic."""

    start: Place
    end: Place
    weight: Positive = 1.0
    one_way: bool = False  # no edge leads against its direction


class _WaypointGraph(_Part):
    """What all layouts have in common; see the modules of `soup_sim.layouts`."""

    pitch_m: Positive = 3.0  # between neighbouring waypoints
    edges: Annotated[list[Edge], Field(max_length=10_000)] = []
    highways: Annotated[list[Highway], Field(max_length=1_000)] = []


class _Aisles(_WaypointGraph):
    """Blocks of storage spots between aisles."""

    aisle_lanes: Annotated[int, Field(ge=1, le=2)] = 2  # 2: one lane a direction
    margin_columns: Annotated[int, Field(ge=1, le=50)] = 4  # free waypoints in front of the stations


class RowsLayout(_Aisles):
    """Rows of storage spots; every spot is next to an aisle."""

    kind: Literal["rows"] = "rows"
    block_columns: Count = 2  # storage spots side by side between two aisles
    block_rows: Count = 10  # storage spots on top of each other between two cross aisles


class DenseLayout(_Aisles):
    """Deep blocks of storage spots: inner buckets must be dug out (the tile problem)."""

    kind: Literal["dense"]
    block_columns: Count = 6
    block_rows: Count = 8


class HexagonalLayout(_Aisles):
    """Blocks of two columns, one shifted by half a pitch: round buckets packed like a honeycomb."""

    kind: Literal["hexagonal"]
    block_rows: Count = 10


class MapLayout(_WaypointGraph):
    """A floor drawn in a text file, one character a waypoint."""

    kind: Literal["map"]
    path: str  # relative to the scenario file
    # how many times more a lane costs against its arrow; null forbids it
    wrong_way: Annotated[float, Field(ge=1, allow_inf_nan=False)] | None = 5.0


Layout_ = Annotated[RowsLayout | DenseLayout | HexagonalLayout | MapLayout, Field(discriminator="kind")]


class Scenario(_Part):
    """A whole warehouse. The defaults are those of the paper's example where it gives a number."""

    name: Annotated[str, Field(min_length=1, max_length=80)]
    floor: Floor
    bots: Count
    buckets: Count
    word_stations: Count | Annotated[list[Position], Field(min_length=1)]  # how many, evenly spaced, or where (m)
    letter_stations: Count | Annotated[list[Position], Field(min_length=1)]
    bot: BotParameters = BotParameters()
    bucket: BucketParameters = BucketParameters()
    word_station: WordStationParameters = WordStationParameters()
    letter_station: LetterStationParameters = LetterStationParameters()
    bundle_size: Count = 4  # letter tiles
    initial_inventory: Share = 0.7  # share of the capacity of all buckets that is filled at the start
    words: str  # any text file of English words, relative to this file
    colours: Colours = ExplicitColours(shares=[0.8, 0.1, 0.05, 0.05])  # or just the list of shares
    orders: Orders = Backlog()
    bundles: Bundles = ChosenBundles()
    layout: Layout_ = RowsLayout()

    @field_validator("colours", mode="before")
    @classmethod
    def _list_alone(cls, colours: object) -> object:
        return {"kind": "list", "shares": colours} if isinstance(colours, list) else colours

    @field_validator("word_stations", "letter_stations", mode="before")
    @classmethod
    def _positions(cls, value: object) -> object:
        if isinstance(value, list):
            return [tuple(p) if isinstance(p, list) else p for p in value]
        return value

    @model_validator(mode="after")
    def _parts_fit_together(self) -> Scenario:
        if self.bundle_size > self.bucket.capacity:
            raise ValueError(
                f"bundle_size|{self.bundle_size} tiles|at most the capacity of a bucket, {self.bucket.capacity}"
            )
        for key in ("word_stations", "letter_stations"):
            positions = getattr(self, key)
            for index, (x, y) in enumerate(positions if isinstance(positions, list) else []):
                if x > self.floor.width_m or y > self.floor.height_m:
                    raise ValueError(
                        f"{key}.{index}|a station at ({x:g}, {y:g})|a place on the floor, "
                        f"0 to {self.floor.width_m:g} by 0 to {self.floor.height_m:g} m"
                    )
        return self

    @property
    def tile_kinds(self) -> int:
        """How many kinds of letter tiles there are: letters times colours."""
        return LETTERS * len(self.colours.shares)

    @property
    def word_station_count(self) -> int:
        """How many word stations there are."""
        return self.word_stations if isinstance(self.word_stations, int) else len(self.word_stations)

    @property
    def letter_station_count(self) -> int:
        """How many letter stations there are."""
        return self.letter_stations if isinstance(self.letter_stations, int) else len(self.letter_stations)


def load_scenario(path: str | Path, overrides: Overrides = ()) -> Scenario:
    """Read a scenario file.

    Args:
        path: The YAML file.
        overrides: `KEY=VALUE` texts that replace single values; dotted keys.

    Returns:
        The scenario, `words` made an absolute path.

    Raises:
        InputError: Anything is wrong with the file, a value or an override.
    """
    path = Path(path)
    data = read_mapping(path)
    overridden = apply_overrides(data, overrides)
    scenario = validate(Scenario, data, path, overridden)
    updates: dict[str, object] = {"words": _anchor(scenario.words, path, "words" in overridden)}
    for key in ("orders", "bundles", "layout"):
        part = getattr(scenario, key)
        if isinstance(part, (OrderFile, BundleFile, MapLayout)):
            place = _anchor(part.path, path, f"{key}.path" in overridden)
            updates[key] = part.model_copy(update={"path": place})
    return scenario.model_copy(update=updates)


def _anchor(place: str, scenario_file: Path, overridden: bool) -> str:
    """A file that a scenario names, relative to the scenario's own folder, or to here if the command line named it."""
    base = Path.cwd() if overridden else scenario_file.resolve().parent
    return str((base / place).resolve())


def scenario_from_json(text: str) -> Scenario:
    """The scenario that another part has published."""
    return Scenario.model_validate_json(text, strict=False)


def load_words(scenario: Scenario, source: object) -> WordList:
    """The word list of a scenario.

    Raises:
        InputError: The file is missing, unreadable or holds no usable word.
    """
    try:
        return read_words(scenario.words)
    except WordFileError as error:
        raise InputError(source, "words", f"{scenario.words}: {error.found}", error.allowed) from error
