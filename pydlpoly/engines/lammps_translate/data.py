"""The data file of LAMMPS: cell, masses, beads by id, velocities and bonded terms, with all digits."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pydlpoly.engines.lammps_translate.formulas import number
from pydlpoly.formats.records import FloatArray

_CHUNK = 100_000  # beads formatted at a time


@dataclass(frozen=True)
class DataFile:
    """Everything in the file but the beads' places and velocities.

    Attributes:
        title: first line.
        cell: (3, 3) lower triangular cell vectors by row.
        masses: of the types, in order.
        types: (N,) counted from 1.
        molecules: (N,) counted from 1.
        charges: (N,) in e; None where beads have none in this run.
        rows: of the sections of terms; ``term_types``: how many types each has.
    """

    title: str
    cell: FloatArray
    masses: tuple[float, ...]
    types: NDArray[np.int64]
    molecules: NDArray[np.int64]
    charges: FloatArray | None
    rows: Mapping[str, NDArray[np.int64]]
    term_types: Mapping[str, int]

    def pieces(self, positions: FloatArray, velocities: FloatArray) -> Iterator[str]:
        """Yield the file's text with these positions, (N, 3) in a cell around the origin, and velocities (N, 3)."""
        yield "\n".join([*self._header(), "", "Masses", "", *self._masses(), ""])
        count = len(self.types)
        columns: list[NDArray[np.generic]] = [np.arange(1, count + 1), self.molecules, self.types]
        form = "%d %d %d"
        if self.charges is not None:
            columns.append(self.charges)
            form += " %.17g"
        columns += list(positions.T)
        yield "\nAtoms # full\n\n" if self.charges is not None else "\nAtoms # molecular\n\n"
        yield from _lines(f"{form} %.17g %.17g %.17g\n", columns)
        yield "\nVelocities\n\n"
        yield from _lines("%d %.17g %.17g %.17g\n", [columns[0], *velocities.T])
        for section, rows in self.rows.items():
            yield f"\n{section}\n\n"
            width = rows.shape[1]
            yield from _lines("%d" + " %d" * width + "\n", [np.arange(1, len(rows) + 1), *rows.T])

    def _header(self) -> Iterable[str]:
        low = -0.5 * self.cell.sum(axis=0)
        yield self.title.replace("\n", " ").strip() or "beads"
        yield ""
        yield f"{len(self.types)} atoms"
        yield f"{len(self.masses)} atom types"
        for section, rows in self.rows.items():
            yield f"{len(rows)} {section.lower()}"
            yield f"{self.term_types[section]} {section.lower()[:-1]} types"
        yield ""
        for k, axis in enumerate("xyz"):
            yield f"{number(low[k])} {number(low[k] + self.cell[k, k])} {axis}lo {axis}hi"
        if np.any(np.tril(self.cell, -1)):
            yield f"{number(self.cell[1, 0])} {number(self.cell[2, 0])} {number(self.cell[2, 1])} xy xz yz"

    def _masses(self) -> list[str]:
        return [f"{k} {number(mass)}" for k, mass in enumerate(self.masses, 1)]


def _lines(form: str, columns: list[NDArray[np.generic]]) -> Iterator[str]:
    count = len(columns[0])
    for start in range(0, count, _CHUNK):
        chosen = (column[start : start + _CHUNK].tolist() for column in columns)
        yield "".join(map(form.__mod__, zip(*chosen, strict=True)))
