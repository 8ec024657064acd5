"""How time goes on, and who is there."""

from __future__ import annotations

from soup_msgs_py.codes import EventType
from soup_msgs_py.mail import Counts
from soup_msgs_py.messages.base import message
from soup_msgs_py.messages.requests import BotReply


@message
class Beat:
    """The world has spoken, and time stays at this instant until every part that it concerns has heard it.

    Attributes:
        time: Simulated time (s); it travels exactly, so that who wanted a beat at a time gets it at that time.
        number: Counts the beats, from 1 on.
        parts: Who has to say that it was heard.
        sequence: Number of the newest event, which they have to have heard by then.
        replies: What the world has answered to bots since the beat before.
    """

    time: float
    number: int
    parts: tuple[str, ...] = ()
    sequence: int = -1
    replies: tuple[BotReply, ...] = ()


@message
class Heard:
    """A part has heard the world up to a beat, and has said all that it wants in return.

    Attributes:
        part: Its name.
        beat: Number of the beat, 0 for none yet.
        next_time: Simulated time (s) at which it wants another beat at the latest; infinity: when something happens.
        reacts: Events upon which it may say something; the world waits for it only after those.
        bots: Whose replies it waits for, and to whose events `reacts` is restricted; empty for a part without bots.
        leaves: Whether the world is not to wait for it any more.
        sent: Messages to other parts so far, by channel (see `mail`), where that has changed.
        got: Messages of other parts that it has taken in so far, likewise.
    """

    part: str
    beat: int
    next_time: float
    reacts: frozenset[EventType] = frozenset()
    bots: frozenset[int] = frozenset()
    leaves: bool = False
    sent: Counts = ()
    got: Counts = ()


@message
class BotGone:
    """Nobody has the mind of a bot any more; what it was asked for ends by itself."""

    bot: int


@message
class Charge:
    """A process says what it is in charge of.

    Attributes:
        part: Its name.
        term: Managers: one more than that of the one before; the highest is in charge.
        rank: Decides between two: of managers of one term the lower, of processes with one bot the higher.
        policy: What it follows.
        bots: The bots whose minds it has.
    """

    part: str
    term: int
    rank: int
    policy: str
    bots: tuple[int, ...] = ()
