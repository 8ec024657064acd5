"""What the fleet asks of bots, and what it is asked for: trips, drives, tasks."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

from soup_msgs import action, msg

from soup_msgs_py.codes import Code, Phase
from soup_msgs_py.messages import (
    DELIVER,
    STORE,
    BotStatus,
    Bound,
    CancelDrive,
    CancelTrip,
    DeliverGoal,
    DriveFeedback,
    DriveGoal,
    DriveResult,
    StoreGoal,
    TaskFeedback,
    Tasks,
    TaskState,
    Trip,
    TripFeedback,
    TripGoal,
    TripResult,
    Visit,
)
from soup_msgs_py.wire.basics import (
    MalformedMessage,
    check_times,
    from_moves,
    from_points,
    from_ros,
    from_stamp,
    header_at,
    member,
    not_absurd,
    to_ints,
    to_moves,
    to_points,
    to_ros,
)

DRIVE, CANCEL_DRIVE, TRIP, CANCEL_TRIP = "drive", "cancel_drive", "trip", "cancel_trip"  # verbs of orders
MOST_ORDERS = 1 << 40  # numbers of orders are below this
ANY_LOAD = -2  # an order to drive with whatever a bot carries


@to_ros.register
def _(trip: Trip) -> msg.Trip:
    visits = [
        msg.Visit(station=visit.station, moves=to_moves(visit.moves), route=to_points(visit.route))
        for visit in trip.visits
    ]
    return msg.Trip(
        trip=trip.trip,
        bucket=trip.bucket,
        fetch_route=to_points(trip.fetch_route),
        visits=visits,
        store_route=to_points(trip.store_route),
    )


@from_ros.register
def _(trip: msg.Trip) -> Trip:
    visits = tuple(
        Visit(visit.station, from_moves(visit.moves), from_points(visit.route)) for visit in not_absurd(trip.visits)
    )
    return Trip(trip.trip, trip.bucket, from_points(trip.fetch_route), visits, from_points(trip.store_route))


@to_ros.register
def _(goal: TripGoal) -> action.CarryTrip.Goal:
    return action.CarryTrip.Goal(trip=to_ros(goal.trip))


def trip_goal(goal: action.CarryTrip.Goal | msg.Order, bot: int) -> TripGoal:
    """A trip that was asked of a bot."""
    return TripGoal(bot, from_ros(goal.trip))


@to_ros.register
def _(goal: DriveGoal) -> action.Drive.Goal:
    return action.Drive.Goal(points=to_points(goal.points), stamps=list(goal.stamps))


def drive_goal(goal: action.Drive.Goal | msg.Order, bot: int, drive: int) -> DriveGoal:
    """A drive that was asked of a bot, under the number that its shell gives it."""
    points, stamps = from_points(goal.points), tuple(not_absurd(goal.stamps))
    check_times(*stamps)
    if len(stamps) not in (0, len(points)):
        raise MalformedMessage(f"{len(stamps)} stamps for {len(points)} points")
    return DriveGoal(bot, drive, points, stamps)


def to_order(asked: DriveGoal | CancelDrive | TripGoal | CancelTrip, run: int, part: str = "") -> msg.Order:
    """What the fleet asks of a bot, in a run of the world; `part` is the process that has its mind."""
    match asked:
        case DriveGoal():
            return msg.Order(
                bot=asked.bot,
                run=run,
                part=part,
                verb=DRIVE,
                number=asked.drive,
                points=to_points(asked.points),
                stamps=list(asked.stamps),
                bucket=ANY_LOAD if asked.bucket is None else asked.bucket,
            )
        case CancelDrive():
            return msg.Order(bot=asked.bot, run=run, part=part, verb=CANCEL_DRIVE, number=asked.drive)
        case TripGoal():
            trip = to_ros(asked.trip)
            return msg.Order(bot=asked.bot, run=run, part=part, verb=TRIP, number=asked.trip.trip, trip=trip)
        case CancelTrip():
            return msg.Order(bot=asked.bot, run=run, part=part, verb=CANCEL_TRIP, number=asked.trip)


@from_ros.register
def _(order: msg.Order) -> DriveGoal | CancelDrive | TripGoal | CancelTrip:
    bot, number = order.bot, order.number
    if not 0 <= number < MOST_ORDERS:
        raise MalformedMessage(f"order {number}")
    match order.verb:
        case verb if verb == DRIVE:
            goal = drive_goal(order, bot, number)
            return goal if order.bucket == ANY_LOAD else replace(goal, bucket=order.bucket)
        case verb if verb == CANCEL_DRIVE:
            return CancelDrive(bot, number)
        case verb if verb == TRIP:
            if order.trip.trip != number:
                raise MalformedMessage(f"trip {order.trip.trip} with the number {number}")
            return trip_goal(order, bot)
        case verb if verb == CANCEL_TRIP:
            return CancelTrip(bot, number)
    raise MalformedMessage(f"no order: {order.verb!r}")


def to_outcome(result: DriveResult | TripResult, run: int, part: str = "") -> msg.Outcome:
    """How a bot's drive or trip ended, in a run of the world; `part` is the process that says so."""
    verb, number = (DRIVE, result.drive) if isinstance(result, DriveResult) else (TRIP, result.trip)
    return msg.Outcome(
        bot=result.bot,
        run=run,
        verb=verb,
        number=number,
        code=result.code.value,
        message=result.message,
        part=part,
    )


