"""Sizes and shapes of molecules: end-to-end distance, radius of gyration and what follows from its tensor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pydlpoly.analysis.frames import Analysis, Mean, masses_of
from pydlpoly.analysis.molecules import Molecules
from pydlpoly.analysis.report import Curve, Number
from pydlpoly.errors import InputError
from pydlpoly.formats.history_reader import Frame
from pydlpoly.formats.records import FloatArray


@dataclass(frozen=True, eq=False)
class Dimensions:
    """Means over molecules of each type and frames; every ``…_error`` is the standard error of its namesake.

    Attributes:
        molecules: names of the types.
        end_to_end_squared: (types,) ⟨R²⟩ between the first and the last bead, Å².
        gyration_squared: (types,) ⟨R_g²⟩, Å².
        tensor: (types, 3, 3) mean gyration tensor in the axes of the simulation, Å²; isotropic in a fluid.
        principal: (types, 3) mean eigenvalues λ₁ ≥ λ₂ ≥ λ₃ of the molecules' tensors, Å².
        asphericity: (types,) ⟨λ₁ − (λ₂ + λ₃)/2⟩, Å²; acylindricity: (types,) ⟨λ₂ − λ₃⟩, Å².
        anisotropy: (types,) ⟨κ²⟩ with κ² = (3 Σλ²/(Σλ)² − 1)/2, from 0 (sphere) to 1 (rod).
    """

    molecules: tuple[str, ...]
    end_to_end_squared: FloatArray
    end_to_end_squared_error: FloatArray
    gyration_squared: FloatArray
    gyration_squared_error: FloatArray
    tensor: FloatArray
    tensor_error: FloatArray
    principal: FloatArray
    principal_error: FloatArray
    asphericity: FloatArray
    asphericity_error: FloatArray
    acylindricity: FloatArray
    acylindricity_error: FloatArray
    anisotropy: FloatArray
    anisotropy_error: FloatArray

    def numbers(self) -> list[Number]:
        """Return the sizes and shapes."""
        found = []
        for k, name in enumerate(self.molecules):
            for label, attribute, unit in (
                ("end-to-end distance squared", "end_to_end_squared", "Å²"),
                ("radius of gyration squared", "gyration_squared", "Å²"),
                ("asphericity", "asphericity", "Å²"),
                ("shape anisotropy", "anisotropy", ""),
            ):
                value, error = (float(getattr(self, attribute + end)[k]) for end in ("", "_error"))
                found.append(Number(f"{name}: {label}", value, error, unit))
        return found

    def curves(self) -> list[Curve]:
        """Return nothing: there are only numbers."""
        return []


class ChainDimensions(Analysis[Dimensions]):
    """Sizes and shapes of molecules, which are made whole across cell boundaries first.

    The gyration tensor is Σ m (r − R)(r − R)ᵀ/Σ m; its eigenvalues' combinations follow Theodorou and Suter,
    Macromolecules 18, 1206 (1985).

    Args:
        molecules: the types, for example ``molecules_of(scene).values()``; types of a single bead are left out.
        mass_weighted: weigh beads by their masses instead of alike.
    """

    def __init__(self, molecules: Sequence[Molecules], *, mass_weighted: bool = True) -> None:
        self._molecules = [one for one in molecules if one.beads.shape[1] > 1 and len(one.beads)]
        if not self._molecules:
            raise InputError("there are no molecules of two or more beads")
        self._mass_weighted = mass_weighted
        self._mean = Mean()

    def add(self, frame: Frame) -> None:
        """Take one frame."""
        masses = masses_of(frame) if self._mass_weighted else np.ones(len(frame.positions))
        self._mean.add([_sizes(one.whole(frame), masses[one.beads]) for one in self._molecules])

    def result(self) -> Dimensions:
        """Return the means and their errors."""
        names = tuple(one.name for one in self._molecules)
        parts = []
        for table in (self._mean.value, self._mean.error):
            tensor, principal = table[:, 2:11].reshape(-1, 3, 3), table[:, 11:14]
            parts.append((table[:, 0], table[:, 1], tensor, principal, table[:, 14], table[:, 15], table[:, 16]))
        return Dimensions(names, *(array for pair in zip(*parts, strict=True) for array in pair))


def _sizes(places: FloatArray, masses: FloatArray) -> FloatArray:
    """Means over molecules of R², R_g², the tensor, its eigenvalues and their combinations, (17,)."""
    ends = np.sum((places[:, -1] - places[:, 0]) ** 2, axis=1)
    weights = masses / masses.sum(axis=1, keepdims=True)
    apart = places - np.einsum("mk,mkx->mx", weights, places)[:, None]
    tensors = np.einsum("mk,mkx,mky->mxy", weights, apart, apart)
    low, middle, high = np.linalg.eigvalsh(tensors).T
    total = low + middle + high
    squares = low**2 + middle**2 + high**2
    shape = 0.5 * (3.0 * squares / np.where(total > 0.0, total, 1.0) ** 2 - 1.0)
    rows = [ends, total, *tensors.reshape(-1, 9).T, high, middle, low, high - 0.5 * (middle + low), middle - low, shape]
    return np.asarray(np.mean(rows, axis=1))
