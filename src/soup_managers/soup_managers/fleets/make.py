"""The fleet policies that come with the warehouse, by the names in a policies file, and the fleet that each needs.

The default of every program is `coordinated`, by `config/policies/best.yaml`.
"""

from __future__ import annotations

import numpy as np

from soup_managers.explain import Explain
from soup_managers.fleets.coordinated.fleet import CoordinatedFleet
from soup_managers.fleets.coordinated.policies import Coordinated
from soup_managers.fleets.minimal.fleet import TripFleet
from soup_managers.fleets.minimal.policies import AnyFleet, FleetPolicy, Minimal
from soup_managers.fleets.planned.fleet import PlannedFleet
from soup_managers.fleets.planned.policies import Planned
from soup_managers.traffic.router import Router
from soup_managers.view import WarehouseView
from soup_msgs_py.errors import InputError
from soup_msgs_py.policies import PolicyChoice, load_policy
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.scenario.floor_plan import CellsLayout
from soup_msgs_py.warehouse.layout import Layout

FLEET: dict[str, type[AnyFleet]] = {"minimal": Minimal, "coordinated": Coordinated, "planned": Planned}
Fleet = TripFleet | CoordinatedFleet | PlannedFleet


def load_fleet(choice: PolicyChoice) -> AnyFleet:
    """Make the fleet policy of a choice.

    Raises:
        InputError: There is no such policy, or its options do not fit.
    """
    return load_policy(choice, "fleet", FLEET, AnyFleet)


def check_fleet(policy: AnyFleet, scenario: Scenario) -> None:
    """Make sure that a fleet policy is made for a warehouse.

    Raises:
        InputError: It is not.
    """
    if isinstance(policy, Planned) and not isinstance(scenario.layout, CellsLayout):
        found = f"a layout of kind {scenario.layout.kind} with fleet policy planned"
        raise InputError(f"scenario {scenario.name}", "layout", found, "a world of cells, as in config/worlds")


def make_fleet(
    scenario: Scenario,
    layout: Layout,
    policy: AnyFleet,
    view: WarehouseView,
    rng: np.random.Generator,
    explain: Explain | None = None,
) -> Fleet:
    """Make the fleet manager that works by a policy; `explain` is told its decisions.

    Compiled code is loaded here, not while bots wait for their first trip.

    Raises:
        InputError: The policy is not made for such a warehouse.
        RunError: It finds no plan for it.
    """
    check_fleet(policy, scenario)
    if isinstance(policy, Planned):
        return PlannedFleet(scenario, layout, policy, view)
    if isinstance(policy, Coordinated):
        return CoordinatedFleet(scenario, layout, policy, view, rng, explain)
    if isinstance(policy, FleetPolicy):
        router = Router(layout)
        router.route(int(layout.storage_spots[0]), int(layout.word_stations[0]))
        return TripFleet(scenario, layout, policy, view, rng, router, explain)
    raise TypeError(f"{type(policy).__name__} extends neither FleetPolicy nor Coordinated nor Planned")
