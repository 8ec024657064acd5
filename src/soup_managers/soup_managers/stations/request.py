"""One request at a time to the world: asked, answered, and seen to have happened."""

from __future__ import annotations

from soup_msgs_py.messages import AssignBundle, AssignWord, Reply
from soup_msgs_py.mind import NEVER

ASK_AGAIN_S = 1.0  # after a refusal
FORGET_S = 5.0  # a request that nobody answers, because the world was started again


class Request:
    """The one request that a manager has under way.

    A reply does not say what it answers, and the view knows of a change only from its event. So the next
    request waits for both: it is decided on a view that has the last one in it.
    """

    def __init__(self) -> None:
        self.drop()

    def drop(self) -> None:
        """Forget the request."""
        self._asked: AssignWord | AssignBundle | None = None
        self._answered = False
        self._happened = False
        self._not_before = -NEVER
        self.next_wake = NEVER

    def is_allowed(self, now: float) -> bool:
        """Whether a new request may be made."""
        return self._asked is None and now >= self._not_before

    def send(self, asked: AssignWord | AssignBundle, now: float) -> None:
        """A request is made."""
        self.drop()
        self._asked = asked
        self.next_wake = now + FORGET_S

    def rest(self, now: float) -> None:
        """Nothing is wanted: look again after a while, or when something happens."""
        self.next_wake = now + ASK_AGAIN_S

    def answered(self, reply: Reply, now: float) -> None:
        """The world replied. After a refusal nothing is asked for a while."""
        if self._asked is None:
            return
        self._answered = True
        if not reply.success:
            self.drop()
            self._not_before = self.next_wake = now + ASK_AGAIN_S
        elif self._happened:
            self.drop()

    def happened(self, job: int, station: int, tile: int) -> None:
        """A word was opened or a bundle staged; it may be the one that was asked for."""
        asked = self._asked
        if asked is None or asked.station != station:
            return
        if isinstance(asked, AssignWord):
            self._happened = asked.word == job
        else:
            self._happened = asked.bundle == job or (asked.bundle < 0 and asked.tile == tile)
        if self._answered and self._happened:
            self.drop()

    def expire(self, now: float) -> None:
        """Give up a request or a pause whose time is over."""
        if now >= self.next_wake:
            self.drop()
