"""The fleet's books: which bots, buckets and storage spots are free, and which trips are under way."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from soup_managers.fleets.minimal.letter_queue import Awaited, LetterQueue
from soup_managers.fleets.minimal.letters import LetterBook
from soup_managers.fleets.minimal.plans import Key, Letter, TripPlan
from soup_managers.traffic.router import Router
from soup_managers.view import WarehouseView
from soup_msgs_py.messages import DELIVER, STORE, BotStatus, Event, Point, SetStorageSpot, TileMove, Trip, Visit
from soup_msgs_py.mind import NEVER
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Layout
from soup_msgs_py.warehouse.tiles import tile_name

LATE_S = 2.0  # how much later than the end of a trip its last events may come


@dataclass(slots=True)
class ActiveTrip:
    """A trip that a bot is on.

    Attributes:
        trip: As it was asked for.
        spot: The storage spot that it keeps, as a waypoint; -1 for none.
        letters: Those it still has to move.
        since: When it was asked for (s); minus infinity where somebody else has asked.
    """

    trip: Trip
    spot: int
    letters: list[Letter]
    since: float


class FleetState:
    """What a fleet policy may know and ask.

    Attributes:
        view: The warehouse as the world tells it.
        layout: The floor.
        router: Ways and what they cost.
        rng: For all random draws of policies.
        free_bots: Bots that stand idle without a bucket, as a bit set.
        loaded_bots: Bots that stand idle with a bucket, as a bit set; what a policy leaves over is stored.
        trips: Trips under way, by bot.
        book: The tasks and their letters.
        wishes: What the policy wants the world to change, until the fleet manager has asked for it.
    """

    def __init__(
        self,
        scenario: Scenario,
        layout: Layout,
        view: WarehouseView,
        router: Router,
        rng: np.random.Generator,
    ) -> None:
        self.view = view
        self.layout = layout
        self.router = router
        self.rng = rng
        self.book = LetterBook()
        self.trips: dict[int, ActiveTrip] = {}
        self.free_bots = 0
        self.loaded_bots = 0
        self._served: dict[Key, int] = {}  # tasks that trips under way are for, and how many
        self.wishes: list[SetStorageSpot] = []
        self._reserved_buckets = 0
        self._reserved_spots: dict[int, int] = {}  # spot to bot
        self._late: list[tuple[float, int, Letter]] = []  # moved for sure, but the event has not come: until, bot
        self._reach_m = 2 * scenario.bot.radius_m  # nearer than this, no other bot gets to the place
        self._standing: dict[int, list[int]] = {}  # idle bots, by the spots that they keep others from
        self._stands_on: dict[int, list[int]] = {}

    # ---- for policies --------------------------------------------------------------------------------------

    @property
    def free_buckets(self) -> int:
        """Buckets that rest and are on no trip, as a bit set."""
        return self.view.resting & ~self._reserved_buckets

    def letters(self) -> Iterator[Letter]:
        """Letters that wait to be moved, first in, first out; without those set aside."""
        return self.book.queue.in_order()

    def defer(self, letter: Letter, reason: str = "") -> None:
        """Set aside a letter that no free bucket can serve, until one may."""
        view = self.view
        if letter.key[0] == STORE:
            until, some, what = LetterQueue.ROOM, view.with_room, "has room"
        else:
            until, some, what = letter.tile, view.holders(letter.tile), f"holds {tile_name(letter.tile)}"
        letter.reason = reason or (f"every bucket that {what} is in use" if some else f"no bucket {what}")
        self._set_aside(letter, until)
        if not self.is_served(letter.key):
            self.book.queue.bring_back(letter.key)  # those that wait for their turn need not wait for this one

    def is_served(self, key: Key) -> bool:
        """Whether a trip is under way for a task; it is until its bucket is back in storage."""
        return key in self._served

    def hold(self, letter: Letter) -> None:
        """Set aside a letter whose task is served, until that trip has ended."""
        letter.reason = "its letters come one at a time"
        self._set_aside(letter, letter.key)

    def _set_aside(self, letter: Letter, until: Awaited) -> None:
        self.book.queue.defer(letter, until)
        task = self.book.tasks[letter.key]
        self.book.changed[task.key] = task

    def bot_under(self, bucket: int) -> int:
        """The idle bot that stands under a resting bucket, so that no other bot gets to it; -1 for none.

        It is not always one of `free_bots`: one whose trip just failed rests for a moment.
        """
        standing = self._standing.get(self.view.spot_of[bucket])
        return standing[0] if standing else -1

    def is_free_spot(self, spot: int) -> bool:
        """Whether a storage spot is empty and not kept for a bucket under way."""
        view = self.view
        if not 0 <= spot < len(view.is_storage_spot) or spot in self._reserved_spots:
            return False
        return bool(view.is_storage_spot[spot] and view.bucket_at[spot] < 0)

    def nearest_free_spot(self, x: float, y: float) -> int:
        """The free storage spot nearest to a place in metres, as a waypoint; -1 where there is none."""
        spots = np.flatnonzero(self.view.is_storage_spot)
        step = self.layout.waypoints[spots] - (x, y)
        order = np.argsort(step[:, 0] * step[:, 0] + step[:, 1] * step[:, 1], kind="stable")
        return next((spot for spot in spots[order].tolist() if self.is_free_spot(spot)), -1)

    def set_storage_spot(self, waypoint: int, storage: bool) -> None:
        """Ask the world to turn a waypoint into a storage spot, or a free one into a plain waypoint.

        `view.storage_spots` will tell whether it did: buckets have to have room. A spot that is kept for a bucket
        under way is not asked for.
        """
        if storage or waypoint not in self._reserved_spots:
            self.wishes.append(SetStorageSpot(waypoint, storage))

    # ---- for the fleet manager -----------------------------------------------------------------------------

    def start(self, plan: TripPlan, number: int, now: float) -> Trip | None:
        """Enter a trip into the books and draw its routes; None where no way leads along the waypoints."""
        trip = self._draw(plan, number)
        if trip is None:
            return None
        letters = [letter for visit in plan.visits for letter in visit.letters]
        for letter in letters:
            self.book.promise(letter)
        self._enter(plan.bot, ActiveTrip(trip, plan.spot, letters, now))
        self.leave(plan.bot)
        return trip

    def adopt(self, status: BotStatus) -> None:
        """Enter a trip that a bot is on already: what it promised counts, whoever asked for it.

        It may be one in a world that has ended since: whatever the bot says next counts, early as its time may be.
        """
        trip = status.trip
        if trip is None:
            return
        letters = []
        for visit in trip.visits[status.visits_done :]:
            for move in visit.moves:
                if move.tile >= 0 and move.job >= 0:
                    key = self._kind_at(visit.station), move.job
                    letters.append(Letter((0, 0), key, visit.station, move.tile))
                    self.book.promise(letters[-1])
        spot = self.view.spot_at(*trip.store_route[-1]) if trip.store_route else -1
        self._enter(status.bot, ActiveTrip(trip, spot, letters, -math.inf))
        self.leave(status.bot)

    def end(self, bot: int, done: bool, now: float) -> None:
        """Take a trip out of the books; letters that it did not move wait again."""
        active = self.trips.pop(bot)
        self._reserved_buckets &= ~(1 << active.trip.bucket)
        if self._reserved_spots.get(active.spot) == bot:
            del self._reserved_spots[active.spot]
        for letter in active.letters:
            if done:
                self._late.append((now + LATE_S, bot, letter))
            else:
                self.book.take_back(letter)
        self._serve_no_more(active.trip)
        self.bucket_freed(active.trip.bucket)

    def expire(self, now: float) -> float:
        """Give up waiting for late events; the time when the next wait is over (NEVER for none)."""
        if not self._late:
            return NEVER
        for until, _, letter in self._late:
            if until <= now:
                self.book.take_back(letter)
        self._late = [late for late in self._late if late[0] > now]
        return min((until for until, _, _ in self._late), default=NEVER)

    def moved(self, event: Event) -> None:
        """A tile was moved between a bucket and a station."""
        key = self._kind_at(event.station), event.job
        active = self.trips.get(event.bot)
        letters = active.letters if active is not None else []
        promised = next((letter for letter in letters if letter.tile == event.tile and letter.key == key), None)
        if promised is not None:
            letters.remove(promised)
        else:
            for late in self._late:
                if late[1] == event.bot and late[2].tile == event.tile and late[2].key == key:
                    promised = late[2]
                    self._late.remove(late)
                    break
        self.book.moved(key, event.tile, event.sequence, promised)

    def bucket_freed(self, bucket: int) -> None:
        """Bring back letters that waited for what a bucket offers, if it is free."""
        queue = self.book.queue
        awaited = queue.awaited
        if not awaited or not self.free_buckets >> bucket & 1:
            return
        offers = [tile for tile in self.view.contents[bucket] if tile in awaited]
        if LetterQueue.ROOM in awaited and self.view.with_room >> bucket & 1:
            offers.append(LetterQueue.ROOM)
        for offer in offers:
            letter = queue.bring_back(offer)
            task = self.book.tasks.get(letter.key) if letter is not None else None
            if task is not None:
                self.book.changed[task.key] = task

    def stand(self, bot: int, bucket: int, available: bool = True) -> None:
        """A bot has come to stand idle, with a bucket (-1: without)."""
        self.leave(bot)
        if bucket >= 0:
            self.loaded_bots |= available << bot
            return
        self.free_bots |= available << bot
        x, y = float(self.view.bot_x[bot]), float(self.view.bot_y[bot])
        spots = self._stands_on[bot] = self.view.spots_within(x, y, self._reach_m)
        for spot in spots:
            self._standing.setdefault(spot, []).append(bot)
        self._spots_freed(spots)

    def leave(self, bot: int) -> None:
        """A bot no longer stands idle."""
        self.free_bots &= ~(1 << bot)
        self.loaded_bots &= ~(1 << bot)
        spots = self._stands_on.pop(bot, [])
        for spot in spots:
            self._standing[spot].remove(bot)
            if not self._standing[spot]:
                del self._standing[spot]
        self._spots_freed(spots)

    def _spots_freed(self, spots: list[int]) -> None:
        for spot in spots:
            bucket = int(self.view.bucket_at[spot])
            if bucket >= 0:
                self.bucket_freed(bucket)

    def _enter(self, bot: int, active: ActiveTrip) -> None:
        self.trips[bot] = active
        for key in self._tasks_of(active.trip):
            self._served[key] = self._served.get(key, 0) + 1
        self._reserved_buckets |= 1 << active.trip.bucket
        if active.spot >= 0:
            self._reserved_spots[active.spot] = bot

    def _serve_no_more(self, trip: Trip) -> None:
        for key in self._tasks_of(trip):
            self._served[key] -= 1
            if not self._served[key]:
                del self._served[key]
                self.book.queue.bring_back(key)

    def _tasks_of(self, trip: Trip) -> set[Key]:
        return {(self._kind_at(visit.station), move.job) for visit in trip.visits for move in visit.moves}

    def _kind_at(self, station: int) -> str:
        return DELIVER if self.layout.is_word_station(station) else STORE

    def _draw(self, plan: TripPlan, number: int) -> Trip | None:
        view, router = self.view, self.router
        loaded = self.loaded_bots >> plan.bot & 1
        holder_x, holder_y = (view.bot_x, view.bot_y) if loaded else (view.bucket_x, view.bucket_y)
        holder = plan.bot if loaded else plan.bucket
        x, y = float(holder_x[holder]), float(holder_y[holder])
        fetch: tuple[Point, ...] = () if loaded else ((x, y),)
        # the spot of a resting bucket is known; anything else joins the graph where it can
        place = -1 if loaded else view.spot_of[plan.bucket]
        visits = []
        stops = [(router.station_waypoints[visit.station], visit) for visit in plan.visits]
        for goal, visit in [*stops, (plan.spot, None)]:
            way = router.route(place, goal) if place >= 0 else router.route_from_place(x, y, goal)
            if way is None:
                return None
            if visit is None:
                return Trip(number, plan.bucket, fetch, tuple(visits), way)
            moves = tuple([TileMove(letter.tile, letter.key[1]) for letter in visit.letters])
            visits.append(Visit(visit.station, moves, way))
            place = goal
        return None
