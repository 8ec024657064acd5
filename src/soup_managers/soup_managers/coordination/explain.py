"""Decisions that explain themselves: each choice with its best alternatives and their scores."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

ALTERNATIVES = 5

Sink = Callable[[dict[str, Any]], None]


class Explain:
    """Tells a sink about choices; without one it costs nothing."""

    def __init__(self, sink: Sink | None) -> None:
        self._sink = sink

    def choice(
        self, decision: str, now: float, scores: NDArray[Any], names: NDArray[Any] | None = None, **about: int
    ) -> None:
        """Tell a choice.

        Args:
            decision: Which decision.
            now: Simulated time (s).
            scores: Of all alternatives, the highest is the best; those that are not finite or 0 are left out.
            names: What the alternatives are called; their index if not given.
            about: What the choice is for.
        """
        if self._sink is None:
            return
        best = [k for k in np.argsort(-scores, kind="stable")[:ALTERNATIVES].tolist() if _counts(float(scores[k]))]
        called = names if names is not None else np.arange(len(scores))
        alternatives = [{"choice": int(called[k]), "score": round(float(scores[k]), 6)} for k in best]
        self._sink({"time": now, "decision": decision, **about, "alternatives": alternatives})


def _counts(score: float) -> bool:
    return bool(np.isfinite(score)) and score != 0.0
