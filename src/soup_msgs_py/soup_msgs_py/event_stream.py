"""How a newcomer joins the stream of events: a snapshot with sequence S, then all events after S."""

from __future__ import annotations

from collections import deque

from soup_msgs_py.messages import Event, Snapshot

MOST_KEPT = 100_000


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
        self._early: deque[Event] = deque(maxlen=MOST_KEPT)

    def restart(self) -> None:
        """Become a newcomer again: there is another world now."""
        self.in_step = False
        self._last = -1
        self._early.clear()

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
        if self.in_step or snapshot.sequence < self._last:
            return []
        later = [event for event in self._early if event.sequence > snapshot.sequence]
        expected = range(snapshot.sequence + 1, snapshot.sequence + 1 + len(later))
        if [event.sequence for event in later] != list(expected):
            return []
        self._early.clear()
        self.in_step = True
        self._last = snapshot.sequence + len(later)
        return [snapshot, *later]
