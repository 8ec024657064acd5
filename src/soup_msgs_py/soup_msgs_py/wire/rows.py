"""The messages that go over the wire, one row each, and what the hints of their fields do not say."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

from soup_msgs import action, msg, srv

from soup_msgs_py import messages as m
from soup_msgs_py import topics
from soup_msgs_py.codes import BotState
from soup_msgs_py.mail import Counts
from soup_msgs_py.wire.basics import MalformedMessage, of_run
from soup_msgs_py.wire.codec import Way, codecs, row
from soup_msgs_py.wire.snapshot import CONTENTS, PATHS

MOST_ORDERS = 1 << 40  # numbers of orders are below this
_ANY_LOAD = -2  # an order to drive with whatever a bot carries
_PART = re.compile(r"(word|letter|fleet) manager|bots [0-9,-]+")
_CHANNEL = re.compile(r"bound|(goals|results) (deliver|store)|(orders|outcomes) bots [0-9,-]+|drives [0-9]+")


# ---- what makes no sense though each number does ----------------------------------------------------------------


def _alike(one: str, other: str) -> Callable[[Any], None]:
    """There is one of the `other` for each `one`, or none at all."""

    def check(value: Any) -> None:
        ones, others = len(getattr(value, one)), len(getattr(value, other))
        if others not in (0, ones):
            raise MalformedMessage(f"{ones} {one} and {others} {other}")

    return check


def _check_bots(bots: m.Bots) -> None:
    if len(bots.state) and bots.state.max() > max(BotState):
        raise MalformedMessage(f"{bots.state.max()} is no state of a bot")


def _check_snapshot(snapshot: m.Snapshot) -> None:
    if len(snapshot.contents) != len(snapshot.buckets.x):
        raise MalformedMessage("contents that do not fit the buckets")


def _check_status(status: m.BotStatus) -> None:
    points, stamps = status.points, status.stamps
    if len(stamps) != len(points) or any(after < before for before, after in pairwise(stamps)):
        raise MalformedMessage(f"{len(points)} points and {len(stamps)} stamps, or stamps that go back")


def _check_task(task: m.TaskState) -> None:
    if task.kind not in (m.DELIVER, m.STORE):
        raise MalformedMessage(f"{task.kind[:40]!r} is no kind of task")


def _check_bound(bound: m.Bound) -> None:
    if len(bound.buckets) != len(bound.stations):
        raise MalformedMessage(f"{len(bound.buckets)} buckets bound for {len(bound.stations)} stations")


def _check_heard(heard: m.Heard) -> None:
    if not _PART.fullmatch(heard.part):
        raise MalformedMessage(f"{heard.part[:40]!r} is no part that the world would wait for")


# ---- fields that travel in another shape --------------------------------------------------------------------------


def _to_moment(time: float) -> float:
    if math.isnan(time):
        raise MalformedMessage("a time that is no number")
    return time


def _from_counts(counts: Counts) -> tuple[list[str], list[int]]:
    return [name for name, _ in counts], [count for _, count in counts]


def _to_counts(names: Sequence[str], counts: Sequence[int]) -> Counts:
    if len(names) != len(counts):
        raise MalformedMessage(f"{len(counts)} counts for {len(names)} channels")
    if not all(_CHANNEL.fullmatch(name) for name in names):
        raise MalformedMessage("counts of a channel that there is not")
    return tuple(zip(names, map(int, counts), strict=True))


def _to_order_number(number: int) -> int:
    if not 0 <= number < MOST_ORDERS:
        raise MalformedMessage(f"order {number}")
    return number


def _to_numbered_trip(trip: msg.Trip, number: int) -> m.Trip:
    if trip.trip != _to_order_number(number):
        raise MalformedMessage(f"trip {trip.trip} with the number {number}")
    return _TRIP.from_ros(trip)


# ---- what bots and managers ask of the world, and how it is answered ----------------------------------------------

row(m.TileMove, msg.TileMove, ways={"tile": Way(out=int), "job": Way(out=int)})
row(m.Grab, msg.BotRequest, verb=topics.GRAB, station=-1)
row(m.Release, msg.BotRequest, verb=topics.RELEASE, bucket=-1, station=-1)
row(m.Transfer, msg.BotRequest, verb=topics.TRANSFER, bucket=-1)
row(m.BotReply, msg.BotReply)
row(m.AssignWord, srv.AssignWord.Request)
row(m.AssignBundle, srv.AssignBundle.Request)
row(m.SetStorageSpot, srv.SetStorageSpot.Request)

# the world's answers to managers, and the calls of a bot's service by a person: (request, bot, number of the request)
assign_word_response = row(m.Reply, srv.AssignWord.Response, apart=("number",)).to_ros
assign_bundle_response = row(m.Reply, srv.AssignBundle.Response, ways={"number": Way("bundle")}).to_ros
storage_spot_response = row(m.Reply, srv.SetStorageSpot.Response, apart=("number",)).to_ros
grab_by_hand = row(m.Grab, srv.Grab.Request, apart=("bot", "request")).from_ros


# ---- what the world tells -----------------------------------------------------------------------------------------

row(m.Event, msg.Event)
row(m.Bots, msg.Bots, check=_check_bots)
row(m.Buckets, msg.Buckets)
row(m.Word, msg.Word, check=_alike("tiles", "filled"))
row(m.Bundle, msg.Bundle)
row(m.WordStationState, msg.WordStation)
row(m.LetterStationState, msg.LetterStation)
row(m.Stations, msg.Stations)
row(m.Snapshot, msg.Snapshot, ways={"contents": CONTENTS, "paths": PATHS}, check=_check_snapshot)
row(m.WorldState, msg.WorldState)


# ---- what the fleet asks of bots ----------------------------------------------------------------------------------

_TIMETABLE = _alike("points", "stamps")
row(m.Visit, msg.Visit)
_TRIP = row(m.Trip, msg.Trip)
trip_goal = row(m.TripGoal, action.CarryTrip.Goal, apart=("bot",)).from_ros  # (goal, bot)
drive_goal = row(  # (goal, bot, number of the drive)
    m.DriveGoal, action.Drive.Goal, apart=("bot", "drive", "bucket"), check=_TIMETABLE
).from_ros
row(m.TripFeedback, action.CarryTrip.Feedback, apart=("bot", "trip"))
row(m.DriveFeedback, action.Drive.Feedback, apart=("bot", "drive"))
_NO_TRIP = msg.Trip()
_MAYBE_A_TRIP = Way(
    "on_trip",
    "trip",
    out=lambda trip: (False, _NO_TRIP) if trip is None else (True, _TRIP.to_ros(trip)),
    back=lambda is_on, trip: _TRIP.from_ros(trip) if is_on else None,
)
row(m.BotStatus, msg.BotStatus, ways={"trip": _MAYBE_A_TRIP}, apart=("part", "number"), check=_check_status)
_NUMBER = Way("number", back=_to_order_number)
_LOAD = Way(
    out=lambda bucket: _ANY_LOAD if bucket is None else bucket,
    back=lambda bucket: None if bucket == _ANY_LOAD else bucket,
)
_NUMBERED_TRIP = Way("trip", "number", out=lambda trip: (_TRIP.to_ros(trip), trip.trip), back=_to_numbered_trip)
_ORDERS = {
    m.DriveGoal: row(m.DriveGoal, msg.Order, verb="drive", ways={"drive": _NUMBER, "bucket": _LOAD}, check=_TIMETABLE),
    m.CancelDrive: row(m.CancelDrive, msg.Order, verb="cancel_drive", ways={"drive": _NUMBER}),
    m.TripGoal: row(m.TripGoal, msg.Order, verb="trip", ways={"trip": _NUMBERED_TRIP}),
    m.CancelTrip: row(m.CancelTrip, msg.Order, verb="cancel_trip", ways={"trip": _NUMBER}),
}
_OUTCOMES = {
    m.DriveResult: row(m.DriveResult, msg.Outcome, verb="drive", ways={"drive": Way("number")}),
    m.TripResult: row(m.TripResult, msg.Outcome, verb="trip", ways={"trip": Way("number")}),
}


def to_order(asked: m.DriveGoal | m.CancelDrive | m.TripGoal | m.CancelTrip, run: int, part: str = "") -> msg.Order:
    """What the fleet asks of a bot, in a run of the world; `part` is the process that has its mind."""
    return of_run(run, _ORDERS[type(asked)].to_ros(asked), part)


def to_outcome(result: m.DriveResult | m.TripResult, run: int, part: str = "") -> msg.Outcome:
    """How a bot's drive or trip ended, in a run of the world; `part` is the process that says so."""
    return of_run(run, _OUTCOMES[type(result)].to_ros(result), part)


