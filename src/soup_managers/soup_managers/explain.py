"""Decisions that explain themselves: each choice with its best alternatives and their scores."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from soup_msgs_py.command_line.output_files import Lines
from soup_msgs_py.warehouse.tiles import tile_name

ALTERNATIVES = 5

Sink = Callable[[dict[str, Any]], None]


@dataclass(frozen=True)
class Decision:
    """What a line about a decision says.

    Attributes:
        chosen: What `chosen` and each `choice` number.
        about: The keys that tell what it is for.
        score: What the scores are.
    """

    chosen: str
    about: tuple[str, ...]
    score: str


BY_POLICY = "the score that the policy gives"
DECISIONS = {
    "words": Decision(
        "a waiting word, which is opened",
        ("station",),
        "`served`: share of its letters that are at the station or come anyway, and more for its age; where room in "
        "buckets is scarce, the tiles that it leaves room for; `in_stock`: minus the letters that are not there; "
        "`minimal` says nothing",
    ),
    "letters": Decision("a tile kind, of which a bundle is to come", (), "how many tiles are lacking"),
    "bundles": Decision("the letter station that gets a bundle", ("tile",), "its free places"),
    "buckets": Decision("a bucket, which is fetched for a station", ("station",), BY_POLICY),
    "bots": Decision("the bot that fetches a bucket", ("bucket",), "minus the cost that the policy gives"),
    "onward": Decision("the station that a bucket on a bot goes to next; -1: none", ("bot", "bucket"), BY_POLICY),
    "storage": Decision(
        "the waypoint where a bucket is stored; -1: none can be reached now",
        ("bot", "bucket"),
        "minus the cost that the policy gives, and more where it would bury others",
    ),
    "trips": Decision("the bucket of a whole trip of the minimal fleet", ("bot", "station", "spot"), "none"),
}


class Explain:
    """Tells a sink about choices; without one it costs nothing.

    Attributes:
        now: Simulated time (s); whoever owns this keeps it.
    """

    def __init__(self, sink: Sink | None = None) -> None:
        self._sink = sink
        self.now = 0.0

    def choice(
        self,
        decision: str,
        chosen: int,
        scores: NDArray[Any],
        names: NDArray[Any] | None = None,
        spelt: Callable[[int], str] | None = None,
        **about: int,
    ) -> None:
        """Tell a choice.

        Args:
            decision: Which decision.
            chosen: The name of what was chosen, -1 for nothing.
            scores: Of all alternatives, the highest is the best; those that are not finite or 0 are left out.
            names: The numbers of the alternatives; their index if not given.
            spelt: What a number stands for in words, where it stands for a word or a tile.
            about: What the choice is for.
        """
        if self._sink is None:
            return
        best = [k for k in np.argsort(-scores, kind="stable")[:ALTERNATIVES].tolist() if _counts(float(scores[k]))]
        called = names if names is not None else np.arange(len(scores))

        def name(number: int) -> dict[str, str]:
            return {"name": spelt(number)} if spelt is not None and number >= 0 else {}

        alternatives = [
            {"choice": int(called[k]), **name(int(called[k])), "score": round(float(scores[k]), 6)} for k in best
        ]
        numbers = {key: int(value) for key, value in about.items()}  # those of arrays are numpy's own
        tile = {"tile_name": tile_name(numbers["tile"])} if "tile" in about else {}
        entry = {"time": round(self.now, 6), "decision": decision, **numbers, **tile, "chosen": int(chosen)}
        self._sink({**entry, **name(int(chosen)), "alternatives": alternatives})


def write_lines(file: Lines) -> Sink:
    """A sink that writes each choice as one line of JSON."""

    def write(entry: dict[str, Any]) -> None:
        file.write(json.dumps(entry, separators=(",", ":")) + "\n")

    return write


def _counts(score: float) -> bool:
    return bool(np.isfinite(score)) and score != 0.0
