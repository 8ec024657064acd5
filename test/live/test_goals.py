"""Goals for a bot whose node comes, goes and comes again: each is answered, none waits for nothing."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from rclpy.action.server import ServerGoalHandle
from soup_msgs import action, msg

from soup_live.actions import GoalClient, GoalServer
from soup_live.process import Live
from soup_live.qos import LATCHED
from soup_msgs_py.codes import Code

pytestmark = [pytest.mark.live, pytest.mark.timeout(120)]
PATIENCE_S = 30.0


class Bot:
    """A node with the drive action and a status; it ends drives at once, or never."""

    def __init__(self, live: Live, *, works: bool) -> None:
        self.asked = 0
        self._live, self._works = live, works
        self.node = live.node("bot_7", "/bot_7")
        self.status = self.node.create_publisher(msg.BotStatus, "status", LATCHED)
        self.server = GoalServer(
            live, self.node, action.Drive, "drive", accept=self._accept, cancel=lambda _: None, check=lambda _: None
        )

    def _accept(self, handle: ServerGoalHandle) -> None:
        self.asked += 1
        if self._works:
            self.server.finish(handle, Code.DONE, "is there")

    def leave(self) -> None:
        """Leave the graph."""
        self._live.leave(self.node)


class Asker:
    """Asks the bot for drives, as the fleet does."""

    def __init__(self, live: Live, *, signs: bool) -> None:
        node = live.node("fleet")
        status = live.subscribe(node, msg.BotStatus, "/bot_7/status", lambda _: None, LATCHED)
        self.client = GoalClient(
            live, node, action.Drive, "/bot_7/drive", status.get_publisher_count if signs else None
        )
        self.results: list[Code] = []

    def ask(self, number: int) -> None:
        """Ask for a drive."""
        self.client.send(number, action.Drive.Goal(), lambda _: None, lambda code, _: self.results.append(code))


@pytest.fixture
def live(domain: str) -> Iterator[Live]:
    """A process in the graph of its own domain."""
    assert domain
    with Live("test", guest=True) as live:
        yield live


@pytest.mark.parametrize("signs", [True, False])
def test_a_drive_is_kept_until_the_bot_comes_fails_when_it_goes_and_works_when_it_is_back(live: Live, signs: bool):
    asker = Asker(live, signs=signs)
    live.every(0.05, asker.client.look)
    asker.ask(1)
    assert not asker.client.ready
    bot = Bot(live, works=True)
    assert live.spin(lambda: asker.results == [Code.DONE], PATIENCE_S)
    bot.leave()
    assert live.spin(lambda: not asker.client.ready, PATIENCE_S)
    asker.ask(2)
    idle = Bot(live, works=False)
    assert live.spin(lambda: idle.asked == 1, PATIENCE_S)
    idle.leave()
    assert live.spin(lambda: asker.results == [Code.DONE, Code.STOPPED], PATIENCE_S)
