"""Whatever a mind or the world may say has a way to somebody."""

from __future__ import annotations

from dataclasses import is_dataclass

from soup_msgs_py import messages as m
from soup_msgs_py.routing import HEARERS, Hearer

# what nodes say to each other, or to people, without a mind in between
OF_SHELLS = {
    m.Beat, m.Heard, m.Charge, m.Tasks, m.Bots, m.Buckets, m.Stations, m.Reply, m.WorldState, m.BotGone,
    m.DriveFeedback,
}  # fmt: skip
PARTS = {
    m.TileMove, m.Visit, m.Trip, m.TaskState, m.Word, m.Bundle, m.WordStationState, m.LetterStationState,
}  # fmt: skip


def test_each_message_has_one_way_or_is_told_by_the_shells_or_is_part_of_another():
    kinds = {kind for kind in vars(m).values() if is_dataclass(kind)}
    assert kinds == HEARERS.keys() | OF_SHELLS | PARTS
    assert not HEARERS.keys() & OF_SHELLS
    assert set(HEARERS.values()) == set(Hearer)


def test_a_fleet_takes_what_is_said_to_it():
    to_fleet = {kind for kind, hearer in HEARERS.items() if hearer is Hearer.FLEET}
    assert {m.DeliverGoal, m.StoreGoal, m.CancelTask, m.BotStatus} < to_fleet
