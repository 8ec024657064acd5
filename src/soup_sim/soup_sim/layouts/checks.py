"""What every layout must fulfil: bodies fit, everything is reachable, nothing is missing."""

from __future__ import annotations

import numpy as np

from soup_msgs_py.errors import InputError
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.scenario.floor_plan import CellsLayout, MapLayout
from soup_sim.layouts.draft import Draft, body_m

MOST_WAYPOINTS = 100_000  # the ways to every station are computed before a run begins: some seconds for 20,000
MOST_STOCK = 50_000_000  # kinds of tiles times buckets: the books of the stock
MOST_TILES = 5_000_000  # in all buckets


def check_size(scenario: Scenario, source: object) -> None:
    """Refuse a warehouse that is too large for anybody's patience or memory before anything of it is made."""
    plan, floor = scenario.layout, scenario.floor
    if not isinstance(plan, CellsLayout | MapLayout):  # whose places are drawn one by one
        places = int(floor.width_m / plan.pitch_m) * int(floor.height_m / plan.pitch_m)
        check_waypoints(places, f"{floor.width_m:g} by {floor.height_m:g} m with", source, "floor")
    kinds, buckets, capacity = scenario.tile_kinds, scenario.buckets, scenario.bucket.capacity
    if kinds * buckets > MOST_STOCK:
        found = f"{kinds:,} kinds of tiles in {buckets:,} buckets"
        raise InputError(source, "colours", found, f"kinds times buckets of at most {MOST_STOCK:,}")
    if capacity * buckets > MOST_TILES:
        found = f"{buckets:,} buckets of {capacity:,} tiles"
        raise InputError(source, "bucket.capacity", found, f"buckets times capacity of at most {MOST_TILES:,}")


def check_waypoints(places: int, found: str, source: object, key: str) -> None:
    """Refuse more waypoints than there may be."""
    if places > MOST_WAYPOINTS:
        allowed = f"at most {MOST_WAYPOINTS:,}: a smaller floor, or a larger layout.pitch_m"
        raise InputError(source, key, f"{found} {places:,} waypoints", allowed)


def check_pitch(scenario: Scenario, source: object) -> None:
    """Bodies at neighbouring waypoints do not touch."""
    pitch, body = scenario.layout.pitch_m, body_m(scenario)
    if pitch <= body:
        raise InputError(source, "layout.pitch_m", pitch, f"more than the diameter of bodies, {body:g} m")


def check_reachable(draft: Draft, scenario: Scenario, source: object) -> None:
    """Every station, lane and storage spot can be reached from every station with a bucket, and left again.

    Loaded bots do not drive through storage spots, except in a layout with deep blocks.
    """
    plan = scenario.layout
    where = (plan.path, "") if isinstance(plan, MapLayout) else (source, "layout")
    passable = np.ones_like(draft.is_spot) if draft.deep else ~draft.is_spot
    part = draft.parts(passable)
    home = part[draft.stations[0]]
    cut_off = passable & (part != home)
    # stations first: if one is cut off, all else may be cut off from it
    order = [w for w in draft.stations if cut_off[w]] or np.flatnonzero(cut_off).tolist()
    if not order and not draft.deep:
        inside = part == home
        enterable, leavable = np.zeros_like(inside), np.zeros_like(inside)
        tails, heads = draft.edges[:, 0], draft.edges[:, 1]
        enterable[heads[inside[tails]]] = True
        leavable[tails[inside[heads]]] = True
        order = np.flatnonzero(draft.is_spot & ~(enterable & leavable)).tolist()
    if order:
        first = order[0]
        found = f"a {_kind(draft, first)} at {draft.name(first)} without a way from and to every station"
        allowed = "places that a bot with a bucket can reach and leave"
        raise InputError(*where, found, allowed if draft.deep else f"{allowed}, not through storage spots")


def check_counts(draft: Draft, scenario: Scenario, source: object) -> None:
    """Every bucket has a storage spot, every bot a place to start."""
    spots, places = int(draft.is_spot.sum()), len(draft.waypoints) - len(draft.stations)
    if scenario.buckets > spots:
        allowed = f"at most the {spots} storage spots of this layout"
        raise InputError(source, "buckets", f"{scenario.buckets} buckets", allowed)
    if scenario.bots > places:
        raise InputError(source, "bots", f"{scenario.bots} bots", f"at most {places} here")


def _kind(draft: Draft, waypoint: int) -> str:
    if waypoint in draft.words:
        return "word station"
    if waypoint in draft.letters:
        return "letter station"
    return "storage spot" if draft.is_spot[waypoint] else "lane"
