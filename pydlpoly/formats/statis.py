"""STATIS: the statistics of a run, one record every few steps, in DL_POLY's classic and YAML forms.

Classic records are ``(i10,1p,e14.6,0p,i10)`` step, time and number of values, then the values, five a line, in
``(1p,5e14.6)``. The values stand in the order of ``STATISTICS_NAMES`` (DL_POLY 5), followed by one mean-square
displacement for each species. ``read_statistics`` reads both forms back.
"""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import IO

import numpy as np

from pydlpoly.errors import InputError
from pydlpoly.formats.atomic import FrameFile, PathLike, RecordWriter
from pydlpoly.formats.fortran import fortran_e, fortran_i
from pydlpoly.formats.records import FloatArray
from pydlpoly.formats.statis_columns import (
    SCALAR_NAMES,
    STATISTICS_NAMES,
    VARIABLE_CELL_LABELS,
    VARIABLE_CELL_NAMES,
    Quantity,
)
from pydlpoly.formats.statis_table import StatisticsTable, read_statistics

__all__ = [
    "STATISTICS_NAMES",
    "Quantity",
    "StatisticsRecord",
    "StatisticsTable",
    "StatisticsWriter",
    "read_statistics",
]


@dataclass(frozen=True, eq=False)
class StatisticsRecord:
    """The statistics of one step, in the units of the file: energies and virials of the whole system in FIELD's unit.

    Attributes:
        step, time: number of the step; time in ps.
        extended_energy … conserved_term: the quantities of ``STATISTICS_NAMES`` (temperatures in K, volume in Å³,
            angles in degrees, pressure in katm; reduced units throughout with ``units dpd``). What a run does not
            have stays 0, as in DL_POLY.
        stress: (3, 3) stress tensor in katm, a pressure being positive.
        square_displacements: mean-square displacement of each species in Å², in the writer's order.
        variable_cell: where the cell moves, the columns of ``VARIABLE_CELL_NAMES``.
    """

    step: int
    time: float
    extended_energy: float = 0.0
    temperature: float = 0.0
    configurational_energy: float = 0.0
    short_range_energy: float = 0.0
    electrostatic_energy: float = 0.0
    bond_energy: float = 0.0
    angle_energy: float = 0.0
    dihedral_energy: float = 0.0
    tether_energy: float = 0.0
    enthalpy: float = 0.0
    rotational_temperature: float = 0.0
    virial: float = 0.0
    short_range_virial: float = 0.0
    electrostatic_virial: float = 0.0
    bond_virial: float = 0.0
    angle_virial: float = 0.0
    constraint_virial: float = 0.0
    tether_virial: float = 0.0
    volume: float = 0.0
    shell_temperature: float = 0.0
    shell_energy: float = 0.0
    shell_virial: float = 0.0
    cell_alpha: float = 0.0
    cell_beta: float = 0.0
    cell_gamma: float = 0.0
    pmf_virial: float = 0.0
    pressure: float = 0.0
    conserved_term: float = 0.0
    stress: FloatArray = field(default_factory=lambda: np.zeros((3, 3)))
    square_displacements: tuple[float, ...] = ()
    variable_cell: tuple[float, ...] = ()

    def values(self) -> FloatArray:
        """Return all numbers in the order of the file: 28 scalars, 9 stress components, species, the cell."""
        scalars = [getattr(self, name) for name in SCALAR_NAMES]
        stress = np.asarray(self.stress, dtype=np.float64).reshape(9)
        return np.array([*scalars, *stress, *self.square_displacements, *self.variable_cell], dtype=np.float64)


