"""Timed drives that bots were asked for and have not begun: simulated time must not overtake them."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from soup_msgs_py.messages import DriveGoal
from soup_msgs_py.mind import NEVER

SAME_S = 1e-6  # simulated: times on the wire are whole nanoseconds
PATIENCE_S = 1.5  # wall time for which a bot that says nothing is waited for: its drive will be refused as late


class Departures:
    """When those depart who have not confirmed their drive. It knows no clock; wall time comes in.

    A drive goes from the fleet over its bot to the world. Were simulated time to go on meanwhile, a busy machine
    would have many drives refused as late, and planning those anew would make it busier still.
    """

    def __init__(self, together: Callable[[int], Iterable[int]]) -> None:
        """Begin with nobody under way.

        Args:
            together: The bots of the process that has a bot, itself included: where one does not answer, nobody does.
        """
        self._together = together
        self._asked: dict[int, tuple[float, float]] = {}  # bot -> departure (simulated s), when it was asked (wall s)
        self._silent: set[int] = set()  # bots that are waited for no more, until their process answers again

    def ask(self, goal: DriveGoal, wall: float) -> None:
        """A bot has been asked to drive at wall time `wall` (s); one without stamps departs when it likes."""
        self._asked.pop(goal.bot, None)
        if goal.stamps and goal.bot not in self._silent:
            self._asked[goal.bot] = goal.stamps[0], wall

    def confirm(self, bot: int) -> None:
        """A bot says that it drives, or that it does not."""
        self._asked.pop(bot, None)
        if bot in self._silent:
            self._silent.difference_update(self._together(bot))

    def give_up(self, bot: int) -> None:
        """A bot does not answer: nobody waits for it and for the others of its process."""
        for mate in self._together(bot):
            self._silent.add(mate)
            self._asked.pop(mate, None)

    def clear(self) -> None:
        """Another world has begun."""
        self._asked.clear()

    def earliest(self, wall: float, now: float) -> float:
        """The simulated time (s) that must not be overtaken yet; infinity for none.

        What departs before `now` has been overtaken. Were that waited for, a fleet that the world has given up once,
        because it thought for too long, would never come back: its drives would be late, and so be waited for.
        """
        for bot in [bot for bot, (_, asked) in self._asked.items() if wall - asked > PATIENCE_S]:
            self.give_up(bot)
        return min((depart for depart, _ in self._asked.values() if depart >= now - SAME_S), default=NEVER)
