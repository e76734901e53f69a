"""Places points and rigid molecules at random or on a lattice in a periodic cell; numpy only.

Everything random is made of ``Generator.random`` alone, so that a seed gives the same places with every numpy. Cells
are (3, 3), one cell vector a row, with the origin at their centre. Lengths are in the unit of the cell.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]


def place_random(count: int, cell: ArrayLike, rng: np.random.Generator) -> FloatArray:
    """Return ``count`` points, uniform in the cell.

    Args:
        count: number of points.
        cell: (3, 3) cell vectors by row.
        rng: where the random numbers come from.

    Returns:
        (count, 3) positions inside the cell.

    Raises:
        ValueError: a negative count, or a cell that is not (3, 3) or spans no volume.
    """
    vectors = _checked(cell)
    if count < 0:
        raise ValueError(f"the number of points must not be negative, not {count}")
    places: FloatArray = (rng.random((count, 3)) - 0.5) @ vectors
    return places


def place_lattice(count: int, cell: ArrayLike) -> FloatArray:
    """Return ``count`` points of a lattice along the cell's axes, as near to equal spacings as whole numbers allow.

    The lattice has at least ``count`` points; those left over stay empty, evenly spread over the lattice.

    Args:
        count: number of points.
        cell: (3, 3) cell vectors by row.

    Returns:
        (count, 3) positions inside the cell.

    Raises:
        ValueError: as for ``place_random``.
    """
    vectors = _checked(cell)
    if count < 0:
        raise ValueError(f"the number of points must not be negative, not {count}")
    if count == 0:
        return np.zeros((0, 3))
    lengths = np.linalg.norm(vectors, axis=1)
    spacing = float((np.prod(lengths) / count) ** (1.0 / 3.0))
    shape = np.maximum(1, np.rint(lengths / spacing)).astype(int)
    while math.prod(shape.tolist()) < count:
        shape[np.argmax(lengths / shape)] += 1
    total = math.prod(shape.tolist())
    chosen = np.arange(count, dtype=np.int64) * total // count
    steps = np.stack(np.unravel_index(chosen, tuple(shape.tolist())), axis=1)
    places: FloatArray = ((steps + 0.5) / shape - 0.5) @ vectors
    return places


def random_rotations(count: int, rng: np.random.Generator, *, mirrored: bool = False) -> FloatArray:
    """Return ``count`` rotations, uniform over all orientations (Shoemake, Graphics Gems III, 1992, p. 124).

    Args:
        count: number of matrices.
        rng: where the random numbers come from.
        mirrored: let each matrix also mirror, with probability 1/2; its determinant is then -1.

    Returns:
        (count, 3, 3) orthogonal matrices R, to be used as R @ r.
    """
    u = rng.random((count, 3))
    inner, outer = np.sqrt(1.0 - u[:, 0]), np.sqrt(u[:, 0])
    first, second = 2.0 * np.pi * u[:, 1], 2.0 * np.pi * u[:, 2]
    x, y, z, w = inner * np.sin(first), inner * np.cos(first), outer * np.sin(second), outer * np.cos(second)
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ]
    matrices: FloatArray = np.moveaxis(np.array(rows), 2, 0)
    if mirrored:
        matrices = matrices * np.where(rng.random(count) < 0.5, -1.0, 1.0)[:, None, None]
    return matrices


def place_rigid(
    template: ArrayLike, centres: ArrayLike, rng: np.random.Generator, *, mirrored: bool = False
) -> FloatArray:
    """Return copies of a rigid molecule, each turned at random about the mean of its beads, which goes to a centre.

    Args:
        template: (b, 3) places of the molecule's beads.
        centres: (n, 3) where the copies go, for example from ``place_random``.
        rng: where the random numbers come from.
        mirrored: let each copy also be mirrored, with probability 1/2.

    Returns:
        (n b, 3) positions, copy after copy, molecules whole: beads may lie outside the cell, and a scene wraps them.

    Raises:
        ValueError: arrays of another shape, a molecule without beads, or numbers that are not finite.
    """
    beads, middles = np.asarray(template, dtype=np.float64), np.asarray(centres, dtype=np.float64)
    for what, array in (("template", beads), ("centres", middles)):
        if array.ndim != 2 or array.shape[1] != 3 or not np.isfinite(array).all():
            raise ValueError(f"the {what} must be rows of three finite numbers, not an array of shape {array.shape}")
    if len(beads) == 0:
        raise ValueError("a molecule needs at least one bead")
    arms = beads - beads.mean(axis=0)
    turned = np.einsum("nij,bj->nbi", random_rotations(len(middles), rng, mirrored=mirrored), arms)
    places: FloatArray = (turned + middles[:, None, :]).reshape(-1, 3)
    return places


def _checked(cell: ArrayLike) -> FloatArray:
    vectors = np.asarray(cell, dtype=np.float64)
    if vectors.shape != (3, 3):
        raise ValueError(f"the cell must be (3, 3), not {vectors.shape}")
    if not abs(np.linalg.det(vectors)) > 0.0:
        raise ValueError("the cell spans no volume")
    return vectors
