"""Cell lists: which discs are near a point, at a cost that does not grow with the number of discs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from soup_msgs_py.kernel import kernel, maker
from soup_msgs_py.messages import Floats

Cells = NDArray[np.int32]


@kernel
def cell_of(value: float, size: float, count: int) -> int:
    """Index along one axis; what lies off the floor belongs to the cell at its edge."""
    cell = int(value / size)
    if cell < 0:
        return 0
    return cell if cell < count else count - 1


@maker
def fill_cells(
    x: Floats, y: Floats, wanted: NDArray[np.bool_], size: float, columns: int, rows: int
) -> tuple[Cells, Cells]:
    """Sort discs into square cells.

    Returns:
        `start`, shape (columns * rows + 1,), and `member`: the discs of cell c are
        `member[start[c]:start[c + 1]]`, ascending.
    """
    n = len(x)
    start = np.zeros(columns * rows + 2, np.int32)
    place = np.empty(n, np.int32)
    for i in range(n):
        if wanted[i]:
            c = cell_of(y[i], size, rows) * columns + cell_of(x[i], size, columns)
            place[i] = c
            start[c + 2] += 1
    for c in range(2, columns * rows + 2):
        start[c] += start[c - 1]
    member = np.empty(n, np.int32)
    for i in range(n):
        if wanted[i]:
            c = place[i] + 1
            member[start[c]] = i
            start[c] += 1
    return start[:-1], member
