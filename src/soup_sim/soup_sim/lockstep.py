"""Lockstep: whom the world waits for, and whom no longer. It knows no clock; wall time comes in."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from soup_msgs_py.messages import Beat, BotReply, Event, Heard
from soup_msgs_py.mind import NEVER, Message
from soup_sim.in_flight import InFlight

# wall time; a part that is silent for longer is waited for no more, until it speaks again
PATIENCE_S = 4.0  # managers may have to plan much
BOTS_PATIENCE_S = 3.0  # bots do not
FIRST_PATIENCE_S = 120.0  # a manager that has just begun may still have to compile what it computes with; bots rehearse
FIRST_ANSWERS = 20  # then it has had to do most of that


@dataclass(slots=True)
class _Listener:
    said: Heard  # the newest
    next_time: float
    asked: bool = False  # whether it is to answer the next beat
    beat: int = 0  # the newest that it is to answer
    expected: bool = False  # whether it has not spoken to this world yet
    answers: int = 0  # beats that it has answered

    @property
    def late(self) -> bool:
        """Whether the world waits for it."""
        return self.expected or self.said.beat < self.beat

    @property
    def patience_s(self) -> float:
        """How long it is waited for (wall s)."""
        if self.said.bots:
            return BOTS_PATIENCE_S
        return FIRST_PATIENCE_S if self.answers < FIRST_ANSWERS else PATIENCE_S


class Lockstep:
    """The parts that think, each with the last beat that it has heard.

    The world stays at an instant at which it has said something until all whom it concerns have heard it, and all that
    they have said to each other upon it. What they ask for in return takes effect at this very instant, as in one
    process, however fast the world runs and however busy the machine is. A world too fast for its minds slows down.

    Attributes:
        lost: Parts that were silent for too long, in the order of their names.
        latency_s: Simulated time that went on without a part that was lost, or a message that was given up (s).
    """

    def __init__(self, beats: int = 0) -> None:
        """Begin with nobody: a part is waited for from the first time that it speaks.

        Args:
            beats: The number of the last beat of a world before, or more: parts answer for it until they hear another.
        """
        self.lost: tuple[str, ...] = ()
        self._parts: dict[str, _Listener] = {}
        self._beats = beats
        self._since = self._heard_at = 0.0  # wall time since which it waits, and when a part spoke last
        self._waited_s: dict[str, float] = {}  # wall time, by the part that was waited for last
        self._asked = 0.0
        self.latency_s = 0.0
        self._replies: list[BotReply] = []  # since the last beat
        self._in_flight = InFlight()

    @property
    def names(self) -> list[str]:
        """The parts that it waits for where that is needed."""
        return list(self._parts)

    def expect(self, parts: Iterable[str], wall: float) -> None:
        """Wait for those who followed a world that goes on now: nothing is to happen that they do not hear of."""
        self._since = wall
        for name in parts:
            self._parts[name] = _Listener(Heard(name, 0, NEVER), NEVER, expected=True, answers=FIRST_ANSWERS)

    @property
    def asked(self) -> bool:
        """Whether the world has said something since the last beat that one of them has to hear."""
        return any(part.asked for part in self._parts.values())

    def tell(self, said: Message) -> None:
        """The world says something: those whom it concerns are to answer the next beat."""
        for part in self._parts.values():
            part.asked = part.asked or _concerns(part.said, said)
        if isinstance(said, BotReply):
            self._replies.append(said)

    @property
    def next_time(self) -> float:
        """The next simulated time (s) at which one of them wants to hear how things are; infinity for never."""
        return min((part.next_time for part in self._parts.values()), default=NEVER)

    def beat(self, now: float, wall: float, sequence: int = -1) -> Beat:
        """The beat that tells at simulated time `now` that the world has said something, and waits.

        Args:
            now: Simulated time (s).
            wall: Any clock of wall time (s).
            sequence: Number of the newest event.
        """
        self._beats += 1
        self._since = wall
        asked = []
        for name, part in self._parts.items():
            if part.asked or part.next_time <= now:
                asked.append(name)
                part.asked, part.beat = False, self._beats
            if part.next_time <= now:
                part.next_time = NEVER
        # nobody waits for those who were lost; one that only stood still is to say that it is back
        replies, self._replies = tuple(self._replies), []
        return Beat(now, self._beats, (*asked, *self.lost), sequence, replies)

    def hear(self, heard: Heard, wall: float) -> None:
        """Take in how far a part is."""
        waited, self._heard_at = self._waits, wall
        self.lost = tuple(name for name in self.lost if name != heard.part)
        if heard.leaves:
            self._parts.pop(heard.part, None)
            self._in_flight.forget(heard.part)
        else:
            part = self._parts.setdefault(heard.part, _Listener(heard, heard.next_time))
            part.answers += part.late and heard.beat >= part.beat
            part.said, part.next_time, part.expected = heard, heard.next_time, False
            self._in_flight.hear(heard)
        if not waited:
            self._since = wall
        elif not self._waits:
            self._waited_s[heard.part] = self._waited_s.get(heard.part, 0.0) + wall - self._since

    def wait(self, wall: float, *, paused: bool = False) -> bool:
        """Whether the world has to stay where it is; while it is paused nobody loses its patience."""
        if paused:
            self._since = wall
        late = self._late()
        silent = [name for name in late if wall - self._since > self._parts[name].patience_s]
        for name in silent:
            del self._parts[name]
        if silent:
            self.lost = tuple(sorted({*self.lost, *silent}))
            for name in silent:
                self._in_flight.forget(name)
        if len(late) > len(silent):
            return True
        if self._in_flight.any:
            if wall - max(self._since, self._heard_at) <= PATIENCE_S:
                return True
            self._in_flight.give_up()
        if not self.asked:  # who will be asked may have said something that it has not told yet
            self._in_flight.settle()
        return False

    @property
    def missing(self) -> tuple[str, ...]:
        """What the world goes on without: parts that were lost, and channels on which messages were given up."""
        return *self.lost, *sorted(self._in_flight.given_up)

    def went_on(self, seconds: float) -> None:
        """Simulated time has gone on for some seconds."""
        if self.lost or self._in_flight.given_up:
            self.latency_s += seconds

    def waited(self, wall: float) -> str:
        """How much the world has waited since this was asked last, and for whom most."""
        elapsed, self._asked = wall - self._asked, wall
        waited_s, self._waited_s = self._waited_s, {}
        if not any(waited_s.values()):
            return "0 % of the time"
        most = max(waited_s, key=lambda part: waited_s[part])
        return f"{100.0 * sum(waited_s.values()) / elapsed:.0f} % of the time, most for {most}"

    @property
    def _waits(self) -> bool:
        return bool(self._late()) or self._in_flight.any

    def _late(self) -> list[str]:
        return [name for name, part in self._parts.items() if part.late]


def _concerns(part: Heard, said: Message) -> bool:
    """Whether a part may say something upon what the world says."""
    if isinstance(said, BotReply):
        return said.bot in part.bots
    if not isinstance(said, Event) or said.type not in part.reacts:
        return False
    return not part.bots or said.bot in part.bots or not part.bots.isdisjoint(said.bots)
