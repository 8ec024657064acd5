"""The planned fleet: a joint plan of the 2023 paper, carried out by bucketbots."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from soup_managers.fleets.minimal.policies import AnyFleet
from soup_managers.planners.anytime import anytime
from soup_managers.planners.check import check_plan
from soup_managers.planners.homing import go_home
from soup_managers.planners.known import PLANNERS
from soup_managers.planners.plan import FLEET, Task
from soup_msgs_py.errors import InputError, RunError
from soup_msgs_py.warehouse.cell_world import World

MOST_ROBOTS, MOST_BOXES = 4, 8  # for which a shortest plan is looked for
MOST_STATES = 200_000
AUTO = "auto"
ROUNDS = 2_000_000
ENDLESS_S = float("inf")


class Planned(AnyFleet):
    """A fleet that makes one plan for all its bots at the start, and carries it out; for worlds of cells.

    The plan depends on nothing but the world, so that a new fleet manager finds the same one.

    Args:
        planner: One of the planners, or `auto`: a shortest plan for few robots, else the best of some tries.
        tries: How many plans to try where a shortest one is not looked for.
        go_home: Whether robots with nothing left to do go back to where they began.
    """

    def __init__(
        self, planner: str = AUTO, tries: Annotated[int, Field(ge=1, le=10_000)] = 6, go_home: bool = True
    ) -> None:
        if planner not in (AUTO, *PLANNERS):
            raise InputError("fleet policy", "planned.options.planner", repr(planner), ", ".join([AUTO, *PLANNERS]))
        self._planner, self._tries, self._goes_home = planner, tries, go_home

    def plan(self, world: World) -> tuple[str, ...]:
        """The letters of each robot.

        Raises:
            InputError: There is no plan, and it is proven.
            RunError: No plan was found.
        """
        task = Task(
            world, FLEET, time_limit_s=ENDLESS_S, most_states=MOST_STATES, most_tries=self._tries, rounds=ROUNDS
        )
        few = len(world.robots) <= MOST_ROBOTS and len(world.boxes) <= MOST_BOXES
        planner = PLANNERS["optimal"] if self._planner == AUTO and few else PLANNERS.get(self._planner, anytime)
        answer = planner(task)
        if answer.plans is None:
            if answer.lower_bound == float("inf"):
                raise InputError("the world of cells", "", answer.note, "a world in which all boxes can be shelved")
            raise RunError(f"no plan for the bots: {answer.note}")
        check_plan(world, answer.plans, carries_over=False)
        return go_home(world, answer.plans) if self._goes_home else answer.plans
