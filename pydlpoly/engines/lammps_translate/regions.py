"""Parts of the cell as regions of LAMMPS.

LAMMPS wraps beads when it builds a new list only, so that a bead may be a little outside of the cell; every region
therefore has its images next to the cell.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from pydlpoly.engines.lammps_translate.formulas import number
from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.cell import widths

EVERYWHERE = "everywhere"
"""The region of all beads; ``everywhere_command`` makes it."""


def everywhere_command() -> str:
    """Return the command that makes the region of all beads."""
    return f"region {EVERYWHERE} block INF INF INF INF INF INF"


def box_commands(name: str, bounds: Sequence[float], cell: FloatArray, margin: float) -> list[str] | None:
    """Return the commands that make a box, with its images within ``margin`` of the cell.

    Args:
        name: of the region.
        bounds: x0 x1 y0 y1 z0 z1 of wrapped positions, from the cell's centre.
        cell: (3, 3) lower triangular cell vectors by row.
        margin: how far outside of the cell beads may be, Å.

    Returns:
        None where the box is bounded along an axis that a cell vector of another axis leans over: the wrapped places of
        such a box have no simple images. Empty when no bead can be inside.
    """
    intervals: list[list[tuple[str, str]]] = []
    for axis in range(3):
        half = 0.5 * float(cell[axis, axis])
        low, high = (float(x) for x in bounds[2 * axis : 2 * axis + 2])
        leans = bool(np.any(cell[axis + 1 :, axis] != 0.0))
        if (low <= -half and high >= half) and not leans:
            intervals.append([("INF", "INF")])
            continue
        if leans:
            lowest = 0.5 * float(np.abs(cell[:, axis]).sum())
            if low > -lowest or high < lowest:
                return None
            intervals.append([("INF", "INF")])
            continue
        low, high = max(low, -half), min(high, half)
        if low >= high:
            return []
        shifts = [0.0, *([-2.0 * half] if high > half - margin else []), *([2.0 * half] if low < margin - half else [])]
        intervals.append([(number(low + shift), number(high + shift)) for shift in shifts])
    blocks = [" ".join(f"{low} {high}" for low, high in three) for three in product(*intervals)]
    return _union(name, [f"block {block}" for block in blocks])


def sphere_commands(name: str, centre: Sequence[float], radius: float, cell: FloatArray, margin: float) -> list[str]:
    """Return the commands that make a sphere and its images, those that reach to within ``margin`` of the cell."""
    across, inverse = widths(cell), np.linalg.inv(cell)
    shapes = []
    for shift in product((0, -1, 1), repeat=3):
        place = np.asarray(centre) + np.asarray(shift, dtype=np.float64) @ cell
        if np.all(np.abs(place @ inverse) * across <= 0.5 * across + radius + margin):
            shapes.append(f"sphere {' '.join(map(number, place))} {number(radius)}")
    return _union(name, shapes)


def sphere_crosses_border(centre: Sequence[float], radius: float, cell: FloatArray) -> bool:
    """Return whether a sphere is not wholly within the cell around the origin."""
    across = widths(cell)
    return bool(np.any(np.abs(np.asarray(centre) @ np.linalg.inv(cell)) * across + radius > 0.5 * across))


def _union(name: str, shapes: list[str]) -> list[str]:
    if len(shapes) == 1:
        return [f"region {name} {shapes[0]}"]
    parts = [f"{name}_{k}" for k in range(len(shapes))]
    lines = [f"region {part} {shape}" for part, shape in zip(parts, shapes, strict=True)]
    return [*lines, f"region {name} union {len(parts)} {' '.join(parts)}"]
