"""The word manager: puts words on word stations and has the fleet bring their letters."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from soup_managers.explain import Explain
from soup_managers.policies.word import WordPolicy
from soup_managers.stations.station_manager import StationManager
from soup_managers.view import WarehouseView
from soup_msgs_py.codes import EventType
from soup_msgs_py.messages import DELIVER, AssignBundle, AssignWord, Bound, DeliverGoal, Event
from soup_msgs_py.mind import Message
from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Layout

_REACTS_TO = frozenset({EventType.WORD_ASSIGNED, EventType.WORD_ARRIVED, EventType.WORD_CLEARED})


class WordManager(StationManager):
    """Opens waiting words where a word station has a place free; each open word is a task of the fleet."""

    kind = DELIVER
    role = "word"

    def __init__(
        self,
        scenario: Scenario,
        layout: Layout,
        policy: WordPolicy,
        view: WarehouseView,
        rng: np.random.Generator,
        explain: Explain | None = None,
    ) -> None:
        super().__init__(view, range(len(layout.word_stations)), explain)
        self.policy = policy
        policy.explain = self._explain
        self._rng = rng
        self._handlers |= {Bound: self._handle_bound}

    @property
    def reacts_to(self) -> frozenset[EventType]:
        """Words that come and go."""
        return _REACTS_TO

    def on_event(self, event: Event, now: float) -> list[Message]:
        """A word that was opened needs letters; a place that became free needs a word."""
        if event.type is EventType.WORD_ASSIGNED:
            return self.assigned(event.job, event.station, -1, now)
        if event.type is EventType.WORD_ARRIVED or event.type is EventType.WORD_CLEARED:
            return self.fill_places(now)
        return []

    def jobs(self) -> Iterable[int]:
        """All open words."""
        return self.view.open_words

    def goal(self, job: int) -> DeliverGoal | None:
        """The letters that a word lacks."""
        word = self.view.open_words.get(job)
        missing = word.missing if word is not None else ()
        return DeliverGoal(job, word.station, job, missing) if word is not None and missing else None

    def choose(self, free: list[int]) -> AssignWord | None:
        """What the word policy says, where words wait."""
        return self.policy.choose(self.view, free, self._rng) if self.view.waiting_words else None

    def problem(self, choice: AssignWord | AssignBundle) -> str:
        """Only a word that waits can be opened."""
        is_there = isinstance(choice, AssignWord) and choice.word in self.view.waiting_words
        return "" if is_there else "a word that does not wait"

    def _handle_bound(self, bound: Bound, now: float) -> list[Message]:
        stations: dict[int, list[int]] = {}
        for bucket, station in zip(bound.buckets, bound.stations, strict=True):
            if bucket >= 0:
                stations.setdefault(station, []).append(bucket)
        self.view.bound = stations
        return []
