"""Results as numbers to print and curves to write or draw."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from pydlpoly.formats.records import FloatArray


@dataclass(frozen=True)
class Number:
    """A result with its standard error; the unit is empty for what has none."""

    name: str
    value: float
    error: float
    unit: str = ""


@dataclass(frozen=True, eq=False)
class Curve:
    """A function with its standard errors: x, y and error are (points,)."""

    group: str
    name: str
    x_label: str
    y_label: str
    x: FloatArray
    y: FloatArray
    error: FloatArray


class Reportable(Protocol):
    """What every result can say of itself."""

    def numbers(self) -> Sequence[Number]:
        """Return the single numbers."""

    def curves(self) -> Sequence[Curve]:
        """Return the functions."""
