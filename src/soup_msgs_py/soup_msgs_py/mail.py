"""What a part has said to other parts and heard from them, counted: so the world knows what is still under way.

A message between two parts (an order, an outcome, a goal, its result) does not pass the world, and takes wall time.
Each end counts it under the name of a channel, and tells the world what has changed with each `Heard`. The names here
are those that `wire.rows` lets pass.
"""

from __future__ import annotations

from collections.abc import Hashable

Counts = tuple[tuple[str, int], ...]  # (channel, messages so far)

BOUND = "bound"


def goals(kind: str) -> str:
    """From the manager that asks for tasks of a kind to the fleet."""
    return f"goals {kind}"


def results(kind: str) -> str:
    """From the fleet to that manager."""
    return f"results {kind}"


def orders(part: str) -> str:
    """From the fleet to a process with bots."""
    return f"orders {part}"


def outcomes(part: str) -> str:
    """From a process with bots to the fleet: how orders ended, and what the bots do."""
    return f"outcomes {part}"


def drives(bot: int) -> str:
    """From any process with bots to the one that has this bot, which is asked to make way."""
    return f"drives {bot}"


class Mail:
    """The counts of one part."""

    def __init__(self) -> None:
        """Nothing was said yet."""
        self._sent: dict[str, int] = {}
        self._got: dict[str, int] = {}
        self._told_sent: dict[str, int] = {}
        self._told_got: dict[str, int] = {}
        self._numbers: dict[tuple[str, Hashable], int] = {}

    def sent(self, channel: str) -> None:
        """One message has been sent."""
        self._sent[channel] = self._sent.get(channel, 0) + 1

    def got(self, channel: str, number: int | None = None, of: Hashable = None) -> None:
        """One message has come.

        Args:
            channel: Its channel.
            number: Its place among those `of` the same thing, from 1 on, where only the newest one is kept: those that
                it has pushed out count as heard. A number that is not above the one before begins anew.
            of: What the sender's numbers count.
        """
        count = 1
        if number is not None:
            before = self._numbers.get((channel, of), 0)
            self._numbers[channel, of] = number
            count = number - before if number > before else number
        self._got[channel] = self._got.get(channel, 0) + count

    @property
    def has_news(self) -> bool:
        """Whether something has changed since `news` was asked for last."""
        return self._sent != self._told_sent or self._got != self._told_got

    def news(self) -> tuple[Counts, Counts]:
        """What was sent and what has come, on the channels where it has changed since this was asked last."""
        sent = tuple([entry for entry in self._sent.items() if self._told_sent.get(entry[0]) != entry[1]])
        got = tuple([entry for entry in self._got.items() if self._told_got.get(entry[0]) != entry[1]])
        self._told_sent, self._told_got = self._sent.copy(), self._got.copy()
        return sent, got

    def tell_all_again(self) -> None:
        """There is another world, which has heard of nothing."""
        self._told_sent, self._told_got = {}, {}
