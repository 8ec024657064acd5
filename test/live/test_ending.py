"""A part that is told to end, or has lost its starter, is gone within seconds, whatever holds it."""

from __future__ import annotations

import contextlib
import signal
from pathlib import Path

import pytest
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import QoSProfile
from soup_msgs import action
from std_msgs.msg import String

from soup_live.actions import GoalClient, GoalServer
from soup_live.process import Live
from soup_live.raw import RawSubscription

from .conftest import Parts, wait_until

pytestmark = [pytest.mark.live, pytest.mark.timeout(120)]
HERE = Path(__file__).parent


PROCESSES = 12  # chaos, the warehouse and what forks and guards it, the world, three managers, four for bots
BY_THE_KERNEL = {-signal.SIGPROF, -signal.SIGALRM}  # the latter on a machine that has no time for who spins


@pytest.mark.parametrize(
    ("where", "statuses"), [("static destructors", BY_THE_KERNEL), ("farewell", BY_THE_KERNEL), ("callback", {1})]
)
def test_a_part_that_spins_is_gone_soon_after_it_was_told_to_end(
    parts: Parts, tmp_path: Path, where: str, statuses: set[int]
):
    ready = tmp_path / "ready"
    part = parts.run_file(HERE / "spinning_part.py", where, str(ready))
    wait_until(lambda: ready.exists() or part.poll() is not None, "the part is at work")
    parts.interrupt(part, signal.SIGTERM)
    assert part.returncode in statuses


@pytest.mark.parametrize("where", ["static destructors", "native callback"])
def test_a_part_that_spins_does_not_outlive_a_starter_that_was_killed(parts: Parts, tmp_path: Path, where: str):
    ready = tmp_path / "ready"
    starter = parts.run_file(HERE / "spinner_starter.py", where, str(ready))
    wait_until(lambda: ready.exists() or starter.poll() is not None, "the part is at work")
    starter.kill()
    assert parts.all_gone()


def test_what_tests_have_started_does_not_outlive_tests_that_are_killed(parts: Parts):
    tests = parts.run_file(HERE / "killed_tests.py")
    wait_until(lambda: len(parts.alive()) == 2 or tests.poll() is not None, "the part is there")
    tests.kill()
    assert tests.wait() == -signal.SIGKILL
    assert parts.all_gone()


def test_chaos_that_is_killed_leaves_no_warehouse(parts: Parts):
    chaos = parts.start("chaos.py", "--set", "bots=4")
    wait_until(lambda: len(parts.alive()) >= PROCESSES or chaos.poll() is not None, "the warehouse is there")
    chaos.kill()
    assert chaos.wait() == -signal.SIGKILL
    assert parts.all_gone()


def threads_of_dds() -> list[str]:
    """What listens for a participant of this process."""
    names = []
    for task in Path("/proc/self/task").iterdir():
        with contextlib.suppress(OSError):  # it has ended meanwhile
            names.append((task / "comm").read_text().strip())
    return [name for name in names if name.startswith("dds.udp")]


def test_who_has_left_the_graph_has_left_dds(domain: str):
    assert domain
    with Live("test", guest=True) as live:
        node = live.node("test")
        everything = [
            GoalServer(live, node, action.Drive, "drive", accept=print, cancel=print, check=print),
            GoalClient(live, node, action.Drive, "drive"),
            live.subscribe(node, String, "words", print, QoSProfile(depth=1)),
            RawSubscription(
                live, node, String, "words", print, QoSProfile(depth=1), SubscriptionEventCallbacks(matched=print)
            ),
        ]
        live.spin(timeout_s=0.5)
        assert threads_of_dds()
    assert not threads_of_dds()
    assert everything  # even where somebody keeps it
