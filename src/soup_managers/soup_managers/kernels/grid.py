"""Which of many fixed points are near a place: points sorted into the cells of a square grid."""

from __future__ import annotations

from soup_msgs_py.warehouse.layout import Floats


class PointGrid:
    """Points of the plane, numbered as given, for questions about places up to some `cell_m` away."""

    def __init__(self, points: Floats, cell_m: float) -> None:
        self._points = [(float(x), float(y)) for x, y in points]
        self._cell_m = cell_m
        self._cells: dict[tuple[int, int], list[int]] = {}
        for number, (x, y) in enumerate(self._points):
            self._cells.setdefault((int(x // cell_m), int(y // cell_m)), []).append(number)

    def within(self, x: float, y: float, radius: float) -> list[int]:
        """Numbers of the points nearer to (x, y) than `radius` metres, the nearest first."""
        cell = self._cell_m
        low, high = int((y - radius) // cell), int((y + radius) // cell)
        found = []
        for column in range(int((x - radius) // cell), int((x + radius) // cell) + 1):
            for row in range(low, high + 1):
                for number in self._cells.get((column, row), ()):
                    px, py = self._points[number]
                    square = (px - x) * (px - x) + (py - y) * (py - y)
                    if square < radius * radius:
                        found.append((square, number))
        if len(found) > 1:
            found.sort()
        return [number for _, number in found]
