"""The letter manager's node."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from soup_msgs import action, srv

from soup_live.process import Live
from soup_managers.explain import Explain
from soup_managers.nodes.station_manager_node import StationManagerNode, role_rng, run_manager
from soup_managers.policies import LETTER, LetterPolicy
from soup_managers.stations.letter_manager import LetterManager
from soup_managers.view import WarehouseView
from soup_msgs_py import topics
from soup_msgs_py.messages import STORE
from soup_msgs_py.policies import PolicyChoice, load_policy
from soup_msgs_py.wire import Announcement


def make_node(live: Live, choice: PolicyChoice, seed: int, explain: Explain, take_over: bool) -> StationManagerNode:
    """Node `/letter_manager`: assigns bundles by a service of the world, has the fleet store them."""

    def make_mind(world: Announcement) -> LetterManager:
        policy = load_policy(choice, "letter", LETTER, LetterPolicy)
        view = WarehouseView(world.scenario, world.layout)
        profile = np.array(world.tile_profile)
        return LetterManager(world.scenario, world.layout, policy, view, role_rng("letter", seed), profile, explain)

    return StationManagerNode(
        live,
        topics.LETTER_MANAGER_NODE,
        STORE,
        make_mind,
        service=(srv.AssignBundle, topics.ASSIGN_BUNDLE),
        action=(action.StoreBundle, topics.STORE_BUNDLE),
        policy=choice.name,
        take_over=take_over,
    )


def main(argv: Sequence[str] | None = None, *, policies: Path | None = None) -> int:
    """Run the letter manager in this process; its exit status."""

    def check(choice: PolicyChoice) -> None:
        load_policy(choice, "letter", LETTER, LetterPolicy)

    return run_manager(argv, "letter", policies, check, make_node)


if __name__ == "__main__":
    sys.exit(main())
