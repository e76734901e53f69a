"""The data file of LAMMPS: cell, masses, beads by id, velocities and bonded terms, with all digits."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pydlpoly.engines.lammps_translate.carried import NOTHING, Carried
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
        carried: what beads carry; ``capacities``: (N,) C_v/k_B of beads that carry heat.
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
    carried: Carried = NOTHING
    capacities: FloatArray | None = None

    def pieces(
        self,
        positions: FloatArray,
        velocities: FloatArray,
        temperatures: FloatArray | None = None,
        concentrations: FloatArray | None = None,
    ) -> Iterator[str]:
        """Yield the file's text.

        Args:
            positions: (N, 3) in a cell around the origin; velocities: (N, 3).
            temperatures: (N,) as k_B T; concentrations: (N, species). Where beads carry them.
        """
        yield "\n".join([*self._header(), "", "Masses", "", *self._masses(), ""])
        ids = np.arange(1, len(self.types) + 1)
        plain = "molecular" if self.charges is None else "full"
        style = self.carried.atom_style(plain)
        own: list[NDArray[np.generic]] = [] if self.charges is None else [self.charges]
        if style == plain:
            columns = [ids, self.molecules, self.types, *own, *positions.T]
            form = ["%d", "%d", "%d", *["%.17g"] * (len(own) + 3)]
        else:
            more = self._carried_columns(temperatures, concentrations)
            columns = [ids, self.types, *positions.T, self.molecules, *own, *more]
            form = ["%d", "%d", *["%.17g"] * 3, "%d", *["%.17g"] * (len(own) + len(more))]
        yield f"\nAtoms # {style.split()[0]}\n\n"
        yield from _lines(" ".join(form) + "\n", columns)
        yield "\nVelocities\n\n"
        yield from _lines("%d %.17g %.17g %.17g\n", [ids, *velocities.T])
        for section, rows in self.rows.items():
            yield f"\n{section}\n\n"
            width = rows.shape[1]
            yield from _lines("%d" + " %d" * width + "\n", [np.arange(1, len(rows) + 1), *rows.T])

    def _carried_columns(
        self, temperatures: FloatArray | None, concentrations: FloatArray | None
    ) -> list[NDArray[np.generic]]:
        """Return the columns of the atom styles, in the order of ``Carried.atom_style``."""
        columns: list[NDArray[np.generic]] = []
        if self.carried.heat:
            assert temperatures is not None
            assert self.capacities is not None
            columns += [temperatures, self.capacities]
        if self.carried.dissolved:
            assert concentrations is not None
            columns += list(concentrations.T)
        if "mdpd" in self.carried.atom_style(""):
            columns.append(np.zeros(len(self.types)))  # densities are computed before they are used
        return columns

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
