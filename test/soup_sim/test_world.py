"""The world: what bots and managers may do, and what it tells."""

from __future__ import annotations

import math

import pytest
from world_hands import bucket_at_hand, clear, codes, do, loaded_at, place, types

from soup_msgs_py import messages as m
from soup_msgs_py.codes import BotState, Code, EventType
from soup_sim.world import World

# ---- collisions ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("a", "b", "va", "vb", "expected"),
    [
        ((10.0, 15.0), (20.0, 15.0), (4.0, 0.0), (-4.0, 0.0), "head on"),
        ((10.0, 15.0), (15.0, 10.0), (3.0, 0.0), (0.0, 3.0), "crossing"),
        ((10.0, 15.0), (20.0, 15.9), (4.0, 0.0), (0.0, 0.0), "glancing"),
    ],
)
def test_two_bots_collide_at_the_computed_instant(world: World, a, b, va, vb, expected) -> None:
    clear(world)
    place(world, bot_0=a, bot_1=b)
    world.handle(m.SetVelocity(0, *va))
    world.handle(m.SetVelocity(1, *vb))
    collision = next(s for s in world.advance(20.0) if isinstance(s, m.Event))
    # both have reached their velocity by then; each lost half of its ramp time v / A on the way
    lag = [math.hypot(*v) / world.scenario.bot.max_acceleration_mps2 / 2.0 for v in (va, vb)]
    dx = (b[0] - vb[0] * lag[1]) - (a[0] - va[0] * lag[0])
    dy = (b[1] - vb[1] * lag[1]) - (a[1] - va[1] * lag[0])
    ux, uy = vb[0] - va[0], vb[1] - va[1]
    radii = 2.0 * world.scenario.bot.radius_m
    q, p, c = ux * ux + uy * uy, 2.0 * (dx * ux + dy * uy), dx * dx + dy * dy - radii * radii
    instant = (-p - math.sqrt(p * p - 4.0 * q * c)) / (2.0 * q)
    assert collision.type is EventType.BOT_COLLISION, expected
    assert collision.bots == (0, 1)
    assert collision.time == pytest.approx(instant, abs=1e-6)


def test_after_a_collision_all_involved_stand_for_the_penalty(world: World) -> None:
    clear(world)
    place(world, bot_0=(10.0, 15.0), bot_1=(14.0, 15.0))
    world.handle(m.FollowPath(0, 7, ((20.0, 15.0),)))
    said = world.advance(60.0)
    collision, reply, *resumed = said
    assert isinstance(reply, m.BotReply) and reply.code is Code.COLLIDED and reply.request == 7
    assert isinstance(collision, m.Event)
    assert [event.time - collision.time for event in resumed if isinstance(event, m.Event)] == pytest.approx([5.0, 5.0])
    assert world.bots().x[0] == pytest.approx(13.0)


def test_a_penalised_bot_refuses_everything_with_a_sentence(world: World) -> None:
    clear(world)
    place(world, bot_0=(10.0, 15.0), bot_1=(14.0, 15.0))
    world.handle(m.FollowPath(0, 7, ((20.0, 15.0),)))
    world.advance(2.0)
    assert world.bots().state[1] == BotState.PENALISED
    for request in (m.FollowPath(0, 8, ((3.0, 3.0),)), m.Grab(0, 9), m.Release(0, 10), m.Transfer(1, 11)):
        reply = do(world, request)
        assert reply.code is Code.PENALISED and "after a collision" in reply.message


def test_an_unloaded_bot_passes_under_resting_buckets_and_a_loaded_one_collides(world: World) -> None:
    x, y = bucket_at_hand(world, 0, 3)
    buckets = world.buckets()
    other = min(
        (b for b in range(world.scenario.buckets) if b != 3),
        key=lambda b: (buckets.x[b] - x) ** 2 + (buckets.y[b] - y) ** 2,
    )
    target = (float(buckets.x[other]), float(buckets.y[other]))
    assert do(world, m.FollowPath(0, 1, (target,))).success
    assert do(world, m.FollowPath(0, 2, ((x, y),))).success
    assert do(world, m.Grab(0, 3, 3)).success
    said = world.handle(m.FollowPath(0, 4, (target,))) + world.advance(world.now + 10.0)
    event = next(s for s in said if isinstance(s, m.Event))
    assert event.type is EventType.BUCKET_COLLISION
    assert event.buckets == (3, other) and event.bots == (0,)


# ---- driving ------------------------------------------------------------------------------------------------------


