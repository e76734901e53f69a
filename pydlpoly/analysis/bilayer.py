"""Thickness of a bilayer and area per molecule."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pydlpoly.analysis.density import along
from pydlpoly.analysis.frames import Analysis, Mean, beads_of, widths
from pydlpoly.analysis.report import Curve, Number
from pydlpoly.errors import InputError
from pydlpoly.formats.history_reader import Frame


@dataclass(frozen=True)
class Bilayer:
    """A bilayer's thickness, Å, and the area of its plane, Å², each with its standard error."""

    thickness: tuple[float, float]
    area: tuple[float, float]

    def numbers(self) -> list[Number]:
        """Return both."""
        return [Number("bilayer thickness", *self.thickness, "Å"), Number("bilayer area", *self.area, "Å²")]

    def curves(self) -> list[Curve]:
        """Return nothing: there are only numbers."""
        return []


class BilayerThickness(Analysis[Bilayer]):
    """Distance between the mean places of the head beads above and below the middle of the tail beads.

    The bilayer lies across one cell vector; it may drift and lie across the cell's boundary.

    Args:
        heads, tails: species.
        axis: "x", "y" or "z".
    """

    def __init__(self, heads: str, tails: str, *, axis: str = "z") -> None:
        if axis not in ("x", "y", "z"):
            raise InputError("expected axis x, y or z", word=axis)
        self._heads, self._tails, self._axis = heads, tails, "xyz".index(axis)
        self._mean = Mean()

    def add(self, frame: Frame) -> None:
        """Take one frame."""
        places = along(frame, self._axis, self._tails)[beads_of(frame, self._heads)]
        upper, lower = places[places > 0.0], places[places <= 0.0]
        if not (len(upper) and len(lower)):
            raise InputError(f"all beads {self._heads} are on one side of the {self._tails} in step {frame.step}")
        width = float(widths(frame.cell)[self._axis])
        area = abs(float(np.linalg.det(frame.cell))) / width
        self._mean.add([(upper.mean() - lower.mean()) * width, area])

    def result(self) -> Bilayer:
        """Return thickness and area."""
        (thickness, area), (thickness_error, area_error) = self._mean.value.tolist(), self._mean.error.tolist()
        return Bilayer((thickness, thickness_error), (area, area_error))
