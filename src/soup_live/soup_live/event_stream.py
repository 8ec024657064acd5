"""How a newcomer joins the stream of events: a snapshot with sequence S, then all events after S."""

from __future__ import annotations

from collections import deque

from soup_msgs_py.messages import Event, Snapshot

MOST_KEPT = 100_000
MOST_BEHIND = 3


class EventStream:
    """Puts the world's snapshots and events, which travel separately, into the order in which they are true.

    Until it is in step it keeps the events that come, and waits for a snapshot that they continue. When it
    finds a gap it hands on the event after it, by which the follower notices too, falls out of step, and joins
    again at a snapshot that holds everything the follower has heard.

    Attributes:
        in_step: Whether the follower knows the world.
        gaps: How often events were missed.
    """

    def __init__(self) -> None:
        """Start as a newcomer."""
        self.in_step = False
        self.gaps = 0
        self._last = -1
        self._told = -1  # newest event that a snapshot told of
        self._behind = 0  # snapshots in a row that were older than the newest event
        self._early: deque[Event] = deque(maxlen=MOST_KEPT)

    @property
    def newest(self) -> int:
        """Number of the newest event that was heard, or that a snapshot held; -1 for none."""
        return self._last

    def restart(self) -> None:
        """Become a newcomer again: there is another world now."""
        self.in_step = False
        self._last = self._told = -1
        self._early.clear()

    def lacks(self, sequence: int) -> bool:
        """In step, the newest snapshot holds events up to `sequence`: whether some are missing, and none shows it.

        Those that the snapshot before told of must have come. If they have not, they were sent before anybody saw that
        this follower listens, and as long as nothing happens it would wait for ever. It is out of step then.
        """
        told, self._told = self._told, sequence
        if not self.in_step or self._last >= told:
            return False
        self.gaps += 1
        self.in_step = False
        return True

    def lose(self) -> None:
        """The follower could make nothing of what it was told: it joins again at the next snapshot."""
        self.in_step = False

    def take_event(self, event: Event) -> list[Event]:
        """Take in an event; which events the follower should handle now."""
        if not self.in_step:
            if self._early and event.sequence <= self._early[-1].sequence:
                self._early.clear()  # another world counts anew
            self._early.append(event)
            return []
        if event.sequence <= self._last:
            return []
        if event.sequence > self._last + 1:
            self.gaps += 1
            self.in_step = False
        self._last = event.sequence
        return [event]

    def take_snapshot(self, snapshot: Snapshot) -> list[Snapshot | Event]:
        """Take in a snapshot; what the follower should handle now: nothing, or it and what came after it."""
        if self.in_step:
            return []
        if snapshot.sequence < self._last:
            self._behind += 1
            if self._behind < MOST_BEHIND:
                return []
            self._early.clear()  # no snapshot is that late: the event that was ahead of its time was nobody's
        self._behind = 0
        later = [event for event in self._early if event.sequence > snapshot.sequence]
        expected = range(snapshot.sequence + 1, snapshot.sequence + 1 + len(later))
        if [event.sequence for event in later] != list(expected):
            return []
        self._early.clear()
        self.in_step = True
        self._last = snapshot.sequence + len(later)
        return [snapshot, *later]
