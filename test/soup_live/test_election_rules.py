"""Of several managers of a role one is in charge: the first, and when it goes the next."""

from __future__ import annotations

import pytest

from soup_live.election_rules import ALONE_S, LOOK_S, SETTLE_S, Election, Standing
from soup_msgs_py.messages import Charge


def candidate(rank: int) -> Election:
    """A candidate that has just been started."""
    return Election("word manager", rank, "served", 0.0)


@pytest.fixture
def first() -> Election:
    """A candidate that is in charge."""
    first = candidate(5)
    first.look(LOOK_S)
    first.look(LOOK_S + SETTLE_S)
    return first


def test_a_newcomer_looks_around_before_it_claims():
    newcomer = candidate(5)
    assert not newcomer.look(0.5 * LOOK_S)
    assert newcomer.look(LOOK_S)
    assert newcomer.standing is Standing.CLAIMS
    assert not newcomer.look(LOOK_S + SETTLE_S)
    assert newcomer.standing is Standing.IN_CHARGE
    assert newcomer.claim == Charge("word manager", 1, 5, "served")


def test_a_newcomer_looks_around_from_when_it_meets_anybody():
    newcomer = candidate(5)
    for wall in (0.5 * LOOK_S, 1.1 * LOOK_S, 2.0 * LOOK_S):
        assert not newcomer.look(wall, alone=True)
    assert not newcomer.look(2.9 * LOOK_S)
    assert newcomer.look(3.0 * LOOK_S)


def test_who_meets_nobody_claims_after_a_while():
    newcomer = candidate(5)
    assert not newcomer.look(0.9 * ALONE_S, alone=True)
    assert not newcomer.look(ALONE_S, alone=True)
    assert newcomer.look(ALONE_S + LOOK_S, alone=True)


def test_a_second_one_stands_by_until_the_first_is_gone(first: Election):
    second = candidate(9)
    second.alive(1)
    second.heard(first.claim)
    for wall in (LOOK_S, 100.0):
        assert not second.look(wall)
        assert second.standing is Standing.STANDS_BY
    second.alive(0)
    assert second.look(101.0)
    assert second.claim.term == first.claim.term + 1


@pytest.mark.parametrize(("own", "other", "stays"), [(5, 9, True), (9, 5, False)])
def test_of_two_that_claim_at_once_one_stays(own: int, other: int, stays: bool):
    one = candidate(own)
    one.look(LOOK_S)
    one.heard(Charge("word manager", 1, other, "served"))
    assert one.standing is (Standing.CLAIMS if stays else Standing.STANDS_BY)
    one.alive(0 if stays else 1)
    one.look(LOOK_S + SETTLE_S)
    assert one.standing is (Standing.IN_CHARGE if stays else Standing.STANDS_BY)


def test_one_that_was_thought_gone_and_comes_back_is_replaced(first: Election):
    first.heard(Charge("word manager", 2, 9, "served"))
    assert first.standing is Standing.REPLACED


def test_its_own_claim_and_older_ones_do_not_disturb_who_is_in_charge(first: Election):
    first.heard(first.claim)
    first.heard(Charge("word manager", 1, 9, "served"))
    assert first.standing is Standing.IN_CHARGE
