"""VAFDAT_<species>: velocity autocorrelation functions, in DL_POLY's layout.

record 1   title
data set   (a8,i10,1p,e16.8,f20.6)   species, number of the last point, ⟨v(t0)·v(t0)⟩, t0
           (1p,2e14.6)               t − t0, ⟨v(t)·v(t0)⟩/⟨v(t0)·v(t0)⟩, from point 0 on

A file of averages over time origins has one data set; t0 is then the last of them. One without has a data set for every
origin, each followed by three empty lines.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import IO

import numpy as np
from numpy.typing import ArrayLike

from pydlpoly.errors import InputError
from pydlpoly.formats.atomic import FrameFile, PathLike, RecordWriter, read_text, replace_file
from pydlpoly.formats.fortran import fortran_e, fortran_f, fortran_i, parse_real, parse_reals
from pydlpoly.formats.records import FloatArray


@dataclass(frozen=True, eq=False)
class VelocityCorrelation:
    """One data set of a VAFDAT file.

    Attributes:
        species: whose velocities.
        at_origin: ⟨v(t0)·v(t0)⟩, 3 k_B T/m in (Å/ps)².
        origin: t0 in ps.
        times: (points,) t − t0 in ps; values: (points,) the function, 1 at time 0.
    """

    species: str
    at_origin: float
    origin: float
    times: FloatArray
    values: FloatArray


def correlation_text(species: str, at_origin: float, origin: float, times: ArrayLike, values: ArrayLike) -> str:
    """Return the lines of one data set; ``times`` and ``values`` are (points,).

    Raises:
        InputError: the name is longer than its column.
    """
    if len(species) > 8:
        raise InputError("a name in a DL_POLY file has at most 8 characters", word=species)
    rows = np.column_stack([np.asarray(times, dtype=np.float64), np.asarray(values, dtype=np.float64)]).tolist()
    head = f"{species:<8}{fortran_i(len(rows) - 1, 10)}{fortran_e(at_origin, 16, 8)}{fortran_f(origin, 20, 6)}"
    return "\n".join([head, *("".join(fortran_e(value, 14, 6) for value in row) for row in rows), ""])


def write_correlation(path: PathLike, title: str, data_set: VelocityCorrelation) -> None:
    """Write a file of one data set in one instant. Raises RunError when it cannot be written."""
    one = data_set
    text = correlation_text(one.species, one.at_origin, one.origin, one.times, one.values)
    replace_file(path, f"{_title(title)}\n{text}")


class CorrelationWriter(RecordWriter):
    """Appends data sets to a file; each is one write.

    Args:
        path: the file.
        title: the run's title (72 characters are kept).
        points: number of points of a data set.
        keep: go on with an existing file of which the first ``keep`` data sets stay; None starts anew.

    Raises:
        InputError: the file to go on with holds fewer data sets.
        RunError: the file cannot be written.
    """

    def __init__(self, path: PathLike, title: str, points: int, keep: int | None = None) -> None:
        """Open the file; see the class."""
        header = f"{_title(title)}\n".encode()
        # Fixed columns: 8+10+16+20 and 28 characters, a line feed each, and three empty lines.
        size = 55 + 29 * points + 3
        kept = len(header) + size * (keep or 0)
        whole = _first_bytes(kept, os.fspath(path))
        self._file = FrameFile(path, header, append=keep is not None, whole_length=whole)

    def write(self, data_set: VelocityCorrelation) -> None:
        """Append one data set."""
        one = data_set
        text = correlation_text(one.species, one.at_origin, one.origin, one.times, one.values)
        self._file.write(f"{text}\n\n\n".encode())


def read_correlations(path: PathLike) -> tuple[VelocityCorrelation, ...]:
    """Read all data sets of a VAFDAT file; one that a kill cut short is left out.

    Raises:
        InputError: the file is missing or not a VAFDAT file.
    """
    name = os.fspath(path)
    lines = read_text(path).splitlines()
    found, at = [], 1
    while at < len(lines):
        if not lines[at].strip():
            at += 1
            continue
        words = lines[at][8:].split()
        try:
            points, at_origin, origin = int(words[0]) + 1, parse_real(words[1]), parse_real(words[2])
            block = lines[at + 1 : at + 1 + points]
            if len(block) < points:
                break
            table = np.array([parse_reals(line.split()) for line in block]).reshape(points, 2)
        except (ValueError, IndexError):
            message = "is not a VAFDAT file: expected species, number of points, value and time, then two columns"
            raise InputError(message, path=name, line=at + 1, word=lines[at].strip()) from None
        found.append(VelocityCorrelation(lines[at][:8].strip(), at_origin, origin, table[:, 0], table[:, 1]))
        at += 1 + points
    return tuple(found)


def _title(title: str) -> str:
    return " ".join(title.splitlines())[:72]


def _first_bytes(kept: int, path: str) -> Callable[[IO[bytes]], int]:
    def whole(handle: IO[bytes]) -> int:
        if handle.seek(0, os.SEEK_END) < kept:
            raise InputError("cannot be continued: it has fewer data sets than the checkpoint says", path=path)
        return kept

    return whole
