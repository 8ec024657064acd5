"""A bot on a trip: it goes through all phases, tries again what passes, and says what it waits for."""

from typing import Any

import numpy as np
import pytest
from bare_floor import STATION, BareFloor, floor_of
from hypothesis import given, settings
from hypothesis import strategies as st
from world_hands import changed

from soup_bots.trip.bot_mind import BotMind, ByHandReply
from soup_msgs_py.codes import Code, EventType, Phase
from soup_msgs_py.messages import (
    BotReply,
    BotStatus,
    CancelDrive,
    CancelTrip,
    DriveFeedback,
    DriveGoal,
    DriveResult,
    Event,
    FollowPath,
    Grab,
    Release,
    SetVelocities,
    SetVelocity,
    TileMove,
    Transfer,
    Trip,
    TripFeedback,
    TripGoal,
    TripResult,
    Visit,
)
from soup_msgs_py.mind import NEVER

BUCKET, SPOT = (20.0, 10.0), (20.0, 40.0)
TRIP = Trip(
    12,
    0,
    ((20.0, 5.0), BUCKET),
    (Visit(0, (TileMove(3, 1), TileMove(4, 1)), ((20.0, 30.0), STATION)),),
    ((20.0, 30.0), SPOT),
)


def wants(floor):
    """The word that the trip is for is open, and the bucket holds its letters."""
    with changed(floor.world) as state:
        state["serving"]["contents"][0] = [(3, 1), (4, 1)]
        state["serving"]["stations"][0]["open_words"] = [(1, "DE", (3, 4), [False, False])]
    return floor


@pytest.fixture
def floor():
    return wants(BareFloor([(5, 5), (50, 50)], buckets=[BUCKET], spots=[SPOT]))


@pytest.fixture
def mind():
    return BotMind(3, floor_of(), retry_s=0.25, penalty_s=5.0)


def said(floor, kind, bot=0):
    return [m for m in floor.told if isinstance(m, kind) and getattr(m, "bot", bot) == bot]


def only(messages, kind):
    (found,) = [m for m in messages if isinstance(m, kind)]
    return found


def reply(request, code=Code.DONE, message="because"):
    return BotReply(request.bot, request.request, code, message, 0.0, 1.0, 1.0)


def ended(floor):
    return lambda: bool(said(floor, TripResult))


def up_to(mind, kind, now=0.0, trip=TRIP) -> Any:
    """Let the mind go through the trip until it makes a request of a kind; that request."""
    out = mind.handle(TripGoal(mind.bot, trip), now)
    while True:
        request = next(m for m in out if isinstance(m, FollowPath | Grab | Transfer | Release))
        if isinstance(request, kind):
            return request
        out = mind.handle(reply(request), now)


def test_a_trip_runs_through_all_phases(floor):
    floor.tell(floor.crew, TripGoal(0, TRIP))
    assert floor.go_on(90, ended(floor))
    assert said(floor, TripResult)[0].code is Code.DONE
    phases = [m.phase for m in said(floor, BotStatus)]
    in_order = [p for k, p in enumerate(phases) if k == 0 or p is not phases[k - 1]]
    assert in_order == [Phase.IDLE, Phase.FETCHING, Phase.VISITING, Phase.STORING, Phase.IDLE]
    buckets = floor.world.buckets()
    assert (buckets.x[0], buckets.y[0], buckets.bot[0]) == (*SPOT, -1)
    assert [m.moves for m in said(floor, Transfer)] == [TRIP.visits[0].moves]


def test_feedback_counts_the_visits(floor):
    floor.tell(floor.crew, TripGoal(0, TRIP))
    floor.go_on(90, ended(floor))
    counts = [m.visits_done for m in said(floor, TripFeedback)]
    assert counts == sorted(counts)
    assert counts[-1] == 1


def test_a_bot_that_carries_the_bucket_skips_fetching():
    floor = wants(BareFloor([(5, 5)], buckets=[BUCKET], spots=[SPOT], carrying={0: 0}))
    floor.tell(floor.crew, TripGoal(0, TRIP))
    assert floor.go_on(90, ended(floor))
    assert not said(floor, Grab)


def test_a_bot_that_carries_another_bucket_says_so():
    floor = BareFloor([(5, 5)], buckets=[BUCKET, BUCKET], carrying={0: 1})
    floor.tell(floor.crew, TripGoal(0, TRIP))
    (result,) = said(floor, TripResult)
    assert result.code is Code.INVALID
    assert "carries bucket 1" in result.message


