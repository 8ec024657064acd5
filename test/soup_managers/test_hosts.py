"""Which process has the mind of which bot, in whatever order they say so."""

from __future__ import annotations

from itertools import permutations

import pytest

from soup_managers.nodes.hosts import Hosts
from soup_msgs_py.messages import Charge


def charge(part: str, rank: int, *bots: int) -> Charge:
    """What a process says."""
    return Charge(part, 0, rank, "straight", bots)


def test_bots_of_a_process_that_is_dead_are_gone_until_it_is_back():
    hosts = Hosts()
    assert not hosts.is_gone(1)
    assert hosts.hear(charge("bots 0-2", 1, 0, 1, 2)) == set()
    assert hosts.hear(charge("bots 3", 2, 3)) == set()
    assert hosts.hear(charge("bots 0-2", 5)) == {0, 1, 2}
    assert [bot for bot in range(5) if hosts.is_gone(bot)] == [0, 1, 2]
    assert hosts.hear(charge("bots 0-2", 6, 0, 1, 2)) == set()
    assert not any(hosts.is_gone(bot) for bot in range(5))


def test_of_two_processes_with_a_bot_the_newer_has_it():
    hosts = Hosts()
    hosts.hear(charge("bots 4", 9, 4))
    hosts.hear(charge("bots 3-5", 1, 3, 4, 5))
    assert hosts.name(4) == "bots 4"
    assert hosts.name(3) == "bots 3-5"
    assert hosts.name(7) == ""
    assert hosts.hear(charge("bots 4", 10)) == set()
    assert hosts.name(4) == "bots 3-5"


@pytest.mark.parametrize("order", list(permutations(range(3))))
def test_what_is_told_late_changes_nothing(order: tuple[int, ...]):
    hosts = Hosts()
    said = [charge("bots 0-1", 1, 0, 1), charge("bots 0-1", 2), charge("bots 0-1", 3, 0, 1)]
    for k in order:
        hosts.hear(said[k])
    assert not hosts.is_gone(0)
    assert hosts.name(1) == "bots 0-1"
