"""A part that dies is started again, each time after a longer pause, until it is given up."""

from __future__ import annotations

import pytest

from soup_lab.launch.restarts import FIRST_S, LONGEST_S, MOST, STEADY_S, Restarts


@pytest.fixture
def restarts() -> Restarts:
    """One part runs."""
    restarts = Restarts()
    restarts.started("world", 0.0)
    return restarts


def test_a_part_that_died_is_due_after_a_pause(restarts: Restarts):
    assert restarts.died("world", 1.0) == FIRST_S
    assert restarts.waits("world")
    assert restarts.due(1.0) == []
    assert restarts.due(1.0 + FIRST_S) == ["world"]
    restarts.started("world", 1.0 + FIRST_S)
    assert not restarts.waits("world")
    assert restarts.due(100.0) == []


def test_each_pause_is_twice_as_long_until_the_part_is_given_up(restarts: Restarts):
    pauses = [restarts.died("world", 1.0) for _ in range(MOST)]
    assert pauses == [min(FIRST_S * 2.0**k, LONGEST_S) for k in range(MOST)]
    assert restarts.died("world", 1.0) is None


def test_a_part_that_ran_steadily_dies_for_the_first_time_again(restarts: Restarts):
    restarts.died("world", 1.0)
    restarts.started("world", 2.0)
    assert restarts.died("world", 2.0 + STEADY_S) == FIRST_S


def test_to_hand_over_is_not_to_die():
    restarts = Restarts()
    restarts.started("fleet manager", 0.0)
    for k in range(3 * MOST):
        assert restarts.handed_over("fleet manager", 10.0 * k) == FIRST_S
        assert restarts.waits("fleet manager")
        restarts.started("fleet manager", 10.0 * k + 1.0)
    assert restarts.died("fleet manager", 200.0) == FIRST_S
