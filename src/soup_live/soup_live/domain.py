"""One world in a ROS domain: looking before starting a second one, and how far discovery reaches."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator, MutableMapping
from contextlib import contextmanager
from pathlib import Path

from rclpy.node import Node

from soup_live.domain_id import VARIABLE, domain_id
from soup_live.process import Live
from soup_msgs_py import topics
from soup_msgs_py.errors import InputError

DISCOVERY_S = 1.5  # a participant announces itself to its neighbours several times in this time
RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
PROFILES = "FASTRTPS_DEFAULT_PROFILES_FILE"
LOCALHOST_ONLY = "ROS_LOCALHOST_ONLY"  # of older ROS; 1 means this machine, 0 the network
# by which a person says that others than this machine are meant, or how processes find each other
OTHERS = (RANGE, PROFILES, "ROS_STATIC_PEERS", "ROS_DISCOVERY_SERVER")
TRANSPORTS = "FASTDDS_BUILTIN_TRANSPORTS"
RMW = "RMW_IMPLEMENTATION"
FAST_DDS = ("rmw_fastrtps_cpp", "rmw_fastrtps_dynamic_cpp")
THIS_MACHINE = Path(__file__).parent / "this_machine.xml"
MOST_LOCAL = 100  # participants that see each other with these profiles
LEFT_TO_OTHERS = 10  # of them, for tools and for programs of the person's own


def stay_on_this_machine(processes: int = 1, environment: MutableMapping[str, str] = os.environ) -> None:
    """Keep a warehouse to this machine, unless the person says otherwise.

    Two people on one network do not meet each other's robots this way. To spread the parts over machines,
    set ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET for all of them. Nobody shares memory: a process that is killed may hold
    what others wait for, and would leave files behind. Messages are as quick without. Another implementation of DDS
    reads none of these profiles: it is told the same in the words that all of them know.

    Raises:
        InputError: There are too many processes to find each other on one machine.
    """
    environment.setdefault(TRANSPORTS, "UDPv4")
    if any(environment.get(name) for name in OTHERS) or environment.get(LOCALHOST_ONLY) == "0":
        return
    if processes > MOST_LOCAL - LEFT_TO_OTHERS:
        allowed = f"at most {MOST_LOCAL - LEFT_TO_OTHERS} on one machine, more with a discovery server (docs/hosts.md)"
        raise InputError("processes", "", processes, allowed)
    environment.pop(LOCALHOST_ONLY, None)  # it would outdo the profiles
    if (environment.get(RMW) or FAST_DDS[0]) in FAST_DDS:
        environment[RANGE] = "SUBNET"
        environment[PROFILES] = str(THIS_MACHINE)
    else:
        environment[RANGE] = "LOCALHOST"


@contextmanager
def only_world(live: Live, node: Node, *, look: bool = True) -> Iterator[None]:
    """Be the domain's only world for as long as the context lasts; enter it before publishing the clock.

    Args:
        live: The process.
        node: A node of it.
        look: Whether to look for worlds on other machines. One that was killed a moment ago is still seen.

    Raises:
        InputError: There is another one.
    """
    with _claim():
        if look:
            _refuse_world_elsewhere(live, node)
        yield


def refuse_second_world(live: Live, node: Node) -> None:
    """Make sure that there is no world in this domain yet.

    Raises:
        InputError: There is one.
    """
    with _claim():
        _refuse_world_elsewhere(live, node)


def _refuse_world_elsewhere(live: Live, node: Node) -> None:
    """Look for a world on other machines, as far as discovery reaches in a moment."""
    if live.spin(lambda: node.count_publishers(topics.CLOCK) > 0, DISCOVERY_S):
        raise _another_world()


@contextmanager
def _claim() -> Iterator[None]:
    """Hold this machine's name for the world of the domain.

    Discovery takes as long as a busy machine lets it. A socket in Linux's abstract namespace is there at once,
    is gone with its process however that ends, and leaves no file.
    """
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as name:
        try:
            name.bind(f"\0alphabet-soup/world/{domain_id()}")
        except OSError as error:
            raise _another_world() from error
        yield


def _another_world() -> InputError:
    return InputError(VARIABLE, "", f"another world in domain {domain_id()}", "a domain of its own for each world")
