"""One world in a ROS domain: looking before starting a second one, and how far discovery reaches."""

from __future__ import annotations

import os
from collections.abc import MutableMapping

from rclpy.node import Node

from soup_msgs_py import topics
from soup_msgs_py.errors import InputError
from soup_msgs_py.live.process import Live

DISCOVERY_S = 1.5  # a participant announces itself to its neighbours several times in this time
RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
MOST_LOCAL = 32  # participants that see each other with the range LOCALHOST


def stay_on_this_machine(processes: int = 1, environment: MutableMapping[str, str] = os.environ) -> None:
    """Keep a warehouse to this machine, unless the person says otherwise or it has too many processes.

    Two people on one network do not meet each other's robots this way. To spread the parts over machines,
    set ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET for all of them.
    """
    if processes < MOST_LOCAL - 4:
        environment.setdefault(RANGE, "LOCALHOST")


def refuse_second_world(live: Live, node: Node) -> None:
    """Make sure that there is no world in this domain yet; call it before publishing the clock.

    Raises:
        InputError: There is one.
    """
    if live.spin(lambda: node.count_publishers(topics.CLOCK) > 0, DISCOVERY_S):
        domain = os.environ.get("ROS_DOMAIN_ID", "0")
        raise InputError("ROS_DOMAIN_ID", "", f"another world in domain {domain}", "a domain of its own for each world")
