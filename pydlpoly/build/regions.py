"""Parts of the cell that molecules are placed in. Points are given anywhere; regions are periodic with the cell.

Cells are (3, 3), one cell vector a row, with the origin at their centre.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pydlpoly.errors import SceneError
from pydlpoly.formats.records import FloatArray

AXES = ("x", "y", "z")
"""Names of the three cell vectors."""

# Points that fail to hit a region so often show that it has no room in the cell.
_MOST_MISSES = 10_000_000


def heights(cell: FloatArray) -> FloatArray:
    """Return the perpendicular distances between opposite faces, (3,)."""
    result: FloatArray = 1.0 / np.linalg.norm(np.linalg.inv(cell), axis=0)
    return result


class Region(ABC):
    """A part of the cell."""

    @abstractmethod
    def contains(self, points: FloatArray, cell: FloatArray) -> NDArray[np.bool_]:
        """Return which of the (n, 3) points lie inside, (n,)."""

    @abstractmethod
    def volume(self, cell: FloatArray) -> float:
        """Return the volume inside the cell. Raises SceneError when the region does not fit the cell."""

    def sample(self, count: int, cell: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Return (count, 3) uniform points inside. Raises SceneError when none are found."""
        found: list[FloatArray] = []
        have = tried = 0
        while have < count:
            trials = max(64, 2 * (count - have))
            points = (rng.random((trials, 3)) - 0.5) @ cell
            inside = points[self.contains(points, cell)]
            found.append(inside)
            have += len(inside)
            tried += trials
            if have == 0 and tried > _MOST_MISSES:
                raise SceneError(f"the region {self} has no room in the cell")
        return np.concatenate(found)[:count] if found else np.zeros((0, 3))


@dataclass(frozen=True)
class Everywhere(Region):
    """The whole cell."""

    def contains(self, points: FloatArray, cell: FloatArray) -> NDArray[np.bool_]:  # noqa: ARG002
        """Return True for each point."""
        return np.ones(len(points), dtype=np.bool_)

    def volume(self, cell: FloatArray) -> float:
        """Return the cell's volume."""
        return abs(float(np.linalg.det(cell)))


@dataclass(frozen=True)
class Slab(Region):
    """A layer between two heights over the plane of the other two cell vectors, measured from the cell's centre."""

    low: float
    high: float
    axis: str = "z"

    def contains(self, points: FloatArray, cell: FloatArray) -> NDArray[np.bool_]:
        """Return which points lie between the two heights."""
        number = _axis(self.axis)
        height = float(heights(cell)[number])
        apart = (points @ np.linalg.inv(cell))[:, number] * height - 0.5 * (self.low + self.high)
        inside: NDArray[np.bool_] = np.abs(apart - height * np.rint(apart / height)) <= 0.5 * (self.high - self.low)
        return inside

    def volume(self, cell: FloatArray) -> float:
        """Return area times thickness."""
        height = float(heights(cell)[_axis(self.axis)])
        if not 0.0 < self.high - self.low <= height:
            message = f"a slab from {self.low:g} to {self.high:g} does not fit a cell of height {height:g}"
            raise SceneError(message)
        return abs(float(np.linalg.det(cell))) * (self.high - self.low) / height


@dataclass(frozen=True)
class Sphere(Region):
    """A sphere."""

    radius: float
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def contains(self, points: FloatArray, cell: FloatArray) -> NDArray[np.bool_]:
        """Return which points are at most a radius away from the centre or one of its images."""
        apart = points - np.array(self.centre)
        apart = apart - np.rint(apart @ np.linalg.inv(cell)) @ cell
        inside: NDArray[np.bool_] = np.einsum("ij,ij->i", apart, apart) <= self.radius**2
        return inside

    def volume(self, cell: FloatArray) -> float:
        """Return 4/3 π r³."""
        _check_radius(self.radius, float(heights(cell).min()), "sphere")
        return 4.0 / 3.0 * math.pi * self.radius**3


@dataclass(frozen=True)
class Cylinder(Region):
    """A cylinder along a cell vector, through the whole cell; ``centre`` is a point on its axis."""

    radius: float
    axis: str = "z"
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def contains(self, points: FloatArray, cell: FloatArray) -> NDArray[np.bool_]:
        """Return which points are at most a radius away from the axis or one of its images."""
        along = cell[_axis(self.axis)] / np.linalg.norm(cell[_axis(self.axis)])
        apart = points - np.array(self.centre)
        apart = apart - np.rint(apart @ np.linalg.inv(cell)) @ cell
        apart = apart - np.outer(apart @ along, along)
        inside: NDArray[np.bool_] = np.einsum("ij,ij->i", apart, apart) <= self.radius**2
        return inside

    def volume(self, cell: FloatArray) -> float:
        """Return π r² times the length of the cell vector."""
        number = _axis(self.axis)
        _check_radius(self.radius, float(np.delete(heights(cell), number).min()), "cylinder")
        return math.pi * self.radius**2 * float(np.linalg.norm(cell[number]))


@dataclass(frozen=True)
class Outside(Region):
    """Everything but these regions, which must not overlap."""

    regions: tuple[Region, ...]

    def contains(self, points: FloatArray, cell: FloatArray) -> NDArray[np.bool_]:
        """Return which points are in none of the regions."""
        inside = np.zeros(len(points), dtype=np.bool_)
        for region in self.regions:
            inside |= region.contains(points, cell)
        return ~inside

    def volume(self, cell: FloatArray) -> float:
        """Return what the regions leave of the cell."""
        return Everywhere().volume(cell) - sum(region.volume(cell) for region in self.regions)


def _axis(name: str) -> int:
    if name not in AXES:
        raise SceneError("an axis is x, y or z", word=name)
    return AXES.index(name)


def _check_radius(radius: float, width: float, what: str) -> None:
    if not 0.0 < radius <= 0.5 * width:
        raise SceneError(f"a {what} of radius {radius:g} does not fit a cell of width {width:g}")
