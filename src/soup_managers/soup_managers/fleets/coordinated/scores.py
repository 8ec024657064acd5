"""Scores as policies give them: one number for each alternative, or the policy has made a mistake."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from soup_msgs_py.mistakes import Mistakes
from soup_msgs_py.warehouse.layout import Floats


@dataclass(frozen=True)
class Scores:
    """Makes sure that the fleet can reckon with what a policy says.

    Attributes:
        mistakes: Where it is noted what it cannot reckon with.
        decision: Which decision the policy takes.
        policy: The policy.
        nothing: The score that stands for none: what is no number becomes this.
    """

    mistakes: Mistakes
    decision: str
    policy: object
    nothing: float

    def of(self, scores: Any, count: int) -> Floats:
        """The scores of so many alternatives."""
        try:
            found = np.asarray(scores, np.float64)
        except (TypeError, ValueError):
            found = np.zeros(())
        if found.shape != (count,):
            self._note("scores for other things than it was asked for", f"{found.shape} instead of ({count},)")
            return np.full(count, self.nothing)
        wrong = np.isnan(found)
        if wrong.any():
            self._note("scores that are no numbers", f"{np.count_nonzero(wrong)} of {count}")
            return np.where(wrong, self.nothing, found)
        return found

    def of_all(self, rows: Iterable[Any], wanted: int, count: int) -> Iterator[Floats]:
        """The scores of the alternatives of several things that were asked about at once."""
        rows = list(rows)
        if len(rows) != wanted:
            self._note("scores for other things than it was asked for", f"{len(rows)} rows instead of {wanted}")
            rows = [np.full(count, self.nothing)] * wanted
        return (self.of(row, count) for row in rows)

    def _note(self, what: str, chosen: str) -> None:
        self.mistakes.add(self.decision, self.policy, what, chosen)
