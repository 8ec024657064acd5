"""A part that follows the world: learns the scenario, joins the events, keeps the time, wakes its mind."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from soup_msgs import msg

from soup_live.allegiance import Allegiance
from soup_live.diagnostics import Report
from soup_live.event_stream import EventStream
from soup_live.process import Live
from soup_live.qos import EVERY_ONE, LATCHED
from soup_msgs_py import topics
from soup_msgs_py.codes import EventType
from soup_msgs_py.mail import Mail
from soup_msgs_py.messages import Beat, BotReply, Event, Heard, Snapshot
from soup_msgs_py.mind import NEVER, Message, Mind
from soup_msgs_py.wire import Announcement, from_ros, read_cdr, to_ros_of

LOOK_S = 0.1  # how often a part that waits looks whether it still has to


class WorldClient:
    """Carries what the world says to a mind, and what the mind says to `carry`.

    Until the part is ready (`missing` says what it still waits for) and in step with the events, the mind is
    told nothing. A world that is started again is noticed by the number of its run: the mind is then made anew. Runs
    that are announced while the world is there, as by a bag that is played, are somebody else's. A mind that cannot
    follow what it was told joins anew, too, at the next snapshot.

    The world waits for everybody who follows: at each beat that asks for it the follower says that it has heard the
    world so far, after all that its mind has said in return, and when it wants the next beat at the latest. It also
    says what the part has sent to other parts and what it has got from them, once its mind has done what it had to
    upon it, so that the world waits for messages that are under way, too.

    Attributes:
        mind: The mind; None before the world has been heard of.
        announcement: What the world has told about its run; None before.
        now: Simulated time (s).
        begun: Whether the mind has ever been told what the world looks like.
        mail: What the part says to others and hears from them. Count what has come before the mind is told.
    """

    def __init__(
        self,
        live: Live,
        node: Node,
        report: Report,
        make_mind: Callable[[Announcement], Mind],
        carry: Callable[[list[Message]], None],
        missing: Callable[[], str],
        concerns: Callable[[Event], bool] | None = None,
        looks: Callable[[], float] = lambda: NEVER,
        bots: frozenset[int] = frozenset(),
        take_reply: Callable[[BotReply], None] = lambda _: None,
    ) -> None:
        """Begin to follow.

        Args:
            live: The process.
            node: The node that subscribes.
            report: Where to say what is waited for.
            make_mind: Makes the mind for a world.
            carry: Takes what the mind says.
            missing: What the part waits for besides the world; empty for nothing.
            concerns: Which events the mind is told; all without.
            looks: The simulated time (s) at which the mind wants to look around next.
            bots: The bots for which the part speaks.
            take_reply: Hands what the world has answered to a bot to the mind.
        """
        self.mind: Mind | None = None
        self.announcement: Announcement | None = None
        self.now = 0.0
        self.begun = False
        self._live, self._name = live, live.name
        self._report = report
        self._make_mind = make_mind
        self._carry = carry
        self._missing = missing
        self._concerns = concerns
        self._looks, self._bots, self._take_reply = looks, bots, take_reply
        self._replies: tuple[BotReply, ...] = ()  # that came with the newest beat
        self._is_behind = False  # whether the mind has not done yet what is due at the newest beat
        self.mail = Mail()
        self._calls = 0  # of the world's services that are not answered yet
        self._reacts: frozenset[EventType] = frozenset()  # as the world was told
        self._beat = 0  # number of the newest one
        self._sequence = -1  # of the newest event when it was said
        self._owes = False  # whether the world waits to be told that it was heard
        self._will_be_asked = False  # by a beat that is on its way
        self._asked_for = NEVER  # the next beat
        self._heard = node.create_publisher(msg.Heard, topics.HEARD, EVERY_ONE)
        self._stream = EventStream()
        self._allegiance: Allegiance[Announcement] = Allegiance()
        self._snapshot: Snapshot | None = None  # the newest one, while it may be needed
        self._asked: Callable[[Snapshot], None] | None = None  # who wants the next one
        live.follow(node, msg.Scenario, topics.SCENARIO, self._on_announcement, LATCHED)
        live.follow(node, msg.Beat, topics.BEAT, self._on_beat, LATCHED, run=lambda: self.run)
        live.follow(node, msg.Event, topics.EVENTS, self._on_event, EVERY_ONE, run=lambda: self.run)
        live.subscribe(node, msg.Snapshot, topics.SNAPSHOT, self._on_snapshot, LATCHED, raw=True)
        live.every(LOOK_S, self._look)
        live.at_end(self._take_leave)

    @property
    def in_step(self) -> bool:
        """Whether the mind knows the world and is being told everything."""
        return self._stream.in_step

    @property
    def run(self) -> int:
        """Number of the world's run; 0 before the world has been heard of."""
        return self.announcement.run if self.announcement is not None else 0

    def tell(self, message: Message, *, is_asked: bool = False) -> None:
        """Hand a message to the mind, and what it says to `carry`.

        Args:
            message: What was said.
            is_asked: Whether the world will ask, with a beat, what the part has to say upon it.
        """
        if self.mind is not None:
            self._carry(self.mind.handle(message, self.now))
        self._will_be_asked = self._will_be_asked or is_asked
        self.settle()

    def call(self, client: Any, request: Any, take: Callable[[Any], None]) -> None:
        """Ask the world through a service, and hand its answer to `take`. The part has not heard a beat before that."""
        self._calls += 1
        run = self.run

        def answered(future: Any) -> None:
            if self.run == run:
                self._calls -= 1
            take(future.result())
            self.settle()

        client.call_async(request).add_done_callback(self._live.guard(answered))

    def _on_announcement(self, announcement: Announcement) -> None:
        self._allegiance.announce(announcement, time.monotonic())
        self._change_over()

    def _change_over(self) -> None:
        announcement = self._allegiance.change(time.monotonic())
        if announcement is None:
            return
        self.announcement = announcement
        self.now = announcement.time
        self._stream.restart()
        self.begun = self._owes = self._will_be_asked = False
        self._replies, self._is_behind = (), False
        self._calls = 0
        self.mail.tell_all_again()
        self.mind = self._make_mind(announcement)

    def _on_beat(self, beat: Beat) -> None:
        self._allegiance.hear(self.run, time.monotonic())
        self._beat, self._sequence = beat.number, beat.sequence
        self.now = self._report.time = max(self.now, beat.time)
        if self.begun:
            if self._name in beat.parts:
                self._owes, self._will_be_asked = True, False
            self._replies += beat.replies
            self._is_behind = True
            self._catch_up()

    def _catch_up(self) -> None:
        """Do what is due at the newest beat, once the events have come that it may have been faster than."""
        if self._stream.in_step and self._stream.newest < self._sequence:
            return
        replies, self._replies = self._replies, ()
        for reply in replies:
            self._take_reply(reply)
        self._wake()
        self._is_behind = False
        self.settle()

    def _take_leave(self) -> None:
        if self.begun:  # one that stands by has the name of the one in charge, which the world waits for
            self._heard.publish(to_ros_of(self.run, Heard(self._name, self._beat, NEVER, leaves=True)))

    def speak_for(self, bots: frozenset[int]) -> None:
        """From now on the part speaks for other bots than before."""
        self._bots = bots
        if self.begun:
            self._say_heard()

    def settle(self) -> None:
        """Tell the world how far the part is, if that is news, and nothing is missing that it has to hear first."""
        if self.mind is None or not self.begun or self._calls or self._is_behind:
            return
        if self._owes or (not self._will_be_asked and self._has_news):
            self._say_heard()

    @property
    def _has_news(self) -> bool:
        assert self.mind is not None
        return self.mail.has_news or self._next() < self._asked_for or self.mind.reacts_to != self._reacts

    def _say_heard(self) -> None:
        assert self.mind is not None
        self._owes = False
        self._asked_for, self._reacts = self._next(), self.mind.reacts_to
        sent, got = self.mail.news()
        heard = Heard(self._name, self._beat, self._asked_for, self._reacts, self._bots, sent=sent, got=got)
        self._heard.publish(to_ros_of(self.run, heard))

    def _next(self) -> float:
        if self.mind is None or not self.in_step:
            return NEVER
        return min(self.mind.next_wake, self._looks())

    def _wake(self) -> None:
        if self.mind is not None and self.in_step and self.mind.next_wake <= self.now:
            self._carry(self.mind.wake(self.now))

    def _on_event(self, event: Event) -> None:
        self._hear(self._stream.take_event(event))
        if self._is_behind:
            self._catch_up()

    def next_snapshot(self, take: Callable[[Snapshot], None]) -> None:
        """Hand over the next snapshot, whoever has asked before."""
        self._asked = take

    def _on_snapshot(self, cdr: bytes) -> None:
        told = read_cdr(cdr, msg.Snapshot)
        self._allegiance.hear(told.run, time.monotonic())
        if not self._live.belongs(told.run, self.run):
            return
        if self.in_step:
            asked, self._asked = self._asked, None
            if asked is not None:
                asked(from_ros(told))
            if not self._stream.lacks(told.sequence):
                return
        self._snapshot = from_ros(told)
        self._look()

    def _look(self) -> None:
        """Join as soon as everything is there."""
        self._change_over()
        self._will_be_asked = False
        if self._is_behind:
            self._catch_up()
        else:
            self.settle()
        if self._stream.gaps:
            self._report.values["missed_events"] = f"{self._stream.gaps} times"
        if self.announcement is None:
            self._report.waits(f"waits for the world (nothing on {topics.SCENARIO} yet)")
            return
        missing = self._missing()
        if self.in_step:
            if missing:
                self._report.waits(missing)
            else:
                self._report.works()
            return
        if missing:
            self._report.waits(missing)
        elif self._snapshot is None or self._snapshot.run != self.announcement.run:
            self._report.waits(f"waits for the world (nothing on {topics.SNAPSHOT} yet)")
        else:
            self._hear(self._stream.take_snapshot(self._snapshot))
            if self.in_step:
                self._snapshot = None
                self.begun = True
                self._say_heard()
                self._report.works()

    def _hear(self, messages: list[Any]) -> None:
        for message in messages:
            self.now = max(self.now, message.time)
            if self._concerns is None or not isinstance(message, Event) or self._concerns(message):
                self.tell(message, is_asked=isinstance(message, Event) and message.type in self._reacts)
        if self.mind is not None and self.mind.lost:
            self._stream.lose()
