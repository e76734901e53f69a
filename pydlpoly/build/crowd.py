"""Beads that have a place already, and which of them a new bead would come too close to."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np
from numpy.typing import NDArray

from pydlpoly.build.regions import heights
from pydlpoly.errors import SceneError
from pydlpoly.formats.records import FloatArray, IntArray

_AROUND = np.array(list(product((-1, 0, 1), repeat=3)), dtype=np.int64)
# So many new beads are compared at the same time, which bounds the memory.
_CHUNK = 50_000
_MOST_CELLS = 1_000_000


class Crowd:
    """Beads in a periodic cell, found by link cells of the largest distance that matters.

    Args:
        cell: (3, 3) cell vectors by row.
        least: (species, species) least distance of each pair of species; 0: any.

    Raises:
        SceneError: a distance that is larger than the cell.
    """

    def __init__(self, cell: FloatArray, least: FloatArray) -> None:
        self.cell, self.least = cell, least
        self._inverse = np.linalg.inv(cell)
        reach = float(least.max(initial=0.0))
        self.matters = reach > 0.0
        width = float(heights(cell).min())
        if reach > width:
            raise SceneError(f"a least distance of {reach:g} is larger than the cell's width {width:g}")
        # However short the distances are, so many cells are enough; more would only cost memory.
        edge = max(reach, (abs(float(np.linalg.det(cell))) / _MOST_CELLS) ** (1.0 / 3.0))
        self._shape = np.maximum(1, np.floor(heights(cell) / edge)).astype(np.int64)
        self._places, self._kinds = np.zeros((0, 3)), np.zeros(0, dtype=np.int64)
        self._alive = np.zeros(0, dtype=np.bool_)
        self._sorted: tuple[IntArray, IntArray, FloatArray] | None = None

    def add(self, places: FloatArray, kinds: IntArray) -> IntArray:
        """Add (n, 3) places of beads of these species; return their numbers."""
        first = len(self._places)
        if self.matters:
            self._places = np.concatenate([self._places, places])
            self._kinds = np.concatenate([self._kinds, kinds])
            self._alive = np.concatenate([self._alive, np.ones(len(places), dtype=np.bool_)])
            self._sorted = None
        return np.arange(first, first + len(places), dtype=np.int64)

    def remove(self, numbers: IntArray) -> None:
        """Take beads away again."""
        if self.matters:
            self._alive[numbers] = False
            self._sorted = None

    def conflicts(self, places: FloatArray, kinds: IntArray) -> tuple[IntArray, IntArray, FloatArray]:
        """Return the pairs that are too close: rows of ``places``, numbers of beads here, distance/least distance."""
        found = [(np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros(0))]
        if self.matters and self._alive.any():
            for start in range(0, len(places), _CHUNK):
                part = slice(start, start + _CHUNK)
                found += self._conflicts(places[part], kinds[part], start)
        rows, numbers, ratios = (np.concatenate(column) for column in zip(*found, strict=True))
        return rows, numbers, ratios

    def kinds(self, numbers: IntArray) -> IntArray:
        """Return the species of beads."""
        return self._kinds[numbers]

    def _cells(self, places: FloatArray) -> tuple[IntArray, FloatArray]:
        fractions = places @ self._inverse + 0.5
        fractions -= np.floor(fractions)
        cells = np.minimum((fractions * self._shape).astype(np.int64), self._shape - 1)
        return cells, (fractions - 0.5) @ self.cell

    def _number(self, cells: IntArray) -> IntArray:
        numbers: IntArray = (cells[:, 0] * self._shape[1] + cells[:, 1]) * self._shape[2] + cells[:, 2]
        return numbers

    def _order(self) -> tuple[IntArray, IntArray, FloatArray]:
        """Return the beads in the order of their cells, where each cell begins, and their places inside the cell."""
        if self._sorted is None:
            alive = np.flatnonzero(self._alive)
            cells, wrapped = self._cells(self._places[alive])
            numbers = self._number(cells)
            order = np.argsort(numbers, kind="stable")
            filled = np.bincount(numbers, minlength=int(np.prod(self._shape)))
            self._sorted = alive[order], np.concatenate([[0], np.cumsum(filled)]), wrapped[order]
        return self._sorted

    def _conflicts(
        self, places: FloatArray, kinds: IntArray, start: int
    ) -> Iterator[tuple[IntArray, IntArray, FloatArray]]:
        """Yield the conflicts with the beads of each of the 27 cells around."""
        order, starts, here = self._order()
        cells, wrapped = self._cells(places)
        for step in _AROUND:
            # A cell beyond a face is one of an image; with fewer than three cells an axis, one cell is seen several
            # times, each time as another image.
            images = np.floor_divide(cells + step, self._shape)
            targets = self._number(cells + step - images * self._shape)
            low = starts[targets]
            many = starts[targets + 1] - low
            rows = np.repeat(np.arange(len(places)), many)
            slots = np.arange(int(many.sum())) + np.repeat(low - (np.cumsum(many) - many), many)
            apart = wrapped[rows] - here[slots] - images[rows] @ self.cell
            least = self.least[kinds[rows], self._kinds[order[slots]]]
            distance = np.sqrt(np.einsum("ij,ij->i", apart, apart))
            close = distance < least
            yield rows[close] + start, order[slots[close]], distance[close] / least[close]


def losers(rows: IntArray, others: IntArray, count: int) -> NDArray[np.bool_]:
    """Return which of ``count`` candidates give way: those in conflict with one of a lower number."""
    lost = np.zeros(count, dtype=np.bool_)
    lost[rows[others < rows]] = True
    return lost
