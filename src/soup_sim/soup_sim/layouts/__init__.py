"""Layouts: waypoints, edges, storage spots and stations, made from a scenario."""

from __future__ import annotations

from soup_msgs_py.scenario import Scenario
from soup_msgs_py.scenario.floor_plan import CellsLayout, DenseLayout, HexagonalLayout, MapLayout
from soup_msgs_py.warehouse.layout import Layout
from soup_sim.layouts.aisles import dense, hexagonal, rows
from soup_sim.layouts.cells import cells
from soup_sim.layouts.checks import check_counts, check_pitch, check_reachable, check_size
from soup_sim.layouts.draft import Draft, body_m
from soup_sim.layouts.drawn_map import drawn_map
from soup_sim.layouts.highways import change_edges


def make_layout(scenario: Scenario, source: object = "scenario") -> Layout:
    """The layout that a scenario asks for.

    Args:
        scenario: The scenario.
        source: The file that error messages name.

    Raises:
        InputError: Bodies, stations or buckets do not fit on the floor, or a place cannot be reached.
    """
    check_pitch(scenario, source)
    check_size(scenario, source)
    draft = _draft(scenario, source)
    change_edges(draft, scenario.layout, body_m(scenario), source)
    if not isinstance(scenario.layout, CellsLayout):  # whose places have been looked at
        check_counts(draft, scenario, source)
        check_reachable(draft, scenario, source)
    return draft.layout(scenario.floor)


def _draft(scenario: Scenario, source: object) -> Draft:
    plan = scenario.layout
    if isinstance(plan, DenseLayout):
        return dense(scenario, plan, source)
    if isinstance(plan, HexagonalLayout):
        return hexagonal(scenario, plan, source)
    if isinstance(plan, MapLayout):
        return drawn_map(scenario, plan, source)
    if isinstance(plan, CellsLayout):
        return cells(scenario, plan, source)
    return rows(scenario, plan, source)
