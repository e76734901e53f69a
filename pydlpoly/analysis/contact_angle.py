"""Contact angle of a droplet on a wall, from a spherical cap through its surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pydlpoly.analysis.density import along
from pydlpoly.analysis.frames import Analysis, beads_of, widths
from pydlpoly.analysis.report import Curve, Number
from pydlpoly.errors import InputError
from pydlpoly.formats.history_reader import Frame
from pydlpoly.formats.records import FloatArray

_BLOCKS = 5
_FEWEST_POINTS = 4


@dataclass(frozen=True, eq=False)
class SphericalCap:
    """A droplet on a wall as a part of a sphere.

    Attributes:
        angle: the contact angle in degrees, measured in the liquid: cos θ = (z_wall − z_centre)/R.
        radius: R of the sphere, Å; height: of its centre above the wall, Å; base: radius of the wetted circle, Å (0
            where the sphere does not reach the wall).
        error: standard error of the angle from averages over blocks of frames, not a number with too few frames.
        liquid: density inside the droplet, per Å³; its surface is where the density is half of it.
        r, z: (bins,) distances from the droplet's axis and heights above the wall, Å; density: (z, r) per Å³.
        surface: (points, 2) r and z of the surface that the sphere was laid through.
    """

    angle: float
    radius: float
    height: float
    base: float
    error: float
    liquid: float
    r: FloatArray
    z: FloatArray
    density: FloatArray
    surface: FloatArray

    def numbers(self) -> list[Number]:
        """Return angle, radius and density."""
        return [
            Number("contact angle", self.angle, self.error, "degrees"),
            Number("radius of the cap", self.radius, float("nan"), "Å"),
            Number("density in the droplet", self.liquid, float("nan"), "1/Å³"),
        ]

    def curves(self) -> list[Curve]:
        """Return the surface, z against r."""
        nothing = np.full(len(self.surface), np.nan)
        return [Curve("contact angle", "surface", "r (Å)", "z (Å)", self.surface[:, 0], self.surface[:, 1], nothing)]


class ContactAngle(Analysis[SphericalCap]):
    """Contact angle of one droplet on a wall across z, below it.

    In every frame the droplet is moved so that its axis, through the mean place of its beads on both periodic axes, is
    that of the profile. Averaged over angles and frames, the density is half the liquid's at the surface.
    A sphere goes through the surface of all layers above ``skip`` by least squares and meets the wall at the angle.

    Args:
        liquid: species of the droplet.
        wall: z of the wall's surface, Å from the middle of the cell.
        reach: largest distance from the axis, Å; by default half the shorter edge.
        bin_width: of heights, Å; distances from the axis have rings of equal area as that of a disc of one bin.
        skip: height of the layers above the wall that are left out, in which beads lie in layers, Å.
    """

    def __init__(
        self,
        liquid: str,
        wall: float,
        *,
        reach: float | None = None,
        bin_width: float = 0.5,
        skip: float = 1.0,
    ) -> None:
        if not bin_width > 0.0 or skip < 0.0 or (reach is not None and not reach > 0.0):
            raise InputError("expected a bin width and a reach above 0 and no negative height to skip")
        self._liquid, self._wall, self._reach = liquid, wall, reach
        self._width, self._skip = bin_width, skip
        self._counts: list[NDArray[np.int32]] = []
        self._edges: tuple[FloatArray, FloatArray] | None = None

    def add(self, frame: Frame) -> None:
        """Take one frame."""
        if np.any(frame.cell != np.diag(np.diag(frame.cell))):
            raise InputError("the contact angle needs a cell with right angles")
        lengths = widths(frame.cell)
        beads = beads_of(frame, self._liquid)
        across = [along(frame, axis, self._liquid)[beads] * lengths[axis] for axis in (0, 1)]
        height = frame.positions[beads, 2]
        if frame.imcon != 6:
            height = height - lengths[2] * np.round(height / lengths[2])
        edges = self._edges
        if edges is None:
            reach = self._reach or 0.5 * float(min(lengths[:2]))
            rings = max(2, int((reach / self._width) ** 2))
            layers = max(1, int((0.5 * lengths[2] - self._wall) / self._width))
            heights, distances = self._width * np.arange(layers + 1.0), self._width * np.sqrt(np.arange(rings + 1.0))
            edges = self._edges = np.asarray(heights), np.asarray(distances)  # rings of equal area
        distance = np.hypot(across[0], across[1])
        counts, _, _ = np.histogram2d(height - self._wall, distance, bins=edges)
        self._counts.append(counts.astype(np.int32))

    def result(self) -> SphericalCap:
        """Return the cap. Raises InputError where no droplet lies on the wall."""
        if self._edges is None:
            raise InputError("no frames were given")
        heights, rings = self._edges
        z, r = 0.5 * (heights[1:] + heights[:-1]), np.sqrt(0.5 * (rings[1:] ** 2 + rings[:-1] ** 2))
        volume = np.pi * self._width**2 * self._width
        density = np.mean(self._counts, axis=0) / volume
        liquid = _density_inside(density, z, self._skip)
        surface = _surface(density, r, z, liquid, self._skip)
        radius, height = fit_cap(surface)
        return SphericalCap(
            angle=_angle(radius, height),
            radius=radius,
            height=height,
            base=float(np.sqrt(max(0.0, radius**2 - height**2))),
            error=self._error(r, z, volume),
            liquid=liquid,
            r=r,
            z=z,
            density=density,
            surface=surface,
        )

    def _error(self, r: FloatArray, z: FloatArray, volume: float) -> float:
        if len(self._counts) < 2 * _BLOCKS:
            return float("nan")
        angles = []
        for block in np.array_split(np.array(self._counts), _BLOCKS):
            density = block.mean(axis=0) / volume
            inside = _density_inside(density, z, self._skip)
            angles.append(_angle(*fit_cap(_surface(density, r, z, inside, self._skip))))
        return float(np.std(angles, ddof=1) / np.sqrt(_BLOCKS))


def fit_cap(surface: FloatArray) -> tuple[float, float]:
    """Return radius and height of the centre of the sphere about the axis through points (r, z), by least squares.

    r² + z² = 2 z c + (R² − c²) is linear in c and R² − c².

    Raises:
        InputError: there are too few points, or no sphere goes through them.
    """
    if len(surface) < _FEWEST_POINTS:
        raise InputError(f"the droplet's surface was found in {len(surface)} layers only: no cap goes through them")
    r, z = surface.T
    (double_centre, rest), *_ = np.linalg.lstsq(np.column_stack([z, np.ones_like(z)]), r**2 + z**2, rcond=None)
    centre = 0.5 * float(double_centre)
    square = float(rest) + centre**2
    if not square > 0.0:
        raise InputError("no spherical cap goes through the droplet's surface")
    return float(np.sqrt(square)), centre


def _angle(radius: float, height: float) -> float:
    return float(np.degrees(np.arccos(np.clip(-height / radius, -1.0, 1.0))))


def _density_inside(density: FloatArray, z: FloatArray, skip: float) -> float:
    """Density in the middle of the droplet: about the axis, over the layers in which most of it is dense."""
    core = density[z > skip, : max(2, density.shape[1] // 50)].mean(axis=1)
    if len(core) == 0 or not core.max() > 0.0:
        raise InputError("no beads of the droplet lie above the layers that are left out")
    return float(np.median(core[core > 0.5 * core.max()]))


def _surface(density: FloatArray, r: FloatArray, z: FloatArray, liquid: float, skip: float) -> FloatArray:
    """(points, 2) r and z where each layer's density falls through half the liquid's, counted from outside."""
    points = []
    for height, layer in zip(z, density, strict=True):
        dense = np.nonzero(layer >= 0.5 * liquid)[0]
        if height <= skip or len(dense) < 2 or dense[-1] + 1 >= len(layer):
            continue
        k = int(dense[-1])
        share = (layer[k] - 0.5 * liquid) / (layer[k] - layer[k + 1])
        points.append((float(r[k] + share * (r[k + 1] - r[k])), float(height)))
    return np.array(points).reshape(-1, 2)
