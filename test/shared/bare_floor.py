"""Bots on a floor without a warehouse: the real world and crew, nobody to manage them, and all that the crew says."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from world_hands import changed

from soup_lab.headless.simulation import Headless
from soup_msgs_py.codes import EventType
from soup_msgs_py.messages import Bots, Point
from soup_msgs_py.mind import Message
from soup_msgs_py.policies import Policies
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Layout
from soup_msgs_py.warehouse.words import WordList
from soup_sim.world import World

SIZE_M = 60.0
STATION = 2.0, 30.0  # the word station
LOOKS_S = 0.1  # between two looks at what is waited for
COLLISIONS = (EventType.BOT_COLLISION, EventType.BUCKET_COLLISION)
NOWHERE = 59.0, 59.0


class Nobody:
    """Stands where a manager was."""

    next_wake = math.inf
    wants_places = False
    reacts_to = frozenset()

    def handle(self, _message: Message, _now: float) -> list[Message]:
        return []


class BareFloor(Headless):
    """Bots and buckets at given places; a bucket may be released on the `spots`, too.

    Attributes:
        told: What the crew has said.
        contacts: How many collisions there have been.
    """

    def __init__(
        self,
        bots: Sequence[Point],
        *,
        buckets: Sequence[Point] = (),
        spots: Sequence[Point] = (),
        carrying: Mapping[int, int] | None = None,
    ) -> None:
        self.told: list[Any] = []
        self.contacts = 0
        buckets = buckets or [NOWHERE]
        scenario = Scenario.model_validate(
            {
                "name": "bare", "floor": {"width_m": SIZE_M, "height_m": SIZE_M}, "bots": len(bots),
                "buckets": len(buckets), "word_stations": 1, "letter_stations": 1, "words": "none",
                "initial_inventory": 0.0, "orders": {"kind": "none"}, "bundles": {"kind": "none"},
            }
        )  # fmt: skip
        world = World(scenario, floor_of([*buckets, *spots], bots), WordList(("BARE",), (), "none"), seed=1)
        with changed(world) as state:
            bodies, lifting = state["bodies"], state["lifting"]
            for bot, xy in enumerate(bots):
                bodies["_state"][bot][1:3] = xy
            bodies["_bucket_xy"] = buckets
            lifting["spot_of"] = [2 + bucket for bucket in range(len(buckets))]
            for bot, bucket in (carrying or {}).items():
                bodies["bucket"][bot], bodies["carrier"][bucket], lifting["spot_of"][bucket] = bucket, bot, -1
            lifting["bucket_on"] = [
                (spot, lifting["spot_of"].index(spot) if spot in lifting["spot_of"] else -1)
                for spot, _ in lifting["bucket_on"]
            ]
        super().__init__(world, Policies(), seed=1, on_event=self._count)
        for role in ("word", "letter", "fleet"):
            self.replace(role, Nobody())

    @property
    def bots(self) -> Bots:
        """The bodies of all bots now."""
        return self.world.bots()

    def go_on(self, seconds: float, until: Callable[[], bool] = lambda: False) -> bool:
        """Let simulated time pass, or until a condition holds; whether it came to hold."""
        end = self.world.now + seconds
        while self.world.now < end and not until():
            self.run(min(end, self.world.now + LOOKS_S))
        return until()

    def _count(self, event: Any) -> None:
        self.contacts += event.type in COLLISIONS

    def _say(self, speaker: Any, messages: list[Message]) -> None:
        if speaker is self.crew:
            self.told += messages
        super()._say(speaker, messages)


def floor_of(spots: Sequence[Point] = (), others: Sequence[Point] = ()) -> Layout:
    """A floor with the word station, a letter station in a corner, storage spots and other waypoints, but no edges."""
    points = [STATION, (2.0, 58.0), *spots, *others]
    return Layout(
        width_m=SIZE_M,
        height_m=SIZE_M,
        waypoints=np.array(points, float),
        edges=np.zeros((0, 2), np.int32),
        edge_weights=np.zeros(0),
        storage_spots=np.arange(2, 2 + len(spots), dtype=np.int32),
        word_stations=np.array([0], np.int32),
        letter_stations=np.array([1], np.int32),
    )
