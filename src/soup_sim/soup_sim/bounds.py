"""What no run can exceed: the word rate of the stations, and that of the fleet. Derived in docs/bounds.md."""

from __future__ import annotations

import math
from dataclasses import dataclass

from scipy.spatial.distance import cdist

from soup_msgs_py.scenario import Scenario
from soup_msgs_py.warehouse.layout import Layout


@dataclass(frozen=True, slots=True)
class Bounds:
    """The bounds of a warehouse.

    Attributes:
        word_rate: The most words a second of mean length that the word stations can build (words/s).
        fleet_rate: The most words a second of mean length that so many bots can give, with as many letters brought in
            as taken out (words/s).
        crossing_s: The least time that a bucket needs from a letter station to a word station (s).
    """

    word_rate: float
    fleet_rate: float
    crossing_s: float


def bounds(scenario: Scenario, layout: Layout, mean_word_length: float) -> Bounds:
    """The bounds of a warehouse whose words have so many letters on average."""
    crossing = crossing_s(scenario, layout)
    word_rate = word_rate_bound(scenario, mean_word_length)
    return Bounds(word_rate, fleet_rate_bound(scenario, crossing, mean_word_length), crossing)


def word_rate_bound(scenario: Scenario, mean_word_length: float) -> float:
    """The most words a second of mean length that the word stations can build (words/s).

    Each moves one tile in `transfer_s`. A policy that opens short words builds more of them: whether a run is at its
    bound is a matter of letters, see `Statistics`.
    """
    station = scenario.word_station
    seconds_per_word = mean_word_length * station.transfer_s + station.clear_s
    return scenario.word_station_count / seconds_per_word if seconds_per_word > 0 else math.inf


def crossing_s(scenario: Scenario, layout: Layout) -> float:
    """The least time in which a bucket gets from a letter station to a word station, or back (s)."""
    words, letters = layout.waypoints[layout.word_stations], layout.waypoints[layout.letter_stations]
    apart = float(cdist(words, letters).min()) if len(words) and len(letters) else 0.0
    apart -= scenario.word_station.tolerance_m + scenario.letter_station.tolerance_m
    return max(0.0, apart) / scenario.bot.max_speed_mps


def letter_s(scenario: Scenario, crossing: float) -> float:
    """The least time of a bot that a letter takes: both transfers, and its share of a way there and back (s)."""
    transfers = scenario.word_station.transfer_s + scenario.letter_station.transfer_s
    return transfers + 2.0 * crossing / scenario.bucket.capacity


def fleet_rate_bound(scenario: Scenario, crossing: float, mean_word_length: float) -> float:
    """The most words a second of mean length that so many bots can give (words/s); `crossing` as in `Bounds` (s)."""
    seconds_per_word = mean_word_length * letter_s(scenario, crossing)
    return scenario.bots / seconds_per_word if seconds_per_word > 0 else math.inf
