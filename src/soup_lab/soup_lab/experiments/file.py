"""The experiment file of `scripts/compare_policies.py`: its keys, and what is wrong with it in one line."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, ValidationInfo, field_validator, model_validator

from soup_msgs_py.errors import InputError
from soup_msgs_py.reading.yaml_input import Model, read_mapping, validate
from soup_msgs_py.scenario.parameters import NotNegative, Part, Positive

Name = Annotated[str, Field(min_length=1, max_length=60)]
Seed = Annotated[int, Field(ge=0, lt=2**63)]
Change = str | dict[str, Any]


class VariantKeys(Part):
    """One variant: what is other than in the base. Each is dotted keys with values, or a whole file in its place."""

    name: Name
    policies: Change = Field(default_factory=dict)
    scenario: Change = Field(default_factory=dict)

    @field_validator("policies", "scenario", mode="before")
    @classmethod
    def _file_or_mapping(cls, value: object, info: ValidationInfo) -> object:
        example = {"policies": "{word: minimal}", "scenario": "{bots: 150}"}[str(info.field_name)]
        allowed = f"dotted keys with values, for instance {example}, or the name of a file"
        if not isinstance(value, (str, dict)) or value == "":
            raise ValueError(f"{value!r}|{allowed}")
        for key in value if isinstance(value, dict) else ():
            if not isinstance(key, str) or not all(key.split(".")):
                raise ValueError(f"the key {key!r}|{allowed}")
        return value


class GroupKeys(Part):
    """Variants that are shown together, as a rule one decision; the base is among them."""

    group: Name
    about: str = ""
    variants: Annotated[list[dict[Any, Any]], Field(min_length=1)]


class ExperimentKeys(Part):
    """A sweep. Files are relative to the experiment file; times are simulated seconds from the start of a run."""

    name: Name
    about: str = ""
    scenario: Annotated[str, Field(min_length=1)]
    set: dict[str, Any] = Field(default_factory=dict)  # values of the scenario that all variants share
    policies: Annotated[str, Field(min_length=1)]
    warmup_s: NotNegative = 0.0
    duration_s: Positive
    seeds: Annotated[list[Seed], Field(min_length=1)] | None = None
    replications: Annotated[int, Field(ge=1, le=10_000)] | None = None  # the same as seeds 1, 2, 3 ...
    variants: Annotated[list[dict[Any, Any]], Field(min_length=1)]

    @field_validator("set", mode="before")
    @classmethod
    def _dotted_keys(cls, value: object) -> object:
        if not isinstance(value, dict) or not all(isinstance(key, str) and all(key.split(".")) for key in value):
            raise ValueError(f"{value!r}|dotted keys with values, for instance {{bots: 150}}")
        return value

    @model_validator(mode="after")
    def _fit_together(self) -> ExperimentKeys:
        if self.warmup_s >= self.duration_s:
            raise ValueError(f"warmup_s|{self.warmup_s:g}|less than duration_s, {self.duration_s:g}")
        if (self.seeds is None) == (self.replications is None):
            found = "neither seeds nor replications" if self.seeds is None else "seeds and replications"
            raise ValueError(f"seeds|{found}|one of them, for instance seeds: [1, 2, 3]")
        for seed in self.seeds or ():
            if self.seeds is not None and self.seeds.count(seed) > 1:
                raise ValueError(f"seeds|{seed} twice|each seed once: the runs would be the same")
        return self

    def run_seeds(self, replications: int | None) -> tuple[int, ...]:
        """The seeds of the runs: the file's, or as many as the command line says, the first ones the file's."""
        seeds = list(self.seeds or range(1, (self.replications or 1) + 1))
        wanted = replications or len(seeds)
        following = range(max(seeds) + 1, max(seeds) + 1 + max(0, wanted - len(seeds)))
        return tuple([*seeds, *following][:wanted])


Groups = list[tuple[GroupKeys, list[VariantKeys]]]


def read_experiment(path: Path) -> tuple[ExperimentKeys, Groups]:
    """Read an experiment file; whether what its variants change exists is not looked at here.

    Raises:
        InputError: The first thing that is wrong with it.
    """
    keys = validate(ExperimentKeys, read_mapping(path), path)
    groups: Groups = []
    for number, data in enumerate(keys.variants):
        group = _part(GroupKeys, data, path, "variants", number, "group")
        where = f"variants.{group.group}"
        if any(group.group == other.group for other, _ in groups):
            raise InputError(path, where, "the group twice", "each group once")
        variants: list[VariantKeys] = []
        for place, mapping in enumerate(group.variants):
            variant = _part(VariantKeys, mapping, path, where, place, "name")
            if any(variant.name == other.name for other in variants):
                raise InputError(path, f"{where}.{variant.name}", "the variant twice", "each name once in its group")
            variants.append(variant)
        groups.append((group, variants))
    return keys, groups


def blame(path: Path, where: str, error: InputError) -> InputError:
    """The same error, told as one of the experiment file."""
    return InputError(path, ".".join(filter(None, [where, error.key])), error.found, error.allowed)


def _part(model: type[Model], data: dict[Any, Any], path: Path, where: str, number: int, name: str) -> Model:
    """One entry of a list, known by its name where it has one, else by its number."""
    known = data.get(name)
    try:
        return validate(model, data, path)
    except InputError as error:
        raise blame(path, f"{where}.{known if isinstance(known, str) and known else number}", error) from error
