"""Which message goes to whom, and how it travels live: one row a message, for all who carry messages."""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

from soup_msgs_py import messages as m
from soup_msgs_py import topics


class Hearer(Enum):
    """Who hears a message."""

    ALL = "everybody"
    WORLD = "world"
    CREW = "bots"
    FLEET = "fleet manager"
    WORD = "word manager"
    ASKER = "who asked for the task"  # the word or the letter manager, by its kind


class Route(NamedTuple):
    """The way of a message.

    Attributes:
        hearer: Who hears it.
        name: The topic, service or action that carries it live; `/bot_N` for each bot's own.
    """

    hearer: Hearer
    name: str


_BOT = "/bot_N/"

ROUTES: dict[type, Route] = {
    m.Snapshot: Route(Hearer.ALL, topics.SNAPSHOT),
    m.Event: Route(Hearer.ALL, topics.EVENTS),
    m.SetVelocity: Route(Hearer.WORLD, _BOT + topics.CMD_VEL),
    m.SetVelocities: Route(Hearer.WORLD, _BOT + topics.CMD_VEL),
    m.FollowPath: Route(Hearer.WORLD, _BOT + topics.PATH),
    m.Grab: Route(Hearer.WORLD, topics.REQUESTS),
    m.Release: Route(Hearer.WORLD, topics.REQUESTS),
    m.Transfer: Route(Hearer.WORLD, topics.REQUESTS),
    m.AssignWord: Route(Hearer.WORLD, topics.ASSIGN_WORD),
    m.AssignBundle: Route(Hearer.WORLD, topics.ASSIGN_BUNDLE),
    m.SetStorageSpot: Route(Hearer.WORLD, topics.SET_STORAGE_SPOT),
    m.BotReply: Route(Hearer.CREW, topics.REPLIES),
    m.DriveGoal: Route(Hearer.CREW, topics.ORDERS),
    m.TripGoal: Route(Hearer.CREW, topics.ORDERS),
    m.CancelDrive: Route(Hearer.CREW, topics.ORDERS),
    m.CancelTrip: Route(Hearer.CREW, topics.ORDERS),
    m.BotStatus: Route(Hearer.FLEET, _BOT + topics.STATUS),
    m.TripFeedback: Route(Hearer.FLEET, _BOT + topics.TRIP),
    m.DriveResult: Route(Hearer.FLEET, topics.OUTCOMES),
    m.TripResult: Route(Hearer.FLEET, topics.OUTCOMES),
    m.DeliverGoal: Route(Hearer.FLEET, topics.DELIVER_LETTERS),
    m.StoreGoal: Route(Hearer.FLEET, topics.STORE_BUNDLE),
    m.CancelTask: Route(Hearer.FLEET, topics.DELIVER_LETTERS),
    m.TaskFeedback: Route(Hearer.ASKER, topics.DELIVER_LETTERS),
    m.TaskResult: Route(Hearer.ASKER, topics.DELIVER_LETTERS),
    m.Bound: Route(Hearer.WORD, topics.BOUND),
}
