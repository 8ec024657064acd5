"""The figures of a run (paper, "Simulation Parameters and Metrics"), over the time after the warm-up."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from soup_msgs_py.codes import BotState, EventType
from soup_msgs_py.messages import Event, Floats
from soup_msgs_py.scenario import Scenario
from soup_sim.bounds import Bounds
from soup_sim.standstill import patience_s

_GIVEN = ("_scenario", "_bounds", "_capacity")  # what comes from the scenario, and no checkpoint needs
_BY_NUMBER = ("_busy_since", "_waiting", "_open", "_brought", "_taken")  # what a checkpoint holds as pairs
_FREE = BotState.FREE  # looked up once: an enumeration's members are slow to reach


class Statistics:
    """Counts events and integrates states over time.

    `fraction_of_bound` is the share of all word stations' time that went into what was done: letters moved into words,
    and words cleared away. So it cannot exceed 1, whatever words are chosen. For words of mean length it is their rate
    over `word_rate_bound`.

    `fraction_of_fleet_bound` is the share of all bots' time that no fleet could have spared: their transfers and, for
    each letter that was brought in and taken out, its share of the least way there and back. It cannot exceed 1 either.

    Args:
        scenario: The scenario.
        bounds: What no run can exceed.
        inventory: Tiles in buckets at the start.
    """

    def __init__(self, scenario: Scenario, bounds: Bounds, inventory: int) -> None:
        self._scenario, self._bounds = scenario, bounds
        self._capacity = scenario.bucket.capacity * scenario.buckets
        self._inventory = inventory
        self._state = [BotState.FREE] * scenario.bots
        self._idle_since = [0.0] * scenario.bots
        self._busy_since: dict[int, float] = {}
        self._waiting: dict[int, float] = {}  # when each word was ordered that no station has yet, the oldest first
        self._moved_at = 0.0  # when a tile was moved last, or the first word ordered after all others were complete
        self._open: dict[int, float] = {}  # the same of those that stations work on
        self._begin(0.0, np.zeros(scenario.bots))

    def _begin(self, now: float, driven: Floats) -> None:
        """Start counting anew: the warm-up is over."""
        self._start, self._driven_start = now, driven.copy()
        self.words_completed = self.letters_in_words = self.letters_dispensed = 0
        self.grabs = self.releases = self.bot_collisions = self.bucket_collisions = 0
        self._word_transfers = self._letter_transfers = self._word_visits = self._letter_visits = 0
        self._last_visit = [-1] * len(self._state)
        self._word_times: list[float] = []
        self._idle = 0.0
        self._idle_since = [now] * len(self._state)
        self._done_s = 0.0  # what word stations have done, in the time that it takes
        self._bots_s = 0.0  # what bots have done at stations, in the time that it takes
        self._crossed = 0  # letters that were taken from a letter station to a word station, and room taken back
        self._brought: dict[int, int] = {}  # letters in each bucket that came in and may be taken out
        self._taken: dict[int, int] = {}  # room in each bucket that was made and may be filled
        self._busy = [0.0, 0.0]
        self._busy_since = dict.fromkeys(self._busy_since, now)
        self._fill_area, self._fill_since = 0.0, now
        self._inventory_start = self._inventory

    def ordered(self, words: Iterable[int], now: float) -> None:
        """Words have been ordered without an event: those at the start of a run."""
        self._waiting.update(dict.fromkeys(words, now))

    def begin_window(self, now: float, driven: Floats) -> None:
        """Forget what the warm-up counted; `driven` is each bot's odometer now (m)."""
        self._begin(now, driven)

    def count(self, event: Event) -> None:
        """Take one event in."""
        kind = event.type
        if kind is EventType.TRANSFERRED:
            self._moved_at = event.time
            at_words = event.station < self._scenario.word_station_count
            visit = self._last_visit[event.bot] != event.station
            self._last_visit[event.bot] = event.station
            self._fill(event.time)
            if at_words:
                self._inventory -= 1
                self._word_transfers += 1
                took = min(self._scenario.word_station.transfer_s, event.time - self._start)
                self._done_s += took
                self._crosses(self._brought, self._taken, event.bucket)
                self._word_visits += visit
            else:
                self._inventory += 1
                self.letters_dispensed += 1
                self._letter_transfers += 1
                took = min(self._scenario.letter_station.transfer_s, event.time - self._start)
                self._crosses(self._taken, self._brought, event.bucket)
                self._letter_visits += visit
            self._bots_s += took
        elif kind is EventType.WORD_COMPLETED:
            self.words_completed += 1
            self.letters_in_words += event.count
            if event.job in self._open:
                self._word_times.append(event.time - self._open.pop(event.job))
        elif kind is EventType.WORD_CLEARED:
            self._done_s += min(self._scenario.word_station.clear_s, event.time - self._start)
        elif kind is EventType.GRABBED:
            self.grabs += 1
            self._last_visit[event.bot] = -1
        elif kind is EventType.RELEASED:
            self.releases += 1
            self._last_visit[event.bot] = -1
        elif kind is EventType.BOT_COLLISION:
            self.bot_collisions += 1
        elif kind is EventType.BUCKET_COLLISION:
            self.bucket_collisions += 1
        elif kind is EventType.WORD_ARRIVED:
            if not self._waiting and not self._open:
                self._moved_at = event.time
            self._waiting[event.job] = event.time
        elif kind is EventType.WORD_ASSIGNED and event.job in self._waiting:
            self._open[event.job] = self._waiting.pop(event.job)

    def bot_state(self, bot: int, state: BotState, now: float) -> None:
        """A bot's body does something else from now on."""
        old = self._state[bot]
        if old is state:
            return
        if old is _FREE:
            self._idle += now - self._idle_since[bot]
        elif state is _FREE:
            self._idle_since[bot] = now
        self._state[bot] = state

    def station_busy(self, station: int, busy: bool, now: float) -> None:
        """A station begins or ends doing something."""
        if busy:
            self._busy_since.setdefault(station, now)
        elif station in self._busy_since:
            kind = 0 if station < self._scenario.word_station_count else 1
            self._busy[kind] += now - self._busy_since.pop(station)

    def capture(self) -> dict[str, Any]:
        """Everything that this part remembers, for a checkpoint."""
        state = {key: value for key, value in vars(self).items() if key not in _GIVEN}
        state["_driven_start"] = self._driven_start.tolist()
        state["_state"] = [int(value) for value in self._state]
        for key in _BY_NUMBER:
            state[key] = list(state[key].items())
        return state

    def restore(self, state: dict[str, Any]) -> None:
        """The opposite of `capture`."""
        vars(self).update({key: list(value) if isinstance(value, list) else value for key, value in state.items()})
        self._driven_start = np.array(state["_driven_start"])
        self._state = [BotState(value) for value in state["_state"]]
        for key in _BY_NUMBER:
            setattr(self, key, dict(map(tuple, state[key])))

    def _crosses(self, there: dict[int, int], here: dict[int, int], bucket: int) -> None:
        """A tile is moved where a bucket is; what was done with it at the other kind of station went the way between.

        No more of it than the bucket holds went at a time.
        """
        here[bucket] = here.get(bucket, 0) + 1
        if there.get(bucket, 0):
            there[bucket] -= 1
            self._crossed += 1

    def _fill(self, now: float) -> None:
        self._fill_area += self._inventory * (now - self._fill_since)
        self._fill_since = now

    def stalled_since(self, now: float) -> float | None:
        """Since when nothing has been moved though words are on order (s); None where work goes on."""
        waits = bool(self._waiting or self._open)
        return self._moved_at if waits and now - self._moved_at > patience_s(self._scenario) else None

    def figures(self, now: float, driven: Floats) -> dict[str, Any]:
        """All figures at simulated time `now`, None for those without a value; `driven` is each bot's odometer (m)."""
        scenario = self._scenario
        seconds = now - self._start
        per_second = 1.0 / seconds if seconds > 0 else 0.0
        distance = float((driven - self._driven_start).sum())
        standing = zip(self._state, self._idle_since, strict=True)
        idle = self._idle + sum(now - since for state, since in standing if state is _FREE)
        busy = list(self._busy)
        for station, since in self._busy_since.items():
            busy[0 if station < scenario.word_station_count else 1] += now - since
        self._fill(now)
        fill = self._fill_area * per_second if seconds > 0 else float(self._inventory)
        rate = self.words_completed * per_second
        share = self._done_s * per_second / scenario.word_station_count
        bounds = self._bounds
        needed_s = self._bots_s + self._crossed * bounds.crossing_s / scenario.bucket.capacity
        return {
            "sim_seconds": now,
            "words_completed": self.words_completed,
            "letters_in_words": self.letters_in_words,
            "words_per_second": rate,
            "word_rate_bound": bounds.word_rate,
            "fraction_of_bound": share if math.isfinite(bounds.word_rate) else math.nan,
            "fleet_rate_bound": bounds.fleet_rate,
            "fraction_of_fleet_bound": (
                needed_s * per_second / scenario.bots if math.isfinite(bounds.fleet_rate) else math.nan
            ),
            "word_time_mean_s": sum(self._word_times) / len(self._word_times) if self._word_times else None,
            "word_time_p95_s": float(np.percentile(self._word_times, 95)) if self._word_times else None,
            "oldest_waiting_word_s": now - next(iter(self._waiting.values()), now),
            "letters_dispensed": self.letters_dispensed,
            "distance_total_m": distance,
            "distance_mean_m": distance / scenario.bots,
            "grabs": self.grabs,
            "releases": self.releases,
            "bot_collisions": self.bot_collisions,
            "bucket_collisions": self.bucket_collisions,
            "bot_idle_fraction": idle * per_second / scenario.bots,
            "bucket_fill_mean": fill / self._capacity,
            "pile_on_word": _ratio(self._word_transfers, self._word_visits),
            "pile_on_letter": _ratio(self._letter_transfers, self._letter_visits),
            "word_station_idle_fraction": _idle(busy[0] * per_second, scenario.word_station_count, seconds),
            "letter_station_idle_fraction": _idle(busy[1] * per_second, scenario.letter_station_count, seconds),
            "inventory_fill_start": self._inventory_start / self._capacity,
            "inventory_fill_end": self._inventory / self._capacity,
            "stalled_since_s": self.stalled_since(now),
        }


def _ratio(tiles: int, visits: int) -> float:
    return tiles / visits if visits else 0.0


def _idle(busy_stations: float, stations: int, seconds: float) -> float:
    return 1.0 - busy_stations / stations if seconds > 0 else 1.0
