"""Distances and pairs of beads in any cell, by SciPy's k-d trees; images of the beads stand for periodicity."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from pydlpoly.analysis.frames import fractional, periodic_axes, widths
from pydlpoly.formats.history_reader import Frame
from pydlpoly.formats.records import FloatArray


def distance_counts(frame: Frame, first: NDArray[np.int64], second: NDArray[np.int64], edges: FloatArray) -> FloatArray:
    """Return numbers of ordered pairs by distance, (len(edges) − 1,): one bead of ``first``, one of ``second``.

    All images count that are within reach; a bead is no pair with itself.

    Args:
        frame: positions and cell.
        first, second: bead ids.
        edges: ascending distances, from 0 on.
    """
    from scipy.spatial import cKDTree  # half a second to import, of every command

    places = _inside(frame)
    around, _ = _with_images(frame, places[second], float(edges[-1]))
    below = cKDTree(places[first]).count_neighbors(cKDTree(around), edges)
    return np.asarray(np.diff(below.astype(np.float64)))


def pairs_within(frame: Frame, beads: NDArray[np.int64], reach: float) -> NDArray[np.int64]:
    """Return pairs of places in ``beads``, (n, 2), of which any two images are not farther apart than ``reach``."""
    from scipy.spatial import cKDTree  # as above

    around, owner = _with_images(frame, _inside(frame)[beads], reach)
    pairs = cKDTree(around).query_pairs(reach, output_type="ndarray").astype(np.int64)
    pairs = pairs[(pairs < len(beads)).any(axis=1)]  # both images: the same pair is there inside the cell, too
    return np.asarray(np.unique(np.sort(owner[pairs], axis=1), axis=0))


def _inside(frame: Frame) -> FloatArray:
    if not any(periodic_axes(frame)):
        return frame.positions
    return np.asarray(fractional(frame.positions, frame) @ frame.cell)


def _with_images(frame: Frame, places: FloatArray, reach: float) -> tuple[FloatArray, NDArray[np.int64]]:
    """The places and their images within ``reach`` of the cell, and of which place each is one."""
    axes = periodic_axes(frame)
    owner = np.arange(len(places))
    if not any(axes):
        return places, owner
    margin = reach / widths(frame.cell)
    inside = places @ np.linalg.inv(frame.cell)
    counts = [int(np.ceil(m)) if axis else 0 for m, axis in zip(margin, axes, strict=True)]
    shown, owners = [places], [owner]
    open_axes = ~np.array(axes)
    for shift in product(*(range(-n, n + 1) for n in counts)):
        if any(shift):
            moved = inside + shift
            near = np.all((np.abs(moved) <= 0.5 + margin + 1e-9) | open_axes, axis=1)
            shown.append(places[near] + np.array(shift, dtype=np.float64) @ frame.cell)
            owners.append(owner[near])
    return np.concatenate(shown), np.concatenate(owners)
