"""Which messages between parts are under way: sent by the one, and not yet taken in by the other.

Each part counts what it sends and what it takes in, channel by channel, and says so after it has done what it had to.
When for each channel both ends have said the same, nothing is under way and nobody has anything left to say: the first
who had said more would have done so upon a message, and that one would show (Mattern, "Algorithms for distributed
termination detection", 1987, section 5: the vector counter method).
"""

from __future__ import annotations

from dataclasses import dataclass, field

from soup_msgs_py.messages import Heard


@dataclass(slots=True)
class _Channel:
    sent: dict[str, int] = field(default_factory=dict)  # by part
    got: dict[str, int] = field(default_factory=dict)
    forgiven: int = 0  # messages that nobody waits for: they were sent to somebody before

    @property
    def open(self) -> int:
        """How many are under way; below zero where messages came that were forgiven."""
        if not self.sent or not self.got:
            return 0
        return self._difference() - self.forgiven

    def forgive(self) -> None:
        """Wait for none of those that are under way."""
        self.forgiven = self._difference() if self.sent and self.got else 0

    def _difference(self) -> int:
        return sum(self.sent.values()) - sum(self.got.values())


class InFlight:
    """The counts of all parts.

    Attributes:
        given_up: Channels on which messages were given up, until something comes there.
    """

    def __init__(self) -> None:
        """Nobody has said anything yet."""
        self.given_up: set[str] = set()
        self._channels: dict[str, _Channel] = {}
        self._unbalanced: set[str] = set()  # names of channels whose two sides differ

    def hear(self, heard: Heard) -> None:
        """Take in what a part has counted."""
        for counts, sent in ((heard.sent, True), (heard.got, False)):
            for name, count in counts:
                channel = self._channels.setdefault(name, _Channel())
                side = channel.sent if sent else channel.got
                before = side.get(heard.part)
                side[heard.part] = count
                if before is None or count < before:  # a newcomer; what was said before was not for it, or not by it
                    channel.forgive()
                if not sent:
                    self.given_up.discard(name)
                self._look(name, channel)

    def forget(self, part: str) -> None:
        """A part is not waited for any more."""
        for name, channel in self._channels.items():
            if channel.sent.pop(part, None) is not None or channel.got.pop(part, None) is not None:
                channel.forgive()
                self._look(name, channel)

    @property
    def open(self) -> list[str]:
        """The channels on which messages are under way."""
        return sorted(name for name in self._unbalanced if self._channels[name].open > 0)

    @property
    def any(self) -> bool:
        """Whether a message is under way."""
        return any(self._channels[name].open > 0 for name in self._unbalanced)

    def settle(self) -> None:
        """Nothing is under way: what seems to have come too often was forgiven before it came."""
        for name in self._unbalanced:
            self._channels[name].forgive()
        self._unbalanced.clear()

    def give_up(self) -> list[str]:
        """Wait no more for what is under way; the channels."""
        names = self.open
        self.given_up |= set(names)
        self.settle()
        return names

    def _look(self, name: str, channel: _Channel) -> None:
        if channel.open:
            self._unbalanced.add(name)
        else:
            self._unbalanced.discard(name)
