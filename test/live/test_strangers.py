"""What somebody else says in the domain of a warehouse neither stops it nor slows it down."""

from __future__ import annotations

import json
from pathlib import Path as File

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from rclpy.qos import DurabilityPolicy, QoSProfile
from soup_msgs import msg
from std_msgs.msg import Header

from .conftest import Parts
from .person import Person

pytestmark = [pytest.mark.live, pytest.mark.timeout(300)]
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
MANY = QoSProfile(depth=10)
AHEAD = 5_000
WORDS = 6


def test_words_are_completed_whatever_strangers_say(parts: Parts, prose: str, tmp_path: File):
    summary = tmp_path / "summary.json"
    arguments = ("--speed", "10", "--summary", str(summary), "--set", f"words={prose}")
    warehouse = parts.start("run_warehouse.py", "--no-dashboard", *arguments)
    with Person() as person:
        person.listen(msg.Statistics, "/world/statistics")
        person.listen(msg.Scenario, "/world/scenario", latched=True)
        person.listen(msg.Snapshot, "/world/snapshot", latched=True)
        told: dict[str, dict[str, str]] = {}

        def note(report: DiagnosticArray) -> None:
            for status in report.status:
                told[status.name] = {pair.key: pair.value for pair in status.values}

        person.node.create_subscription(DiagnosticArray, "/diagnostics", note, 100)

        def words() -> int:
            return person.heard["/world/statistics"].words_completed if "/world/statistics" in person.heard else 0

        person.wait(lambda: words() > 0 and "/world/snapshot" in person.heard, "a word is completed")
        scenario, snapshot = person.heard["/world/scenario"], person.heard["/world/snapshot"]
        run = scenario.run
        # the beginning of a bag of another run
        scenario.run = snapshot.run = run + 1
        snapshot.sequence = 0
        far = Path(header=Header(frame_id="odom"), poses=[PoseStamped()])
        long = Path(poses=[PoseStamped()] * 100_000)
        nameless = DiagnosticArray(status=[DiagnosticStatus(), DiagnosticStatus(name="camera")])
        said = [
            ("/world/scenario", scenario, LATCHED),
            ("/world/snapshot", snapshot, LATCHED),
            ("/world/events", msg.Event(run=run + 1, sequence=1, type="word_cleared", job=77, station=3), MANY),
            ("/world/events", msg.Event(run=run, sequence=AHEAD, type="grabbed", bot=1, bucket=1), MANY),
            ("/world/beat", msg.Beat(run=run, time=1e308, number=1), LATCHED),
            ("/bot_3/path", far, MANY),
            ("/bot_3/path", long, MANY),
            ("/diagnostics", nameless, MANY),
        ]
        publishers = []
        for topic, message, profile in said:
            publisher = person.node.create_publisher(type(message), topic, profile)
            person.wait(lambda p=publisher: p.get_subscription_count() > 0, f"somebody listens to {topic}")
            publisher.publish(message)
            publishers.append(publisher)
        before = words()
        person.wait(lambda: words() >= before + WORDS, "words are completed")
        person.wait(lambda: int(told["world"]["malformed_messages"]) >= 2, "the world has refused both paths")
        assert int(told["word manager"]["foreign_messages"]) > 0
        assert "bytes" in told["world"]["last_malformed"] or "odom" in told["world"]["last_malformed"]
    parts.interrupt(warehouse)
    assert warehouse.returncode == 0
    assert json.loads(summary.read_text())["violations"] == 0
