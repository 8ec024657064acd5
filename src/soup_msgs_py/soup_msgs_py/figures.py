"""The figures of a run: for each key of a summary its words, its unit and what it means, and how its value is written.

One source for the table on the screen, the page and `docs/reference/figures.md`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

SHARE = "%"  # of a figure that is a share, 0 to 1


@dataclass(frozen=True)
class Figure:
    """What a person needs to read a value.

    Attributes:
        words: What the figure is called where a person reads it.
        unit: Of the value as it is shown; a share is shown in percent. Empty for counts and names.
        meaning: How it is counted.
    """

    words: str
    unit: str
    meaning: str


FIGURES = {
    "sim_seconds": Figure("simulated time", "s", "from the start of the run, warm-up included"),
    "wall_seconds": Figure("wall time", "s", "that the run took"),
    "real_time_factor": Figure("real-time factor", "", "simulated seconds for each wall second"),
    "words_completed": Figure("words completed", "", "all words that were finished after the warm-up"),
    "letters_in_words": Figure("letters in them", "", "letters of the completed words"),
    "words_per_second": Figure("word rate", "words/s", "words completed for each simulated second after the warm-up"),
    "word_rate_bound": Figure(
        "bound of the word rate",
        "words/s",
        "what the word stations could do with words of mean length if letters were always at hand",
    ),
    "fraction_of_bound": Figure(
        "share of the bound", SHARE, "what word stations moved and cleared, over what they could in that time"
    ),
    "fleet_rate_bound": Figure(
        "bound of the fleet",
        "words/s",
        "what so many bots could do with words of mean length: both transfers of a letter, and the least way in full "
        "buckets",
    ),
    "fraction_of_fleet_bound": Figure(
        "share of the fleet's bound", SHARE, "time of the bots that no fleet could have spared, over all of their time"
    ),
    "stalled_since_s": Figure(
        "stalled since", "s", "when a letter was moved last, where it is long ago and words are on order; else null"
    ),
    "word_time_mean_s": Figure(
        "time of a word, mean", "s", "from its order to its completion, of the words completed after the warm-up"
    ),
    "word_time_p95_s": Figure("time of a word, 95 %", "s", "what 95 % of these words do not exceed"),
    "oldest_waiting_word_s": Figure(
        "oldest waiting word", "s", "since the order of the oldest word that no station has opened yet, at the end"
    ),
    "letters_dispensed": Figure("letters dispensed", "", "tiles that letter stations put into buckets"),
    "distance_total_m": Figure("distance, all bots", "m", "driven by all bots together"),
    "distance_mean_m": Figure("distance, mean bot", "m", "driven by one bot on average"),
    "grabs": Figure("grabs", "", "buckets lifted"),
    "releases": Figure("releases", "", "buckets set down"),
    "bot_collisions": Figure("bot collisions", "", "of a bot with a bot"),
    "bucket_collisions": Figure("bucket collisions", "", "of a carried bucket with another bucket"),
    "bot_idle_fraction": Figure("bots idle", SHARE, "share of the bots' time without a request under way"),
    "bucket_fill_mean": Figure("buckets, mean fill", SHARE, "tiles over capacity, mean over time and buckets"),
    "pile_on_word": Figure("pile-on, word stations", "tiles/visit", "tiles transferred for each visit of a bucket"),
    "pile_on_letter": Figure("pile-on, letter stations", "tiles/visit", "tiles transferred for each visit of a bucket"),
    "word_station_idle_fraction": Figure("word stations idle", SHARE, "share of their time without a transfer"),
    "letter_station_idle_fraction": Figure("letter stations idle", SHARE, "share of their time without a transfer"),
    "inventory_fill_start": Figure("stock at the start", SHARE, "tiles over the capacity of all buckets"),
    "inventory_fill_end": Figure("stock at the end", SHARE, "tiles over the capacity of all buckets"),
    "bots": Figure("bots", "", "of the scenario"),
    "buckets": Figure("buckets", "", "of the scenario"),
    "word_stations": Figure("word stations", "", "of the scenario"),
    "letter_stations": Figure("letter stations", "", "of the scenario"),
    "scenario": Figure("scenario", "", "its name"),
    "policies": Figure("policy", "", "the name of the policy of each role: word, letter, fleet, bot"),
    "seed": Figure("seed", "", "of all random numbers"),
    "violations": Figure("violations", "", "broken conservation laws, found by the judge; anything but 0 is a fault"),
    "station_policies": Figure("station policy", "", "what word stations and letter stations do next by themselves"),
    "latency_s": Figure(
        "time without answers", "s", "simulated time that went on without a part or message that was waited for in vain"
    ),
}
_NONE = {"violations": "not judged", "stalled_since_s": "never"}  # what no value says
# Of a running world only, on /world/statistics.
LIVE_FIGURES = {
    "refused_requests": Figure("refused requests", "", "requests that the world answered with no"),
    "malformed_messages": Figure("malformed messages", "", "messages that made no sense and were dropped"),
}
# Of a joint plan, in the summary of scripts/plan_world.py.
PLAN_FIGURES = {
    "planner": Figure("planner", "", "its name"),
    "rules": Figure("rules", "", "what robots may do"),
    "makespan": Figure("steps of the plan", "", "until the last box is on its shelf"),
    "proven_optimal": Figure("proven shortest", "", "whether no plan has fewer steps"),
    "lower_bound": Figure("fewest steps possible", "", "no plan has fewer; the planner knows no more"),
    "gap": Figure("steps over fewest possible", "", "1 for a plan that is proven shortest"),
    "nodes_generated": Figure("states generated", "", "in the search"),
    "nodes_expanded": Figure("states expanded", "", "in the search"),
    "search_seconds": Figure("search time", "s", "wall time"),
    "robots": Figure("robots", "", "in the world"),
    "boxes": Figure("boxes", "", "in the world"),
    "note": Figure("note", "", "why there is no plan, or what it is worth"),
}
_NEGLIGIBLE = 1e-6  # half an interval that says nothing about the digits of its mean
_ALL = {**PLAN_FIGURES, **LIVE_FIGURES, **FIGURES}


def known(key: str) -> Figure:
    """The figure of a key; of one that nobody has described, its own key in words."""
    return _ALL.get(key) or Figure(key.replace("_", " "), "", "")


def rows(figures: Mapping[str, Any]) -> Iterable[tuple[str, str, str, str]]:
    """Figures as a person reads them, one row each: key, words, value, unit."""
    for key, value in figures.items():
        figure = known(key)
        if isinstance(value, Mapping):
            for part, name in value.items():
                yield key, f"{figure.words}, {part.replace('_', ' ')}", written(name), ""
        else:
            yield key, figure.words, told(key, value), figure.unit


def told(key: str, value: Any) -> str:
    """The value of a figure as a person reads it, in the figure's unit."""
    if value is None and key in _NONE:
        return _NONE[key]
    return str(value) if key == "seed" else written(value, known(key).unit)


def with_interval(mean: float, half_width: float | None) -> str:
    """A mean as far as it is known: half its interval to two digits, and the mean no further than these."""
    if half_width is None:
        return written(mean)
    if half_width < _NEGLIGIBLE:
        return f"{written(mean)} ± {written(half_width)}"
    places = max(0, 1 - math.floor(math.log10(half_width)))
    return f"{mean:,.{places}f} ± {half_width:,.{places}f}"


def written(value: Any, unit: str = "") -> str:
    """A value in the unit of its figure: counts whole, measured ones to three digits, at least to whole ones."""
    if value is None:
        return "not known"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if not isinstance(value, (int, float)):
        return str(value)
    if unit == SHARE:
        value = 100.0 * value
    if isinstance(value, int) or abs(value) >= 100.0:
        return f"{value:,.0f}"
    return f"{value:.3g}"