def test_without_a_store_route_the_bot_keeps_the_bucket(floor):
    floor.tell(floor.crew, TripGoal(0, Trip(12, 0, TRIP.fetch_route, TRIP.visits, ())))
    assert floor.go_on(90, ended(floor))
    assert said(floor, TripResult)[0].code is Code.DONE
    assert floor.bots.bucket[0] == 0
    assert floor.crew.minds[0].bucket == 0


def test_a_second_trip_is_refused(mind):
    up_to(mind, Grab)
    result = only(mind.handle(TripGoal(3, Trip(13, 0, (), (), ())), 1.0), TripResult)
    assert (result.trip, result.code) == (13, Code.BUSY)
    assert "on trip 12; cancel it first" in result.message


# collisions and refusals


def test_after_a_collision_the_bot_waits_until_it_resumes_and_drives_on():
    floor = wants(BareFloor([(5, 5), (5, 7.2)], buckets=[BUCKET], spots=[SPOT]))
    floor.tell(floor.crew, TripGoal(0, TRIP))
    floor.tell(floor.crew, SetVelocity(1, 0.0, -4.0))
    assert floor.go_on(1, lambda: floor.contacts == 1)
    assert "collision" in said(floor, BotStatus)[-1].message
    assert floor.go_on(95, ended(floor))
    assert said(floor, TripResult)[0].code is Code.DONE


def test_a_collision_during_a_transfer_only_repeats_the_tiles_that_have_not_moved(mind):
    transfer = up_to(mind, Transfer)
    mind.handle(Event(0.0, 0, EventType.TRANSFERRED, bot=3), 0.0)
    mind.handle(reply(transfer, Code.COLLIDED), 0.0)
    again = only(mind.handle(Event(5.0, 1, EventType.RESUMED, bot=3), 5.0), Transfer)
    assert isinstance(again, Transfer) and isinstance(transfer, Transfer)
    assert again.moves == transfer.moves[1:]


def test_a_lost_resumption_does_not_stop_the_bot_for_ever(mind):
    mind.handle(reply(up_to(mind, Grab), Code.COLLIDED), 1.0)
    assert 6.0 < mind.next_wake < 8.0
    assert only(mind.wake(mind.next_wake), Grab).bucket == 0


@pytest.mark.parametrize("code", [Code.BUSY, Code.MOVING, Code.BLOCKED])
def test_what_passes_is_tried_again_a_little_later(mind, code):
    grab = up_to(mind, Grab)
    out = mind.handle(reply(grab, code, "another bot is served"), 1.0)
    assert only(out, BotStatus).message.endswith("another bot is served")
    assert mind.next_wake == 1.25
    again = only(mind.wake(1.25), Grab)
    assert again.request > grab.request
    assert mind.next_wake == NEVER


@pytest.mark.parametrize("code", [Code.NOT_NEEDED, Code.NOT_IN_BUCKET, Code.BUCKET_FULL, Code.NOTHING_STAGED])
def test_refused_tiles_do_not_end_the_trip_but_its_result_mentions_them(mind, code):
    out = mind.handle(reply(up_to(mind, Transfer), code, "no E0 in bucket 0"), 1.0)
    for kind in (FollowPath, Release):
        request = only(out, kind)
        out = mind.handle(reply(request), 1.0)
    result = only(out, TripResult)
    assert result.code is Code.DONE
    assert "word station 0: no E0 in bucket 0" in result.message


def test_out_of_tolerance_the_bot_drives_to_the_point_again_but_not_for_ever(mind):
    out = mind.handle(reply(up_to(mind, Grab), Code.OUT_OF_TOLERANCE), 1.0)
    tries = 0
    while not any(isinstance(m, TripResult) for m in out):
        path = only(out, FollowPath)
        assert path.points == (BUCKET,)
        out = mind.handle(reply(only(mind.handle(reply(path), 1.0), Grab), Code.OUT_OF_TOLERANCE), 1.0)
        tries += 1
    assert tries == 2
    assert only(out, TripResult).code is Code.OUT_OF_TOLERANCE


