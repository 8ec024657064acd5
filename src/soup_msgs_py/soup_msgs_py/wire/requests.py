"""What a bot and a person ask in messages that are not ours, or not in our words."""

from __future__ import annotations

from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Path
from soup_msgs import msg, srv
from std_msgs.msg import Header

from soup_msgs_py import topics
from soup_msgs_py.messages import FollowPath, Grab, Release, SetVelocity, TileMove, Transfer
from soup_msgs_py.warehouse.tiles import parse_tile
from soup_msgs_py.wire.basics import (
    MalformedMessage,
    check_frame,
    finite,
    from_points,
    from_stamp,
    header_at,
    not_absurd,
    to_points,
)
from soup_msgs_py.wire.codec import from_ros


def to_twist(velocity: SetVelocity) -> Twist:
    """A target velocity as what any teleoperation program publishes; frame `map`."""
    twist = Twist()
    twist.linear.x, twist.linear.y = float(velocity.vx), float(velocity.vy)
    twist.angular.z = float(velocity.turn_radps)
    return twist


def from_twist(twist: Twist, bot: int) -> SetVelocity:
    """The target velocity that was published on a bot's topic."""
    return SetVelocity(bot, finite(twist.linear.x), finite(twist.linear.y), finite(twist.angular.z))


def to_path(path: FollowPath) -> Path:
    """A path; its stamp in nanoseconds is the request's number, the stamps of its poses are the times."""
    seconds, nanoseconds = divmod(path.request, 1_000_000_000)
    header = Header(stamp=Time(sec=seconds, nanosec=nanoseconds), frame_id=topics.FRAME)
    poses = []
    for index, point in enumerate(to_points(path.points)):
        pose = PoseStamped(header=header_at(path.stamps[index] if path.stamps else 0.0))
        pose.pose.position = point
        poses.append(pose)
    return Path(header=header, poses=poses)


def from_path(path: Path, bot: int) -> FollowPath:
    """The path that was published on a bot's topic; without any stamp: as soon as possible."""
    for header in (path.header, *(pose.header for pose in not_absurd(path.poses))):
        check_frame(header.frame_id)
    stamps = tuple(from_stamp(pose.header.stamp) for pose in path.poses)
    points = from_points([pose.pose.position for pose in path.poses])
    if not points:
        raise MalformedMessage("a path without a point")
    request = path.header.stamp.sec * 1_000_000_000 + path.header.stamp.nanosec
    return FollowPath(bot, request, points, stamps if any(stamps) else ())


def from_bot_request(request: msg.BotRequest, bots: int) -> Grab | Release | Transfer:
    """What a bot asks of a world that has so many bots."""
    if not 0 <= request.bot < bots:
        raise MalformedMessage(f"bot {request.bot}, there are {bots}")
    return from_ros(request)


def transfer_by_hand(request: srv.Transfer.Request, bot: int, token: int) -> Transfer:
    """A person's call of a bot's transfer service.

    Raises:
        MalformedMessage: The tile is not written as a letter and the number of its colour.
    """
    try:
        tile = parse_tile(request.tile)
    except ValueError as error:
        raise MalformedMessage(str(error)) from error
    if tile >= 2**31:
        raise MalformedMessage(f"{request.tile!r} is a colour that no message can hold")
    return Transfer(bot, token, request.station, (TileMove(tile, request.job),))
