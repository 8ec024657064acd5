"""The failure detector: which bots do what they were asked for; who died or is silent, forgot it, or went wrong."""

from __future__ import annotations

from collections.abc import Sequence

from soup_managers.state.robots import Activity, Robot
from soup_msgs_py.codes import Phase
from soup_msgs_py.messages import BotStatus
from soup_msgs_py.mind import NEVER

HEARD_S = 0.01  # after its departure at the latest, a bot must have said that it drives
ANSWER_S = 0.5  # so long it may think before it says so
RESULT_LATE_S = 1.0  # after a bot has said that it is idle, the result of what it did is waited for so long
SILENT_S = 10.0  # a bot that has never said anything and has stood for so long is taken for dead
STRANGE_S = 30.0  # the same for one that works for somebody else


class Liveness:
    """The fleet's books about bots that it can't rely on.

    Attributes:
        unplaced: Bots of which it is not known yet where they will stand: they may be on their way for others.
        lost: Bots that are left alone, until they say that they are idle and are seen where they stand.
    """

    def __init__(self, robots: Sequence[Robot]) -> None:
        """Begin with bots that have said nothing."""
        self._robots = robots
        self.unplaced: dict[int, Robot] = {robot.number: robot for robot in robots}
        self.lost: dict[int, Robot] = {}
        self._spoke: set[int] = set()
        self._idle_at: dict[int, float] = {}  # whose newest status says that they stand idle, and since when (s)
        self._unheard: dict[int, float] = {}  # until when bots may confirm their drives
        self._stopping: dict[int, float] = {}  # until when bots that were told to stop may say that they have
        self._doubted: dict[int, float] = {}  # until when results of bots that are idle may come
        self._struck: dict[int, float] = {}  # until when bots may tell that a collision has stopped them
        self._stood: dict[int, tuple[float, float, float]] = {}  # unplaced bots: since when, and where, they stand

    @property
    def next_time(self) -> float:
        """When somebody is overdue next (s)."""
        return min((*self._unheard.values(), *self._doubted.values(), *self._stopping.values()), default=NEVER)

    @property
    def wants_places(self) -> bool:
        """Whether the fleet has to see where bots stand."""
        return bool(self.unplaced or self._struck) or any(bot in self._idle_at for bot in self.lost)

    @property
    def silent(self) -> set[int]:
        """Lost bots that have not said yet that they are idle."""
        return self.lost.keys() - self._idle_at.keys()

    def idle_since(self, bot: int, now: float) -> float:
        """When a bot said that it stands idle, if that was its newest status; else now (s)."""
        return min(self._idle_at.get(bot, now), now)

    # ---- what bots are asked for and say -----------------------------------------------------------------------

    def asked(self, robot: Robot, now: float, depart: float) -> None:
        """A bot was asked to drive."""
        self._doubted.pop(robot.number, None)
        self._unheard[robot.number] = min(depart, now + ANSWER_S) + HEARD_S

    def told_to_stop(self, robot: Robot, now: float) -> float:
        """A bot was told to stop on its way; by when it says so (s), if it hears."""
        self._stopping[robot.number] = now + ANSWER_S
        return self._stopping[robot.number]

    def collided(self, bots: Sequence[int], now: float) -> None:
        """A collision has stopped bots on their way, also those for which nobody answers."""
        for bot in bots:
            if bot in self.silent:
                self._struck[bot] = now
            elif self._robots[bot].activity is Activity.DRIVES:
                self._struck[bot] = now + ANSWER_S

    def struck(self, seen_at: float) -> list[Robot]:
        """Bots that have not told that a collision stopped them, and were seen since; they are told of once."""
        return self._over(self._struck, seen_at)

    def heard(self, status: BotStatus, now: float) -> None:
        """A bot said what it does."""
        bot = status.bot
        self._struck.pop(bot, None)
        self._spoke.add(bot)
        if status.phase is not Phase.IDLE:
            self._idle_at.pop(bot, None)
            self._doubted.pop(bot, None)
            if status.phase is Phase.DRIVING:
                self._unheard.pop(bot, None)
            return
        self._idle_at[bot] = status.time
        robot = self._robots[bot]
        busy = robot.activity is Activity.DRIVES or robot.activity is Activity.WORKS
        if busy and bot not in self._unheard and status.time >= robot.asked_at:
            self._doubted[bot] = now + RESULT_LATE_S

    def ended(self, robot: Robot) -> bool:
        """The result of what a bot was asked for is there; whether it had said that it began."""
        self._doubted.pop(robot.number, None)
        self._stopping.pop(robot.number, None)
        return self._unheard.pop(robot.number, None) is None

    def overdue(self, now: float) -> list[Robot]:
        """Bots that have not confirmed their drives, or are idle though no result has come."""
        late = [bot for bot, until in (*self._unheard.items(), *self._doubted.items()) if until <= now]
        return [self._robots[bot] for bot in sorted(set(late))]

    def deaf(self, now: float) -> list[Robot]:
        """Bots that have not said that they stopped; they are told of once."""
        return self._over(self._stopping, now)

    def _over(self, until: dict[int, float], now: float) -> list[Robot]:
        """Take those out whose time is over."""
        over = sorted(bot for bot, end in until.items() if end <= now)
        for bot in over:
            del until[bot]
        return [self._robots[bot] for bot in over]

    # ---- bots that are lost and found ----------------------------------------------------------------------

    def lose(self, robot: Robot, now: float) -> None:
        """Leave a bot alone."""
        robot.is_lost(now)
        self._stopping.pop(robot.number, None)
        self.unplaced.pop(robot.number, None)
        self.lost[robot.number] = robot

    def placed(self, bot: int) -> None:
        """It is known where a bot will stand."""
        self.unplaced.pop(bot, None)
        self.lost.pop(bot, None)

    def forget_idle(self, robot: Robot) -> None:
        """What a bot said before it was asked for something counts no more: it did not answer that."""
        if self._idle_at.get(robot.number, NEVER) <= robot.asked_at:
            self._idle_at.pop(robot.number, None)  # nobody has asked one that drives for an earlier fleet

    def gone(self, bot: int) -> None:
        """Nobody answers for a bot until it speaks again."""
        self._idle_at.pop(bot, None)

    def found(self, now: float, seen_at: float) -> list[Robot]:
        """Lost bots that can be used again, as places of all bots were seen at `seen_at`; they are lost no more."""
        if not self.lost:
            return []
        found = [
            robot
            for bot, robot in self.lost.items()
            if bot in self._idle_at and seen_at >= robot.failed_at and now >= max(robot.retry_at, robot.arrives)
        ]
        for robot in found:
            del self.lost[robot.number]
        return found

    def dead(self, places: Sequence[tuple[float, float]], now: float) -> list[Robot]:
        """Unplaced bots that have stood still for so long that nobody can be behind them.

        Args:
            places: Where every bot is (m).
            now: When that was seen (s).
        """
        dead = []
        for bot, robot in self.unplaced.items():
            x, y = places[bot]
            since, *before = self._stood.get(bot, (now, x, y))
            if before != [x, y]:
                since = now
            self._stood[bot] = since, x, y
            if now - since >= (STRANGE_S if bot in self._spoke else SILENT_S):
                dead.append(robot)
        return dead
