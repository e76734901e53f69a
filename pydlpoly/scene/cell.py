"""The simulation cell as DL_POLY means it: which numbers an ``imcon`` uses, boxes of open systems, wrapping."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pydlpoly.errors import SceneError
from pydlpoly.formats.records import Configuration, FloatArray
from pydlpoly.scene.settings import Notes, place

_PERIODIC = {
    0: (False, False, False),
    1: (True, True, True),
    2: (True, True, True),
    3: (True, True, True),
    6: (True, True, False),
}
_NO_LONGER = {4: "truncated octahedron", 5: "rhombic dodecahedron", 7: "hexagonal prism"}

# No length in a scene is longer (Å): a tenth of a metre. Larger numbers are slips, and their cubes overflow.
LONGEST = 1e9

# A bead meets no more images of another within a range: beyond this a step takes minutes, and a cell is a slip.
MOST_IMAGES = 30_000

# DL_POLY adds this to the cutoff when it builds the box of an open system, so that no bead lies on its face.
_MARGIN = 1e-6


def resolve_cell(config: Configuration, cutoff: float, notes: Notes) -> tuple[FloatArray, tuple[bool, bool, bool]]:
    """Return the cell vectors by row (Å) and the periodicity along them.

    Args:
        config: the configuration with its ``imcon`` and the cell as the file has it.
        cutoff: the global cutoff (Å), which sets the least extent of axes that are not periodic.
        notes: receives the numbers of the cell that are not used.

    Raises:
        SceneError: an ``imcon`` that is not modelled, or a cell without volume.
    """
    imcon = config.imcon
    if imcon not in _PERIODIC:
        shape = f" ({_NO_LONGER[imcon]}: no longer in DL_POLY either)" if imcon in _NO_LONGER else ""
        raise SceneError(
            f"periodicity key imcon {imcon}{shape} is not modelled; 0, 1, 2, 3 and 6 are", path=config.path
        )
    if not np.all(np.abs(config.cell) <= LONGEST):
        text = f"the cell vectors contain a number that is not finite or beyond {LONGEST:g} ang"
        raise SceneError(text, path=config.path)
    if imcon == 0:
        cell = _open(config, cutoff, notes)
    elif imcon == 1:
        cell = _cubic(config, notes)
    elif imcon == 2:
        cell = _orthorhombic(config, notes)
    else:
        cell = np.array(config.cell) if imcon == 3 else _slab(config, cutoff, notes)
    lengths = np.linalg.norm(cell, axis=1)
    if not abs(np.linalg.det(cell)) > 1e-12 * float(np.prod(lengths)):
        rows = "; ".join(" ".join(f"{x:g}" for x in row) for row in config.cell)
        raise SceneError(f"the cell vectors ({rows}) span no volume (imcon {imcon})", path=config.path)
    return cell, _PERIODIC[imcon]


def wrap(positions: FloatArray, cell: FloatArray, periodic: tuple[bool, bool, bool]) -> FloatArray:
    """Return positions in the cell around the origin: fractional coordinates in [−½, ½) along periodic axes.

    Beads that lie inside keep their coordinates to the last bit.
    """
    fractional = positions @ np.linalg.inv(cell)
    cells: FloatArray = np.where(periodic, np.floor(fractional + 0.5), 0.0)
    moved = np.any(cells != 0.0, axis=1)
    wrapped = np.array(positions, dtype=np.float64)
    wrapped[moved] -= cells[moved] @ cell
    return wrapped


def widths(cell: FloatArray) -> FloatArray:
    """Return the perpendicular distances between opposite faces (Å)."""
    result: FloatArray = 1.0 / np.linalg.norm(np.linalg.inv(cell), axis=0)
    return result


def images_within(reach: float, cell_widths: Sequence[float]) -> float:
    """Return how many images of a bead a range can hold; ``cell_widths`` are those along the periodic axes (Å)."""
    return math.prod(2.0 * math.ceil(reach / width) + 1.0 for width in cell_widths)


def _open(config: Configuration, cutoff: float, notes: Notes) -> FloatArray:
    extents = [_open_extent(config, axis, cutoff) for axis in range(3)]
    text = " x ".join(f"{x:g}" for x in extents)
    notes.choice(
        f"no periodicity: volume and pressure are those of DL_POLY's box around the beads, {text} ang", config.path
    )
    return np.diag(extents)


def _cubic(config: Configuration, notes: Notes) -> FloatArray:
    edge = float(config.cell[0, 0])
    if not edge > 0.0:
        raise SceneError(f"the cubic cell's edge must be positive, not {edge:g}", path=config.path)
    others = [float(x) for x in np.diag(config.cell)[1:] if x != edge]
    if others:
        text = ", ".join(f"{x:g}" for x in others)
        notes.warning(
            f"imcon 1 uses only the first edge {edge:g}; {text} on the diagonal has no effect", place(config.path, None)
        )
    _note_off_diagonal(config, notes)
    return np.diag([edge] * 3)


def _orthorhombic(config: Configuration, notes: Notes) -> FloatArray:
    edges = np.diag(config.cell)
    if not np.all(edges > 0.0):
        text = " ".join(f"{x:g}" for x in edges)
        raise SceneError(f"the orthorhombic cell's edges must be positive, not {text}", path=config.path)
    _note_off_diagonal(config, notes)
    return np.diag(edges)


def _slab(config: Configuration, cutoff: float, notes: Notes) -> FloatArray:
    cell = np.array(config.cell)
    if np.any(cell[:2, 2] != 0.0):
        raise SceneError("a slab (imcon 6) needs its first two cell vectors in the xy plane", path=config.path)
    if np.any(cell[2, :2] != 0.0):
        notes.warning("imcon 6: only the z component of the third cell vector is used", place(config.path, None))
    extent = _open_extent(config, 2, cutoff)
    cell[2] = (0.0, 0.0, extent)
    notes.choice(f"slab: volume and pressure use DL_POLY's extent along z, {extent:g} ang", place(config.path, None))
    return cell


def _open_extent(config: Configuration, axis: int, cutoff: float) -> float:
    reach = cutoff + _MARGIN
    farthest = float(np.max(np.abs(config.positions[:, axis]), initial=0.0))
    return max(2.0 * farthest + reach, 3.0 * reach, float(config.cell[axis, axis]))


def _note_off_diagonal(config: Configuration, notes: Notes) -> None:
    if np.any(config.cell[~np.eye(3, dtype=bool)] != 0.0):
        notes.warning(
            f"imcon {config.imcon} uses only the diagonal of the cell; the other numbers have no effect", config.path
        )
