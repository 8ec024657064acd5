"""Scenarios: every configurable parameter of a warehouse, checked before anything starts.

A scenario file is YAML; its keys are the fields below, units are in the names. Source: the 2006 paper, section
"Simulation Parameters and Metrics".
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field, field_validator, model_validator

from soup_msgs_py.errors import InputError
from soup_msgs_py.policies import anchor
from soup_msgs_py.reading.files import folder_of, whole_path
from soup_msgs_py.reading.yaml_input import Overrides, apply_overrides, read_mapping, validate
from soup_msgs_py.scenario.demand import (
    Backlog,
    BundleFile,
    Bundles,
    ChosenBundles,
    Colours,
    ExplicitColours,
    OrderFile,
    Orders,
)
from soup_msgs_py.scenario.floor_plan import Layout_, MapLayout, RowsLayout
from soup_msgs_py.scenario.parameters import (
    BotParameters,
    BucketParameters,
    Count,
    Floor,
    LetterStationParameters,
    Part,
    Position,
    Share,
    WordStationParameters,
)
from soup_msgs_py.warehouse.cell_world import SUFFIX, world_scenario
from soup_msgs_py.warehouse.tiles import LETTERS
from soup_msgs_py.warehouse.words import WordFileError, WordList, read_words

Positions = Annotated[list[Position], Field(min_length=1, max_length=1_000)]


class Scenario(Part):
    """A whole warehouse. The defaults are those of the paper's example where it gives a number."""

    name: Annotated[str, Field(min_length=1, max_length=80)] = Field(description="shown in tables and on the page")
    floor: Floor = Field(description="how large it is")
    bots: Count = Field(description="how many bucketbots")
    buckets: Count = Field(description="how many buckets")
    word_stations: Count | Positions = Field(
        description="how many, evenly spaced along the right edge, or where each is, in metres"
    )
    letter_stations: Count | Positions = Field(
        description="how many, evenly spaced along the left edge, or where each is, in metres"
    )
    bot: BotParameters = Field(default=BotParameters(), description="size, speed and times of a bot")
    bucket: BucketParameters = Field(default=BucketParameters(), description="size and capacity of a bucket")
    word_station: WordStationParameters = Field(
        default=WordStationParameters(), description="what word stations have in common"
    )
    letter_station: LetterStationParameters = Field(
        default=LetterStationParameters(), description="what letter stations have in common"
    )
    bundle_size: Count = Field(default=4, description="letter tiles in a bundle; at most the capacity of a bucket")
    initial_inventory: Share = Field(
        default=0.7, description="share of the capacity of all buckets that is filled at the start"
    )
    words: str = Field(description="path of any text file of English words")
    colours: Colours = Field(
        default=ExplicitColours(shares=[0.8, 0.1, 0.05, 0.05]),
        description="how often each colour is; the list of shares alone will do: `[0.8, 0.2]`",
    )
    orders: Orders = Field(default=Backlog(), description="which words customers order, and when")
    bundles: Bundles = Field(default=ChosenBundles(), description="which letters arrive, and when")
    layout: Layout_ = Field(default=RowsLayout(), description="where waypoints, aisles and storage spots are")

    @field_validator("name")
    @classmethod
    def _can_be_shown(cls, name: str) -> str:
        if not name.isprintable():
            raise ValueError(f"{name!r}|a name without control characters")
        return name

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
        path: The YAML file, or a world file of cells (.txt).
        overrides: `KEY=VALUE` texts that replace single values; dotted keys.

    Returns:
        The scenario, all files that it names made absolute paths.

    Raises:
        InputError: Anything is wrong with the file, a value or an override.
    """
    path = Path(path)
    data = world_scenario(path) if path.suffix == SUFFIX else read_mapping(path)
    overridden = apply_overrides(data, overrides)
    scenario = validate(Scenario, data, path, overridden)
    updates: dict[str, object] = {"words": whole_path(scenario.words, _base("words", path, overridden))}
    for key in ("word_station", "letter_station"):
        part = getattr(scenario, key)
        policy = anchor(part.policy, _base(f"{key}.policy.name", path, overridden))
        updates[key] = part.model_copy(update={"policy": policy})
    for key in ("orders", "bundles", "layout"):
        part = getattr(scenario, key)
        if isinstance(part, (OrderFile, BundleFile, MapLayout)):
            place = whole_path(part.path, _base(f"{key}.path", path, overridden))
            updates[key] = part.model_copy(update={"path": place})
    return scenario.model_copy(update=updates)


def _base(key: str, scenario_file: Path, overridden: set[str]) -> Path:
    """The folder that a file named under a key is relative to: the scenario's own, or here if the command line did."""
    here = any(key == named or key.startswith(f"{named}.") for named in overridden)
    return Path.cwd() if here else folder_of(scenario_file)


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