# ---- tasks of the fleet -------------------------------------------------------------------------------------------

row(m.DeliverGoal, action.DeliverLetters.Goal)
row(m.StoreGoal, action.StoreBundle.Goal)
_FEEDBACKS = {
    m.DELIVER: row(m.TaskFeedback, action.DeliverLetters.Feedback, apart=("kind", "task")),
    m.STORE: row(m.TaskFeedback, action.StoreBundle.Feedback, apart=("kind", "task")),
}
row(m.TaskState, msg.Task, check=_check_task)
row(m.Tasks, msg.Tasks)
row(m.Bound, msg.Bound, apart=("number",), check=_check_bound)


def task_feedback(feedback: Any, kind: str, task: int) -> m.TaskFeedback:
    """How far a task of the fleet has come."""
    return _FEEDBACKS[kind].from_ros(feedback, kind, task)


codecs[m.TaskFeedback] = _FEEDBACKS[m.DELIVER]._replace(to_ros=lambda told: _FEEDBACKS[told.kind].to_ros(told))


# ---- pace, and who is in charge -----------------------------------------------------------------------------------

_COUNTS = {name: Way(f"{name}_on", name, out=_from_counts, back=_to_counts) for name in ("sent", "got")}
row(m.Beat, msg.Beat)
row(m.Heard, msg.Heard, ways={"next_time": Way(back=_to_moment), **_COUNTS}, check=_check_heard)
row(m.Charge, msg.Charge)
