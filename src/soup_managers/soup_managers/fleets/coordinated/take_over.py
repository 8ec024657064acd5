"""Take-over: what bots do for an earlier fleet when a new one begins, which goes on with that."""

from __future__ import annotations

from soup_managers.state.robots import Purpose
from soup_msgs_py.codes import Phase
from soup_msgs_py.messages import BotStatus, Trip


def drives_on(status: BotStatus) -> bool:
    """Whether a bot is on a drive that has a timetable."""
    return bool(status.stamps) and status.trip is None


def stays(status: BotStatus) -> bool:
    """Whether a bot that works stays where it is for all of its work, as on all trips of this fleet."""
    trip = status.trip
    if trip is None:
        return status.phase is Phase.FINISHING
    return not trip.fetch_route and not any(visit.route for visit in trip.visits) and len(trip.store_route) <= 1


def purpose_of(trip: Trip) -> Purpose:
    """What a trip is for on which a bot stays where it is."""
    if trip.visits:
        return Purpose.SERVE
    return Purpose.STORE if trip.store_route else Purpose.FETCH
