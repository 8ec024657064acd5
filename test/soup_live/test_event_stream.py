"""A newcomer knows everything after its snapshot, and notices when it has missed something."""

from __future__ import annotations

from unittest.mock import create_autospec

from hypothesis import given
from hypothesis import strategies as st

from soup_live.event_stream import EventStream
from soup_msgs_py.codes import EventType
from soup_msgs_py.messages import Event, Snapshot


def event(sequence: int) -> Event:
    return Event(float(sequence), sequence, EventType.GRABBED)


def snapshot(sequence: int) -> Snapshot:
    made = create_autospec(Snapshot, instance=True)
    made.sequence = sequence
    return made


def test_events_before_the_first_snapshot_are_kept_and_told_after_it():
    stream = EventStream()
    assert [stream.take_event(event(n)) for n in (4, 5, 6)] == [[], [], []]
    start = snapshot(4)
    assert stream.take_snapshot(start) == [start, event(5), event(6)]
    assert stream.take_event(event(7)) == [event(7)]


def test_a_snapshot_that_the_events_do_not_continue_is_not_taken():
    stream = EventStream()
    stream.take_event(event(9))
    assert stream.take_snapshot(snapshot(4)) == []
    assert not stream.in_step
    later = snapshot(9)
    assert stream.take_snapshot(later) == [later]


def test_an_event_after_a_gap_is_told_and_then_nothing_until_a_snapshot_that_holds_it():
    stream = EventStream()
    stream.take_snapshot(snapshot(0))
    assert stream.take_event(event(3)) == [event(3)]
    assert (stream.gaps, stream.in_step) == (1, False)
    assert stream.take_event(event(4)) == []
    assert stream.take_snapshot(snapshot(2)) == []
    again = snapshot(3)
    assert stream.take_snapshot(again) == [again, event(4)]


def test_an_event_far_ahead_that_was_nobodys_does_not_keep_a_follower_out_for_ever():
    stream = EventStream()
    stream.take_snapshot(snapshot(0))
    stream.take_event(event(10**15))
    later = [snapshot(number) for number in (1, 2, 3)]
    assert [stream.take_snapshot(made) for made in later] == [[], [], [later[2]]]
    assert stream.take_event(event(4)) == [event(4)]


def test_in_step_a_snapshot_tells_nothing_new():
    stream = EventStream()
    stream.take_snapshot(snapshot(0))
    assert stream.take_snapshot(snapshot(5)) == []


def test_events_that_were_sent_before_anybody_listened_are_missed_though_nothing_happens_after_them():
    stream = EventStream()
    assert stream.take_snapshot(snapshot(4))
    assert not stream.lacks(6)  # they may be on their way
    assert stream.lacks(6)
    assert (stream.gaps, stream.in_step) == (1, False)
    assert stream.take_snapshot(snapshot(6))
    stream.take_event(event(7))
    assert not stream.lacks(7)
    assert not stream.lacks(9)
    stream.take_event(event(8))
    stream.take_event(event(9))
    assert not stream.lacks(9)
    assert stream.in_step


def test_with_another_world_everything_begins_anew():
    stream = EventStream()
    stream.take_snapshot(snapshot(50))
    stream.restart()
    first = snapshot(0)
    assert stream.take_snapshot(first) == [first]
    assert stream.take_event(event(1)) == [event(1)]


def test_the_last_events_of_an_old_world_do_not_keep_a_follower_from_joining_the_new_one():
    stream = EventStream()
    stream.take_snapshot(snapshot(50))
    stream.restart()
    stream.take_event(event(51))
    for number in (1, 2, 3):
        assert stream.take_event(event(number)) == []
    second = snapshot(2)
    assert stream.take_snapshot(second) == [second, event(3)]


@given(st.sets(st.integers(1, 40)), st.lists(st.integers(0, 40)))
def test_whatever_is_lost_the_follower_hears_no_event_twice_and_no_gap_in_step(lost: set[int], snapshots: list[int]):
    stream, known = EventStream(), -1
    for number in range(1, 41):
        for said in stream.take_snapshot(snapshot(number)) if number in snapshots else []:
            known = said.sequence if not isinstance(said, Event) else check(said, known)
        if number in lost:
            continue
        for said in stream.take_event(event(number)):
            known = number if not stream.in_step else check(said, known)


def check(said: Event, known: int) -> int:
    assert said.sequence == known + 1
    return said.sequence
