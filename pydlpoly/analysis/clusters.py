"""Clusters: beads, or molecules, that hang together by distances up to a reach."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pydlpoly.analysis.frames import Analysis, Mean, beads_of
from pydlpoly.analysis.molecules import Molecules, molecule_numbers
from pydlpoly.analysis.neighbours import pairs_within
from pydlpoly.analysis.report import Curve, Number
from pydlpoly.errors import InputError
from pydlpoly.formats.history_reader import Frame
from pydlpoly.formats.records import FloatArray


@dataclass(frozen=True, eq=False)
class Clusters:
    """Sizes of clusters, in beads or in molecules, averaged over frames; each number with its standard error.

    Attributes:
        count: mean number of clusters, (value, error).
        mean_size: mean of a frame's average size; weight_mean_size: of Σn²/Σn, the size that a member sees.
        largest: mean of a frame's largest size.
        sizes: (n,) sizes that occurred; frequency: (n,) how many clusters of that size a frame has on average.
    """

    count: tuple[float, float]
    mean_size: tuple[float, float]
    weight_mean_size: tuple[float, float]
    largest: tuple[float, float]
    sizes: NDArray[np.int64]
    frequency: FloatArray

    def numbers(self) -> list[Number]:
        """Return number and sizes."""
        return [
            Number("clusters: number", *self.count),
            Number("clusters: mean size", *self.mean_size),
            Number("clusters: mean size by weight", *self.weight_mean_size),
            Number("clusters: largest", *self.largest),
        ]

    def curves(self) -> list[Curve]:
        """Return how often each size occurs."""
        nothing = np.full(len(self.sizes), np.nan)
        sizes = self.sizes.astype(np.float64)
        return [Curve("clusters", "sizes", "size", "clusters a frame", sizes, self.frequency, nothing)]


class ClusterSizes(Analysis[Clusters]):
    """Sizes of the sets that are connected by distances up to ``reach``.

    Args:
        reach: in Å.
        species: only beads of these species; by default all.
        molecules: count molecules: those of which any two chosen beads are within reach hang together.
    """

    def __init__(self, reach: float, *, species: Sequence[str] = (), molecules: Sequence[Molecules] = ()) -> None:
        if not reach > 0.0:
            raise InputError(f"the reach must be positive, not {reach}")
        self._reach, self._species, self._molecules = reach, tuple(species), tuple(molecules)
        self._mean = Mean()
        self._frequency: NDArray[np.int64] = np.zeros(1, dtype=np.int64)

    def add(self, frame: Frame) -> None:
        """Take one frame."""
        sizes = np.bincount(self.labels(frame))
        total = sizes.sum()
        self._mean.add([len(sizes), total / len(sizes), np.sum(sizes**2) / total, sizes.max()])
        frequency = np.bincount(sizes, minlength=len(self._frequency))
        frequency[: len(self._frequency)] += self._frequency
        self._frequency = frequency

    def labels(self, frame: Frame) -> NDArray[np.int64]:
        """Return the number of its cluster for every bead chosen, or for every molecule, (n,)."""
        from scipy.sparse import coo_matrix  # half a second to import, of every command
        from scipy.sparse.csgraph import connected_components

        beads = np.arange(len(frame.positions))
        if self._species:
            beads = np.concatenate([beads_of(frame, name) for name in self._species])
        pairs = pairs_within(frame, beads, self._reach)
        members = np.arange(len(beads))
        if self._molecules:
            numbers = molecule_numbers(self._molecules, len(frame.positions))[beads]
            members = np.unique(numbers, return_inverse=True)[1]
        i, j = members[pairs].T
        count = int(members.max()) + 1
        graph = coo_matrix((np.ones(len(i), dtype=np.int8), (i, j)), shape=(count, count))
        return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)

    def result(self) -> Clusters:
        """Return numbers and sizes."""
        pairs = list(zip(self._mean.value.tolist(), self._mean.error.tolist(), strict=True))
        sizes = np.flatnonzero(self._frequency)
        return Clusters(pairs[0], pairs[1], pairs[2], pairs[3], sizes, self._frequency[sizes] / self._mean.taken)