@from_ros.register
def _(outcome: msg.Outcome) -> DriveResult | TripResult:
    code = member(Code, outcome.code)
    if outcome.verb == DRIVE:
        return DriveResult(outcome.bot, outcome.number, code, outcome.message)
    if outcome.verb == TRIP:
        return TripResult(outcome.bot, outcome.number, code, outcome.message)
    raise MalformedMessage(f"the outcome of {outcome.verb!r}")


@to_ros.register
def _(feedback: TripFeedback) -> action.CarryTrip.Feedback:
    return action.CarryTrip.Feedback(
        phase=feedback.phase.value, message=feedback.message, visits_done=feedback.visits_done
    )


@to_ros.register
def _(feedback: DriveFeedback) -> action.Drive.Feedback:
    return action.Drive.Feedback(
        phase=feedback.phase.value, message=feedback.message, distance=float(feedback.distance_m)
    )


@to_ros.register
def _(status: BotStatus) -> msg.BotStatus:
    message = msg.BotStatus(
        header=header_at(status.time),
        bot=status.bot,
        phase=status.phase.value,
        bucket=status.bucket,
        on_trip=status.trip is not None,
        visits_done=status.visits_done,
        message=status.message,
        points=to_points(status.points),
        stamps=status.stamps,
    )
    if status.trip is not None:
        message.trip = to_ros(status.trip)
    return message


@from_ros.register
def _(status: msg.BotStatus) -> BotStatus:
    trip = from_ros(status.trip) if status.on_trip else None
    phase = member(Phase, status.phase)
    time = from_stamp(status.header.stamp)
    points, stamps = from_points(status.points), tuple(not_absurd(status.stamps))
    check_times(*stamps)
    if len(stamps) != len(points) or any(after < before for before, after in pairwise(stamps)):
        raise MalformedMessage(f"{len(points)} points and {len(stamps)} stamps, or stamps that go back")
    return BotStatus(time, status.bot, phase, status.bucket, trip, status.visits_done, status.message, points, stamps)


@to_ros.register
def _(goal: DeliverGoal) -> action.DeliverLetters.Goal:
    return action.DeliverLetters.Goal(task=goal.task, station=goal.station, word=goal.word, tiles=goal.tiles)


@from_ros.register
def _(goal: action.DeliverLetters.Goal) -> DeliverGoal:
    return DeliverGoal(goal.task, goal.station, goal.word, to_ints(goal.tiles))


@to_ros.register
def _(goal: StoreGoal) -> action.StoreBundle.Goal:
    return action.StoreBundle.Goal(
        task=goal.task, station=goal.station, bundle=goal.bundle, tile=goal.tile, count=goal.count
    )


@from_ros.register
def _(goal: action.StoreBundle.Goal) -> StoreGoal:
    return StoreGoal(goal.task, goal.station, goal.bundle, goal.tile, goal.count)


@to_ros.register
def _(feedback: TaskFeedback) -> action.DeliverLetters.Feedback | action.StoreBundle.Feedback:
    kind = action.DeliverLetters if feedback.kind == DELIVER else action.StoreBundle
    return kind.Feedback(missing=feedback.missing, message=feedback.message)


def task_feedback(feedback: Any, kind: str, task: int) -> TaskFeedback:
    """How far a task of the fleet has come."""
    return TaskFeedback(kind, task, to_ints(feedback.missing), feedback.message)


@to_ros.register
def _(tasks: Tasks) -> msg.Tasks:
    lines = [
        msg.Task(
            task=task.task,
            kind=task.kind,
            station=task.station,
            job=task.job,
            tiles=task.tiles,
            bots=task.bots,
            message=task.message,
        )
        for task in tasks.tasks
    ]
    return msg.Tasks(header=header_at(tasks.time), tasks=lines)


@from_ros.register
def _(tasks: msg.Tasks) -> Tasks:
    lines = []
    for task in not_absurd(tasks.tasks):
        if task.kind not in (DELIVER, STORE):
            raise MalformedMessage(f"{task.kind[:40]!r} is no kind of task")
        lines.append(
            TaskState(
                task.task,
                task.kind,
                task.station,
                task.job,
                to_ints(task.tiles),
                to_ints(task.bots),
                task.message,
            )
        )
    return Tasks(from_stamp(tasks.header.stamp), tuple(lines))


@to_ros.register
def _(bound: Bound) -> msg.Bound:
    return msg.Bound(header=header_at(bound.time), buckets=list(bound.buckets), stations=list(bound.stations))


@from_ros.register
def _(bound: msg.Bound) -> Bound:
    buckets, stations = to_ints(bound.buckets), to_ints(bound.stations)
    if len(buckets) != len(stations):
        raise MalformedMessage(f"{len(buckets)} buckets bound for {len(stations)} stations")
    return Bound(from_stamp(bound.header.stamp), buckets, stations)
