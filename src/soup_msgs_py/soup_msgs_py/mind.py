"""What every mind is: a plain object; a message and the simulated time go in, messages come out."""

from __future__ import annotations

import math
from typing import Any, Protocol

from soup_msgs_py.codes import EventType

NEVER = math.inf
Message = Any  # one of the dataclasses of `messages`
EVERYTHING = frozenset(EventType)


class Mind(Protocol):
    """A part of the warehouse that thinks. It knows no clock, no thread and no socket.

    Whatever carries the messages (a node, or the one-process runner) calls `handle` for each message and `wake`
    when simulated time has reached `next_wake`.
    """

    next_wake: float

    @property
    def reacts_to(self) -> frozenset[EventType]:
        """The events upon which it may say something. After others the world need not wait for it."""
        ...

    @property
    def lost(self) -> bool:
        """Whether it can follow no longer what the world says, and needs a snapshot."""
        ...

    def handle(self, message: Message, now: float) -> list[Message]:
        """Take in one message at simulated time `now` (s); what the mind says in return."""
        ...

    def wake(self, now: float) -> list[Message]:
        """Do what was due at `next_wake`, and set the next one (NEVER for none)."""
        ...
