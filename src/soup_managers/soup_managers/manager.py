"""What all managers have in common: the view, and which message goes where."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from soup_managers.view import WarehouseView
from soup_msgs_py.codes import EventType
from soup_msgs_py.messages import Event, Snapshot
from soup_msgs_py.mind import EVERYTHING, NEVER, Message
from soup_msgs_py.mistakes import Mistakes


class Manager:
    """A mind that follows the world's snapshot and events.

    Attributes:
        view: What it knows of the world; where `view.lost`, a new snapshot has to be asked for.
        next_wake: As in `Mind`.
        mistakes: What its policies chose that cannot be.
    """

    def __init__(self, view: WarehouseView) -> None:
        self.view = view
        self.next_wake = NEVER
        self.mistakes = Mistakes()
        # events up to here are in this manager's books; a shared view may be ahead of them
        self._sequence = -1
        self._resets = 0
        self._handlers: dict[type, Callable[[Any, float], list[Message]]] = {
            Event: self._handle_event,
            Snapshot: self._handle_snapshot,
        }

    @property
    def reacts_to(self) -> frozenset[EventType]:
        """As in `Mind`."""
        return EVERYTHING

    @property
    def lost(self) -> bool:
        """As in `Mind`."""
        return self.view.lost

    def handle(self, message: Message, now: float) -> list[Message]:
        """Take in one message at simulated time `now` (s); what the manager says in return.

        Messages of kinds that do not concern it are ignored.
        """
        handler = self._handlers.get(type(message))
        return handler(message, now) if handler is not None else []

    def wake(self, now: float) -> list[Message]:
        """Do what was due at `next_wake`."""
        raise NotImplementedError

    def on_event(self, event: Event, now: float) -> list[Message]:
        """React to an event that is new to this manager; the view has it already."""
        raise NotImplementedError

    def on_world(self, now: float) -> list[Message]:
        """Make the own books anew from the view: after the first snapshot, and after a gap."""
        raise NotImplementedError

    def _handle_event(self, event: Event, now: float) -> list[Message]:
        self.view.apply(event)
        if self._resets != self.view.resets:
            return self._start_anew(now)
        if event.sequence <= self._sequence or self.view.lost:
            return []
        self._sequence = event.sequence
        return self.on_event(event, now)

    def _handle_snapshot(self, snapshot: Snapshot, now: float) -> list[Message]:
        self.view.reset(snapshot)
        return self._start_anew(now) if self._resets != self.view.resets else []

    def _start_anew(self, now: float) -> list[Message]:
        self._resets = self.view.resets
        self._sequence = self.view.sequence
        return self.on_world(now)
