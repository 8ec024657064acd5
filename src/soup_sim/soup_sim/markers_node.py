"""What RViz and Foxglove show of the warehouse: a few big markers, drawn by the world's node."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from rclpy.node import Node
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from soup_live.qos import SHOWN_LATCHED
from soup_msgs_py import topics
from soup_msgs_py.codes import BotState
from soup_msgs_py.messages import Bots, Buckets
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Layout
from soup_msgs_py.wire import to_stamp

FLOOR = ColorRGBA(r=0.93, g=0.93, b=0.91, a=1.0)
SPOT = ColorRGBA(r=0.80, g=0.80, b=0.78, a=1.0)
WORD_STATION = ColorRGBA(r=0.10, g=0.45, b=0.75, a=1.0)
LETTER_STATION = ColorRGBA(r=0.10, g=0.60, b=0.35, a=1.0)
BUCKET = ColorRGBA(r=0.55, g=0.45, b=0.35, a=1.0)
INK = ColorRGBA(r=0.1, g=0.1, b=0.1, a=1.0)
BOT = {
    BotState.FREE: ColorRGBA(r=0.55, g=0.60, b=0.68, a=1.0),
    BotState.MOVING: ColorRGBA(r=0.95, g=0.60, b=0.10, a=1.0),
    BotState.GRABBING: ColorRGBA(r=0.60, g=0.35, b=0.75, a=1.0),
    BotState.RELEASING: ColorRGBA(r=0.60, g=0.35, b=0.75, a=1.0),
    BotState.TRANSFERRING: ColorRGBA(r=0.10, g=0.65, b=0.70, a=1.0),
    BotState.PENALISED: ColorRGBA(r=0.85, g=0.15, b=0.15, a=1.0),
}
BOT_HEIGHT, BUCKET_HEIGHT, TEXT_HEIGHT = 0.3, 0.9, 2.0  # m


class Markers:
    """Draws the warehouse while somebody looks."""

    def __init__(self, node: Node, scenario: Scenario, layout: Layout) -> None:
        """Make the publisher, and everything that never moves."""
        self._publisher = node.create_publisher(MarkerArray, topics.MARKERS, SHOWN_LATCHED)
        self._scenario = scenario
        self._still = list(self._draw_still(layout))

    def publish(self, bots: Bots, buckets: Buckets) -> None:
        """Draw the warehouse as it is now."""
        if self._publisher.get_subscription_count() == 0:
            return
        header = Header(stamp=to_stamp(bots.time), frame_id=topics.FRAME)
        markers = [*self._still, *self._draw_moving(bots, buckets)]
        for marker in markers:
            marker.header = header
        self._publisher.publish(MarkerArray(markers=markers))

    def _draw_still(self, layout: Layout) -> Iterable[Marker]:
        width, height = float(layout.width_m), float(layout.height_m)
        floor = _marker("floor", Marker.CUBE, (width, height, 0.02), FLOOR)
        floor.pose.position = Point(x=width / 2, y=height / 2, z=-0.02)
        yield floor
        side = 2.0 * self._scenario.bucket.radius_m
        spots = _marker("storage spots", Marker.CUBE_LIST, (0.5 * side, 0.5 * side, 0.01), SPOT)
        spots.points = _points(*_columns(layout.waypoints[layout.storage_spots]), 0.0)
        yield spots
        for name, colour, waypoints in (
            ("word stations", WORD_STATION, layout.word_stations),
            ("letter stations", LETTER_STATION, layout.letter_stations),
        ):
            stations = _marker(name, Marker.CUBE_LIST, (1.5 * side, 1.5 * side, 0.05), colour)
            stations.points = _points(*_columns(layout.waypoints[waypoints]), 0.0)
            yield stations
        for station in range(len(layout.stations)):
            x, y = layout.station_xy(station)
            label = _marker("station names", Marker.TEXT_VIEW_FACING, (0.0, 0.0, 0.8), INK, station)
            label.pose.position = Point(x=x, y=y, z=TEXT_HEIGHT)
            label.text = layout.station_name(station)
            yield label

    def _draw_moving(self, bots: Bots, buckets: Buckets) -> Iterable[Marker]:
        side = 2.0 * self._scenario.bucket.radius_m
        boxes = _marker("buckets", Marker.CUBE_LIST, (0.7 * side, 0.7 * side, 0.6), BUCKET)
        boxes.points = _points(buckets.x, buckets.y, BUCKET_HEIGHT)
        yield boxes
        size = 2.0 * self._scenario.bot.radius_m
        bodies = _marker("bots", Marker.SPHERE_LIST, (size, size, 0.4 * size), INK)
        bodies.points = _points(bots.x, bots.y, BOT_HEIGHT)
        bodies.colors = [BOT[BotState(state)] for state in bots.state.tolist()]
        yield bodies
        headings = _marker("headings", Marker.LINE_LIST, (0.12 * size, 0.0, 0.0), INK)
        tips = _points(
            bots.x + 0.6 * size * np.cos(bots.heading),
            bots.y + 0.6 * size * np.sin(bots.heading),
            BOT_HEIGHT + 0.3 * size,
        )
        middles = _points(bots.x, bots.y, BOT_HEIGHT + 0.3 * size)
        headings.points = [point for pair in zip(middles, tips, strict=True) for point in pair]
        yield headings


def _marker(name: str, kind: int, scale: tuple[float, float, float], colour: ColorRGBA, number: int = 0) -> Marker:
    x, y, z = scale
    pose = Pose(orientation=Quaternion(w=1.0))
    return Marker(
        ns=name,
        id=number,
        type=kind,
        action=Marker.ADD,
        scale=Vector3(x=x, y=y, z=z),
        color=colour,
        pose=pose,
    )


def _columns(places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return places[:, 0], places[:, 1]


def _points(x: np.ndarray, y: np.ndarray, z: float) -> list[Point]:
    return [Point(x=float(a), y=float(b), z=z) for a, b in zip(x.tolist(), y.tolist(), strict=True)]