class StatisticsWriter(RecordWriter):
    """Writes STATIS record by record; each record is one write, so that a killed run leaves whole records.

    Args:
        path: the file.
        title: the run's title.
        energy_label: the energy unit as text, for example ``kJ/mol``.
        species: species names, one mean-square displacement each.
        variable_cell: number of columns of a cell that moves, a key of ``VARIABLE_CELL_NAMES``.
        yaml: DL_POLY's ``io_statis_yaml`` form.
        append: go on with an existing file of the same form; a record that a kill cut short is dropped.
        keep_until: with ``append``, drop records of later steps, so that a run that continues from a checkpoint
            older than its last record has no step twice.

    Raises:
        InputError: the file to be continued is of another form or has another number of values.
        RunError: the file cannot be written.
    """

    def __init__(
        self,
        path: PathLike,
        title: str,
        energy_label: str,
        species: Sequence[str],
        *,
        variable_cell: int = 0,
        yaml: bool = False,
        append: bool = False,
        keep_until: int | None = None,
    ) -> None:
        """Open the file; see the class."""
        self._yaml = yaml
        self._species = tuple(species)
        self._cell = VARIABLE_CELL_NAMES[variable_cell]
        self._count = len(STATISTICS_NAMES) + len(self._species) + variable_cell
        self._path = os.fspath(path)
        header = self._yaml_header(title, energy_label) if yaml else _classic_header(title, energy_label)
        self._file = FrameFile(
            path, header.encode("utf-8"), append=append, whole_length=lambda handle: self._whole(handle, keep_until)
        )

    def write(self, record: StatisticsRecord) -> None:
        """Append one record.

        Raises:
            RunError: the file cannot be written.
            ValueError: the record's number of species or of the cell's columns is not the writer's.
        """
        values = record.values()
        if len(values) != self._count:
            moved, cell = len(record.square_displacements), len(record.variable_cell)
            found = f"{moved} displacements for {len(self._species)} species"
            raise ValueError(f"{found}, {cell} numbers of the cell for {len(self._cell)} columns")
        text = _yaml_row(record, values) if self._yaml else _classic_record(record, values)
        self._file.write(text.encode("ascii"))

    def _yaml_header(self, title: str, energy_label: str) -> str:
        labels = ["step", "time", *(q.label for q in STATISTICS_NAMES), *(f"amsd {s}" for s in self._species)]
        labels += [VARIABLE_CELL_LABELS[name] for name in self._cell]
        flow = ", ".join(_quoted(label) for label in labels)
        lines = ["%YAML 1.2", "---", f"title: {_quoted(title)}", f"energy unitS: {_quoted(energy_label)}"]
        return "\n".join([*lines, "labels:", f"  - [ {flow} ]", "timesteps:", ""])

    def _whole(self, handle: IO[bytes], keep_until: int | None) -> int:
        """How many bytes of an existing file are whole records of steps up to ``keep_until``."""
        content = handle.read()
        if content.startswith(b"%YAML") != self._yaml and content:
            raise InputError("cannot be continued: one of the files is YAML, the other classic", path=self._path)
        ends = _yaml_record_ends(content) if self._yaml else _classic_record_ends(content, self._count)
        if ends is None:
            message = f"cannot be continued: its records do not hold {self._count} values, as this run's do"
            raise InputError(message, path=self._path)
        kept = [end for step, end in ends if step is None or keep_until is None or step <= keep_until]
        return kept[-1] if kept else 0


def _classic_header(title: str, energy_label: str) -> str:
    return f"title: {_quoted(title)}\nenergy unitS: {' '.join(energy_label.splitlines())}\n"


def _quoted(text: str) -> str:
    """A YAML single-quoted scalar on one line."""
    return "'" + " ".join(text.splitlines()).replace("'", "''") + "'"


def _classic_record(record: StatisticsRecord, values: FloatArray) -> str:
    numbers = [fortran_e(v, 14, 6) for v in values.tolist()]
    lines = ["".join(numbers[start : start + 5]) for start in range(0, len(numbers), 5)]
    head = fortran_i(record.step, 10) + fortran_e(record.time, 14, 6) + fortran_i(len(numbers), 10)
    return "\n".join([head, *lines, ""])


def _yaml_row(record: StatisticsRecord, values: FloatArray) -> str:
    numbers = [_yaml_real(v) for v in [record.time, *values.tolist()]]
    return f"  - [ {', '.join([str(record.step), *numbers])} ]\n"


def _yaml_real(value: float) -> str:
    if np.isnan(value):
        return ".nan"
    return f"{value:.6E}" if np.isfinite(value) else ("-.inf" if value < 0 else ".inf")


def _classic_record_ends(content: bytes, count: int) -> list[tuple[int | None, int]] | None:
    """(step, end) of the header (step None) and of each whole record; None when the records have another length."""
    lines = content.split(b"\n")[:-1]  # what follows the last line feed is torn
    ends: list[tuple[int | None, int]] = []
    length, block = 0, 1 + -(-count // 5)
    if len(lines) >= 2:
        length = len(lines[0]) + len(lines[1]) + 2
        ends.append((None, length))
    for start in range(2, len(lines) - block + 1, block):
        words = lines[start].split()
        if len(words) != 3 or words[2] != str(count).encode() or not words[0].isdigit():
            return None
        length += sum(len(line) + 1 for line in lines[start : start + block])
        ends.append((int(words[0]), length))
    return ends


def _yaml_record_ends(content: bytes) -> list[tuple[int | None, int]] | None:
    ends: list[tuple[int | None, int]] = []
    length, in_rows = 0, False
    for line in content.split(b"\n")[:-1]:
        length += len(line) + 1
        if in_rows and (match := re.match(rb"\s*- \[\s*(\d+).*\]\s*$", line)):
            ends.append((int(match[1]), length))
        elif line.startswith(b"timesteps:"):
            in_rows = True
            ends.append((None, length))
    return ends