@pytest.mark.parametrize("code", [Code.BUCKET_TAKEN, Code.UNKNOWN, Code.SPOT_TAKEN, Code.ALREADY_CARRYING])
def test_what_does_not_pass_ends_the_trip_with_its_code_and_sentence(mind, code):
    result = only(mind.handle(reply(up_to(mind, Grab), code, "bot 4 has it"), 1.0), TripResult)
    assert (result.code, result.message) == (code, "bot 4 has it")
    assert mind.phase is Phase.IDLE


def test_stale_replies_are_ignored(mind):
    path = up_to(mind, FollowPath)
    grab = only(mind.handle(reply(path), 1.0), Grab)
    assert mind.handle(reply(path, Code.REPLACED), 1.0) == []
    assert only(mind.handle(reply(grab), 1.0), FollowPath)


# cancelling


def test_a_cancelled_trip_stops_the_driving_bot_at_once(floor):
    floor.tell(floor.crew, TripGoal(0, TRIP))
    floor.go_on(2)
    floor.tell(floor.crew, CancelTrip(0, 12))
    assert said(floor, TripResult)[0].code is Code.CANCELLED
    floor.go_on(1)
    assert floor.bots.vx[0] == floor.bots.vy[0] == 0
    assert not floor.crew.wants_to_sense


def test_a_cancelled_trip_finishes_the_operation_under_way(mind):
    grab = up_to(mind, Grab)
    assert not any(isinstance(m, TripResult) for m in mind.handle(CancelTrip(3, 12), 1.0))
    assert only(mind.handle(reply(grab), 1.5), TripResult).code is Code.CANCELLED
    assert mind.bucket == 0


def test_cancelling_a_trip_that_the_bot_is_not_on_changes_nothing(mind):
    up_to(mind, Grab)
    assert mind.handle(CancelTrip(3, 11), 1.0) == []


def test_a_trip_cancelled_while_it_waits_ends_at_once(mind):
    mind.handle(reply(up_to(mind, Transfer), Code.BUSY), 1.0)
    assert only(mind.handle(CancelTrip(3, 12), 1.1), TripResult).code is Code.CANCELLED
    assert mind.next_wake == NEVER


# drives and requests by hand


def test_a_drive_ends_at_its_last_point(floor):
    floor.tell(floor.crew, DriveGoal(0, 5, ((20.0, 5.0), (20.0, 20.0))))
    assert floor.go_on(20, lambda: bool(said(floor, DriveResult)))
    assert said(floor, DriveResult)[0].code is Code.DONE
    assert (floor.bots.x[0], floor.bots.y[0]) == (20.0, 20.0)


@pytest.mark.parametrize("code", [Code.COLLIDED, Code.PENALISED, Code.LATE, Code.BUSY])
def test_a_drive_by_a_timetable_that_was_interrupted_is_over(mind, code):
    path = only(mind.handle(DriveGoal(3, 5, ((1.0, 1.0), (2.0, 1.0)), (1.0, 3.0)), 0.0), FollowPath)
    out = mind.handle(reply(path, code), 1.0)
    assert only(out, DriveResult).code is code
    assert only(out, BotStatus).phase is Phase.IDLE
    assert mind.next_wake == NEVER


def test_a_way_that_was_planned_for_another_load_is_refused(mind):
    refused = only(mind.handle(DriveGoal(3, 1, ((9.0, 9.0),), bucket=8), 0.0), DriveResult)
    assert (refused.code, refused.message) == (
        Code.INVALID, "bot 3 carries nothing, the way is for one that carries bucket 8",
    )  # fmt: skip
    assert not mind.driving
    mind.handle(DriveGoal(3, 2, ((9.0, 9.0),), bucket=-1), 0.0)
    assert mind.driving


def test_a_new_drive_replaces_the_old_one(mind):
    mind.handle(DriveGoal(3, 1, ((9.0, 9.0),)), 0.0)
    result = only(mind.handle(DriveGoal(3, 2, ((9.0, 1.0),)), 1.0), DriveResult)
    assert (result.drive, result.code) == (1, Code.REPLACED)
    assert only(mind.handle(CancelDrive(3, 2), 2.0), DriveResult).code is Code.CANCELLED


def test_who_ends_a_drive_that_a_bot_does_not_have_is_told_what_it_does(mind):
    mind.handle(DriveGoal(3, 1, ((9.0, 9.0),)), 0.0)
    status = only(mind.handle(CancelDrive(3, 0), 1.0), BotStatus)
    assert (status.phase, status.time) == (Phase.DRIVING, 1.0)
    assert mind.driving


