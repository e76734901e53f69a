"""DIAGNOSTICS: what shows whether a run can be trusted, as plain columns that ``numpy.loadtxt`` reads.

One header line ``# step time[ps] …``, then one line a record. Energies and momenta have all their digits, so that a run
that continues computes its drifts from the first line of the file.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from pydlpoly.errors import InputError
from pydlpoly.formats.atomic import FrameFile, PathLike, RecordWriter, read_text
from pydlpoly.formats.records import FloatArray


@dataclass(frozen=True)
class Column:
    """One column of the file.

    Attributes:
        name: as in the header and in ``read_diagnostics``.
        kind: what is measured, which says the unit.
        meaning: one phrase for the documentation.
        digits: behind the point, in exponential form; 16 are all there are.
    """

    name: str
    kind: str
    meaning: str
    digits: int = 9


COLUMNS = (
    Column("step", "", "number of the step", 4),
    Column("time", "time", "simulated time"),
    Column("kinetic_temperature", "temperature", "of the velocities"),
    Column("configurational_temperature", "temperature", "of the positions, this step alone"),
    Column("squared_force", "squared force", "Σ|∇U|² over the mobile beads"),
    Column("laplacian", "force per length", "Σ∇²U over the mobile beads"),
    Column("energy", "energy", "potential and kinetic energy per bead", 16),
    Column("energy_drift", "energy", "the same less that of the first record; an error only with nve"),
    *(
        Column(f"pressure_{name}", "pressure", f"part of the pressure: {what}")
        for name, what in (
            ("kinetic", "momenta"),
            ("conservative", "pair laws"),
            ("drag", "drag"),
            ("noise", "noise"),
            ("bonded", "bonded terms"),
            ("charge", "electrostatics"),
        )
    ),
    *(Column(f"momentum_{axis}", "momentum", f"total momentum along {axis}", 16) for axis in "xyz"),
    Column("momentum_drift", "momentum", "length of total momentum less that of the first record"),
)
"""Columns of every file, in their order."""

HEAT_COLUMNS = (
    Column("internal_temperature", "temperature", "internal energy over the heat capacity of all beads"),
    Column("internal_energy", "energy", "internal energy per bead", 16),
    Column("conserved_energy", "energy", "what is conserved, per bead (heat.md)", 16),
    Column("conserved_drift", "energy", "the same less that of the first record"),
)
"""Columns that follow where beads carry heat."""

_MOMENTA = ("momentum_x", "momentum_y", "momentum_z")
_TIME_AND_MECHANICS = {
    "time": "ps",
    "squared force": "Da^2*ang^2/ps^4",
    "force per length": "Da/ps^2",
    "momentum": "Da*ang/ps",
}


class DiagnosticsWriter(RecordWriter):
    """Writes DIAGNOSTICS record by record; each is one write, so that a killed run leaves whole lines.

    Args:
        path: the file.
        units: unit words for "temperature", "energy" and "pressure"; None in reduced units.
        heat: beads carry heat, and ``HEAT_COLUMNS`` follow.
        append: go on with an existing file; a line that a kill cut short is dropped.
        keep_until: with ``append``, drop lines of later steps.

    Raises:
        InputError: the file to be continued has other columns or is no such file.
        RunError: the file cannot be written.
    """

    def __init__(
        self,
        path: PathLike,
        units: Mapping[str, str] | None = None,
        *,
        heat: bool = False,
        append: bool = False,
        keep_until: int | None = None,
    ) -> None:
        """Open the file; see the class."""
        self._path = os.fspath(path)
        self._first: dict[str, float] | None = None
        self._columns = (*COLUMNS, *HEAT_COLUMNS) if heat else COLUMNS
        words = _words(units, self._columns)
        # Right-aligned; a column is as wide as its word or as sign, digits and exponent, whichever is longer.
        self._widths = [max(len(word), column.digits + 8) for word, column in zip(words, self._columns, strict=True)]
        cells = [word.rjust(width) for word, width in zip(words, self._widths, strict=True)]
        header = ("#" + " ".join(cells) + "\n").encode("ascii")
        self._file = FrameFile(
            path, header, append=append, whole_length=lambda handle: self._whole(handle, header, keep_until)
        )

    def write(self, step: int, values: Mapping[str, float]) -> None:
        """Append one record: all columns by name but the step and the drifts, which follow from the first record.

        Raises:
            RunError: the file cannot be written.
            KeyError: a column is missing.
        """
        if self._first is None:
            self._first = dict(values)
        first = self._first
        moved = [values[name] - first[name] for name in _MOMENTA]
        drifts = {
            "energy_drift": values["energy"] - first["energy"],
            "momentum_drift": float(np.sqrt(sum(x * x for x in moved))),
        }
        if "conserved_energy" in values:
            drifts["conserved_drift"] = values["conserved_energy"] - first["conserved_energy"]
        every = {**values, **drifts}
        cells = [
            f"{every[column.name]:{width}.{column.digits}e}"
            for column, width in zip(self._columns[1:], self._widths[1:], strict=True)
        ]
        self._file.write((" ".join([f" {step:{self._widths[0]}d}", *cells]) + "\n").encode("ascii"))

    def _whole(self, handle: IO[bytes], header: bytes, keep_until: int | None) -> int:
        """How many bytes of an existing file are whole lines of steps up to ``keep_until``."""
        lines = handle.read().split(b"\n")[:-1]  # what follows the last line feed is torn
        if not lines:
            return 0
        if lines[0] + b"\n" != header:
            raise InputError("cannot be continued: it has other columns or units than this run", path=self._path)
        kept = len(header)
        for number, line in enumerate(lines[1:], 2):
            row = _numbers(line.decode("latin-1"), len(self._columns), self._path, number)
            if keep_until is not None and row[0] > keep_until:
                break
            if self._first is None:
                self._first = {column.name: value for column, value in zip(self._columns, row, strict=True)}
            kept += len(line) + 1
        return kept


def read_diagnostics(path: PathLike) -> dict[str, NDArray[Any]]:
    """Read DIAGNOSTICS; a last line that a kill cut short is left out.

    Returns:
        The columns by name (``COLUMNS``, and ``HEAT_COLUMNS`` where beads carry heat), each of one value a record;
        "step" holds whole numbers.

    Raises:
        InputError: the file is missing or is no such file.
    """
    name = os.fspath(path)
    lines = read_text(path).split("\n")[:-1]
    if not lines or not lines[0].startswith("#"):
        raise InputError("is no DIAGNOSTICS: its first line does not name columns", path=name, line=1)
    names = [word.split("[")[0] for word in lines[0].removeprefix("#").split()]
    rows = [_numbers(line, len(names), name, number) for number, line in enumerate(lines[1:], 2)]
    table: FloatArray = np.array(rows, dtype=np.float64).reshape(len(rows), len(names))
    columns: dict[str, NDArray[Any]] = {word: table[:, k].copy() for k, word in enumerate(names)}
    if "step" in columns:
        columns["step"] = columns["step"].astype(np.int64)
    return columns


def _words(units: Mapping[str, str] | None, columns: Sequence[Column]) -> list[str]:
    """Return ``name[unit]`` of each column, ``name`` where there is no unit."""
    known = {} if units is None else {**_TIME_AND_MECHANICS, **units}
    found = [known.get(column.kind, "").replace(" ", "_") for column in columns]
    return [f"{column.name}[{unit}]" if unit else column.name for column, unit in zip(columns, found, strict=True)]


def _numbers(line: str, count: int, path: str, number: int) -> list[float]:
    words: Sequence[str] = line.split()
    if len(words) != count:
        raise InputError(f"expected {count} numbers, found {len(words)}", path=path, line=number)
    try:
        return [float(word) for word in words]
    except ValueError as error:
        raise InputError("expected numbers", path=path, line=number) from error
