"""What a planner is asked for, and what it answers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from soup_msgs_py.warehouse.cell_world import World

PICK_OR_DROP, WAIT = "P", "W"


@dataclass(frozen=True)
class Rules:
    """What robots may do, and when a plan is done.

    Both papers' worlds have in common: a robot moves one cell a step (U, D, L, R) or picks up the box, or drops its
    box on the empty shelf, of the cell where it stands (P). Boxes on the floor and empty shelves may be driven over,
    a shelf that was filled is blocked for whoever is not on it. No two robots are in one cell, and no two change
    places.

    Attributes:
        name: `default` or `paper`.
        may_wait: Whether robots may stand (W).
        must_leave: Whether a plan is only done when no robot is on a shelf; its makespan is its whole length.
            Otherwise it is done with the last drop.
        carries_over: Whether a robot that has a box may drive over another box.
    """

    name: str
    may_wait: bool
    must_leave: bool
    carries_over: bool = True


DEFAULT = Rules("default", may_wait=True, must_leave=False)
PAPER = Rules("paper", may_wait=False, must_leave=True)
FLEET = Rules("fleet", may_wait=True, must_leave=False, carries_over=False)  # what bucketbots can do: buckets collide
RULES = {rules.name: rules for rules in (DEFAULT, PAPER, FLEET)}


@dataclass(frozen=True)
class Task:
    """What to plan.

    Attributes:
        world: The world at its start.
        rules: What robots may do.
        weight: By which the heuristic of the paper's planners is multiplied (weighted A*).
        time_limit_s: Wall seconds for the search.
        seed: Of what is drawn at random.
        most_states: After so many states the search for an optimum gives up.
        most_tries: After so many plans the search for a good one ends.
        rounds: Changes that are tried for each of these plans.
    """

    world: World
    rules: Rules = DEFAULT
    weight: float = 1.0
    time_limit_s: float = 60.0
    seed: int = 0
    most_states: int = 6_000_000
    most_tries: int = 1_000_000_000
    rounds: int = 20_000_000


@dataclass(frozen=True)
class Answer:
    """What a planner found.

    Attributes:
        plans: The letters of each robot, all equally many; None where no plan was found.
        lower_bound: No plan takes fewer steps; infinite: there is none.
        proven_optimal: Whether no plan can be shorter.
        nodes_generated: States that were made.
        nodes_expanded: States whose successors were made.
        search_s: Wall seconds, start to end.
        note: Why there is no plan or no proof.
    """

    plans: tuple[str, ...] | None
    lower_bound: float
    proven_optimal: bool
    nodes_generated: int
    nodes_expanded: int
    search_s: float
    note: str = ""

    @property
    def makespan(self) -> int | None:
        """How many steps the plan takes."""
        return None if self.plans is None else len(self.plans[0])

    @property
    def gap(self) -> float | None:
        """The plan's steps over the lower bound, 1 for an optimal one."""
        if self.plans is None:
            return None
        return 1.0 if self.makespan == self.lower_bound else len(self.plans[0]) / max(1.0, self.lower_bound)


class Planner(Protocol):
    """Finds a plan."""

    def __call__(self, task: Task) -> Answer:
        """Plan."""
        ...
