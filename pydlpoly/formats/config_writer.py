"""Writes CONFIG and REVCON files in DL_POLY's record layout, or with as many digits as asked for."""

from __future__ import annotations

import io
from typing import IO

import numpy as np

from pydlpoly.errors import InputError
from pydlpoly.formats.fortran import (
    ByteColumns,
    fortran_e,
    fortran_f_columns,
    fortran_g20_10,
    fortran_i,
    integer_columns,
    record,
    text_columns,
)
from pydlpoly.formats.lexing import WORD_LIMIT
from pydlpoly.formats.records import Configuration, FloatArray

_CHUNK = 50_000  # beads formatted at the same time
_BLANK, _LINE_FEED = ord(" "), ord("\n")
_WIDTH = 72
_LARGEST_STEP = 10**9  # more digits would touch the number before


def write_config(configuration: Configuration, digits: int | None = None) -> str:
    """Return the text of a CONFIG file; arguments and errors as in ``write_config_to``."""
    buffer = io.BytesIO()
    write_config_to(buffer, configuration, digits)
    return buffer.getvalue().decode("ascii")


def write_config_to(file: IO[bytes], configuration: Configuration, digits: int | None = None) -> None:
    """Write a CONFIG file to a binary file, chunk by chunk.

    Args:
        file: open for writing bytes.
        configuration: what to write. Line 2 carries step, timestep and time at level 2 and whenever one is not zero.
            Without periodicity (imcon 0) the file has no cell.
        digits: None for DL_POLY's own records of 73 bytes (vectors ``3g20.10``: ten digits); a number for vectors,
            cell and times with so many significant digits (17 reads back exactly), in longer records.

    Raises:
        InputError: the configuration cannot be written so that it would be read back: arrays of the wrong shape,
            numbers that are not finite, names that are empty, too long or have blanks, forces without velocities.
    """
    _check(configuration, digits)
    file.write(record(configuration.title))
    file.write(record(_header(configuration, digits), width=_WIDTH if digits is None else _WIDTH + digits))
    if configuration.imcon:
        file.write(_vectors(configuration.cell, digits, is_cell=True).tobytes())
    given = (configuration.positions, configuration.velocities, configuration.forces)
    arrays = [array for array in given if array is not None]
    for start in range(0, len(configuration.names), _CHUNK):
        part = slice(start, start + _CHUNK)
        names = _name_records(configuration.names[part], start + 1)
        vectors = [_vectors(array[part], digits) for array in arrays]
        file.write(np.concatenate([names, *vectors], axis=1).tobytes())


def _header(configuration: Configuration, digits: int | None) -> str:
    level, imcon, beads = configuration.level, configuration.imcon, len(configuration.names)
    step, timestep, time = configuration.step, configuration.timestep, configuration.time
    if level < 2 and not (step or timestep or time):
        return "".join(fortran_i(number, 10) for number in (level, imcon, beads))
    if step < _LARGEST_STEP:
        numbers = "".join(fortran_i(number, 10) for number in (level, imcon, beads, step))
    else:
        numbers = f"{level:5d}{imcon:5d}{beads:10d} {step:19d}"
    if digits is None:
        return numbers + fortran_e(timestep, 16, 7) + fortran_e(time, 16, 7)
    return f"{numbers} {timestep:.{digits - 1}E} {time:.{digits - 1}E}"


def _name_records(names: tuple[str, ...], first: int) -> ByteColumns:
    """Return ``a8,i10`` and 54 blanks for each bead, shape (n, 73)."""
    ids = integer_columns(np.arange(first, first + len(names)), 10)
    return _closed([text_columns(names, WORD_LIMIT), ids])


def _vectors(array: FloatArray, digits: int | None, *, is_cell: bool = False) -> ByteColumns:
    """Return one record for each vector, shape (n, record length)."""
    if digits is not None:
        width = digits + 8  # sign, point, exponent of up to three digits, a blank
        texts = [f"{value:{width}.{digits - 1}E}" for value in np.asarray(array, dtype=np.float64).ravel().tolist()]
        columns = np.frombuffer("".join(texts).encode("ascii"), dtype=np.uint8)
    else:
        columns = fortran_f_columns(array, 20, 10, shrink=True) if is_cell else fortran_g20_10(array)
    return _closed([columns.reshape(len(array), -1)])


def _closed(parts: list[ByteColumns]) -> ByteColumns:
    """Join columns, pad them to a full record and end it."""
    beads = len(parts[0])
    padding = max(0, _WIDTH - sum(part.shape[1] for part in parts))
    blanks = np.full((beads, padding), _BLANK, dtype=np.uint8)
    return np.concatenate([*parts, blanks, np.full((beads, 1), _LINE_FEED, dtype=np.uint8)], axis=1)


def _check(configuration: Configuration, digits: int | None) -> None:
    if digits is not None and not 1 <= digits <= 40:
        raise InputError(f"digits must be 1 to 40, not {digits}")
    if configuration.imcon not in (0, 1, 2, 3, 6):
        raise InputError(f"imcon {configuration.imcon} cannot be written; expected 0, 1, 2, 3 or 6")
    if not 0 <= configuration.step < 10**18 or not configuration.timestep >= 0.0:
        raise InputError("step and timestep must not be negative")
    if not np.isfinite([configuration.timestep, configuration.time]).all():
        raise InputError("timestep and time must be finite numbers")
    if configuration.velocities is None and configuration.forces is not None:
        raise InputError("forces without velocities cannot be written; give velocities too")
    _check_arrays(configuration)
    for name in dict.fromkeys(configuration.names):
        if not 1 <= len(name) <= WORD_LIMIT or name.split() != [name]:
            raise InputError(f"a name must have 1 to {WORD_LIMIT} characters and no blanks", word=name)


def _check_arrays(configuration: Configuration) -> None:
    beads = len(configuration.names)
    if beads == 0:
        raise InputError("a configuration without beads cannot be written")
    shapes = {"positions": (beads, 3), "velocities": (beads, 3), "forces": (beads, 3), "cell": (3, 3)}
    for what, shape in shapes.items():
        array = getattr(configuration, what)
        if array is None:
            continue
        if np.shape(array) != shape:
            raise InputError(f"the {what} must have shape {shape}, not {np.shape(array)}")
        if not np.isfinite(array).all():
            broken = np.flatnonzero(~np.isfinite(array).all(axis=1))
            raise InputError(f"the {what} have a number that is not finite in row {broken[0] + 1}")