def test_a_path_stops_at_corners_and_passes_points_on_a_line(world: World) -> None:
    clear(world)
    place(world, bot_0=(5.0, 15.0))
    reply = do(world, m.FollowPath(0, 1, ((10.0, 15.0), (20.0, 15.0), (20.0, 25.0))))
    v, a = 4.0, 20.0
    assert reply.time == pytest.approx((15.0 / v + v / a) + (10.0 / v + v / a))
    assert (reply.x, reply.y) == (20.0, 25.0)


def test_stamps_of_a_path_are_kept_where_they_can_be(world: World) -> None:
    clear(world)
    place(world, bot_0=(5.0, 15.0))
    reply = do(world, m.FollowPath(0, 1, ((10.0, 15.0), (10.0, 16.0)), (4.0, 4.0)))
    assert reply.time == pytest.approx(4.0 + 1.0 / 4.0 + 4.0 / 20.0)
    assert do(world, m.FollowPath(0, 2, ((5.0, 16.0),), (12.5,))).time == pytest.approx(12.5)


def test_a_path_whose_departure_has_passed_is_refused_as_late(world: World) -> None:
    clear(world)
    place(world, bot_0=(5.0, 15.0))
    world.advance(3.0)
    path = ((5.0, 15.0), (10.0, 15.0))
    assert do(world, m.FollowPath(0, 1, path, (2.9, 9.0))).code is Code.LATE
    assert do(world, m.FollowPath(0, 2, path, (3.0, 9.0))).time == pytest.approx(9.0)
    world.advance(12.0)
    assert do(world, m.FollowPath(0, 3, ((5.0, 15.0),), (2.9,))).code is Code.DONE


def test_a_new_motion_replaces_the_old_one(world: World) -> None:
    clear(world)
    place(world, bot_0=(5.0, 15.0))
    world.handle(m.FollowPath(0, 1, ((30.0, 15.0),)))
    world.advance(2.0)
    said = world.handle(m.FollowPath(0, 2, ((30.0, 25.0),)))
    assert [(s.request, s.code) for s in said if isinstance(s, m.BotReply)] == [(1, Code.REPLACED)]
    assert [s.request for s in world.advance(60.0) if isinstance(s, m.BotReply)] == [2]


@pytest.mark.parametrize(
    ("points", "stamps", "code"),
    [
        ((), (), Code.INVALID),
        (((100.0, 3.0),), (), Code.OFF_FLOOR),
        (((float("nan"), 3.0),), (), Code.OFF_FLOOR),
        (((3.0, 3.0), (4.0, 3.0)), (1.0,), Code.INVALID),
        (((3.0, 3.0), (4.0, 3.0)), (2.0, 1.0), Code.INVALID),
    ],
)
def test_a_path_that_makes_no_sense_is_refused(world: World, points, stamps, code) -> None:
    assert do(world, m.FollowPath(0, 1, points, stamps)).code is code


def test_a_velocity_by_hand_that_is_no_number_is_ignored(world: World) -> None:
    before = world.bots()
    world.handle(m.SetVelocity(0, float("nan"), 1.0))
    world.advance(1.0)
    assert world.bots().x[0] == before.x[0]


# ---- grab and release ---------------------------------------------------------------------------------------------


def test_grab_takes_its_time_and_lifts_the_bucket(world: World) -> None:
    x, y = bucket_at_hand(world, 0, 3)
    reply = do(world, m.Grab(0, 1))
    assert reply.success and reply.time == pytest.approx(0.5)
    assert world.bots().bucket[0] == 3 and world.buckets().bot[3] == 0
    assert do(world, m.Grab(0, 2)).code is Code.ALREADY_CARRYING
    assert do(world, m.Release(0, 3)).success
    assert (world.buckets().x[3], world.buckets().y[3]) == (x, y)


def test_out_of_tolerance_every_service_says_no_with_a_sentence(world: World) -> None:
    x, y = bucket_at_hand(world, 0, 3)
    place(world, bot_0=(x + 0.11, y))
    grab = do(world, m.Grab(0, 1, 3))
    assert grab.code is Code.OUT_OF_TOLERANCE and "0.110 m" in grab.message
    assert do(world, m.Grab(0, 1)).code is Code.OUT_OF_TOLERANCE
    place(world, bot_0=(x, y))
    assert do(world, m.Grab(0, 2)).success
    transfer = do(world, m.Transfer(0, 3))
    assert transfer.code is Code.OUT_OF_TOLERANCE and "come within" in transfer.message
    assert do(world, m.FollowPath(0, 4, ((x + 0.2, y),))).success
    release = do(world, m.Release(0, 5))
    assert release.code is Code.OUT_OF_TOLERANCE and "storage spot" in release.message


