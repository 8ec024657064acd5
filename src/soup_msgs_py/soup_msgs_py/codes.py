"""The enumerations of the shared language. Their values are what travels on the wire."""

from __future__ import annotations

from enum import IntEnum, StrEnum


class Code(StrEnum):
    """How a request ended."""

    DONE = "done"
    OUT_OF_TOLERANCE = "out_of_tolerance"
    ALREADY_CARRYING = "already_carrying"
    NOT_CARRYING = "not_carrying"
    BUCKET_TAKEN = "bucket_taken"
    SPOT_TAKEN = "spot_taken"
    BLOCKED = "blocked"
    MOVING = "moving"
    BUSY = "busy"
    PENALISED = "penalised"
    COLLIDED = "collided"
    REPLACED = "replaced"
    NOT_NEEDED = "not_needed"
    NOT_IN_BUCKET = "not_in_bucket"
    BUCKET_FULL = "bucket_full"
    NOTHING_STAGED = "nothing_staged"
    STATION_FULL = "station_full"
    OFF_FLOOR = "off_floor"
    TOO_FAST = "too_fast"
    LATE = "late"
    UNKNOWN = "unknown"
    INVALID = "invalid"
    CANCELLED = "cancelled"
    STOPPED = "stopped"


class EventType(StrEnum):
    """What can happen in the world."""

    WORD_ARRIVED = "word_arrived"
    WORD_ASSIGNED = "word_assigned"
    WORD_COMPLETED = "word_completed"
    WORD_CLEARED = "word_cleared"
    BUNDLE_ARRIVED = "bundle_arrived"
    BUNDLE_STAGED = "bundle_staged"
    BUNDLE_EMPTIED = "bundle_emptied"
    GRABBED = "grabbed"
    RELEASED = "released"
    TRANSFERRED = "transferred"
    BOT_COLLISION = "bot_collision"
    BUCKET_COLLISION = "bucket_collision"
    RESUMED = "resumed"
    SPOT_MADE = "spot_made"
    SPOT_REMOVED = "spot_removed"


class BotState(IntEnum):
    """What a bot's body does. Only FREE counts as idle."""

    FREE = 0
    MOVING = 1
    GRABBING = 2
    RELEASING = 3
    TRANSFERRING = 4
    PENALISED = 5


class Phase(StrEnum):
    """Which part of its work a bot's mind is at."""

    IDLE = "idle"
    DRIVING = "driving"
    FETCHING = "fetching"
    VISITING = "visiting"
    STORING = "storing"
    BY_HAND = "by_hand"
    FINISHING = "finishing"  # its body, at rest, ends what a mind before this one asked for
