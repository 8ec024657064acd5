"""The world's node: carries requests to the world and tells everybody what happens, at the pace asked for."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from typing import Any

from geometry_msgs.msg import Twist
from nav_msgs.msg import Path as RosPath
from rclpy.duration import Duration
from rosgraph_msgs.msg import Clock
from soup_msgs import msg, srv

from soup_live.diagnostics import WAITS, PartsWatch, Report
from soup_live.process import Live
from soup_live.qos import COMMANDS, EVERY_ONE, LATCHED, SHOWN
from soup_live.services import Answer, serve
from soup_live.vacancies import Vacancies
from soup_msgs_py import topics
from soup_msgs_py.messages import BotReply, Event, Heard, Reply, WorldState
from soup_msgs_py.mind import NEVER, Message
from soup_msgs_py.policies import Policies, policies_of
from soup_msgs_py.wire import (
    Announcement,
    assign_bundle_response,
    assign_word_response,
    from_bot_request,
    from_path,
    from_ros,
    from_twist,
    storage_spot_response,
    to_ros,
    to_ros_of,
    to_stamp,
    to_statistics,
)
from soup_sim.checkpoint import make_checkpoint
from soup_sim.checkpoint_keeper import CheckpointKeeper
from soup_sim.lockstep import Lockstep
from soup_sim.markers_node import Markers
from soup_sim.pacing import Pacer
from soup_sim.run_recorder import RunRecorder
from soup_sim.time_services import TimeServices
from soup_sim.world import World

TICK_S = 0.01  # wall time between two looks at the pace
CLOCK_S = 0.04  # wall time between two ticks of /clock, and between two beats at most while time goes on
JUDGE_S = 0.2  # wall time between two looks of the judge at where everything is
SLOWEST_POSES_S, FASTEST_POSES_S = 0.1, 1.0 / 30.0  # wall time between two poses
MARKERS_S = 0.25
SNAPSHOT_S = 1.0
STATIONS_S = 0.2
STATISTICS_S = 1.0
STATE_S = 2.0  # wall time between two checkpoints on a topic, where somebody listens
FAREWELL_S = 2.0  # wall time at most, for everybody to get the last messages


class WorldNode:
    """Node `/world`.

    Attributes:
        over: Whether the run has reached its end.
        checkpoints: Keeps the state of the world in files.
    """

    def __init__(
        self, live: Live, node: Any, world: World, pacer: Pacer, record: RunRecorder, parts: Sequence[str] = ()
    ) -> None:
        """Begin to publish and to listen.

        Args:
            live: The process.
            node: The node `world`.
            world: The world itself.
            pacer: How fast it runs, and until when.
            record: Keeps the run's books.
            parts: Who followed the world before it was started again.
        """
        self.over = False
        self._live, self._world, self._pacer, self._record = live, world, pacer, record
        self._refused = 0
        self._rate_from = (0.0, 0.0)
        self._clock = node.create_publisher(Clock, topics.CLOCK, SHOWN)
        self._scenario = node.create_publisher(msg.Scenario, topics.SCENARIO, LATCHED)
        # the newest one alone: a newcomer that began with an older one would lack the events in between
        self._snapshot = node.create_publisher(msg.Snapshot, topics.SNAPSHOT, LATCHED)
        self._bots = node.create_publisher(msg.Bots, topics.BOTS, SHOWN)
        self._buckets = node.create_publisher(msg.Buckets, topics.BUCKETS, SHOWN)
        self._stations = node.create_publisher(msg.Stations, topics.STATIONS, SHOWN)
        self._events = node.create_publisher(msg.Event, topics.EVENTS, EVERY_ONE)
        self._replies = node.create_publisher(msg.BotReply, topics.REPLIES, EVERY_ONE)
        # clocks go on while worlds are started again
        self._lockstep = Lockstep(time.time_ns() // 1000)
        self._lockstep.expect(parts, time.monotonic())
        self._beat = node.create_publisher(msg.Beat, topics.BEAT, LATCHED)
        self._sensed_bots = node.create_publisher(msg.Bots, topics.SENSED_BOTS, SHOWN)
        self._sensed_buckets = node.create_publisher(msg.Buckets, topics.SENSED_BUCKETS, SHOWN)
        self._statistics = node.create_publisher(msg.Statistics, topics.STATISTICS, SHOWN)
        self._state = node.create_publisher(msg.WorldState, topics.STATE, LATCHED)
        self._markers = Markers(node, world.scenario, world.layout)
        self._parts = PartsWatch(live, node)
        self._vacancies = Vacancies(self._parts, world.scenario.bots)
        self._report = Report(live, node)
        self._report.works()
        self._listen(node)
        profile = tuple(map(float, world.tile_profile))
        announcement = Announcement(
            world.now, world.scenario, world.layout, profile, world.run, world.seed, world.warmup_s
        )
        self._scenario.publish(to_ros(announcement))
        self._state_time = -1.0  # of the newest checkpoint on the topic
        self._poses_s = world.scenario.bot.radius_m / world.scenario.bot.max_speed_mps
        self._clock_due = self._poses_due = self._judge_due = 0.0
        self._poses_at = world.now  # simulated time (s) of the next poses, where the pace has a limit
        self._told_time = -1.0  # simulated time (s) of the newest beat
        live.every(TICK_S, self._tick)
        live.every(SNAPSHOT_S, self._publish_snapshot)
        live.every(STATIONS_S, lambda: self._publish(self._stations, world.stations()))
        live.every(STATISTICS_S, self._publish_statistics)
        live.every(STATISTICS_S, self._report_waits)
        live.every(STATE_S, self._publish_state)
        live.every(MARKERS_S, lambda: self._markers.publish(world.bots(), world.buckets()))

    def _listen(self, node: Any) -> None:
        live, bots = self._live, self._world.scenario.bots
        for bot in range(bots):
            velocity, path = topics.bot_topic(bot, topics.CMD_VEL), topics.bot_topic(bot, topics.PATH)
            live.subscribe(node, Twist, velocity, lambda m, bot=bot: self._ask(from_twist(m, bot)), COMMANDS)
            live.subscribe(node, RosPath, path, lambda m, bot=bot: self._ask(from_path(m, bot)), COMMANDS)
        live.subscribe(node, msg.Heard, topics.HEARD, self._on_heard, EVERY_ONE)
        # the last one: who sees it knows that the world listens to the others, too
        live.subscribe(node, msg.BotRequest, topics.REQUESTS, self._on_request, EVERY_ONE)
        serve(live, node, srv.AssignWord, topics.ASSIGN_WORD, self._on_assign_word)
        serve(live, node, srv.AssignBundle, topics.ASSIGN_BUNDLE, self._on_assign_bundle)
        serve(live, node, srv.SetStorageSpot, topics.SET_STORAGE_SPOT, self._on_set_storage_spot)
        self._time = TimeServices(live, node, self._world, self._pacer, self._advance, self._publish_poses)
        self.checkpoints = CheckpointKeeper(live, node, self._world, self._pacer, self._lockstep, self._record)

    @property
    def latency_s(self) -> float:
        """Simulated time that went on without a part or a message that the world had waited for in vain (s)."""
        return self._lockstep.latency_s

    def policies(self) -> Policies:
        """What the parts that are at work say that they follow."""
        return policies_of(self._parts.at_work)

    # ---- time ---------------------------------------------------------------------------------------------

    def _tick(self) -> None:
        self._advance()
        world, wall = self._world, time.monotonic()
        self._report.time = world.now
        if wall >= self._clock_due:
            self._clock_due = wall + CLOCK_S
            self._clock.publish(Clock(clock=to_stamp(world.now)))
            self._tell_time()
        if wall >= self._poses_due:
            self._publish_poses()
        if wall >= self._judge_due:
            self._judge_due = wall + JUDGE_S
            self._record.poses(world.bots(), world.buckets())
        self.checkpoints.look()
        self._time.answer_steps()
        if world.now >= self._pacer.end:
            self.over = True
            self._record.flush()
            self._report.publish()
            self._publish_snapshot()
            self._publish_statistics()
            for publisher in (self._events, self._replies, self._snapshot, self._statistics):
                left = max(0.0, wall + FAREWELL_S - time.monotonic())
                publisher.wait_for_all_acked(Duration(seconds=left))
            self._live.stop()

    def _advance(self) -> None:
        """Go as far as the pace allows, but not past an instant at which something was said that a part has to hear."""
        wall, world, lockstep = time.monotonic(), self._world, self._lockstep
        until = self._pacer.until(wall, world.now, without=bool(lockstep.missing))
        while not lockstep.wait(wall, paused=self._pacer.paused):
            if not lockstep.asked:
                before = world.now
                until_then = min(until, lockstep.next_time, self._poses_at)
                said = world.advance(max(world.now, until_then), pause=True)
                lockstep.went_on(world.now - before)
                self._tell(said)
                if world.now >= self._poses_at:
                    self._publish_poses()
                if not lockstep.asked and world.now < lockstep.next_time:
                    if said or world.now < until:
                        continue  # nobody has to hear it
                    return
            if lockstep.next_time <= world.now:
                self._publish(self._sensed_buckets, world.buckets())
                self._publish(self._sensed_bots, world.bots())
            self._publish_beat(wall)

    def _tell_time(self) -> None:
        """Let parts that nothing has concerned for a while know how late it is; anybody may publish on /clock."""
        wall, now = time.monotonic(), self._world.now
        if now > self._told_time and not self._lockstep.wait(wall, paused=self._pacer.paused):
            self._publish_beat(wall)

    def _publish_beat(self, wall: float) -> None:
        self._told_time = self._world.now
        self._publish(self._beat, self._lockstep.beat(self._told_time, wall, self._world.sequence))

    def _on_heard(self, message: msg.Heard) -> None:
        heard: Heard = from_ros(message)
        if self._is_meant(message.run):
            self._lockstep.hear(heard, time.monotonic())
            self._advance()

    def _on_request(self, message: msg.BotRequest) -> None:
        request = from_bot_request(message, self._world.scenario.bots)
        if self._is_meant(message.run):
            self._ask(request)

    def _is_meant(self, run: int) -> bool:
        """Whether what was said for a run, 0 for the present one, is for this world."""
        return run == 0 or self._live.belongs(run, self._world.run)

    def _ask(self, message: Message) -> Reply | None:
        """Hand a request to the world at the time that it is now; its answer to a manager."""
        self._advance()
        answer = self._tell(self._world.handle(message))
        if self._lockstep.asked:
            self._advance()
        return answer

    def _tell(self, said: list[Event | BotReply | Reply]) -> Reply | None:
        answer = None
        for message in said:
            self._lockstep.tell(message)
            if isinstance(message, Event):
                self._record.event(message)
                self._publish(self._events, message)
            else:
                self._refused += not message.success
                if isinstance(message, BotReply):
                    self._publish(self._replies, message)
                else:
                    answer = message
        return answer

    # ---- services -----------------------------------------------------------------------------------------

    def _on_assign_word(self, request: srv.AssignWord.Request, answer: Answer) -> None:
        reply = self._ask(from_ros(request))
        assert reply is not None
        answer.give(assign_word_response(reply))

    def _on_assign_bundle(self, request: srv.AssignBundle.Request, answer: Answer) -> None:
        reply = self._ask(from_ros(request))
        assert reply is not None
        answer.give(assign_bundle_response(reply))

    def _on_set_storage_spot(self, request: srv.SetStorageSpot.Request, answer: Answer) -> None:
        reply = self._ask(from_ros(request))
        assert reply is not None
        answer.give(storage_spot_response(reply))

    def _publish_poses(self) -> None:
        """Tell where everything is, often enough in simulated time to see the turns of a path, and again after that.

        A machine that is busy does not see less of the run; a world without a limit to its speed goes by wall time.
        """
        wall, world, speed = time.monotonic(), self._world, self._pacer.speed
        if math.isinf(speed):
            self._poses_due, self._poses_at = wall + FASTEST_POSES_S, NEVER
        else:
            period = min(max(self._poses_s, FASTEST_POSES_S * speed), SLOWEST_POSES_S * speed)
            self._poses_due, self._poses_at = wall + SLOWEST_POSES_S, world.now + period
        if self._buckets.get_subscription_count():
            self._publish(self._buckets, world.buckets())
        self._publish(self._bots, world.bots())

    def _publish(self, publisher: Any, message: Any) -> None:
        publisher.publish(to_ros_of(self._world.run, message))

    # ---- now and then -------------------------------------------------------------------------------------

    def _publish_snapshot(self) -> None:
        self._snapshot.publish(to_ros(self._world.snapshot()))

    def _publish_state(self) -> None:
        world = self._world
        if self._state.get_subscription_count() == 0 or world.now == self._state_time:
            return
        self._state_time = world.now
        self._state.publish(to_ros(WorldState(world.now, world.run, world.sequence, make_checkpoint(world))))

    def _report_waits(self) -> None:
        self._report.values[WAITS] = self._lockstep.waited(time.monotonic())
        missing = self._lockstep.missing
        if missing:
            self._report.waits(f"goes on without {', '.join(missing)}: silent for too long")
        elif vacant := self._vacancies.look():
            self._report.waits(vacant)
        elif stalled := self._world.stalled():
            self._report.waits(stalled)
        else:
            self._report.works()

    def _publish_statistics(self) -> None:
        world, wall = self._world, self._pacer.wall_seconds
        figures = world.statistics(wall)
        seconds, since = world.now - self._rate_from[0], wall - self._rate_from[1]
        self._rate_from = world.now, wall
        figures["real_time_factor"] = seconds / since if since > 0.0 else 0.0
        figures["refused_requests"] = self._refused
        figures["malformed_messages"] = self._live.malformed
        figures["violations"] = self._record.violations
        figures["latency_s"] = self._lockstep.latency_s
        self._statistics.publish(to_statistics(world.now, figures))
