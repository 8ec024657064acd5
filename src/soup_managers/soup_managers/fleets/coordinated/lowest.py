"""The few best of many."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def lowest(costs: NDArray[Any], most: int) -> list[int]:
    """Indices of the lowest costs, shape (n,), at most so many, the lowest first; of equals the first one first."""
    if len(costs) <= 4 * most:
        return np.argsort(costs, kind="stable")[:most].tolist()
    low = np.flatnonzero(costs <= np.partition(costs, most - 1)[most - 1])
    return low[np.argsort(costs[low], kind="stable")[:most]].tolist()
