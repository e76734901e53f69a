"""Orientational order of molecules: director, order parameter, and order along a given axis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pydlpoly.analysis.frames import Analysis, Mean
from pydlpoly.analysis.molecules import Molecules
from pydlpoly.analysis.report import Curve, Number
from pydlpoly.errors import InputError
from pydlpoly.formats.history_reader import Frame
from pydlpoly.formats.records import FloatArray


@dataclass(frozen=True, eq=False)
class Orientation:
    """How far molecules point the same way.

    Attributes:
        order: largest eigenvalue of a frame's Q = ⟨(3 u uᵀ − 1)/2⟩, averaged over frames, and its standard error. About
            1/√N for N molecules without order.
        director: (3,) its direction, of the mean of Q.
        along: ⟨P₂(u·n)⟩ for the axis n, and its standard error: 0 on average without order; None without an axis.
    """

    order: tuple[float, float]
    director: FloatArray
    along: tuple[float, float] | None

    def numbers(self) -> list[Number]:
        """Return the order parameters and the director."""
        found = [Number("orientational order", *self.order)]
        if self.along is not None:
            found.append(Number("orientational order along the axis", *self.along))
        nan = float("nan")
        return [*found, *(Number(f"director {a}", float(x), nan) for a, x in zip("xyz", self.director, strict=True))]

    def curves(self) -> list[Curve]:
        """Return nothing: there are only numbers."""
        return []


class OrientationalOrder(Analysis[Orientation]):
    """Order of the vectors u from one bead of each molecule to another.

    Args:
        molecules: the types.
        first, last: which beads of a molecule, from 0, or from the end when negative.
        axis: an axis to measure order along, (3,), such as a membrane's normal.
    """

    def __init__(
        self, molecules: Sequence[Molecules], *, first: int = 0, last: int = -1, axis: ArrayLike | None = None
    ) -> None:
        self._molecules, self._ends = tuple(molecules), (first, last)
        if not self._molecules:
            raise InputError("there are no molecules")
        self._axis = None if axis is None else np.asarray(axis, dtype=np.float64)
        self._order, self._tensor, self._along = Mean(), Mean(), Mean()

    def add(self, frame: Frame) -> None:
        """Take one frame."""
        first, last = self._ends
        places = [one.whole(frame) for one in self._molecules]
        vectors = np.concatenate([place[:, last] - place[:, first] for place in places])
        lengths = np.linalg.norm(vectors, axis=1)
        if not lengths.all():
            raise InputError(f"a molecule's two beads are in the same place in step {frame.step}")
        units = vectors / lengths[:, None]
        tensor = 1.5 * units.T @ units / len(units) - 0.5 * np.eye(3)
        self._tensor.add(tensor)
        self._order.add(np.linalg.eigvalsh(tensor)[-1])
        if self._axis is not None:
            self._along.add(self._axis @ tensor @ self._axis / (self._axis @ self._axis))

    def result(self) -> Orientation:
        """Return order parameters and director."""
        director = np.linalg.eigh(self._tensor.value)[1][:, -1]
        along = None if self._axis is None else (float(self._along.value), float(self._along.error))
        return Orientation((float(self._order.value), float(self._order.error)), np.asarray(director), along)
