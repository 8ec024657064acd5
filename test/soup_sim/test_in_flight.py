"""What is under way between parts is known from what both ends have counted, whatever the order of the news."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from soup_msgs_py.codes import Code
from soup_msgs_py.mail import Mail
from soup_msgs_py.messages import BotReply, Heard
from soup_sim.in_flight import InFlight
from soup_sim.lockstep import PATIENCE_S, Lockstep
from soup_sim.summary import lateness

FLEET, BOTS = "fleet manager", "bots 0-3"
ORDERS, OUTCOMES = "orders bots 0-3", "outcomes bots 0-3"


def heard(part: str, sent: dict[str, int] | None = None, got: dict[str, int] | None = None) -> Heard:
    """A part says what it has counted."""
    return Heard(part, 0, math.inf, sent=tuple((sent or {}).items()), got=tuple((got or {}).items()))


@pytest.fixture
def flight() -> InFlight:
    """The fleet has sent three orders, and all have been heard."""
    flight = InFlight()
    flight.hear(heard(FLEET, sent={ORDERS: 3}))
    flight.hear(heard(BOTS, got={ORDERS: 3}))
    return flight


def test_a_message_is_under_way_until_it_was_heard(flight: InFlight):
    assert not flight.any
    flight.hear(heard(FLEET, sent={ORDERS: 4}))
    assert flight.open == [ORDERS]
    flight.hear(heard(BOTS, got={ORDERS: 4}))
    assert not flight.any


def test_one_that_was_heard_before_its_sender_has_said_so_is_not_under_way(flight: InFlight):
    flight.hear(heard(BOTS, got={ORDERS: 4}))
    assert not flight.any
    flight.hear(heard(FLEET, sent={ORDERS: 4}))
    assert not flight.any


def test_nobody_waits_for_what_was_sent_to_somebody_who_is_gone(flight: InFlight):
    flight.hear(heard(FLEET, sent={ORDERS: 5}))
    flight.forget(BOTS)
    assert not flight.any
    flight.hear(heard(BOTS, got={ORDERS: 1}))  # another one, which has heard one of them
    assert not flight.any
    flight.hear(heard(FLEET, sent={ORDERS: 6}))
    assert flight.any


def test_one_that_begins_to_count_anew_is_another_one(flight: InFlight):
    flight.hear(heard(FLEET, sent={ORDERS: 1}))
    assert not flight.any
    flight.hear(heard(FLEET, sent={ORDERS: 2}))
    assert flight.any
    flight.hear(heard(BOTS, got={ORDERS: 4}))
    assert not flight.any


def test_what_was_forgiven_too_early_does_not_hide_what_comes_later(flight: InFlight):
    flight.forget(BOTS)
    flight.hear(heard(BOTS, got={ORDERS: 0}))
    flight.hear(heard(BOTS, got={ORDERS: 2}))  # two that were under way to it when it was heard first
    flight.settle()
    flight.hear(heard(FLEET, sent={ORDERS: 4}))
    assert flight.any


def test_who_gives_up_says_so_until_something_is_heard_there_again(flight: InFlight):
    flight.hear(heard(FLEET, sent={ORDERS: 4}))
    assert flight.give_up() == [ORDERS]
    assert not flight.any
    assert flight.given_up == {ORDERS}
    flight.hear(heard(BOTS, got={ORDERS: 4}))
    assert flight.given_up == set()


def test_the_world_waits_for_a_message_between_two_others_and_says_what_it_gave_up():
    listeners = Lockstep()
    listeners.hear(heard(FLEET, sent={ORDERS: 1}), 0.0)
    listeners.hear(heard(BOTS, got={ORDERS: 1}), 0.0)
    assert not listeners.wait(0.0)
    listeners.hear(heard(FLEET, sent={ORDERS: 2}), 1.0)
    assert listeners.wait(1.0)
    assert listeners.wait(1.0 + PATIENCE_S)
    assert not listeners.wait(1.1 + PATIENCE_S)
    assert listeners.missing == (ORDERS,)
    listeners.went_on(2.5)
    assert listeners.latency_s == 2.5
    listeners.hear(heard(BOTS, got={ORDERS: 2}), 9.0)
    listeners.went_on(4.0)
    assert listeners.latency_s == 2.5
    assert listeners.missing == ()


def test_who_needs_long_to_answer_gets_as_long_for_what_is_sent_to_it_then():
    listeners = Lockstep()
    listeners.hear(heard(FLEET, sent={ORDERS: 1}), 0.0)
    listeners.hear(heard(BOTS, got={ORDERS: 1}), 0.0)
    listeners.hear(heard(FLEET, sent={ORDERS: 2}), 1.0)
    listeners.hear(heard(FLEET, sent={ORDERS: 3}), PATIENCE_S)
    assert listeners.wait(PATIENCE_S + 2.0)


def test_what_somebody_says_before_it_was_asked_is_not_taken_for_what_was_forgiven():
    listeners = Lockstep()
    listeners.hear(heard(FLEET), 0.0)
    listeners.hear(replace(heard(BOTS, sent={OUTCOMES: 1}), bots=frozenset(range(4))), 0.0)
    listeners.hear(heard(FLEET, got={OUTCOMES: 1}), 0.0)
    listeners.tell(BotReply(3, 1, Code.DONE, "", 1.0, 0.0, 0.0))  # the bots say something upon it at once
    listeners.hear(heard(FLEET, got={OUTCOMES: 2}), 0.1)
    assert not listeners.wait(0.1)
    beat = listeners.beat(1.0, 0.1)
    assert [reply.bot for reply in beat.replies] == [3]
    listeners.hear(replace(heard(BOTS, sent={OUTCOMES: 2}), beat=beat.number, bots=frozenset(range(4))), 0.2)
    assert not listeners.wait(0.2)


@given(st.integers(0, 2**32), st.integers(2, 5))
def test_nothing_is_under_way_where_the_counts_say_so(seed: int, parts: int):
    """Parts that say random things to each other upon what they hear, over wires of random speed."""
    draw = random.Random(seed)
    mails = [Mail() for _ in range(parts)]
    wires: dict[tuple[int, int], int] = {}  # messages from one part to another
    news: list[list[Heard]] = [[] for _ in range(parts)]  # to the world, of each part in their order
    flight = InFlight()

    def act(part: int, most: int) -> None:
        for _ in range(draw.randint(0, most)):
            other = draw.randrange(parts)
            wires[part, other] = wires.get((part, other), 0) + 1
            mails[part].sent(f"{part} {other}")
        sent, got = mails[part].news()
        news[part].append(Heard(str(part), 0, math.inf, sent=sent, got=got))

    for sender in range(parts):
        for receiver in range(parts):
            flight.hear(heard(str(sender), sent={f"{sender} {receiver}": 0}))
            flight.hear(heard(str(receiver), got={f"{sender} {receiver}": 0}))
    for part in range(parts):
        act(part, 2)
        flight.hear(news[part].pop(0))  # the world has asked each, and waits for its answer
    for _ in range(200):
        moves = [
            *((False, wire) for wire, count in wires.items() if count),
            *((True, p) for p in range(parts) if news[p]),
        ]
        if not flight.any:
            assert not any(wires.values())
            break
        is_news, what = draw.choice(moves)
        if is_news:
            flight.hear(news[what].pop(0))
        else:
            sender, receiver = what
            wires[what] -= 1
            mails[receiver].got(f"{sender} {receiver}")
            act(receiver, 1)


@pytest.mark.parametrize(("latency_s", "warns"), [(0.0, False), (9.0, False), (11.0, True)])
def test_a_run_that_went_on_without_somebody_for_more_than_a_hundredth_of_it_is_told(latency_s: float, warns: bool):
    assert bool(lateness({"latency_s": latency_s, "sim_seconds": 900.0})) == warns
