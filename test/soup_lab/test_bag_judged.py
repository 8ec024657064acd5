"""Whoever recorded a lawful run is not accused: wherever its bag ends, and whatever it lacks."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest
from rclpy.serialization import serialize_message
from recorded_run import BEGIN, SPEED, Said, recorded, write_bag

from soup_lab.bags import summary as bag_summary
from soup_lab.bags import summary_program as bag_summary_cli
from soup_lab.bags.course import Course, Sight, read_course
from soup_lab.bags.judge import Verdict, judge_course
from soup_lab.bags.reader import Bag, open_bag
from soup_lab.bags.what_if import beside, take_moment
from soup_msgs_py import topics
from soup_msgs_py.codes import EventType
from soup_msgs_py.messages import Event
from soup_msgs_py.wire import to_ros_of

END_S = 80.0


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The bag of a whole run."""
    found = tmp_path_factory.mktemp("run") / "bag"
    write_bag(found, recorded()).close()
    return found


def instants(bag: Bag) -> list[float]:
    """When something happened."""
    return sorted({event.time for event in read_course(bag).events.values()})


def judged(folder: Path, said: list[Said]) -> Verdict:
    write_bag(folder, said).close()
    with open_bag(folder) as bag:
        return judge_course(read_course(bag))


def test_a_whole_run_is_judged_to_its_end(folder: Path):
    with open_bag(folder) as bag:
        assert judge_course(read_course(bag)) == Verdict(0, END_S)


def test_a_course_that_is_cut_in_the_middle_of_an_instant_breaks_no_law(folder: Path):
    with open_bag(folder) as bag:
        middle = instants(bag)[5::80]
        for stop in [*middle, *(time - 1e-9 for time in middle), 41.3, 62.5]:
            verdict = judge_course(read_course(bag, stop))
            assert verdict.violations == 0, stop
            assert stop - 5.0 <= verdict.until <= stop


def test_what_if_does_not_accuse_the_recorded_run_whatever_the_duration(folder: Path):
    with open_bag(folder) as bag:
        for until in (None, 51.25, 63.7, 77.3):
            original = take_moment(bag, 50.0, until).original()
            assert original["violations"] == 0, until


def test_what_if_shows_what_was_not_judged(folder: Path):
    with open_bag(folder) as bag:
        original = take_moment(bag, 50.0, None).original()
    shown = beside(original | {"violations": None}, original, 50.0)
    assert list(shown.columns[1].cells)[-1] == "not judged"


@pytest.mark.parametrize("name", [topics.EVENTS, topics.SNAPSHOT, topics.BOTS, topics.BUCKETS])
@pytest.mark.parametrize("lag", [1, 7, 40])
def test_a_bag_some_of_whose_topics_end_before_others_is_judged_up_to_a_common_instant(
    tmp_path: Path, name: str, lag: int
):
    said = list(recorded())
    mine = [k for k, message in enumerate(said) if message[0] == name]
    gone = set(mine[-lag:] if name != topics.SNAPSHOT else mine[-lag // 7 :])
    verdict = judged(tmp_path / "bag", [message for k, message in enumerate(said) if k not in gone])
    assert verdict.violations == 0
    assert 0.0 < verdict.until <= END_S


@pytest.mark.parametrize("share", [0.21, 0.43, 0.66, 0.87])
def test_a_bag_whose_recorder_was_killed_is_judged_up_to_its_last_whole_instant(tmp_path: Path, share: float):
    said = recorded()
    until = said[int(share * len(said))][1]
    verdict = judged(tmp_path / "bag", list(said[: int(share * len(said))]))
    assert verdict.violations == 0
    assert verdict.until == pytest.approx((until - BEGIN) * 1e-9 * SPEED, abs=5.0)
    assert verdict.why == "" or verdict.why.startswith("judged up to ")


def test_where_events_are_missing_a_bag_is_not_judged_and_no_number_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    low, high = (BEGIN + round(at * 1e9 / SPEED) for at in (40.0, 45.0))
    write_bag(tmp_path / "bag", [message for message in recorded() if not low < message[1] <= high]).close()
    summary = tmp_path / "summary.json"
    assert bag_summary_cli.main([str(tmp_path / "bag"), "--summary", str(summary)]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert json.loads(summary.read_text())["violations"] is None
    assert "events are missing" in out
    assert "not judged: events before 45." in out


def test_what_a_world_did_at_the_instant_it_was_restored_from_is_told_by_its_next_snapshot(folder: Path):
    with open_bag(folder) as bag:
        course = read_course(bag)
    at = next(b.time for a, b in pairwise(course.events.values()) if a.time == b.time)
    same = [number for number, event in course.events.items() if event.time == at]
    again = Course(course.announcement, events=dict(course.events), sights=[Sight(same[-1], at, 1)])
    again.goes_on_from(replace(course.announcement, time=at))
    assert max(again.events) == same[-1]
    again.take_sight(Sight(same[0], at, 2))
    assert max(again.events) == same[0]
    assert again.sights == [Sight(same[0], at, 2)]


def test_what_another_world_said_meanwhile_is_left_out_of_the_course(tmp_path: Path):
    foreign = serialize_message(to_ros_of(8, Event(time=41.0, sequence=5000, type=EventType.GRABBED, bot=1, bucket=1)))
    said = list(recorded())
    said.insert(len(said) // 2, (topics.EVENTS, said[len(said) // 2][1], foreign))
    write_bag(tmp_path / "bag", said).close()
    with open_bag(tmp_path / "bag") as bag:
        course = read_course(bag)
    assert judge_course(course) == Verdict(0, END_S)
    assert course.senseless == {topics.EVENTS: 1}


def test_a_bag_tells_how_long_words_took_only_if_it_tells_when_they_were_ordered(folder: Path):
    with open_bag(folder) as bag:
        course = read_course(bag)
    whole = bag_summary.summarize(course)
    opened = {event.job for event in course.events.values() if event.type is EventType.WORD_ASSIGNED}
    waits = sum(word.word not in opened for word in course.start.waiting_words) if course.start is not None else 0
    assert waits and whole["oldest_waiting_word_s"] == pytest.approx(course.last)
    assert 0.0 < whole["word_time_mean_s"] <= whole["word_time_p95_s"] <= course.last
    first = min(course.events)
    later = bag_summary.summarize(replace(course, events={k: v for k, v in course.events.items() if k > first}))
    assert [later[key] for key in bag_summary.WORD_TIMES] == [None, None, None]