def test_a_velocity_by_hand_replaces_a_drive(mind):
    mind.handle(DriveGoal(3, 1, ((9.0, 9.0),)), 0.0)
    by_hand = SetVelocity(3, 1.0, 0.0)
    out = mind.handle(by_hand, 1.0)
    assert by_hand in out
    assert only(out, DriveResult).code is Code.REPLACED
    assert mind.phase is Phase.BY_HAND
    assert not mind.driving
    mind.handle(SetVelocity(3, 0.0, 0.0), 2.0)
    assert mind.phase is Phase.IDLE


def test_on_a_trip_requests_by_hand_are_refused(mind):
    up_to(mind, Transfer)
    for request in (Grab(3, 77), Release(3, 77), Transfer(3, 77)):
        (answer,) = mind.handle(request, 1.0)
        assert isinstance(answer, ByHandReply)
        assert (answer.token, answer.reply.code) == (77, Code.BUSY)
        assert "on trip 12; cancel it first" in answer.reply.message
    (answer,) = mind.handle(SetVelocity(3, 1.0, 0.0), 1.0)
    assert answer.reply.code is Code.BUSY


def test_a_request_by_hand_is_forwarded_and_its_reply_handed_back(mind):
    grab = only(mind.handle(Grab(3, 77, 5), 1.0), Grab)
    assert (grab.bucket, grab.request != 77) == (5, True)
    answer = only(mind.handle(reply(grab), 1.5), ByHandReply)
    assert (answer.token, answer.reply.code) == (77, Code.DONE)
    assert (mind.bucket, mind.phase) == (5, Phase.IDLE)


# laws


@settings(max_examples=300, deadline=None, derandomize=True)
@given(st.lists(st.sampled_from(list(Code)), max_size=60), st.lists(st.integers(0, 9), max_size=60))
def test_whatever_the_world_answers_a_trip_has_one_result_and_the_bot_never_forgets_to_go_on(codes, other):
    mind = BotMind(3, floor_of(), retry_s=0.25, penalty_s=5.0)
    now, results = 0.0, 0
    out = mind.handle(TripGoal(3, TRIP), now)
    for step, code in enumerate(codes):
        results += sum(isinstance(m, TripResult) for m in out)
        requests = [m for m in out if isinstance(m, FollowPath | Grab | Transfer | Release)]
        assert len(requests) <= 1
        if mind.trip is None:
            break
        if requests:
            now += 0.1
            out = mind.handle(reply(requests[0], code), now)
        elif mind.next_wake < NEVER:
            now = mind.next_wake
            resumes = other[step : step + 1] == [1]
            out = mind.handle(Event(now, 0, EventType.RESUMED, bot=3), now) if resumes else mind.wake(now)
        elif mind.held:
            out = [mind.path(now)]
        else:
            pytest.fail("the bot waits for nothing")
    results += sum(isinstance(m, TripResult) for m in out) if mind.trip is None and codes and results == 0 else 0
    assert results == (mind.trip is None)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.integers(0, 2**32 - 1))
def test_the_same_start_gives_the_same_run(seed):
    def run():
        rng = np.random.default_rng(seed)
        places = rng.permutation([(x, y) for x in range(10, 50, 6) for y in range(10, 50, 6)])
        floor = BareFloor([tuple(p) for p in places[:10]])
        for bot in range(10):
            floor.tell(floor.crew, DriveGoal(bot, bot, ((float(places[10 + bot][0]), float(places[10 + bot][1])),)))
        floor.go_on(4)
        return floor.bots.x.tobytes() + floor.bots.y.tobytes(), sum(isinstance(m, SetVelocities) for m in floor.told)

    assert run() == run()


def test_a_mind_that_is_started_again_goes_on_with_the_path_of_the_one_before(mind):
    path = FollowPath(mind.bot, 77, ((1.0, 1.0), (5.0, 1.0)), (20.0, 22.0))
    status = only(mind.begin(-1, 10.0, path=path), BotStatus)
    assert (status.phase, status.points, status.stamps) == (Phase.DRIVING, path.points, path.stamps)
    assert only(mind.handle(TripGoal(mind.bot, TRIP), 11.0), TripResult).code is Code.BUSY
    told = only(mind.handle(CancelDrive(mind.bot, 0), 12.0), BotStatus)
    assert told.phase is Phase.DRIVING
    (idle,) = mind.handle(reply(path), 22.0)
    assert idle.phase is Phase.IDLE
    assert mind.next_wake == NEVER


