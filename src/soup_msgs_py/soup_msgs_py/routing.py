"""Which message goes to whom: one row a message. Where they travel live is in `topics`, and in the nodes."""

from __future__ import annotations

from enum import Enum

from soup_msgs_py import messages as m


class Hearer(Enum):
    """Who hears a message."""

    ALL = "everybody"
    WORLD = "world"
    CREW = "bots"
    FLEET = "fleet manager"
    WORD = "word manager"
    ASKER = "who asked for the task"  # the word or the letter manager, by its kind


HEARERS: dict[type, Hearer] = {
    m.Snapshot: Hearer.ALL,
    m.Event: Hearer.ALL,
    m.SetVelocity: Hearer.WORLD,
    m.SetVelocities: Hearer.WORLD,
    m.FollowPath: Hearer.WORLD,
    m.Grab: Hearer.WORLD,
    m.Release: Hearer.WORLD,
    m.Transfer: Hearer.WORLD,
    m.AssignWord: Hearer.WORLD,
    m.AssignBundle: Hearer.WORLD,
    m.SetStorageSpot: Hearer.WORLD,
    m.BotReply: Hearer.CREW,
    m.DriveGoal: Hearer.CREW,
    m.TripGoal: Hearer.CREW,
    m.CancelDrive: Hearer.CREW,
    m.CancelTrip: Hearer.CREW,
    m.BotStatus: Hearer.FLEET,
    m.TripFeedback: Hearer.FLEET,
    m.DriveResult: Hearer.FLEET,
    m.TripResult: Hearer.FLEET,
    m.DeliverGoal: Hearer.FLEET,
    m.StoreGoal: Hearer.FLEET,
    m.CancelTask: Hearer.FLEET,
    m.TaskFeedback: Hearer.ASKER,
    m.TaskResult: Hearer.ASKER,
    m.Bound: Hearer.WORD,
}
