"""An experiment, checked and ready to run: the base, and groups of variants that each change something of it."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from soup_lab.experiments.file import Change, VariantKeys, blame, read_experiment
from soup_lab.experiments.identity import settings_digest
from soup_lab.headless.runs import RunPlan
from soup_lab.headless.simulation import make_minds
from soup_msgs_py.errors import InputError
from soup_msgs_py.policies import ROLES, Policies, PolicyChoice, anchor, load_policies, name_alone
from soup_msgs_py.reading.files import folder_of, read_text
from soup_msgs_py.reading.yaml_input import LARGEST_FILE_BYTES, read_mapping, validate
from soup_sim.scenario_loader import Warehouse, load_warehouse


@dataclass(frozen=True)
class Case:
    """One way of running: the base or a variant. Two cases with one digest are the same runs.

    Attributes:
        name: As it is shown.
        group: The group's name, empty for the base.
        plan: What to run.
        digest: Fingerprint of all that decides the outcome of a run, but for the seed and the code.
        changed: The values of the scenario that it changes, by their dotted keys.
    """

    name: str
    group: str
    plan: RunPlan
    digest: str
    changed: dict[str, Any]

    @property
    def label(self) -> str:
        """The name, with its group."""
        return f"{self.group}: {self.name}" if self.group else self.name


@dataclass(frozen=True)
class Group:
    """Variants that are shown together."""

    name: str
    about: str
    cases: tuple[Case, ...]


@dataclass(frozen=True)
class Experiment:
    """A sweep: all cases are run with the same seeds (common random numbers)."""

    name: str
    about: str
    texts: dict[str, str]  # all files that it was read from, the experiment file first, by name
    seeds: tuple[int, ...]
    base: Case
    groups: tuple[Group, ...]

    def cases(self) -> list[Case]:
        """The base and all variants, each digest once."""
        first: dict[str, Case] = {}
        for case in (self.base, *(case for group in self.groups for case in group.cases)):
            first.setdefault(case.digest, case)
        return list(first.values())

    def shown(self, group: Group) -> list[Case]:
        """The cases of a group, the base first unless it is one of them."""
        there = any(case.digest == self.base.digest for case in group.cases)
        return list(group.cases) if there else [self.base, *group.cases]


def load_experiment(path: Path, replications: int | None = None) -> Experiment:
    """Read an experiment file and all files that it names.

    Args:
        path: The experiment file.
        replications: How many runs a case, instead of what the file says.

    Raises:
        InputError: Anything is wrong, in any variant; nothing has been run.
    """
    keys, groups = read_experiment(path)
    folder = folder_of(path)
    scenario, policies, shared = folder / keys.scenario, folder / keys.policies, keys.set
    warehouses: dict[str, Warehouse] = {}

    def case(name: str, group: str, warehouse: Warehouse, chosen: Policies, changed: dict[str, Any]) -> Case:
        plan = RunPlan(warehouse, chosen, keys.duration_s, keys.warmup_s)
        return Case(name, group, plan, settings_digest(plan), changed)

    base_policies = load_policies(policies)
    make_minds(base_policies)
    if shared:
        with _told(path, "set", shared):
            base_warehouse = _changed_warehouse(scenario, shared, folder)
    else:
        base_warehouse = load_warehouse(scenario)
    base = case(policies.stem, "", base_warehouse, base_policies, {})

    def variant(keys: VariantKeys, group: str) -> Case:
        where = f"variants.{group}.{keys.name}"
        chosen, warehouse, changed = base_policies, base_warehouse, {}
        if keys.policies:
            with _told(path, f"{where}.policies", keys.policies):
                chosen = _changed_policies(policies, keys.policies, folder, path)
                make_minds(chosen)
        if keys.scenario:
            key = repr(keys.scenario)
            with _told(path, f"{where}.scenario", keys.scenario):
                if key not in warehouses:
                    change = keys.scenario if isinstance(keys.scenario, str) else {**shared, **keys.scenario}
                    warehouses[key] = _changed_warehouse(scenario, change, folder)
            warehouse = warehouses[key]
            changed = keys.scenario if isinstance(keys.scenario, dict) else {}
        return case(keys.name, group, warehouse, chosen, changed)

    loaded = tuple(Group(g.group, g.about, tuple(variant(v, g.group) for v in variants)) for g, variants in groups)
    files = {str(path): path, keys.scenario: scenario, keys.policies: policies}
    changes = [change for _, variants in groups for v in variants for change in (v.scenario, v.policies)]
    files.update({change: folder / change for change in changes if isinstance(change, str)})
    texts = {name: read_text(file, LARGEST_FILE_BYTES, "a text file") for name, file in files.items()}
    return Experiment(keys.name, keys.about, texts, keys.run_seeds(replications), base, loaded)


@contextlib.contextmanager
def _told(path: Path, where: str, change: Change) -> Iterator[None]:
    """What is wrong with changed values is told as an error of the experiment file; a whole file tells its own."""
    try:
        yield
    except InputError as error:
        if isinstance(change, str) and Path(error.source).is_absolute():
            raise
        raise blame(path, where, error) from error


def _changed_warehouse(base: Path, change: Change, folder: Path) -> Warehouse:
    if isinstance(change, str):
        return load_warehouse(folder / change)
    texts = [f"{key}={yaml.safe_dump(value, default_flow_style=True, width=10**6)}" for key, value in change.items()]
    with contextlib.chdir(folder):  # files that an override names are relative to where the program is
        return load_warehouse(base, texts)


def _changed_policies(base: Path, change: Change, folder: Path, path: Path) -> Policies:
    if isinstance(change, str):
        return load_policies(folder / change)
    data = read_mapping(base)
    for key, value in change.items():
        _put(data, key, _anchored(value, folder))
    policies = validate(Policies, data, path)
    return Policies(**{role: anchor(getattr(policies, role), base.parent) for role in ROLES})


def _put(data: dict[str, Any], key: str, value: object) -> None:
    """Put a value under a dotted key; a policy that stands there as a name alone becomes a mapping on the way."""
    *parents, last = key.split(".")
    for index, parent in enumerate(parents):
        below = name_alone(data.setdefault(parent, {}))
        if not isinstance(below, dict):
            found = f"{below!r} at {'.'.join(parents[: index + 1])}"
            raise InputError("", key, found, "a dotted key through mappings and names of policies")
        data[parent] = dict(below)
        data = data[parent]
    data[last] = value


def _anchored(value: Any, folder: Path) -> Any:
    """Make the file of each `file.py:Class` in a value absolute, so that every process finds it."""
    if isinstance(value, dict):
        return {key: _anchored(part, folder) for key, part in value.items()}
    if isinstance(value, str) and value:
        return anchor(PolicyChoice(name=value), folder).name
    return value
