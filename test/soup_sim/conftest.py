"""Fixtures: small warehouses."""

from __future__ import annotations

from pathlib import Path

import pytest

from soup_msgs_py.scenario import Scenario, load_scenario, load_words
from soup_msgs_py.warehouse.layout import Layout
from soup_msgs_py.warehouse.words import WordList
from soup_sim.layouts import make_layout
from soup_sim.world import World

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def demo() -> Scenario:
    """The demo scenario."""
    return load_scenario(ROOT / "config/scenarios/demo.yaml")


@pytest.fixture(scope="session")
def demo_layout(demo: Scenario) -> Layout:
    """Its floor."""
    return make_layout(demo)


@pytest.fixture(scope="session")
def words(demo: Scenario) -> WordList:
    """Its words."""
    return load_words(demo, "demo")


@pytest.fixture
def world(demo: Scenario, demo_layout: Layout, words: WordList) -> World:
    """A fresh demo warehouse."""
    return World(demo, demo_layout, words, seed=1)
