"""Which processes have the minds of which bots, as they say themselves and as their starter says of dead ones."""

from __future__ import annotations

from soup_msgs_py.messages import Charge


class Hosts:
    """The newest word of each process with bots."""

    def __init__(self) -> None:
        """Nobody has said anything yet."""
        self._charges: dict[str, Charge] = {}
        self._host: dict[int, Charge] = {}  # by bot; of two the newer process
        self._known: set[int] = set()

    def hear(self, charge: Charge) -> set[int]:
        """Take in which bots a process has.

        Returns:
            The bots that nobody has any more since then.
        """
        before = self._charges.get(charge.part)
        if before is not None and before.rank > charge.rank:
            return set()  # the process before is told late
        self._charges[charge.part] = charge
        had = set(self._host)
        self._host = {}
        for newer in sorted(self._charges.values(), key=lambda said: said.rank):
            self._host |= dict.fromkeys(newer.bots, newer)
        self._known |= self._host.keys()
        return had - self._host.keys()

    def name(self, bot: int) -> str:
        """The process that has a bot, as it calls itself; empty where nobody has said so."""
        host = self._host.get(bot)
        return host.part if host is not None else ""

    def is_gone(self, bot: int) -> bool:
        """Whether somebody had the mind of a bot, and nobody has it now."""
        return bot in self._known and bot not in self._host
