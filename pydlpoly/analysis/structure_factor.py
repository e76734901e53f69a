"""Static structure factors on the lattice of wave vectors that fit into the cell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from pydlpoly.analysis.frames import Analysis, Mean, beads_of, fractional, fully_periodic
from pydlpoly.analysis.report import Curve, Number
from pydlpoly.errors import InputError
from pydlpoly.formats.history_reader import Frame
from pydlpoly.formats.records import FloatArray

_AT_ONCE = 4_000_000  # phases


@dataclass(frozen=True, eq=False)
class StructureFactors:
    """A static structure factor, averaged over shells of wave vectors.

    Attributes:
        q: (shells,) mean length of the wave vectors in 1/Å; vectors: (shells,) how many were used.
        values: (shells,) S(q), and its standard error ``error``.
    """

    q: FloatArray
    vectors: NDArray[np.int64]
    values: FloatArray
    error: FloatArray

    def numbers(self) -> list[Number]:
        """Return place and height of the highest point."""
        k = int(np.argmax(self.values))
        height = Number("S(q): highest", float(self.values[k]), float(self.error[k]))
        return [height, Number("S(q): at q", float(self.q[k]), float("nan"), "1/Å")]

    def curves(self) -> list[Curve]:
        """Return the function."""
        return [Curve("structure factor", "S", "q (1/Å)", "S(q)", self.q, self.values, self.error)]


class StructureFactor(Analysis[StructureFactors]):
    """S(q) = ⟨|Σ_j exp(−i q·r_j)|²⟩/N on the vectors 2π n·h⁻¹ of the cell, of each pair ±q one, without q = 0.

    Args:
        largest: the largest q in 1/Å, by default 8 vectors along the shortest reciprocal one.
        width: of a shell in 1/Å, by default the shortest reciprocal vector.
        species: only beads of these species; by default all.
        most: at most so many vectors of a shell are used, chosen evenly; 0: all.
    """

    def __init__(
        self,
        *,
        largest: float | None = None,
        width: float | None = None,
        species: Sequence[str] = (),
        most: int = 200,
    ) -> None:
        self._largest, self._width, self._species, self._most = largest, width, tuple(species), most
        self._vectors: NDArray[np.int64] = np.zeros((0, 3), dtype=np.int64)
        self._shells: NDArray[np.int64] = np.zeros(0, dtype=np.int64)
        self._mean, self._lengths = Mean(), Mean()

    def add(self, frame: Frame) -> None:
        """Take one frame of a fully periodic cell."""
        fully_periodic(frame)
        if not len(self._vectors):
            self._choose(frame.cell)
        places = fractional(frame.positions, frame)
        if self._species:
            places = places[np.concatenate([beads_of(frame, name) for name in self._species])]
        strength = np.abs(density_waves(places, self._vectors)) ** 2 / len(places)
        lengths = np.linalg.norm(wave_vectors(self._vectors, frame.cell), axis=1)
        counts = np.bincount(self._shells)
        self._mean.add(np.bincount(self._shells, weights=strength) / counts)
        self._lengths.add(np.bincount(self._shells, weights=lengths) / counts)

    def _choose(self, cell: FloatArray) -> None:
        shortest = float(np.linalg.norm(wave_vectors(np.eye(3, dtype=np.int64), cell), axis=1).min())
        largest = 8.0 * shortest if self._largest is None else self._largest
        width = shortest if self._width is None else self._width
        vectors = lattice_vectors(cell, largest)
        shells = np.floor(np.linalg.norm(wave_vectors(vectors, cell), axis=1) / width + 1e-9).astype(np.int64)
        chosen = []
        for shell in np.unique(shells).tolist():
            inside = np.flatnonzero(shells == shell)
            if 0 < self._most < len(inside):
                inside = inside[np.linspace(0, len(inside) - 1, self._most).round().astype(int)]
            chosen.append(inside)
        self._vectors = vectors[np.concatenate(chosen)]
        self._shells = np.repeat(np.arange(len(chosen)), [len(inside) for inside in chosen])

    def result(self) -> StructureFactors:
        """Return the function and its errors."""
        return StructureFactors(self._lengths.value, np.bincount(self._shells), self._mean.value, self._mean.error)


def wave_vectors(numbers: NDArray[np.int64], cell: FloatArray) -> FloatArray:
    """Return 2π h⁻¹ n, (n, 3) in 1/Å, of triples of whole numbers (n, 3)."""
    return np.asarray(2.0 * np.pi * numbers @ np.linalg.inv(cell).T)


def lattice_vectors(cell: FloatArray, largest: float) -> NDArray[np.int64]:
    """Return triples of whole numbers, (n, 3), of wave vectors up to ``largest``, of each ± pair one, without 0.

    Raises:
        InputError: there is none so short.
    """
    reach = np.floor(largest * np.linalg.norm(cell, axis=1) / (2.0 * np.pi) + 1e-9).astype(int)
    grid = np.array(list(product(*(range(-n, n + 1) for n in reach.tolist()))), dtype=np.int64)
    first = np.where(grid[:, 0] != 0, grid[:, 0], np.where(grid[:, 1] != 0, grid[:, 1], grid[:, 2]))
    short = np.linalg.norm(wave_vectors(grid, cell), axis=1) <= largest * (1.0 + 1e-9)
    found: NDArray[np.int64] = grid[(first > 0) & short]
    if not len(found):
        raise InputError(f"no wave vector of this cell is as short as {largest:g}")
    return found


def density_waves(places: FloatArray, numbers: NDArray[np.int64]) -> NDArray[np.complex128]:
    """Return Σ exp(−2πi n·s) over beads with fractional places s (N, 3), for every triple n (n, 3)."""
    waves = np.zeros(len(numbers), dtype=np.complex128)
    size = max(1, _AT_ONCE // max(len(places), 1))
    for start in range(0, len(numbers), size):
        phases = places @ numbers[start : start + size].T
        waves[start : start + size] = np.exp(-2j * np.pi * phases).sum(axis=0)
    return waves
