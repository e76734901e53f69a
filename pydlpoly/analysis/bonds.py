"""Distributions of bond lengths and of angles between bonds."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pydlpoly.analysis.frames import Analysis, Mean, minimum_image
from pydlpoly.analysis.report import Curve, Number
from pydlpoly.errors import InputError
from pydlpoly.formats.history_reader import Frame
from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.model import Scene


@dataclass(frozen=True, eq=False)
class Distributions:
    """Distributions of lengths (Å) or angles (degrees), by kind.

    Attributes:
        quantity: "bond length" or "angle"; kinds: names.
        x: (kinds, bins) middle of each bin.
        density: (kinds, bins) probability densities, 1/Å or 1/degree, and their standard errors ``error``.
        mean: (kinds,) means over all terms and frames, and their standard errors ``mean_error``.
        spread: (kinds,) standard deviations about the mean.
    """

    quantity: str
    kinds: tuple[str, ...]
    x: FloatArray
    density: FloatArray
    error: FloatArray
    mean: FloatArray
    mean_error: FloatArray
    spread: FloatArray

    def numbers(self) -> list[Number]:
        """Return the means."""
        unit = "Å" if self.quantity == "bond length" else "°"
        rows = zip(self.kinds, self.mean.tolist(), self.mean_error.tolist(), strict=True)
        return [Number(f"{self.quantity} {kind}", value, error, unit) for kind, value, error in rows]

    def curves(self) -> list[Curve]:
        """Return the distributions."""
        unit = "Å" if self.quantity == "bond length" else "°"
        rows = zip(self.kinds, self.x, self.density, self.error, strict=True)
        label = f"{self.quantity} ({unit})"
        return [Curve(self.quantity, kind, label, f"density (1/{unit})", x, d, e) for kind, x, d, e in rows]


def terms_of(scene: Scene, kind: str) -> dict[str, NDArray[np.int64]]:
    """Return the bead ids of a scene's bonds ("bond", (n, 2)) or angles ("angle", (n, 3)) by the species' names."""
    found: dict[str, list[NDArray[np.int64]]] = {}
    for term in () if scene.bonded is None else scene.bonded.terms:
        if term.kind == kind:
            species = scene.beads.species[term.beads]
            for row in np.unique(species, axis=0):
                names = [scene.species[k] for k in row.tolist()]
                label = "-".join(min(names, names[::-1]))
                found.setdefault(label, []).append(term.beads[(species == row).all(axis=1)].astype(np.int64))
    return {label: np.concatenate(parts) for label, parts in found.items()}


class _Distribution(Analysis[Distributions]):
    """Histograms of one value a term; see the two classes below."""

    _quantity, _beads = "", 0

    def __init__(self, terms: Mapping[str, ArrayLike], bins: int, reach: float | None) -> None:
        self._terms = {kind: np.asarray(ids, dtype=np.int64).reshape(-1, self._beads) for kind, ids in terms.items()}
        if not self._terms or bins < 1:
            raise InputError(f"there is no {self._quantity} to collect, or no bin to collect it in")
        self._bins, self._reach = bins, reach
        self._tops: FloatArray = np.zeros(0)
        self._density, self._moments = Mean(), Mean()

    def add(self, frame: Frame) -> None:
        """Take one frame."""
        values = [self._values(frame, ids) for ids in self._terms.values()]
        if not len(self._tops):
            self._tops = np.array([self._reach or 2.0 * max(float(one.max()), 1e-12) for one in values])
        rows = []
        for one, top in zip(values, self._tops.tolist(), strict=True):
            counts, _ = np.histogram(one, self._bins, (0.0, top))
            rows.append(counts / (len(one) * top / self._bins))
        self._density.add(rows)
        self._moments.add([(one.mean(), np.mean(one**2)) for one in values])

    @abstractmethod
    def _values(self, frame: Frame, ids: NDArray[np.int64]) -> FloatArray:
        """Return the value of every term, beads by ids, (n, beads of a term)."""

    def result(self) -> Distributions:
        """Return distributions and means."""
        first, second = self._moments.value.T
        x = (np.arange(self._bins) + 0.5)[None, :] * self._tops[:, None] / self._bins
        return Distributions(
            self._quantity,
            tuple(self._terms),
            x,
            self._density.value,
            self._density.error,
            first,
            self._moments.error[:, 0],
            np.sqrt(np.maximum(second - first**2, 0.0)),
        )


class BondLengths(_Distribution):
    """Distributions of distances between two beads, by the nearest image.

    Args:
        terms: (n, 2) bead ids by a name for them, for example ``terms_of(scene, "bond")``.
        bins: number of bins up to ``reach`` (Å), by default twice the largest length of the first frame. Longer ones
            count in the means only.
    """

    _quantity, _beads = "bond length", 2

    def __init__(self, terms: Mapping[str, ArrayLike], *, bins: int = 100, reach: float | None = None) -> None:
        super().__init__(terms, bins, reach)

    def _values(self, frame: Frame, ids: NDArray[np.int64]) -> FloatArray:
        apart = minimum_image(frame.positions[ids[:, 1]] - frame.positions[ids[:, 0]], frame)
        return np.asarray(np.linalg.norm(apart, axis=1))


class BondAngles(_Distribution):
    """Distributions of angles, in degrees from 0 to 180; the vertex is the middle one of three beads.

    Args:
        terms: (n, 3) bead ids by a name for them, for example ``terms_of(scene, "angle")``.
        bins: number of bins.
    """

    _quantity, _beads = "angle", 3

    def __init__(self, terms: Mapping[str, ArrayLike], *, bins: int = 90) -> None:
        super().__init__(terms, bins, 180.0)

    def _values(self, frame: Frame, ids: NDArray[np.int64]) -> FloatArray:
        middle = frame.positions[ids[:, 1]]
        a, b = (minimum_image(frame.positions[ids[:, k]] - middle, frame) for k in (0, 2))
        cosine = np.sum(a * b, axis=1) / (np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1))
        return np.asarray(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))
