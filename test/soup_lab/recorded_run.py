"""A lawful run of a warehouse, recorded in one process: all that a summary of its bag is made of."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from pathlib import Path

from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock

from soup_lab.bags.interfaces import Definitions
from soup_lab.bags.record_node import offered
from soup_lab.bags.writer import BagWriter, Topic
from soup_lab.headless.simulation import Headless
from soup_live.qos import LATCHED
from soup_msgs_py import topics
from soup_msgs_py.messages import Event, WorldState
from soup_msgs_py.policies import load_policies
from soup_msgs_py.wire import Announcement, to_ros, to_ros_of, to_stamp, to_statistics
from soup_sim.checkpoint import make_checkpoint
from soup_sim.scenario_loader import load_warehouse

CONFIG = Path(__file__).resolve().parents[2] / "config"
BEGIN = 1_790_000_000_000_000_000  # ns since 1970
SPEED, RUN = 5, 7
POSES_S, SNAPSHOT_S = 0.5, 5.0
KINDS = {
    topics.SCENARIO: "Scenario", topics.SNAPSHOT: "Snapshot", topics.BOTS: "Bots", topics.BUCKETS: "Buckets",
    topics.EVENTS: "Event", topics.STATISTICS: "Statistics", topics.STATE: "WorldState",
}  # fmt: skip
DEFINITIONS = Definitions()
QOS = offered(LATCHED)
Said = tuple[str, int, bytes]  # topic, time (ns since 1970), serialized message


@cache
def recorded(until: float = 80.0) -> tuple[Said, ...]:
    """What a world of the demonstration says up to a simulated time (s)."""
    warehouse = load_warehouse(CONFIG / "scenarios/demo.yaml", [])
    world = warehouse.world(1)
    said: list[Said] = []

    def say(name: str, message: object) -> None:
        said.append((name, BEGIN + round(world.now * 1e9 / SPEED), serialize_message(message)))

    def on_event(event: Event) -> None:
        say(topics.EVENTS, to_ros_of(RUN, event))

    def tell_all() -> None:
        say(topics.STATISTICS, to_statistics(world.now, world.statistics(world.now / SPEED)))
        say(topics.STATE, to_ros(WorldState(world.now, RUN, world.sequence, make_checkpoint(world))))
        say(topics.SNAPSHOT, to_ros_of(RUN, world.snapshot()))

    announcement = Announcement(0.0, world.scenario, world.layout, tuple(world.tile_profile), RUN, 1, 0.0)
    say(topics.SCENARIO, to_ros(announcement))
    tell_all()
    run = Headless(world, load_policies(CONFIG / "policies/best.yaml", {}), 1, on_event)
    while world.now < until:
        run.run(min(until, world.now + POSES_S))
        say(topics.CLOCK, Clock(clock=to_stamp(world.now)))
        say(topics.BUCKETS, to_ros_of(RUN, world.buckets()))
        say(topics.BOTS, to_ros_of(RUN, world.bots()))
        if world.now % SNAPSHOT_S == 0.0 or world.now >= until:
            tell_all()
    return tuple(said)


def write_bag(folder: Path, said: Iterable[Said], *, flush_every: int = 100) -> BagWriter:
    """A bag of what was said; a chunk of it holds so many messages. It is not closed."""
    writer = BagWriter.create(folder)
    numbers: dict[str, int] = {}
    for k, (name, at, cdr) in enumerate(said):
        if name not in numbers:
            kind = f"soup_msgs/msg/{KINDS[name]}" if name in KINDS else "rosgraph_msgs/msg/Clock"
            numbers[name] = writer.add(Topic(name, kind, *DEFINITIONS.of(kind), QOS))
        writer.write(numbers[name], at, cdr)
        if k % flush_every == flush_every - 1:
            writer.flush()
    return writer