def test_a_mind_whose_body_still_works_for_the_one_before_is_of_no_use_until_that_is_done(mind):
    status = only(mind.begin(5, 10.0, at_work=True), BotStatus)
    assert (status.phase, status.bucket) == (Phase.FINISHING, 5)
    assert only(mind.handle(TripGoal(mind.bot, TRIP), 11.0), TripResult).code is Code.BUSY
    assert only(mind.handle(DriveGoal(mind.bot, 3, ((1.0, 2.0),)), 11.0), DriveResult).code is Code.BUSY
    for request in (SetVelocity(mind.bot, 1.0, 0.0), SetVelocity(mind.bot, 0.0, 0.0)):
        assert only(mind.handle(request, 11.0), ByHandReply).reply.code is Code.BUSY
    assert mind.phase is Phase.FINISHING
    (idle,) = mind.handle(reply(Transfer(mind.bot, 77, 0, ())), 12.0)
    assert (idle.phase, idle.bucket) == (Phase.IDLE, 5)


def test_a_mind_that_did_not_hear_that_the_work_of_the_one_before_is_done_looks_for_itself(mind):
    mind.begin(5, 10.0, at_work=True)
    for code, phase in ((Code.BUSY, Phase.FINISHING), (Code.INVALID, Phase.IDLE)):
        (look,) = mind.wake(mind.next_wake)
        assert look == Transfer(mind.bot, look.request, -1, ())
        mind.handle(reply(look, code), 50.0)
        assert mind.phase is phase
    assert mind.next_wake == NEVER


def test_a_path_that_has_ended_unheard_is_not_waited_for(mind):
    path = FollowPath(mind.bot, 77, ((1.0, 1.0), (5.0, 1.0)), (2.0, 4.0))
    mind.begin(-1, 10.0, path=path)
    assert 10.0 < mind.next_wake < 15.0
    (idle,) = mind.wake(mind.next_wake)
    assert idle.phase is Phase.IDLE
    assert mind.next_wake == NEVER


def test_a_new_drive_takes_the_place_of_the_path_of_the_mind_before(mind):
    mind.begin(-1, 10.0, path=FollowPath(mind.bot, 77, ((1.0, 1.0), (5.0, 1.0)), (20.0, 22.0)))
    path = only(mind.handle(DriveGoal(mind.bot, 3, ((1.0, 2.0),), (30.0,)), 12.0), FollowPath)
    assert mind.handle(reply(FollowPath(mind.bot, 77, ()), Code.REPLACED), 12.0) == []
    assert mind.next_wake == NEVER
    assert only(mind.handle(reply(path), 30.0), DriveResult).code is Code.DONE


def test_a_drive_says_how_far_it_is_and_what_the_bot_waits_for(mind):
    mind.place = (1.0, 1.0)
    begins = only(mind.handle(DriveGoal(3, 5, ((4.0, 5.0), (4.0, 9.0))), 0.0), DriveFeedback)
    assert (begins.drive, begins.phase, begins.distance_m) == (5, Phase.DRIVING, 9.0)
    assert begins.message == "drives to (4.0, 9.0)"
    waits = only(mind.waits("bot 7 stands in its way", 1.0), DriveFeedback)
    assert waits.message.endswith("bot 7 stands in its way")
    mind.corner, mind.place = 1, (4.0, 6.0)
    goes_on = only(mind.waits("", 2.0), DriveFeedback)
    assert (goes_on.message, goes_on.distance_m) == ("drives to (4.0, 9.0)", 3.0)
    struck = only(mind.collided(3.0), DriveFeedback)
    assert "collision" in struck.message
    out = mind.handle(CancelDrive(3, 5), 4.0)
    assert [m for m in out if isinstance(m, DriveFeedback)] == []
    assert [m for m in mind.waits("on its own", 5.0) if isinstance(m, DriveFeedback)] == []


def test_a_drive_is_told_of_from_its_beginning(floor):
    floor.tell(floor.crew, DriveGoal(0, 5, ((20.0, 5.0), (20.0, 20.0))))
    assert floor.go_on(20, lambda: bool(said(floor, DriveResult)))
    assert said(floor, DriveFeedback)[0].message == "drives to (20.0, 20.0)"
