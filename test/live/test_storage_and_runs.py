"""A person changes where buckets may rest; a world that is started again is a new run for everybody."""

from __future__ import annotations

import pytest
from soup_msgs import msg, srv

from .conftest import Parts
from .person import Person
from .test_by_hand import granted, refused

pytestmark = [pytest.mark.live, pytest.mark.timeout(600)]


def test_a_person_makes_a_storage_spot_and_takes_it_away(parts: Parts):
    world = parts.start("run_world.py")
    told: list[msg.Event] = []
    with Person() as person:
        for kind, topic in ((msg.Scenario, "/world/scenario"), (msg.Snapshot, "/world/snapshot")):
            person.listen(kind, topic, latched=True)
        person.node.create_subscription(msg.Event, "/world/events", told.append, 100)
        person.wait(lambda: {"/world/scenario", "/world/snapshot"} <= person.heard.keys(), "the world is there")
        layout = person.heard["/world/scenario"].layout
        spots = set(layout.storage_spots)
        assert set(person.heard["/world/snapshot"].storage_spots) == spots
        stations = {*layout.word_stations, *layout.letter_stations}
        lane = next(w for w in range(len(layout.waypoint_x)) if w not in spots | stations)

        name = "/world/set_storage_spot"
        granted(person.call(srv.SetStorageSpot, name, waypoint=lane, storage=True))
        refused(person.call(srv.SetStorageSpot, name, waypoint=lane, storage=True), "not_needed")
        refused(person.call(srv.SetStorageSpot, name, waypoint=layout.word_stations[0], storage=True), "blocked")
        refused(person.call(srv.SetStorageSpot, name, waypoint=-7, storage=True), "unknown")
        person.wait(lambda: set(person.heard["/world/snapshot"].storage_spots) == spots | {lane}, "the snapshot")
        granted(person.call(srv.SetStorageSpot, name, waypoint=lane, storage=False))
        person.wait(lambda: set(person.heard["/world/snapshot"].storage_spots) == spots, "the snapshot after that")
        changes = [(event.type, event.waypoint) for event in told if event.type.startswith("spot_")]
        assert changes == [("spot_made", lane), ("spot_removed", lane)]
    parts.interrupt(world)


def test_managers_and_bots_begin_anew_with_a_world_that_is_started_again(parts: Parts):
    def start_world():
        return parts.start("run_world.py", "--speed", "5", "--set", "bots=1", "--seed", "5")

    others = [parts.start("run_bots.py", "0"), parts.start("run_fleet_manager.py"), parts.start("run_word_manager.py")]
    world = start_world()
    with Person() as person:
        person.listen(msg.Snapshot, "/world/snapshot", latched=True)
        person.listen(msg.Buckets, "/world/buckets")

        def works() -> bool:
            """Words are open, and the bot has fetched a bucket for one."""
            snapshot, buckets = person.heard.get("/world/snapshot"), person.heard.get("/world/buckets")
            if snapshot is None or buckets is None:
                return False
            return any(station.open_words for station in snapshot.word_stations) and max(buckets.bot) >= 0

        person.wait(works, "work in the first world")
        first = person.heard["/world/snapshot"].run
        parts.interrupt(world)
        person.heard.clear()
        world = start_world()
        # the first world's last messages may still be on their way
        person.wait(lambda: works() and person.heard["/world/snapshot"].run != first, "work in the second world")
    for process in [*others, world]:
        parts.interrupt(process)
