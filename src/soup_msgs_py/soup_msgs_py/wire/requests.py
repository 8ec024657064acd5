"""What bots, managers and persons ask of the world and of a bot, and how it is answered."""

from __future__ import annotations

from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Path
from soup_msgs import msg, srv
from std_msgs.msg import Header

from soup_msgs_py import topics
from soup_msgs_py.codes import Code
from soup_msgs_py.messages import (
    AssignBundle,
    AssignWord,
    BotReply,
    FollowPath,
    Grab,
    Release,
    Reply,
    SetStorageSpot,
    SetVelocity,
    TileMove,
    Transfer,
)
from soup_msgs_py.tiles import parse_tile
from soup_msgs_py.wire.basics import (
    MalformedMessage,
    check_finite,
    check_frame,
    fill_result,
    from_moves,
    from_points,
    from_ros,
    from_stamp,
    header_at,
    member,
    not_absurd,
    read_result,
    to_moves,
    to_points,
    to_ros,
    to_stamp,
)


def to_twist(velocity: SetVelocity) -> Twist:
    """A target velocity as what any teleoperation program publishes; frame `map`."""
    twist = Twist()
    twist.linear.x, twist.linear.y = float(velocity.vx), float(velocity.vy)
    twist.angular.z = float(velocity.turn_radps)
    return twist


def from_twist(twist: Twist, bot: int) -> SetVelocity:
    """The target velocity that was published on a bot's topic."""
    vx, vy, turn = twist.linear.x, twist.linear.y, twist.angular.z
    check_finite(vx, vy, turn)
    return SetVelocity(bot, vx, vy, turn)


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


@to_ros.register
def _(request: Grab) -> msg.BotRequest:
    return msg.BotRequest(bot=request.bot, request=request.request, verb=topics.GRAB, bucket=request.bucket, station=-1)


@to_ros.register
def _(request: Release) -> msg.BotRequest:
    return msg.BotRequest(bot=request.bot, request=request.request, verb=topics.RELEASE, bucket=-1, station=-1)


@to_ros.register
def _(request: Transfer) -> msg.BotRequest:
    message = msg.BotRequest(
        bot=request.bot, request=request.request, verb=topics.TRANSFER, bucket=-1, station=request.station
    )
    message.moves = to_moves(request.moves)
    return message


@from_ros.register
def _(request: msg.BotRequest) -> Grab | Release | Transfer:
    match request.verb:
        case topics.GRAB:
            return Grab(request.bot, request.request, request.bucket)
        case topics.RELEASE:
            return Release(request.bot, request.request)
        case topics.TRANSFER:
            return Transfer(request.bot, request.request, request.station, from_moves(request.moves))
    raise MalformedMessage(f"{request.verb[:40]!r} is no verb")


def from_bot_request(request: msg.BotRequest, bots: int) -> Grab | Release | Transfer:
    """What a bot asks of a world that has so many bots."""
    if not 0 <= request.bot < bots:
        raise MalformedMessage(f"bot {request.bot}, there are {bots}")
    return from_ros(request)


@to_ros.register
def _(reply: BotReply) -> msg.BotReply:
    return msg.BotReply(
        stamp=to_stamp(reply.time),
        bot=reply.bot,
        request=reply.request,
        success=reply.success,
        code=reply.code.value,
        message=reply.message,
        x=float(reply.x),
        y=float(reply.y),
    )


@from_ros.register
def _(reply: msg.BotReply) -> BotReply:
    check_finite(reply.x, reply.y)
    code = member(Code, reply.code)
    return BotReply(reply.bot, reply.request, code, reply.message, from_stamp(reply.stamp), reply.x, reply.y)


@to_ros.register
def _(request: AssignWord) -> srv.AssignWord.Request:
    return srv.AssignWord.Request(word=request.word, station=request.station)


@from_ros.register
def _(request: srv.AssignWord.Request) -> AssignWord:
    return AssignWord(request.word, request.station)


@to_ros.register
def _(request: AssignBundle) -> srv.AssignBundle.Request:
    return srv.AssignBundle.Request(station=request.station, bundle=request.bundle, tile=request.tile)


@from_ros.register
def _(request: srv.AssignBundle.Request) -> AssignBundle:
    return AssignBundle(request.station, request.bundle, request.tile)


@to_ros.register
def _(request: SetStorageSpot) -> srv.SetStorageSpot.Request:
    return srv.SetStorageSpot.Request(waypoint=request.waypoint, storage=request.storage)


@from_ros.register
def _(request: srv.SetStorageSpot.Request) -> SetStorageSpot:
    return SetStorageSpot(request.waypoint, request.storage)


def assign_word_response(reply: Reply) -> srv.AssignWord.Response:
    """The world's answer to the word manager."""
    return fill_result(srv.AssignWord.Response(), reply.code, reply.message)


def assign_bundle_response(reply: Reply) -> srv.AssignBundle.Response:
    """The world's answer to the letter manager."""
    return fill_result(srv.AssignBundle.Response(bundle=reply.number), reply.code, reply.message)


def storage_spot_response(reply: Reply) -> srv.SetStorageSpot.Response:
    """The world's answer to who changes its storage spots."""
    return fill_result(srv.SetStorageSpot.Response(), reply.code, reply.message)


@from_ros.register
def _(response: srv.AssignWord.Response) -> Reply:
    return Reply(*read_result(response))


@from_ros.register
def _(response: srv.SetStorageSpot.Response) -> Reply:
    return Reply(*read_result(response))


@from_ros.register
def _(response: srv.AssignBundle.Response) -> Reply:
    return Reply(*read_result(response), response.bundle)


def grab_by_hand(request: srv.Grab.Request, bot: int, token: int) -> Grab:
    """A person's call of a bot's grab service."""
    return Grab(bot, token, request.bucket)


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
