"""A person drives one bot from a program of their own: cmd_vel, grab, transfer, release, the drive action."""

from __future__ import annotations

from typing import Any

import pytest
from geometry_msgs.msg import Point
from rclpy.action import ActionClient
from soup_msgs import action, msg, srv
from std_srvs.srv import SetBool

from .conftest import Parts
from .person import Person

pytestmark = [pytest.mark.live, pytest.mark.timeout(600)]
WITHIN_M = 0.05


def test_a_person_fetches_a_bucket_serves_a_word_and_brings_the_bucket_back(parts: Parts):
    world = parts.start("run_world.py", "--speed", "2", "--set", "bots=1", "--set", "buckets=1")
    bot = parts.start("run_bots.py", "0")
    with Person() as person:
        for kind, topic in ((msg.Bots, "/world/bots"), (msg.Buckets, "/world/buckets")):
            person.listen(kind, topic)
        for kind, topic in ((msg.Scenario, "/world/scenario"), (msg.Snapshot, "/world/snapshot")):
            person.listen(kind, topic, latched=True)
        person.listen(msg.BotStatus, "/bot_0/status", latched=True)
        everything = {"/world/buckets", "/world/scenario", "/world/snapshot", "/bot_0/status"}
        person.wait(lambda: everything <= person.heard.keys(), "the world and the bot are there")
        layout, buckets = person.heard["/world/scenario"].layout, person.heard["/world/buckets"]
        spot = buckets.x[0], buckets.y[0]
        waypoint = layout.word_stations[0]
        station = layout.waypoint_x[waypoint], layout.waypoint_y[waypoint]

        refused(person.call(srv.Grab, "/bot_0/grab"), "out_of_tolerance")
        refused(person.call(srv.Release, "/bot_0/release"), "not_carrying")
        refused(person.call(srv.Transfer, "/bot_0/transfer"), "not_carrying")

        person.drive(0, *spot, WITHIN_M)
        granted(person.call(srv.Grab, "/bot_0/grab"))
        refused(person.call(srv.Grab, "/bot_0/grab"), "already_carrying")
        refused(person.call(srv.Transfer, "/bot_0/transfer", station=0), "out_of_tolerance")
        refused(person.call(srv.Transfer, "/bot_0/transfer", tile="?"), "invalid")

        person.drive(0, *station, WITHIN_M)
        refused(person.call(srv.Release, "/bot_0/release"), "out_of_tolerance")
        refused(person.call(srv.Transfer, "/bot_0/transfer"), "not_needed")
        snapshot = person.heard["/world/snapshot"]
        inside = set(snapshot.content_tile)
        word = next(word for word in snapshot.waiting_words if inside & set(word.tiles))
        granted(person.call(srv.AssignWord, "/world/assign_word", word=word.word, station=0))
        granted(person.call(srv.Transfer, "/bot_0/transfer"))
        person.wait(lambda: person.heard["/world/buckets"].tiles[0] == buckets.tiles[0] - 1, "the tile is gone")

        person.drive(0, *spot, WITHIN_M)
        granted(person.call(srv.Release, "/bot_0/release"))
        person.wait(lambda: person.heard["/world/buckets"].bot[0] == -1, "the bucket rests")
        person.wait(lambda: person.heard["/bot_0/status"].phase == "idle", "the bot stands idle")
    parts.interrupt(bot)
    parts.interrupt(world)
    assert (bot.returncode, world.returncode) == (0, 0)


@pytest.mark.parametrize(
    ("policy", "reason"),
    [
        ("straight", "stands after a collision until its penalty is over"),
        ("evade", "waits for bot 1, whose turn it is at its goal"),
    ],
)
def test_a_drive_that_waits_says_what_for_until_it_is_cancelled(parts: Parts, policy: str, reason: str):
    world = parts.start("run_world.py", "--set", "bots=2", "--set", "buckets=1")
    bot = parts.start("run_bots.py", "0", "--policy", policy)  # nobody moves bot 1
    with Person() as person:
        person.listen(msg.Bots, "/world/bots")
        person.listen(msg.BotStatus, "/bot_0/status", latched=True)
        person.wait(lambda: "/bot_0/status" in person.heard, "the bot is there")
        told: list[action.Drive.Feedback] = []
        client = ActionClient(person.node, action.Drive, "/bot_0/drive")
        person.wait(client.server_is_ready, "somebody serves /bot_0/drive")
        x, y = person.place(1)
        goal = action.Drive.Goal(points=[Point(x=x, y=y)])
        accepted: Any = client.send_goal_async(goal, lambda message: told.append(message.feedback))
        person.wait(accepted.done, "the goal is answered")
        waits = f"drives to ({x:.1f}, {y:.1f}); {reason}"
        person.wait(lambda: any(feedback.message == waits for feedback in told), f"the drive says: {waits}")
        assert {feedback.phase for feedback in told} == {"driving"}
        handle: Any = accepted.result()
        assert handle.accepted
        result: Any = handle.get_result_async()
        handle.cancel_goal_async()
        person.wait(result.done, "the drive ends")
        assert (result.result().result.success, result.result().result.code) == (False, "cancelled")
        person.wait(lambda: person.heard["/bot_0/status"].phase == "idle", "the bot stands idle")
        client.destroy()
    parts.interrupt(bot)
    parts.interrupt(world)
    assert (bot.returncode, world.returncode) == (0, 0)


def test_time_is_paused_stepped_and_paced_by_services(parts: Parts):
    kept = parts.folder / "kept"
    (kept / "world.checkpoint").mkdir(parents=True)  # where a file is to be: it cannot be written
    world = parts.start("run_world.py", "--checkpoint", str(kept), "--every", "0.1")
    with Person() as person:
        assert person.call(SetBool, "/world/pause", data=True).success
        granted(person.call(srv.Step, "/world/step", seconds=0.5))
        refused(person.call(srv.Step, "/world/step", seconds=-1.0), "invalid")
        refused(person.call(srv.Step, "/world/step", seconds=float("nan")), "invalid")
        assert person.call(SetBool, "/world/pause", data=False).success
        refused(person.call(srv.Step, "/world/step", seconds=1.0), "moving")
        granted(person.call(srv.SetSpeed, "/world/set_speed", real_time_factor=7.5))
        refused(person.call(srv.SetSpeed, "/world/set_speed", real_time_factor=0.0), "invalid")
        refused(person.call(srv.AssignWord, "/world/assign_word", word=-5, station=0), "unknown")
        refused(person.call(srv.AssignBundle, "/world/assign_bundle", station=99), "unknown")
        granted(person.call(srv.Checkpoint, "/world/checkpoint", path="now.checkpoint"))
        assert (kept / "now.checkpoint").stat().st_size > 0
        for elsewhere in (parts.folder / "now.checkpoint", kept / "profile"):
            refused(person.call(srv.Checkpoint, "/world/checkpoint", path=str(elsewhere)), "invalid")
            assert not elsewhere.exists()
        (kept / "world.checkpoint").rmdir()
        person.wait((kept / "world.checkpoint").exists, "the checkpoint that failed is tried again")
    told = parts.interrupt(world)
    assert "world.checkpoint: could not be written: Is a directory; tried again" in told
    assert "world.checkpoint: written again" in told


def granted(answer: srv.Grab.Response) -> None:
    assert answer.success, f"{answer.code}: {answer.message}"
    assert answer.code == "done"


def refused(answer: srv.Grab.Response, code: str) -> None:
    assert not answer.success
    assert answer.code == code, answer.message
    assert len(answer.message.split()) > 2, "a sentence says why"
