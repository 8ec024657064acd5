"""The planners, by the names by which they are asked for."""

from __future__ import annotations

from soup_managers.planners.anytime import anytime
from soup_managers.planners.joint import multi_action, single_action
from soup_managers.planners.optimal import optimal
from soup_managers.planners.plan import Planner

PLANNERS: dict[str, Planner] = {
    "optimal": optimal,
    "anytime": anytime,
    "multi-action": multi_action,
    "single-action": single_action,
}
