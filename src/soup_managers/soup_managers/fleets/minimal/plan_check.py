"""Whether a trip that a fleet policy planned can be."""

from __future__ import annotations

from soup_managers.fleets.minimal.plans import Letter, Place, PlanError, TripPlan
from soup_managers.fleets.minimal.state import FleetState
from soup_msgs_py.messages import DELIVER
from soup_msgs_py.warehouse.tiles import tile_name


def check_plan(plan: TripPlan, fleet: FleetState) -> None:
    """Check a plan against the books: nothing may be promised twice.

    Raises:
        PlanError: The bot, the bucket, the spot or a letter is not to be had.
    """
    bot, bucket = plan.bot, plan.bucket
    if not 0 <= bucket < len(fleet.view.contents):
        raise PlanError(f"there is no bucket {bucket}")
    if bot >= 0 and fleet.loaded_bots >> bot & 1:
        if fleet.view.bot_bucket[bot] != bucket:
            raise PlanError(f"bot {bot} carries another bucket than {bucket}")
    elif bot < 0 or not fleet.free_bots >> bot & 1:
        raise PlanError(f"bot {bot} is not idle")
    elif not fleet.free_buckets >> bucket & 1:
        raise PlanError(f"bucket {bucket} is in use")
    elif fleet.bot_under(bucket) not in (-1, bot):
        raise PlanError(f"bot {fleet.bot_under(bucket)} stands under bucket {bucket}, bot {bot} cannot get there")
    comes_back = 0 <= plan.spot == fleet.view.spot_of[bucket] and fleet.view.bucket_bot[bucket] < 0
    if not (comes_back or fleet.is_free_spot(plan.spot)):
        raise PlanError(f"storage spot {plan.spot} is not free for bucket {bucket}")
    _check_letters(plan, fleet)


def _check_letters(plan: TripPlan, fleet: FleetState) -> None:
    contents = dict(fleet.view.contents[plan.bucket])
    room = fleet.view.room_in(plan.bucket)
    planned: list[Letter] = []
    for visit in plan.visits:
        for letter in visit.letters:
            name = tile_name(letter.tile)
            if letter in planned:
                raise PlanError(f"letter {name} of {letter.key[0]} {letter.key[1]} is planned twice")
            planned.append(letter)
            if letter.place not in (Place.QUEUED, Place.DEFERRED):
                raise PlanError(f"letter {name} of {letter.key[0]} {letter.key[1]} is {letter.place.value}")
            if letter.station != visit.station:
                raise PlanError(f"letter {name} belongs to station {letter.station}, not {visit.station}")
            step = -1 if letter.key[0] == DELIVER else 1
            contents[letter.tile] = contents.get(letter.tile, 0) + step
            room -= step
            if contents[letter.tile] < 0:
                raise PlanError(f"bucket {plan.bucket} holds too few {name}")
            if room < 0:
                raise PlanError(f"bucket {plan.bucket} has too little room for {name}")
