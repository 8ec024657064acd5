"""Decisions that explain themselves: each choice with its best alternatives and their scores."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

ALTERNATIVES = 5

Sink = Callable[[dict[str, Any]], None]


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
        **about: int,
    ) -> None:
        """Tell a choice.

        Args:
            decision: Which decision.
            chosen: The name of what was chosen, -1 for nothing.
            scores: Of all alternatives, the highest is the best; those that are not finite or 0 are left out.
            names: What the alternatives are called; their index if not given.
            about: What the choice is for.
        """
        if self._sink is None:
            return
        best = [k for k in np.argsort(-scores, kind="stable")[:ALTERNATIVES].tolist() if _counts(float(scores[k]))]
        called = names if names is not None else np.arange(len(scores))
        alternatives = [{"choice": int(called[k]), "score": round(float(scores[k]), 6)} for k in best]
        entry = {"time": round(self.now, 6), "decision": decision, **about, "chosen": int(chosen)}
        self._sink({**entry, "alternatives": alternatives})


def write_lines(file: IO[str]) -> Sink:
    """A sink that writes each choice as one line of JSON."""

    def write(entry: dict[str, Any]) -> None:
        file.write(json.dumps(entry, separators=(",", ":")) + "\n")

    return write


def _counts(score: float) -> bool:
    return bool(np.isfinite(score)) and score != 0.0
