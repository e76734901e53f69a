"""Density profiles along a cell vector."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from pydlpoly.analysis.frames import Analysis, Mean, beads_of, fractional, masses_of, widths
from pydlpoly.analysis.report import Curve, Number
from pydlpoly.errors import InputError
from pydlpoly.formats.history_reader import Frame
from pydlpoly.formats.records import FloatArray

Weight = Literal["number", "mass", "charge"]
_UNITS = {"number": "1/Å³", "mass": "Da/Å³", "charge": "e/Å³"}


@dataclass(frozen=True, eq=False)
class DensityProfiles:
    """Profiles of some species.

    Attributes:
        species: names; axis: "x", "y" or "z"; weight: "number", "mass" or "charge".
        z: (bins,) middle of each bin, Å from the middle of the cell, across its faces.
        density: (species, bins) per Å³, and its standard error ``error``.
    """

    species: tuple[str, ...]
    axis: str
    weight: Weight
    z: FloatArray
    density: FloatArray
    error: FloatArray

    def __getitem__(self, species: str) -> FloatArray:
        """Return the profile of a species, (bins,). Raises KeyError when it was not collected."""
        if species not in self.species:
            raise KeyError(species)
        return np.asarray(self.density[self.species.index(species)])

    def numbers(self) -> list[Number]:
        """Return each profile's largest value."""
        best = np.argmax(self.density, axis=1)
        rows = zip(self.species, self.density, self.error, best.tolist(), strict=True)
        unit = _UNITS[self.weight]
        return [Number(f"density {name}: highest", float(d[k]), float(e[k]), unit) for name, d, e, k in rows]

    def curves(self) -> list[Curve]:
        """Return the profiles."""
        rows = zip(self.species, self.density, self.error, strict=True)
        label = f"density ({_UNITS[self.weight]})"
        return [Curve("density", name, f"{self.axis} (Å)", label, self.z, d, e) for name, d, e in rows]


class DensityProfile(Analysis[DensityProfiles]):
    """Density in slices across a cell vector.

    Args:
        axis: "x", "y" or "z": the first, second or third cell vector.
        bins: number of slices over the cell; where the cell varies they vary with it.
        species: names; by default all.
        weight: "number", "mass" or "charge".
        centre: move every frame so that beads of this species are in the middle, as for a membrane that drifts.
    """

    def __init__(
        self,
        axis: str = "z",
        *,
        bins: int = 100,
        species: Sequence[str] = (),
        weight: Weight = "number",
        centre: str | None = None,
    ) -> None:
        if axis not in ("x", "y", "z") or weight not in _UNITS or bins < 1:
            raise InputError(f"expected axis x, y or z, weight {', '.join(_UNITS)} and at least one bin")
        self._axis, self._name, self._bins = "xyz".index(axis), axis, bins
        self._species, self._weight, self._centre = tuple(species), weight, centre
        self._mean, self._extent = Mean(), Mean()

    def add(self, frame: Frame) -> None:
        """Take one frame."""
        self._species = self._species or tuple(dict.fromkeys(frame.names))
        place = along(frame, self._axis, self._centre)
        weights = {"number": np.ones(len(place)), "mass": masses_of(frame), "charge": frame.charges}[self._weight]
        slice_volume = abs(float(np.linalg.det(frame.cell))) / self._bins
        rows = []
        for name in self._species:
            beads = beads_of(frame, name)
            counts, _ = np.histogram(place[beads], self._bins, (-0.5, 0.5), weights=weights[beads])
            rows.append(counts / slice_volume)
        self._mean.add(rows)
        self._extent.add(widths(frame.cell)[self._axis])

    def result(self) -> DensityProfiles:
        """Return the profiles and their errors."""
        z = ((np.arange(self._bins) + 0.5) / self._bins - 0.5) * float(self._extent.value)
        return DensityProfiles(self._species, self._name, self._weight, z, self._mean.value, self._mean.error)


def along(frame: Frame, axis: int, centre: str | None = None) -> FloatArray:
    """Return fractional places along a cell vector, (N,), from −1/2 to 1/2 where it is periodic.

    With ``centre`` the mean of that species is at 0; on a periodic axis the mean on the circle.
    """
    place = fractional(frame.positions, frame)[:, axis]
    if centre is None:
        return place
    beads = place[beads_of(frame, centre)]
    if frame.imcon == 0 or (frame.imcon == 6 and axis == 2):
        return np.asarray(place - beads.mean())
    place = place - np.angle(np.exp(2j * np.pi * beads).mean()) / (2.0 * np.pi)
    return np.asarray(place - np.floor(place + 0.5))
