"""The one place that turns dataclasses into ROS messages and back.

`to_ros` and `from_ros` cover what corresponds one to one; the other functions take what the message itself
does not hold (the bot that a topic belongs to, the number of an action's goal). What comes from the wire is
not trusted: numbers that are none, lengths that do not fit, unknown words, absurd sizes raise `MalformedMessage`.
"""

from __future__ import annotations

from soup_msgs_py.wire.announcement import Announcement, from_statistics, to_statistics
from soup_msgs_py.wire.basics import MalformedMessage, fill_result, from_stamp, read_cdr, read_result, to_stamp
from soup_msgs_py.wire.codec import from_cdr, from_ros, to_ros, to_ros_of
from soup_msgs_py.wire.requests import (
    from_bot_request,
    from_path,
    from_twist,
    to_path,
    to_twist,
    transfer_by_hand,
)
from soup_msgs_py.wire.rows import (
    MOST_ORDERS,
    assign_bundle_response,
    assign_word_response,
    drive_goal,
    grab_by_hand,
    storage_spot_response,
    task_feedback,
    to_order,
    to_outcome,
    trip_goal,
)

__all__ = [
    "MOST_ORDERS",
    "Announcement",
    "MalformedMessage",
    "assign_bundle_response",
    "assign_word_response",
    "drive_goal",
    "fill_result",
    "from_bot_request",
    "from_cdr",
    "from_path",
    "from_ros",
    "from_stamp",
    "from_statistics",
    "from_twist",
    "grab_by_hand",
    "read_cdr",
    "read_result",
    "storage_spot_response",
    "task_feedback",
    "to_order",
    "to_outcome",
    "to_path",
    "to_ros",
    "to_ros_of",
    "to_stamp",
    "to_statistics",
    "to_twist",
    "transfer_by_hand",
    "trip_goal",
]
