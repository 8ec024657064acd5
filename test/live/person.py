"""A person's own ROS program: plain rclpy, nothing of the warehouse but its messages."""

from __future__ import annotations

import gc
import math
import time
from typing import Any

import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from soup_msgs import msg

NEWEST = QoSProfile(depth=1)
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
PATIENCE_S = 240.0


class Person:
    """One node, asking and waiting. Use it as a context manager."""

    def __init__(self) -> None:
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        self.node = Node("person", context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self.heard: dict[str, Any] = {}

    def __enter__(self) -> Person:
        return self

    def __exit__(self, *_: object) -> None:
        self._executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown(context=self._context)
        gc.collect()  # the participant leaves the graph when nothing refers to it any more

    def listen(self, kind: type, topic: str, latched: bool = False) -> None:
        """Keep the newest message of a topic in `heard`."""
        profile = LATCHED if latched else NEWEST
        self.node.create_subscription(kind, topic, lambda message: self.heard.__setitem__(topic, message), profile)

    def wait(self, condition: Any, what: str) -> None:
        """Spin until something is so."""
        deadline = time.monotonic() + PATIENCE_S
        while not condition():
            assert time.monotonic() < deadline, f"waited in vain: {what}"
            self._executor.spin_once(timeout_sec=0.05)

    def call(self, kind: Any, name: str, **request: Any) -> Any:
        """Call a service and wait for its answer."""
        client = self.node.create_client(kind, name)
        self.wait(client.service_is_ready, f"service {name}")
        future = client.call_async(kind.Request(**request))
        self.wait(future.done, f"the answer of {name}")
        return future.result()

    def nodes(self) -> set[str]:
        """All nodes of the graph but this one, with their namespaces."""
        names = self.node.get_node_names_and_namespaces()
        return {f"{space.rstrip('/')}/{name}" for name, space in names} - {"/person"}

    def place(self, bot: int) -> tuple[float, float]:
        """Where a bot is."""
        self.heard.pop("/world/bots", None)
        self.wait(lambda: "/world/bots" in self.heard, "/world/bots")
        bots: msg.Bots = self.heard["/world/bots"]
        return bots.x[bot], bots.y[bot]

    def drive(self, bot: int, x: float, y: float, within: float) -> None:
        """Steer a bot to a place by cmd_vel, as a joystick would, and stop there."""
        steering = self.node.create_publisher(Twist, f"/bot_{bot}/cmd_vel", 10)
        self.wait(lambda: steering.get_subscription_count() > 0, "the world listens to cmd_vel")
        deadline = time.monotonic() + PATIENCE_S
        calm = 0
        while calm < 3:
            assert time.monotonic() < deadline, f"bot {bot} never got to ({x}, {y})"
            dx, dy = (goal - is_at for goal, is_at in zip((x, y), self.place(bot), strict=True))
            away = math.hypot(dx, dy)
            calm = calm + 1 if away < within else 0
            speed = 0.0 if away < within else min(away, 3.0)
            twist = Twist()
            twist.linear.x, twist.linear.y = speed * dx / max(away, 1e-9), speed * dy / max(away, 1e-9)
            steering.publish(twist)
        self.node.destroy_publisher(steering)
