"""The letter manager: decides which letters come in and has the fleet store them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from soup_managers.explain import Explain
from soup_managers.policies.letter import LetterPolicy
from soup_managers.stations.station_manager import StationManager
from soup_managers.view import WarehouseView
from soup_msgs_py.codes import EventType
from soup_msgs_py.messages import STORE, AssignBundle, AssignWord, Event, StoreGoal
from soup_msgs_py.mind import Message
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Floats, Layout

_REACTS_TO = frozenset(
    {EventType.BUNDLE_STAGED, EventType.BUNDLE_EMPTIED, EventType.BUNDLE_ARRIVED, EventType.WORD_ASSIGNED}
)
_WITH_PLACES = _REACTS_TO | {EventType.TRANSFERRED}


class LetterManager(StationManager):
    """Stages bundles where a letter station has a place free; each staged bundle is a task of the fleet."""

    kind = STORE
    role = "letter"

    def __init__(
        self,
        scenario: Scenario,
        layout: Layout,
        policy: LetterPolicy,
        view: WarehouseView,
        rng: np.random.Generator,
        tile_profile: Floats,
        explain: Explain | None = None,
    ) -> None:
        """Make a letter manager.

        Args:
            scenario: The warehouse.
            layout: Its floor.
            policy: What decides.
            view: What it knows of the world.
            rng: For the policy's random draws.
            tile_profile: Expected share of each tile kind in all tiles, shape (kinds,).
            explain: Is told what the policy's choices are made of.
        """
        words = len(layout.word_stations)
        super().__init__(view, range(words, words + len(layout.letter_stations)), explain)
        self.policy = policy
        policy.explain = self._explain
        self._rng = rng
        self._target = tile_profile * (scenario.initial_inventory * scenario.buckets * scenario.bucket.capacity)

    @property
    def reacts_to(self) -> frozenset[EventType]:
        """Bundles and words that come and go; used letters too, while there is a place for a bundle of new ones."""
        has_place = any(self.view.free_places[station] > 0 for station in self._stations)
        return _WITH_PLACES if has_place else _REACTS_TO

    def on_event(self, event: Event, now: float) -> list[Message]:
        """A bundle that was staged is to be stored; a place or a gap in the stock is to be filled."""
        kind = event.type
        if kind is EventType.BUNDLE_STAGED:
            return self.assigned(event.job, event.station, event.tile, now)
        fills = kind is EventType.BUNDLE_EMPTIED or kind is EventType.BUNDLE_ARRIVED or kind is EventType.WORD_ASSIGNED
        consumed = kind is EventType.TRANSFERRED and event.station < self._stations.start
        return self.fill_places(now) if fills or consumed else []

    def jobs(self) -> Iterable[int]:
        """All staged bundles."""
        return self.view.staged_bundles

    def goal(self, job: int) -> StoreGoal | None:
        """The tiles that are still in a bundle."""
        bundle = self.view.staged_bundles.get(job)
        if bundle is None or bundle.count <= 0:
            return None
        return StoreGoal(job, bundle.station, job, bundle.tile, bundle.count)

    def choose(self, free: list[int]) -> AssignBundle | None:
        """What the letter policy says."""
        return self.policy.choose(self.view, free, self._target, self._rng)

    def problem(self, choice: AssignWord | AssignBundle) -> str:
        """Only a bundle that waits can be staged or, where bundles are chosen, a new one of a kind that there is."""
        if not isinstance(choice, AssignBundle):
            return "what is no bundle"
        if choice.bundle >= 0:
            return "" if choice.bundle in self.view.waiting_bundles else "a bundle that does not wait"
        if self.view.scenario.bundles.kind != "chosen":
            return "a new bundle, where bundles come by themselves"
        return "" if 0 <= choice.tile < self.view.kinds else "a kind of tile that there is not"
