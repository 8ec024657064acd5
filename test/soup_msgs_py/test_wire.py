"""What is said in dataclasses arrives unchanged over the wire, and what makes no sense does not arrive."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import replace
from enum import Enum
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped, Twist
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from nav_msgs.msg import Path
from rclpy.serialization import deserialize_message, serialize_message
from soup_msgs import action, msg, srv
from std_msgs.msg import Header

import _environment
from soup_msgs_py import messages as m
from soup_msgs_py import wire
from soup_msgs_py.codes import BotState, Code, EventType, Phase
from soup_msgs_py.scenario import load_scenario
from soup_msgs_py.warehouse.layout import Layout
from soup_msgs_py.wire import basics

DEMO = load_scenario(_environment.ROOT / "config" / "scenarios" / "demo.yaml")

int32 = st.integers(-(2**31), 2**31 - 1)
int64 = st.integers(-(2**63), 2**63 - 1)
place = st.floats(-1e4, 1e4)
time = st.floats(0, 1e6)
text = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=30)
points = st.lists(st.tuples(place, place), max_size=5).map(tuple)
some_ints = st.lists(int32, max_size=6).map(tuple)
moves = st.lists(st.builds(m.TileMove, int32, int32), max_size=4).map(tuple)
bundles = st.lists(st.builds(m.Bundle, int32, int32, int32), max_size=3).map(tuple)


@st.composite
def words(draw: st.DrawFn) -> m.Word:
    tiles = draw(some_ints)
    filled = draw(st.sampled_from([0, len(tiles)]).flatmap(lambda n: st.lists(st.booleans(), min_size=n, max_size=n)))
    return m.Word(draw(int32), draw(text), tiles, tuple(filled))


some_words = st.lists(words(), max_size=3).map(tuple)
word_stations = st.lists(st.builds(m.WordStationState, int32, place, place, int32, some_words), max_size=3).map(tuple)
replies = st.builds(m.BotReply, int32, int64, st.sampled_from(Code), text, time, place, place)
counts = st.lists(
    st.tuples(
        st.sampled_from(("bound", "goals deliver", "results store", "orders bots 0-3", "drives 7")),
        st.integers(0, 2**63),
    ),
    max_size=3,
).map(tuple)
letter_stations = st.lists(st.builds(m.LetterStationState, int32, place, place, int32, bundles), max_size=3).map(tuple)


@st.composite
def bots(draw: st.DrawFn, size: int | None = None) -> m.Bots:
    n = draw(st.integers(0, 5)) if size is None else size
    x, y, heading, vx, vy = (draw(arrays.arrays(np.float64, n, elements=place)) for _ in range(5))
    bucket = draw(arrays.arrays(np.int32, n))
    state = draw(arrays.arrays(np.uint8, n, elements=st.integers(0, max(BotState))))
    return m.Bots(draw(time), x, y, heading, vx, vy, bucket, state)


@st.composite
def buckets(draw: st.DrawFn, size: int | None = None) -> m.Buckets:
    n = draw(st.integers(0, 5)) if size is None else size
    x, y = (draw(arrays.arrays(np.float64, n, elements=place)) for _ in range(2))
    return m.Buckets(draw(time), x, y, draw(arrays.arrays(np.int32, n)), draw(arrays.arrays(np.uint16, n)))


timed_paths = st.builds(
    lambda bot, request, drive: m.FollowPath(
        bot, request, tuple((x, y) for x, y, _ in drive), tuple(sorted(stamp for *_, stamp in drive))
    ),
    int32, int64, st.lists(st.tuples(place, place, time), min_size=1, max_size=4),
)  # fmt: skip


@st.composite
def snapshots(draw: st.DrawFn) -> m.Snapshot:
    content = st.dictionaries(int32, st.integers(0, 2**16 - 1), max_size=4)
    contents = tuple(draw(st.lists(content, max_size=4)))
    return m.Snapshot(
        draw(time), draw(int64), draw(bots()), draw(buckets(len(contents))), contents, draw(word_stations),
        draw(letter_stations), draw(some_words), draw(bundles), draw(int32), draw(some_ints), draw(int64),
        draw(st.lists(timed_paths, max_size=3).map(tuple)),
    )  # fmt: skip


@st.composite
def layouts(draw: st.DrawFn) -> Layout:
    n, e = draw(st.integers(1, 6)), draw(st.integers(0, 6))
    waypoint = st.integers(0, n - 1)
    some = st.integers(0, 3).flatmap(lambda k: arrays.arrays(np.int32, k, elements=waypoint))
    return Layout(
        draw(place), draw(place), draw(arrays.arrays(np.float64, (n, 2), elements=place)),
        draw(arrays.arrays(np.int32, (e, 2), elements=waypoint)),
        draw(arrays.arrays(np.float64, e, elements=st.floats(0, 10))), draw(some), draw(some), draw(some),
    )  # fmt: skip


events = st.builds(
    m.Event, time, int64, st.sampled_from(EventType), int32, int32, int32, int32, int32, int32, place, place,
    some_ints, some_ints, some_ints, text, int32,
)  # fmt: skip
visits = st.lists(st.builds(m.Visit, int32, moves, points), max_size=3).map(tuple)
trips = st.builds(m.Trip, int64, int32, points, visits, points)
drives = st.lists(st.tuples(place, place, time), max_size=4).map(
    lambda drive: (tuple((x, y) for x, y, _ in drive), tuple(sorted(stamp for *_, stamp in drive)))
)
states = st.builds(m.TaskState, int64, st.sampled_from([m.DELIVER, m.STORE]), int32, int32, some_ints, some_ints, text)

ONE_TO_ONE = {
    "grab": st.builds(m.Grab, int32, int64, int32),
    "release": st.builds(m.Release, int32, int64),
    "transfer": st.builds(m.Transfer, int32, int64, int32, moves),
    "reply of a bot": replies,
    "word to open": st.builds(m.AssignWord, int32, int32),
    "bundle to stage": st.builds(m.AssignBundle, int32, int32, int32),
    "storage spot to make or remove": st.builds(m.SetStorageSpot, int32, st.booleans()),
    "event": events,
    "bots": bots(),
    "buckets": buckets(),
    "stations": st.builds(m.Stations, time, word_stations, letter_stations),
    "snapshot": snapshots(),
    "layout": layouts(),
    "trip": trips,
    "status of a bot": st.builds(
        m.BotStatus, time, int32, st.sampled_from(Phase), int32, st.none() | trips, int32, text
    ),
    "status of a bot that drives": drives.map(
        lambda drive: m.BotStatus(3.0, 4, Phase.DRIVING, -1, None, 0, "drives", *drive)
    ),
    "letters to deliver": st.builds(m.DeliverGoal, int64, int32, int32, some_ints),
    "bundle to store": st.builds(m.StoreGoal, int64, int32, int32, int32, int32),
    "tasks": st.builds(m.Tasks, time, st.lists(states, max_size=3).map(tuple)),
    "beat": st.builds(
        m.Beat,
        time,
        st.integers(0, 2**64 - 1),
        st.lists(text, max_size=3).map(tuple),
        int64,
        st.lists(replies, max_size=3).map(tuple),
    ),
    "what a part has heard": st.builds(
        m.Heard,
        st.sampled_from(("word manager", "letter manager", "fleet manager", "bots 0-3,5")),
        st.integers(0, 2**64 - 1),
        time | st.just(math.inf),
        st.frozensets(st.sampled_from(EventType)),
        st.frozensets(st.integers(0, 2**31 - 1), max_size=3),
        st.booleans(),
        counts,
        counts,
    ),
}


def over_the_wire(message: Any) -> Any:
    """What the other side of a topic gets."""
    return deserialize_message(serialize_message(message), type(message))


def assert_alike(one: Any, other: Any) -> None:
    """Equal, but for what a float32 (places of buckets, velocities) or a stamp cannot hold."""
    if isinstance(one, np.ndarray):
        assert one.shape == other.shape
        np.testing.assert_allclose(other, one, rtol=1e-6, atol=1e-6)
    elif dataclasses.is_dataclass(one):
        assert type(one) is type(other)
        for field in dataclasses.fields(one):
            assert_alike(getattr(one, field.name), getattr(other, field.name))
    elif isinstance(one, tuple):
        assert isinstance(other, tuple)
        assert len(one) == len(other)
        for a, b in zip(one, other, strict=True):
            assert_alike(a, b)
    elif isinstance(one, float):
        assert math.isclose(one, other, rel_tol=1e-9, abs_tol=2e-9)
    else:
        assert one == other
        assert isinstance(other, Enum) == isinstance(one, Enum)


@pytest.mark.parametrize("kind", ONE_TO_ONE)
@given(data=st.data())
def test_a_message_arrives_as_it_was_sent(kind: str, data: st.DataObject):
    message = data.draw(ONE_TO_ONE[kind])
    assert_alike(message, wire.from_ros(over_the_wire(wire.to_ros(message))))


@given(st.builds(m.SetVelocity, st.just(3), place, place, place))
def test_a_velocity_arrives_on_the_topic_of_its_bot(velocity: m.SetVelocity):
    assert wire.from_twist(over_the_wire(wire.to_twist(velocity)), 3) == velocity


@given(
    st.integers(0, (2**31 - 1) * 10**9), st.lists(st.tuples(place, place, st.floats(1, 1e6)), min_size=1, max_size=5)
)
def test_a_path_keeps_its_number_and_its_times(number: int, corners: list[tuple[float, float, float]]):
    path = m.FollowPath(5, number, tuple((x, y) for x, y, _ in corners), tuple(t for _, _, t in corners))
    assert_alike(path, wire.from_path(over_the_wire(wire.to_path(path)), 5))
    hurried = dataclasses.replace(path, stamps=())
    assert_alike(hurried, wire.from_path(over_the_wire(wire.to_path(hurried)), 5))


@given(st.sampled_from(Code), text, int32)
def test_a_reply_to_a_manager_arrives(code: Code, message: str, number: int):
    reply = m.Reply(code, message, number)
    assert wire.from_ros(over_the_wire(wire.assign_bundle_response(reply))) == reply
    unnumbered = dataclasses.replace(reply, number=-1)
    assert wire.from_ros(over_the_wire(wire.assign_word_response(reply))) == unnumbered
    assert wire.from_ros(over_the_wire(wire.storage_spot_response(reply))) == unnumbered


@given(st.sampled_from([m.DELIVER, m.STORE]), int64, some_ints, text)
def test_the_progress_of_a_task_arrives(kind: str, task: int, missing: tuple[int, ...], message: str):
    feedback = m.TaskFeedback(kind, task, missing, message)
    assert wire.task_feedback(over_the_wire(wire.to_ros(feedback)), kind, task) == feedback


@given(trips, points, st.sampled_from(Phase), int32, text)
def test_what_the_fleet_and_a_bot_say_to_each_other_arrives(
    trip: m.Trip, corners: tuple[m.Point, ...], phase: Phase, done: int, message: str
):
    assert wire.trip_goal(over_the_wire(wire.to_ros(m.TripGoal(7, trip))), 7) == m.TripGoal(7, trip)
    drive = m.DriveGoal(7, 12, corners)
    assert wire.drive_goal(over_the_wire(wire.to_ros(drive)), 7, 12) == drive
    feedback = over_the_wire(wire.to_ros(m.TripFeedback(7, trip.trip, phase, done, message)))
    assert (feedback.phase, feedback.visits_done, feedback.message) == (phase.value, done, message)


orders = st.integers(0, wire.MOST_ORDERS - 1)


@given(
    st.builds(m.CancelDrive, int32, orders)
    | st.builds(m.CancelTrip, int32, orders)
    | st.builds(
        lambda bot, number, drive, load: replace(m.DriveGoal(bot, number, *drive), bucket=load),
        int32,
        orders,
        drives,
        st.none() | st.integers(-1, 2**31 - 1),
    )
    | st.builds(lambda bot, number, trip: m.TripGoal(bot, replace(trip, trip=number)), int32, orders, trips),
    int64,
)
def test_an_order_of_the_fleet_arrives(asked: m.DriveGoal | m.CancelDrive | m.TripGoal | m.CancelTrip, run: int):
    order = over_the_wire(wire.to_order(asked, run, "bots 0-3"))
    assert (wire.from_ros(order), order.run, order.part) == (asked, run, "bots 0-3")


@given(st.builds(m.DriveResult, int32, orders, st.sampled_from(Code), text)
       | st.builds(m.TripResult, int32, orders, st.sampled_from(Code), text), int64)  # fmt: skip
def test_the_outcome_of_an_order_arrives(result: m.DriveResult | m.TripResult, run: int):
    outcome = over_the_wire(wire.to_outcome(result, run, "bots 0-3"))
    assert (wire.from_ros(outcome), outcome.run, outcome.part) == (result, run, "bots 0-3")


@given(st.binary(max_size=300), int64, st.integers(0, 2**63))
def test_a_checkpoint_arrives_whole(checkpoint: bytes, run: int, sequence: int):
    state = m.WorldState(1.5, run, sequence, checkpoint)
    assert wire.from_ros(over_the_wire(wire.to_ros(state))) == state


@given(layouts(), st.lists(st.floats(0, 1), max_size=5).map(tuple), int64, st.integers(0, 2**63), st.floats(0, 1e6))
def test_the_scenario_arrives_whole(layout: Layout, profile: tuple[float, ...], run: int, seed: int, warmup_s: float):
    announcement = wire.Announcement(1.5, DEMO, layout, profile, run, seed, warmup_s)
    assert_alike(announcement, wire.from_ros(over_the_wire(wire.to_ros(announcement))))


def test_figures_arrive_under_their_names():
    figures = {"words_completed": 3, "words_per_second": 0.25, "violations": 0, "no such figure": 1}
    arrived = wire.from_statistics(over_the_wire(wire.to_statistics(12.0, figures)))
    assert arrived["words_completed"] == 3
    assert arrived["words_per_second"] == 0.25
    assert "no such figure" not in arrived


# ---- hostile input --------------------------------------------------------------------------------------------


def twist(**linear: float) -> Twist:
    message = Twist()
    for name, value in linear.items():
        setattr(message.linear, name, value)
    return message


def path_of(count: int, x: float = 0.0) -> Path:
    pose = PoseStamped()
    pose.pose.position.x = x
    return Path(poses=[pose] * count)


def snapshot_with_path(times: list[float], *places: float) -> msg.Snapshot:
    """With a path of one bot, whose points have these times and places."""
    return msg.Snapshot(
        content_start=[0], path_bot=[0], path_request=[1], path_start=[0, len(times)],
        path_x=list(places), path_y=list(places), path_time=times,
    )  # fmt: skip


def bots_message(**changes: Any) -> msg.Bots:
    three = {"x": [0.0] * 3, "y": [0.0] * 3, "heading": [0.0] * 3, "vx": [0.0] * 3, "vy": [0.0] * 3}
    return msg.Bots(**{**three, "bucket": [-1] * 3, "state": [0] * 3, **changes})


NONSENSE = {
    "a velocity that is no number": lambda: wire.from_twist(twist(x=math.nan), 0),
    "an infinite velocity": lambda: wire.from_twist(twist(y=-math.inf), 0),
    "a path without a point": lambda: wire.from_path(path_of(0), 0),
    "a path to nowhere": lambda: wire.from_path(path_of(2, math.inf), 0),
    "a path in a frame that is not the floor's": lambda: wire.from_path(Path(header=Header(frame_id="odom"), poses=[
        PoseStamped()]), 0),
    "a place in a frame that is not the floor's": lambda: wire.from_path(Path(poses=[
        PoseStamped(header=Header(frame_id="base_link"))]), 0),
    "a path of a million points": lambda: wire.from_path(path_of(1_000_000), 0),
    "a verb that nobody knows": lambda: wire.from_ros(msg.BotRequest(verb="explode")),
    "a bot that does not exist": lambda: wire.from_bot_request(msg.BotRequest(bot=12, verb="grab"), 12),
    "a bot of negative number": lambda: wire.from_bot_request(msg.BotRequest(bot=-1, verb="grab"), 12),
    "a million tiles to move": lambda: wire.from_ros(
        msg.BotRequest(verb="transfer", moves=[msg.TileMove()] * 1_000_000)
    ),
    "an event that nobody knows": lambda: wire.from_ros(msg.Event(type="earthquake")),
    "an event at no place": lambda: wire.from_ros(msg.Event(type="grabbed", x=math.nan)),
    "a code that nobody knows": lambda: wire.from_ros(msg.BotReply(code="maybe")),
    "a phase that nobody knows": lambda: wire.from_ros(msg.BotStatus(phase="dreaming")),
    "an order that nobody knows": lambda: wire.from_ros(msg.Order(verb="dance")),
    "an order of an absurd number": lambda: wire.from_ros(msg.Order(verb="drive", number=-1)),
    "an order to drive nowhere": lambda: wire.from_ros(
        msg.Order(verb="drive", points=[path_of(1, math.nan).poses[0].pose.position])
    ),
    "an order to drive beyond all floors": lambda: wire.from_ros(
        msg.Order(verb="drive", points=[path_of(1, 1e300).poses[0].pose.position])
    ),
    "an order to be there at the end of time": lambda: wire.from_ros(
        msg.Order(verb="drive", points=[path_of(1).poses[0].pose.position], stamps=[1e308])
    ),
    "a beat at the end of time": lambda: wire.from_ros(msg.Beat(time=1e308)),
    "a drive to the end of time": lambda: wire.from_ros(
        msg.BotStatus(phase="driving", points=[path_of(1).poses[0].pose.position], stamps=[1e308])
    ),
    "a path under way to the end of time": lambda: wire.from_ros(snapshot_with_path([1e308], 0.0)),
    "an order with another trip": lambda: wire.from_ros(msg.Order(verb="trip", number=3, trip=msg.Trip(trip=4))),
    "an outcome of nothing": lambda: wire.from_ros(msg.Outcome(verb="dance", code="done")),
    "an outcome that nobody knows": lambda: wire.from_ros(msg.Outcome(verb="drive", code="maybe")),
    "a drive with a time too many": lambda: wire.from_ros(msg.BotStatus(phase="driving", stamps=[1.0])),
    "a drive back in time": lambda: wire.from_ros(
        msg.BotStatus(phase="driving", points=[pose.pose.position for pose in path_of(2).poses], stamps=[2.0, 1.0])
    ),
    "poses of unequal length": lambda: wire.from_ros(bots_message(y=[0.0])),
    "poses at no place": lambda: wire.from_ros(bots_message(x=[math.nan] * 3)),
    "a state that nobody knows": lambda: wire.from_ros(bots_message(state=[9, 0, 0])),
    "buckets of unequal length": lambda: wire.from_ros(msg.Buckets(x=[0.0], y=[0.0], bot=[-1])),
    "a word with too many marks": lambda: wire.from_ros(msg.Word(tiles=[1], filled=[True, False])),
    "contents of no bucket": lambda: wire.from_ros(msg.Snapshot(content_start=[0, 1], content_tile=[1])),
    "contents that run backwards": lambda: wire.from_ros(
        msg.Snapshot(content_start=[0, 2, 1], buckets=msg.Buckets(x=[0.0] * 2, y=[0.0] * 2, bot=[0, 0], tiles=[0, 0]))
    ),
    "paths of no bot": lambda: wire.from_ros(msg.Snapshot(content_start=[0], path_start=[0, 1], path_x=[1.0])),
    "a path under way to nowhere": lambda: wire.from_ros(snapshot_with_path([1.0], math.nan)),
    "a path of too few places": lambda: wire.from_ros(snapshot_with_path([1.0, 2.0])),
    "a path back in time": lambda: wire.from_ros(snapshot_with_path([2.0, 1.0], 0.0, 0.0)),
    "a storage spot off the floor": lambda: wire.from_ros(msg.Layout(storage_spots=[4])),
    "a scenario of another version": lambda: wire.from_ros(msg.Scenario(json='{"name": 3}')),
    "a count without a channel": lambda: wire.from_ros(msg.Heard(part="fleet manager", sent=[1])),
    "a channel that there is not": lambda: wire.from_ros(msg.Heard(part="fleet manager", got_on=["x"], got=[1])),
    "a beat wanted at no time": lambda: wire.from_ros(msg.Heard(next_time=math.nan)),
    "a task of no kind": lambda: wire.from_ros(msg.Tasks(tasks=[msg.Task(kind="dance")])),
    "a trip over nowhere": lambda: wire.trip_goal(
        action.CarryTrip.Goal(trip=msg.Trip(fetch_route=[path_of(1, math.nan).poses[0].pose.position])), 0
    ),
    "a tile that is no letter": lambda: wire.transfer_by_hand(srv.Transfer.Request(tile="42"), 0, 0),
    "a colour beyond counting": lambda: wire.transfer_by_hand(srv.Transfer.Request(tile="E999999999"), 0, 0),
}  # fmt: skip


@pytest.mark.parametrize("nonsense", NONSENSE)
def test_what_makes_no_sense_is_refused(nonsense: str):
    with pytest.raises(wire.MalformedMessage):
        NONSENSE[nonsense]()


def test_a_path_of_a_hundred_thousand_poses_is_refused_before_it_is_unpacked(monkeypatch: pytest.MonkeyPatch):
    cdr = serialize_message(path_of(100_000))

    def unpack(_cdr: bytes, _kind: type) -> Any:
        raise AssertionError("it was unpacked")

    monkeypatch.setattr(basics, "deserialize_message", unpack)
    with pytest.raises(wire.MalformedMessage, match="bytes; allowed: at most 1048576"):
        wire.read_cdr(cdr, Path)


def test_a_path_that_names_the_frame_of_the_floor_or_none_is_taken():
    for frame in ("map", ""):
        path = path_of(1, 2.0)
        path.header.frame_id = path.poses[0].header.frame_id = frame
        assert wire.from_path(path, 3).points == ((2.0, 0.0),)


@pytest.mark.parametrize(
    ("message", "field"),
    [(Header(frame_id="mapXY"), "frame_id"), (msg.Order(verb="mapXY"), "verb"), (msg.BotRequest(verb="mapXY"), "verb")],
    ids=["frame of a path", "order to the fleet", "request to the world"],
)
def test_a_string_that_is_not_utf8_comes_out_as_another_string_and_ends_nobody(message: Any, field: str):
    bytes_ = serialize_message(message).replace(b"mapXY", b"m\xff\xfe\xc3(")
    assert getattr(deserialize_message(bytes_, type(message)), field) == "m\ufffd\ufffd\ufffd("
