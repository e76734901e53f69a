"""Cells turned so that a lies along x and b in the plane of x and y, as HOOMD and DCD want them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pydlpoly.errors import InputError
from pydlpoly.formats.records import FloatArray


@dataclass(frozen=True, eq=False)
class Upright:
    """A cell with a along x and b in the plane of x and y.

    Attributes:
        cell: (3, 3) by row, lower triangular with a positive diagonal.
        turn: (3, 3) rotation: vectors of beads times it are those in this cell. None where nothing is turned.
    """

    cell: FloatArray
    turn: FloatArray | None = None

    def turned(self, vectors: FloatArray) -> FloatArray:
        """Return vectors (N, 3) of the file's frame."""
        return vectors if self.turn is None else np.asarray(vectors @ self.turn)

    def back(self, vectors: FloatArray) -> FloatArray:
        """Return vectors (N, 3) of the run's frame."""
        return vectors if self.turn is None else np.asarray(vectors @ self.turn.T)


def upright(cell: FloatArray) -> Upright:
    """Return the cell in that orientation.

    Raises:
        InputError: the cell is left-handed, or spans no volume.
    """
    volume = float(np.linalg.det(cell))
    if not volume > 0.0:
        word = "is left-handed: no rotation brings it into this format" if volume < 0.0 else "spans no volume"
        raise InputError(f"the cell {word}")
    if not np.any(np.triu(cell, 1)) and np.all(np.diag(cell) > 0.0):
        return Upright(np.array(cell))
    # The rows of the cell are the columns of QR's matrix.
    turn, triangle = np.linalg.qr(np.asarray(cell).T)
    signs = np.sign(np.diag(triangle))
    turn = turn * signs
    return Upright(np.tril((triangle * signs[:, None]).T), turn)
