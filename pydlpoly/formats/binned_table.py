"""PROFILE and MAP: averages in bins as plain columns that ``numpy.loadtxt`` reads. Not files of DL_POLY.

line 1   # pydlpoly profile: title
line 2   # bins N, samples N, beads outside the bins in a sample X
line 3   # units: name unit, name unit, …
line 4   # names of the columns
then     one line a bin: its middle along each axis, and the averages; in PROFILE each with its error beside it.
         In MAP a blank line ends each row of bins.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from pydlpoly.errors import InputError
from pydlpoly.formats.atomic import PathLike, read_text, replace_file
from pydlpoly.formats.records import FloatArray

_MARK = "# pydlpoly profile: "
_COUNTS = re.compile(r"# bins (\d+(?: x \d+)?), samples (\d+), beads outside the bins in a sample (\S+)")
_ERROR = "_error"


@dataclass(frozen=True, eq=False)
class BinnedTable:
    """Averages in bins along one or two axes.

    Attributes:
        axes: "x", "y" or "z", one for each axis.
        centres: for each axis the middles of the bins, (bins,), measured from the middle of the cell.
        samples: number of samples.
        outside: mean number of beads that lay outside the bins, beyond the cell along an open axis.
        values: by quantity, shaped as the bins; not a number where no bead ever was, for what is an average over beads.
        errors: standard errors, of profiles along one axis; empty for maps.
        units: by quantity and axis, empty in reduced units.
    """

    title: str
    axes: tuple[str, ...]
    centres: tuple[FloatArray, ...]
    samples: int
    outside: float
    values: Mapping[str, FloatArray]
    errors: Mapping[str, FloatArray] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)

    def __getitem__(self, quantity: str) -> FloatArray:
        """Return the averages of a quantity. Raises KeyError when the table does not have it."""
        return self.values[quantity]


def write_binned(path: PathLike, table: BinnedTable) -> None:
    """Replace the file.

    Raises:
        RunError: the file cannot be written.
    """
    names = [*table.axes]
    columns = [grid.ravel() for grid in np.meshgrid(*table.centres, indexing="ij")]
    for name, values in table.values.items():
        names.append(name)
        columns.append(values.ravel())
        if name in table.errors:
            names.append(name + _ERROR)
            columns.append(table.errors[name].ravel())
    units = ", ".join(f"{name} {unit}" for name, unit in table.units.items() if unit) or "reduced"
    bins = " x ".join(str(len(middles)) for middles in table.centres)
    head = [
        _MARK + " ".join(table.title.split()),
        f"# bins {bins}, samples {table.samples}, beads outside the bins in a sample {table.outside:g}",
        f"# units: {units}",
        "# " + " ".join(names),
    ]
    rows = [" ".join(f"{value:16.9E}" for value in row) for row in np.stack(columns, axis=1).tolist()]
    if len(table.axes) > 1:
        length = len(table.centres[-1])
        rows = [line for k in range(0, len(rows), length) for line in (*rows[k : k + length], "")]
    replace_file(Path(path), "\n".join([*head, *rows]) + "\n")


def is_binned(path: Path) -> bool:
    """Return whether a file begins as PROFILE and MAP do."""
    if not path.is_file():
        return False
    with path.open("rb") as file:
        return file.read(len(_MARK)) == _MARK.encode()


def read_binned(path: PathLike) -> BinnedTable:
    """Read PROFILE or MAP.

    Raises:
        InputError: the file is missing or is another one.
    """
    text = read_text(path)
    lines = text.splitlines()
    place = str(path)
    counts = _COUNTS.fullmatch(lines[1]) if len(lines) > 4 else None
    if counts is None or not lines[0].startswith(_MARK):
        raise InputError("is no profile or map of pydlpoly", path=place, line=1)
    names = lines[3].removeprefix("# ").split()
    shape = tuple(int(number) for number in counts[1].split(" x "))
    axes, bins = tuple(names[: len(shape)]), int(np.prod(shape))
    rows = [line for line in lines[4:] if line.strip()]
    whole = sum(len(row.split()) == len(names) for row in rows)
    if whole != bins or len(rows) != bins:
        expected = f"expected {bins} lines of {len(names)} numbers, found {whole}"
        raise InputError(f"is cut short or damaged: {expected}", path=place)
    try:
        table = np.loadtxt(rows, ndmin=2)
    except ValueError as error:
        raise InputError(f"cannot be read: {error}", path=place) from error
    values: dict[str, FloatArray] = {}
    errors: dict[str, FloatArray] = {}
    last = ""
    for name, column in zip(names[len(shape) :], table.T[len(shape) :], strict=True):
        if name == last + _ERROR:
            errors[last] = column.reshape(shape)
        else:
            values[name] = column.reshape(shape)
        last = name
    grids = [table[:, k].reshape(shape) for k in range(len(shape))]
    centres = tuple(np.moveaxis(grid, k, 0).reshape(shape[k], -1)[:, 0].copy() for k, grid in enumerate(grids))
    words = lines[2].removeprefix("# units: ").split(", ")
    units = dict(word.split(" ", 1) for word in words if " " in word)
    title, samples, outside = lines[0].removeprefix(_MARK), int(counts[2]), float(counts[3])
    return BinnedTable(title, axes, centres, samples, outside, values, errors, units)
