"""Scenario loading, from a file to a world: everything that is read and checked before anything starts."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from soup_msgs_py.reading.yaml_input import Overrides
from soup_msgs_py.scenario import Scenario, load_scenario, load_words
from soup_msgs_py.warehouse.layout import Layout
from soup_msgs_py.warehouse.words import WordList
from soup_sim.arrivals import TimedBundle, TimedWord, read_timed_bundles, read_timed_words
from soup_sim.layouts import make_layout
from soup_sim.station_policies import station_policies
from soup_sim.world import World


@dataclass(frozen=True)
class Warehouse:
    """A checked scenario and all that belongs to it."""

    scenario: Scenario
    layout: Layout
    words: WordList
    timed_words: tuple[TimedWord, ...]
    timed_bundles: tuple[TimedBundle, ...]

    def world(self, seed: int, warmup_s: float = 0.0, run: int = 0) -> World:
        """A new world; rates and counts cover what comes after the warm-up (simulated s)."""
        return World(
            self.scenario, self.layout, self.words, seed, warmup_s, self.timed_words, self.timed_bundles, run
        )  # fmt: skip


def load_warehouse(path: str | Path, overrides: Overrides = ()) -> Warehouse:
    """Read a scenario file and all files that it names.

    Args:
        path: The scenario file.
        overrides: `KEY=VALUE` texts that replace single values.

    Raises:
        InputError: Anything is wrong, the names and options of station policies included.
    """
    scenario = load_scenario(path, overrides)
    for make_policy in station_policies(scenario, path):
        make_policy()
    return Warehouse(
        scenario,
        make_layout(scenario, path),
        load_words(scenario, path),
        read_timed_words(scenario, path),
        read_timed_bundles(scenario, path),
    )
