"""Cell lists: which discs are near a point, at a cost that does not grow with the number of discs."""

from __future__ import annotations

from soup_msgs_py.kernel import kernel

CELL_M = 12.0  # much smaller or larger cells cost time


@kernel
def cell_of(value: float, size: float, count: int) -> int:
    """Index along one axis; what lies off the floor belongs to the cell at its edge."""
    cell = int(value / size)
    if cell < 0:
        return 0
    return cell if cell < count else count - 1


@kernel
def fill_cells(x, y, wanted, size, columns, rows, start, member, place):
    """Sort discs into square cells.

    Args:
        x: Where the discs are, shape (n,).
        y: Where the discs are, shape (n,).
        wanted: Which of them to sort, shape (n,).
        size: Side of a cell.
        columns: Number of cells along x.
        rows: Number of cells along y.
        start: Shape (columns * rows + 2,); takes where the discs of each cell begin in `member`. Those of cell c
            are `member[start[c] : start[c + 1]]`, ascending.
        member: Takes the discs, shape (n,).
        place: Room for what is needed on the way, shape (n,).
    """
    cells = columns * rows
    start[:] = 0
    for i in range(len(x)):
        if wanted[i]:
            c = cell_of(y[i], size, rows) * columns + cell_of(x[i], size, columns)
            place[i] = c
            start[c + 2] += 1
    for c in range(2, cells + 2):
        start[c] += start[c - 1]
    for i in range(len(x)):
        if wanted[i]:
            c = place[i] + 1
            member[start[c]] = i
            start[c] += 1
