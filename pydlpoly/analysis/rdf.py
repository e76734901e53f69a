"""Radial distribution functions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np

from pydlpoly.analysis.frames import Analysis, Mean, beads_of, fully_periodic, minimum_image, widths
from pydlpoly.analysis.molecules import Molecules
from pydlpoly.analysis.neighbours import distance_counts
from pydlpoly.analysis.report import Curve, Number
from pydlpoly.errors import InputError
from pydlpoly.formats.history_reader import Frame
from pydlpoly.formats.records import FloatArray


@dataclass(frozen=True, eq=False)
class RadialDistributions:
    """Radial distribution functions of pairs of species.

    Attributes:
        pairs: the two species of each function.
        r: (bins,) middle of each bin in Å.
        g: (pairs, bins) the functions, and their standard errors ``error``.
        n: (pairs, bins) mean number of beads of the second species within the outer edge of the bin around one of the
            first.
    """

    pairs: tuple[tuple[str, str], ...]
    r: FloatArray
    g: FloatArray
    error: FloatArray
    n: FloatArray

    def __getitem__(self, pair: tuple[str, str]) -> FloatArray:
        """Return g(r) of a pair, (bins,), its species in either order. Raises KeyError when it was not collected."""
        for names, function in zip(self.pairs, self.g, strict=True):
            if pair in (names, names[::-1]):
                return np.asarray(function)
        raise KeyError(pair)

    def numbers(self) -> list[Number]:
        """Return place and height of each function's highest point."""
        best = np.argmax(self.g, axis=1)
        return [
            number
            for k, (a, b) in enumerate(self.pairs)
            for number in (
                Number(f"g(r) {a} {b}: highest", float(self.g[k, best[k]]), float(self.error[k, best[k]])),
                Number(f"g(r) {a} {b}: at r", float(self.r[best[k]]), 0.5 * float(self.r[1] - self.r[0]), "Å"),
            )
        ]

    def curves(self) -> list[Curve]:
        """Return the functions."""
        rows = zip(self.pairs, self.g, self.error, strict=True)
        return [Curve("rdf", f"{a} {b}", "r (Å)", "g(r)", self.r, g, error) for (a, b), g, error in rows]


class RadialDistribution(Analysis[RadialDistributions]):
    """g(r) of pairs of species: pairs in a shell over those of as many beads without order.

    The shell has its exact volume 4πΔ(r² + Δ²/12), and a bead is no pair with itself, as in RDFDAT. For distributions
    of molecules' centres give frames of ``molecule_centres``.

    Args:
        pairs: of species; by default all.
        bin_width: Δ in Å.
        reach: the largest distance in Å, at most (the default) half the smallest width of the first frame's cell.
        between: leave out pairs within one of these molecules.
    """

    def __init__(
        self,
        pairs: Sequence[tuple[str, str]] | None = None,
        *,
        bin_width: float = 0.05,
        reach: float | None = None,
        between: Sequence[Molecules] = (),
    ) -> None:
        if not bin_width > 0.0:
            raise InputError(f"the width of a bin must be positive, not {bin_width}")
        self._pairs = tuple(pairs) if pairs is not None else ()
        self._width, self._reach, self._between = bin_width, reach, tuple(between)
        self._edges: FloatArray = np.zeros(0)
        self._mean = Mean()

    def add(self, frame: Frame) -> None:
        """Take one frame of a fully periodic cell."""
        volume, largest = fully_periodic(frame), 0.5 * float(widths(frame.cell).min())
        if not len(self._edges):
            self._begin(frame, largest)
        if self._edges[-1] > largest * (1.0 + 1e-9) and self._mean.taken == 0:
            raise InputError(f"g(r) to {self._edges[-1]:g} is asked for; this cell allows {largest:g}, half its width")
        shells = 4.0 / 3.0 * np.pi * np.diff(self._edges**3)
        rows = []
        for a, b in self._pairs:
            first, second = beads_of(frame, a), beads_of(frame, b)
            counts = distance_counts(frame, first, second, self._edges)
            all_pairs = len(first) * len(second) - (len(first) if a == b else 0)
            within, number = self._within(frame, a, b)
            counts, possible = counts - within, all_pairs - number
            if possible < 1:
                raise InputError(f"there is no pair of {a} and {b} to count")
            rows.append((counts / (possible * shells / volume), np.cumsum(counts) / len(first)))
        self._mean.add(rows)

    def _begin(self, frame: Frame, largest: float) -> None:
        names = tuple(dict.fromkeys(frame.names))
        single = {name for name in names if frame.names.count(name) < 2}
        every = [pair for pair in combinations_with_replacement(names, 2) if not (pair[0] == pair[1] in single)]
        self._pairs = self._pairs or tuple(every)
        if not self._pairs:
            raise InputError("g(r) needs two beads")
        reach = largest if self._reach is None else self._reach
        bins = int(np.floor(reach / self._width + 1e-9))
        if bins < 1:
            raise InputError(f"no bin of {self._width:g} fits into {reach:g}")
        self._edges = np.arange(bins + 1, dtype=np.float64) * np.float64(self._width)

    def _within(self, frame: Frame, a: str, b: str) -> tuple[FloatArray, int]:
        """Ordered pairs of one bead of ``a`` and one of ``b`` in the same molecule: by distance, and how many."""
        counts, total = np.zeros(len(self._edges) - 1), 0
        names = np.array(frame.names, dtype=object)
        for one in self._between:
            kinds = names[one.beads[0]]
            i, j = np.nonzero((kinds[:, None] == a) & (kinds[None, :] == b))
            i, j = i[i != j], j[i != j]
            places = frame.positions[one.beads]
            for bead, other in zip(i.tolist(), j.tolist(), strict=True):
                apart = np.linalg.norm(minimum_image(places[:, bead] - places[:, other], frame), axis=1)
                counts += np.histogram(apart, self._edges)[0]
                total += len(apart)
        return counts, total

    def result(self) -> RadialDistributions:
        """Return the functions and their errors."""
        mean, error = self._mean.value, self._mean.error
        r = 0.5 * (self._edges[1:] + self._edges[:-1])
        return RadialDistributions(self._pairs, r, mean[:, 0], error[:, 0], mean[:, 1])