def test_a_moving_bot_can_neither_grab_nor_release(world: World) -> None:
    clear(world)
    world.handle(m.SetVelocity(0, 0.0, 1.0))
    assert do(world, m.Grab(0, 1)).code is Code.MOVING
    assert do(world, m.Release(0, 2)).code is Code.MOVING


def test_a_bucket_on_another_bot_and_a_bucket_that_is_not_there_are_refused(world: World) -> None:
    bucket_at_hand(world, 0, 3)
    assert do(world, m.Grab(0, 1)).success
    assert do(world, m.Grab(1, 2, 3)).code is Code.BUCKET_TAKEN
    assert do(world, m.Grab(1, 3, 10_000)).code is Code.UNKNOWN
    assert do(world, m.Release(1, 4)).code is Code.NOT_CARRYING
    assert do(world, m.Transfer(1, 5)).code is Code.NOT_CARRYING


# ---- stations -----------------------------------------------------------------------------------------------------


def test_a_word_station_takes_only_tiles_that_its_open_words_need(world: World) -> None:
    loaded_at(world, 0)
    assert do(world, m.Transfer(0, 2)).code is Code.NOT_NEEDED
    snapshot = world.snapshot()
    held = set(snapshot.contents[3])
    word = next(w for w in snapshot.waiting_words if held & set(w.tiles))
    assert types(world.handle(m.AssignWord(word.word, 0))) == [EventType.WORD_ASSIGNED, EventType.WORD_ARRIVED]
    tile = next(t for t in word.tiles if t in held)
    started = world.now
    said = world.handle(m.Transfer(0, 3, 0, (m.TileMove(tile, word.word),))) + world.advance(world.now + 10.0)
    event, reply = said
    assert isinstance(event, m.Event) and event.type is EventType.TRANSFERRED
    assert (event.tile, event.job, event.bucket, event.station) == (tile, word.word, 3, 0)
    assert event.time - started == pytest.approx(world.scenario.word_station.transfer_s)
    assert isinstance(reply, m.BotReply) and reply.success
    assert world.snapshot().contents[3].get(tile, 0) == snapshot.contents[3][tile] - 1


def test_a_station_works_through_many_tiles_one_after_another(world: World) -> None:
    station = world.scenario.word_station_count
    loaded_at(world, station)
    for _ in range(2):
        world.handle(m.AssignBundle(station, tile=4))
    started = world.now
    reply = do(world, m.Transfer(0, 3, station, (m.TileMove(),) * 6))
    assert reply.success and reply.message == "6 of 6 tiles moved"
    assert reply.time - started == pytest.approx(6 * world.scenario.letter_station.transfer_s)
    left = world.snapshot().letter_stations[0].staged_bundles
    assert [bundle.count for bundle in left] == [2]


def test_a_full_bucket_takes_no_tile(world: World) -> None:
    station = world.scenario.word_station_count
    loaded_at(world, station)
    for _ in range(4):
        world.handle(m.AssignBundle(station, tile=4))
    reply = do(world, m.Transfer(0, 3, station, (m.TileMove(),) * 14))
    assert reply.code is Code.BUCKET_FULL and reply.message.startswith("12 of 14")


def test_limits_of_open_words_and_staged_bundles_hold(world: World) -> None:
    waiting = [word.word for word in world.snapshot().waiting_words]
    said = [s for word in waiting[:5] for s in world.handle(m.AssignWord(word, 0))]
    assert codes(said) == [Code.DONE] * 4 + [Code.STATION_FULL]
    first = world.scenario.word_station_count
    said = [s for _ in range(5) for s in world.handle(m.AssignBundle(first, tile=0))]
    assert codes(said) == [Code.DONE] * 4 + [Code.STATION_FULL]


@pytest.mark.parametrize(
    "request_",
    [
        m.AssignWord(-1, 0),
        m.AssignWord(0, 3),
        m.AssignWord(0, 99),
        m.AssignBundle(0, tile=0),
        m.AssignBundle(3, tile=10_000),
        m.AssignBundle(3, tile=-5),
        m.AssignBundle(3, bundle=77),
    ],
)
def test_an_assignment_that_makes_no_sense_is_refused(world: World, request_) -> None:
    (reply,) = world.handle(request_)
    assert isinstance(reply, m.Reply) and reply.code is Code.UNKNOWN


def test_a_bot_that_does_not_exist_is_told_so(world: World) -> None:
    (reply,) = world.handle(m.Grab(1234, 1))
    assert isinstance(reply, m.BotReply) and reply.code is Code.UNKNOWN
