"""Lamellar order: how far beads of a species lie in layers, their direction and their period."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pydlpoly.analysis.frames import Analysis, Mean, beads_of, fractional, fully_periodic
from pydlpoly.analysis.report import Curve, Number
from pydlpoly.analysis.structure_factor import density_waves, lattice_vectors, wave_vectors
from pydlpoly.formats.history_reader import Frame
from pydlpoly.formats.records import FloatArray


@dataclass(frozen=True, eq=False)
class Lamellae:
    """The strongest density wave.

    Attributes:
        squared_order: (|Σ exp(i q·r)|² − N)/(N (N − 1)) of that wave and its standard error: 1 when all beads are in
            planes a period apart, 0 on average for beads without order.
        order: its square root, 0 where it is negative.
        normal: (3,) direction of q; period: 2π/q in Å.
        indices: (3,) which vector of the reciprocal lattice it is.
    """

    squared_order: tuple[float, float]
    order: float
    normal: FloatArray
    period: float
    indices: NDArray[np.int64]

    def numbers(self) -> list[Number]:
        """Return order, period and direction."""
        nan = float("nan")
        normal = (Number(f"lamellar normal {a}", float(x), nan) for a, x in zip("xyz", self.normal, strict=True))
        squared = Number("lamellar order squared", *self.squared_order)
        return [squared, Number("lamellar period", self.period, nan, "Å"), *normal]

    def curves(self) -> list[Curve]:
        """Return nothing: there are only numbers."""
        return []


class LamellarOrder(Analysis[Lamellae]):
    """Strength of the density waves of a species that fit into the cell; the strongest on average is reported.

    Args:
        species: whose beads.
        shortest: the shortest period looked for, Å; by default a quarter of the longest edge.
    """

    def __init__(self, species: str, *, shortest: float | None = None) -> None:
        self._species, self._shortest = species, shortest
        self._vectors: NDArray[np.int64] = np.zeros((0, 3), dtype=np.int64)
        self._cell: FloatArray = np.eye(3)
        self._mean, self._waves = Mean(), Mean()

    def add(self, frame: Frame) -> None:
        """Take one frame of a fully periodic cell."""
        fully_periodic(frame)
        if not len(self._vectors):
            edge = float(np.linalg.norm(frame.cell, axis=1).max())
            shortest = 0.25 * edge if self._shortest is None else self._shortest
            self._vectors = lattice_vectors(frame.cell, 2.0 * np.pi / shortest)
        places = fractional(frame.positions, frame)[beads_of(frame, self._species)]
        strength = np.abs(density_waves(places, self._vectors)) ** 2
        self._mean.add((strength - len(places)) / (len(places) * max(len(places) - 1, 1)))
        self._waves.add(wave_vectors(self._vectors, frame.cell))

    def result(self) -> Lamellae:
        """Return the strongest wave."""
        strength, error = self._mean.value, self._mean.error
        best = int(np.argmax(strength))
        wave = self._waves.value[best]
        length = float(np.linalg.norm(wave))
        order = float(np.sqrt(max(strength[best], 0.0)))
        squared = (float(strength[best]), float(error[best]))
        return Lamellae(squared, order, wave / length, 2.0 * np.pi / length, self._vectors[best])
