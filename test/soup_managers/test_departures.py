"""The world waits for drives that are on their way to their bots, but for no bot for ever."""

from hypothesis import given
from hypothesis import strategies as st

from soup_managers.departures import PATIENCE_S, Departures
from soup_msgs_py.messages import DriveGoal
from soup_msgs_py.mind import NEVER

TIMES = st.floats(0.0, 1e5, allow_nan=False)


def alone(bot: int) -> tuple[int]:
    """Each bot has a process of its own."""
    return (bot,)


def _drive(bot: int, *stamps: float) -> DriveGoal:
    return DriveGoal(bot, 1, ((0.0, 0.0),) * max(len(stamps), 1), stamps)


@given(st.dictionaries(st.integers(0, 20), TIMES), st.sets(st.integers(0, 20)))
def test_time_stops_at_the_first_departure_that_nobody_has_confirmed(asked: dict[int, float], confirmed: set[int]):
    departures = Departures(alone)
    for bot, depart in asked.items():
        departures.ask(_drive(bot, depart, depart + 5.0), 0.0)
    for bot in confirmed:
        departures.confirm(bot)
    open_ = [depart for bot, depart in asked.items() if bot not in confirmed]
    assert departures.earliest(0.0, 0.0) == min(open_, default=NEVER)


def test_a_newer_drive_of_a_bot_takes_the_place_of_the_older_one():
    departures = Departures(alone)
    departures.ask(_drive(3, 10.0), 0.0)
    departures.ask(_drive(3, 12.0), 0.0)
    assert departures.earliest(0.0, 0.0) == 12.0
    departures.ask(_drive(3), 0.0)
    assert departures.earliest(0.0, 0.0) == NEVER


def test_a_silent_bot_is_waited_for_no_longer_than_patience_lasts():
    departures = Departures(alone)
    departures.ask(_drive(3, 10.0), 100.0)
    departures.ask(_drive(4, 11.0), 101.0)
    assert departures.earliest(100.0 + PATIENCE_S, 0.0) == 10.0
    assert departures.earliest(100.5 + PATIENCE_S, 0.0) == 11.0
    assert departures.earliest(101.5 + PATIENCE_S, 0.0) == NEVER


def test_what_has_been_overtaken_is_waited_for_no_more():
    departures = Departures(alone)
    departures.ask(_drive(3, 10.0), 0.0)
    departures.ask(_drive(4, 12.0), 0.0)
    assert departures.earliest(0.0, 10.0) == 10.0
    assert departures.earliest(0.0, 10.1) == 12.0
    assert departures.earliest(0.0, 15.0) == NEVER


def test_another_world_is_not_held_by_the_drives_of_the_last_one():
    departures = Departures(alone)
    departures.ask(_drive(3, 10.0), 0.0)
    departures.clear()
    assert departures.earliest(0.0, 0.0) == NEVER


def test_where_one_bot_does_not_answer_nobody_of_its_process_is_waited_for_until_one_does():
    departures = Departures(lambda bot: (3, 4) if bot in (3, 4) else (bot,))
    departures.ask(_drive(3, 10.0), 0.0)
    departures.ask(_drive(4, 11.0), PATIENCE_S)
    departures.ask(_drive(5, 12.0), PATIENCE_S)
    assert departures.earliest(PATIENCE_S + 0.5, 0.0) == 12.0
    departures.ask(_drive(4, 11.5), PATIENCE_S + 0.5)
    assert departures.earliest(PATIENCE_S + 0.5, 0.0) == 12.0
    departures.confirm(4)
    departures.ask(_drive(3, 11.0), PATIENCE_S + 1.0)
    assert departures.earliest(PATIENCE_S + 1.0, 0.0) == 11.0
