"""Messages that make no sense are refused and counted, at every input, and the warehouse goes on."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Point, PoseStamped, Twist, Vector3
from nav_msgs.msg import Path
from rclpy.action import ActionClient
from rclpy.qos import DurabilityPolicy, QoSProfile
from soup_msgs import action, msg, srv

from .conftest import Parts
from .person import Person

pytestmark = [pytest.mark.live, pytest.mark.timeout(600)]
EACH = 500
AT_ONCE = 25
NAN = math.nan
LATCHED = QoSProfile(depth=EACH, durability=DurabilityPolicy.TRANSIENT_LOCAL)
MANY = QoSProfile(depth=EACH)


def nan_path() -> Path:
    """A path to nowhere."""
    path = Path(poses=[PoseStamped()])
    path.poses[0].pose.position = Point(x=NAN)
    return path


# topic, what comes there, which process has to count it
ON_TOPICS: dict[str, tuple[str, Any, QoSProfile, str]] = {
    "velocity": ("/bot_3/cmd_vel", Twist(linear=Vector3(x=NAN)), MANY, "world"),
    "infinite turn": ("/bot_4/cmd_vel", Twist(angular=Vector3(z=math.inf)), MANY, "world"),
    "path": ("/bot_3/path", nan_path(), MANY, "world"),
    "no such bot": ("/world/requests", msg.BotRequest(bot=9999, verb="grab"), MANY, "world"),
    "negative bot": ("/world/requests", msg.BotRequest(bot=-1, verb="release"), MANY, "world"),
    "no verb": ("/world/requests", msg.BotRequest(bot=1, verb="steal"), MANY, "world"),
    "heard at no time": ("/world/heard", msg.Heard(part="fleet manager", next_time=NAN), MANY, "world"),
    "heard by a stranger": ("/world/heard", msg.Heard(part="stranger"), MANY, "world"),
    "reacts to nothing known": ("/world/heard", msg.Heard(part="word manager", reacts=["doom"]), MANY, "world"),
    "event": ("/world/events", msg.Event(type="doom", sequence=5), MANY, "word manager"),
    "event nowhere": ("/world/events", msg.Event(type="grabbed", x=NAN), MANY, "letter manager"),
    "beat": ("/world/beat", msg.Beat(time=NAN), LATCHED, "fleet manager"),
    "reply": ("/world/replies", msg.BotReply(bot=2, code="perhaps"), MANY, "bots 0-19"),
    "reply from nowhere": ("/world/replies", msg.BotReply(bot=2, code="done", x=NAN), MANY, "bots 0-19"),
    "scenario": ("/world/scenario", msg.Scenario(run=5, json='{"bots": "many"}'), LATCHED, "fleet manager"),
    "status of another bot": ("/bot_5/status", msg.BotStatus(bot=6, phase="idle"), LATCHED, "fleet manager"),
    "status without a phase": ("/bot_5/status", msg.BotStatus(bot=5, phase="dancing"), LATCHED, "fleet manager"),
    "order to nobody": ("/fleet/orders", msg.Order(bot=1, verb="dance"), MANY, "bots 0-19"),
    "order to drive nowhere": (
        "/fleet/orders",
        msg.Order(bot=1, verb="drive", points=[Point(x=NAN)]),
        MANY,
        "bots 0-19",
    ),
    "outcome": ("/fleet/outcomes", msg.Outcome(bot=1, verb="drive", code="perhaps"), MANY, "fleet manager"),
    "bound": ("/fleet/bound", msg.Bound(buckets=[1, 2], stations=[1]), LATCHED, "word manager"),
}


def test_ten_thousand_malformed_messages_are_counted_and_letters_move_on(parts: Parts, prose: str):
    warehouse = parts.start("run_warehouse.py", "--no-dashboard", "--speed", "5", "--set", f"words={prose}")
    with Person() as person:
        counted: dict[str, int] = {}

        def note(report: Any) -> None:
            for status in report.status:
                values = {pair.key: pair.value for pair in status.values}
                counted[status.name] = int(values["malformed_messages"])

        person.node.create_subscription(DiagnosticArray, "/diagnostics", note, 100)
        person.listen(msg.Statistics, "/world/statistics")

        def letters() -> int:
            return person.heard["/world/statistics"].letters_in_words if "/world/statistics" in person.heard else 0

        person.wait(lambda: letters() > 0, "letters move")

        def bother(publisher: Any, message: Any) -> bool:
            for _ in range(AT_ONCE):
                publisher.publish(message)
            return True

        for kind, (topic, message, profile, who) in ON_TOPICS.items():
            wanted = counted[who] + EACH
            publisher = person.node.create_publisher(type(message), topic, profile)
            person.wait(lambda p=publisher: p.get_subscription_count() > 0, f"somebody listens to {topic}")
            person.wait(
                lambda p=publisher, m=message, who=who, wanted=wanted: bother(p, m) and counted[who] >= wanted,
                f"{who} counts: {kind}",
            )
            person.node.destroy_publisher(publisher)
        for kind, ask in GOALS.items():
            before = sum(counted.values())
            assert not ask(person), kind
            person.wait(lambda before=before: sum(counted.values()) >= before + EACH // 2, f"counted: {kind}")
        assert sum(counted.values()) >= 10_000
        assert person.call(srv.SetSpeed, "/world/set_speed", real_time_factor=NAN).success is False
        assert person.call(srv.Step, "/world/step", seconds=NAN).success is False
        assert person.call(srv.AssignWord, "/world/assign_word", word=-7, station=99).success is False
        assert person.call(srv.Transfer, "/bot_1/transfer", tile="42").success is False
        moved = letters()
        person.wait(lambda: letters() > moved, "letters move on")
        assert person.heard["/world/statistics"].violations == 0
    parts.interrupt(warehouse)
    assert warehouse.returncode == 0


def _goals(kind: Any, name: str, goal: Any) -> Callable[[Person], bool]:
    """Ask for a goal many times; whether one was accepted."""

    def ask(person: Person) -> bool:
        client = ActionClient(person.node, kind, name)
        person.wait(client.server_is_ready, f"somebody serves {name}")
        accepted = False
        for _ in range(EACH // 2):
            future = client.send_goal_async(goal)
            person.wait(future.done, f"the answer of {name}")
            answer: Any = future.result()
            accepted |= answer.accepted
        client.destroy()
        return accepted

    return ask


GOALS = {
    "drive to nowhere": _goals(action.Drive, "/bot_2/drive", action.Drive.Goal(points=[Point(x=NAN)])),
    "trip over nowhere": _goals(
        action.CarryTrip, "/bot_2/trip", action.CarryTrip.Goal(trip=msg.Trip(fetch_route=[Point(y=math.inf)]))
    ),
}
