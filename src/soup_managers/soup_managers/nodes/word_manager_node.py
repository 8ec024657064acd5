"""The word manager's node."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from soup_msgs import action, srv

from soup_live.process import Live
from soup_managers.explain import Explain
from soup_managers.nodes.station_manager_node import StationManagerNode, role_rng, run_manager
from soup_managers.policies import WORD, WordPolicy
from soup_managers.stations.word_manager import WordManager
from soup_managers.view import WarehouseView
from soup_msgs_py import topics
from soup_msgs_py.messages import DELIVER
from soup_msgs_py.policies import PolicyChoice, load_policy
from soup_msgs_py.wire import Announcement


def make_node(live: Live, choice: PolicyChoice, seed: int, explain: Explain, take_over: bool) -> StationManagerNode:
    """Node `/word_manager`: assigns words by a service of the world, has the fleet deliver letters."""

    def make_mind(world: Announcement) -> WordManager:
        policy = load_policy(choice, "word", WORD, WordPolicy)
        view = WarehouseView(world.scenario, world.layout)
        return WordManager(world.scenario, world.layout, policy, view, role_rng("word", seed), explain)

    return StationManagerNode(
        live,
        topics.WORD_MANAGER_NODE,
        DELIVER,
        make_mind,
        service=(srv.AssignWord, topics.ASSIGN_WORD),
        action=(action.DeliverLetters, topics.DELIVER_LETTERS),
        policy=choice.name,
        take_over=take_over,
    )


def main(argv: Sequence[str] | None = None, *, policies: Path | None = None) -> int:
    """Run the word manager in this process; its exit status."""

    def check(choice: PolicyChoice) -> None:
        load_policy(choice, "word", WORD, WordPolicy)

    return run_manager(argv, "word", policies, check, make_node)


if __name__ == "__main__":
    sys.exit(main())
