"""Reads and writes TABLE (TABVDW) files: tabulated pair laws, U and G = −r dU/dr on one regular grid."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pydlpoly.errors import InputError, suggest
from pydlpoly.formats.lexing import (
    WORD_LIMIT,
    Line,
    LineReader,
    content_lines,
    parse_integer,
    parse_number,
    plain_line_ends,
    read_text,
    split_words,
)
from pydlpoly.formats.records import Field, FloatArray, PairTable

_COLUMNS = 4  # numbers on a line
_LEAST_POINTS = 4  # three-point interpolation and one interval


class _Grid(NamedTuple):
    spacing: float
    cutoff: float
    points: int


def read_table(path: str | Path, field: Field) -> tuple[PairTable, ...]:
    """Read the tables of all pairs that FIELD declares ``tab``, in the order of FIELD.

    Args:
        path: the TABLE file.
        field: the FIELD it belongs to.

    Raises:
        InputError: the file is damaged or cut short, its grid is unusable, it has a pair that FIELD does not declare
            ``tab``, or lacks one that it does.
    """
    return parse_table(read_text(path), field, path=str(path))


def parse_table(text: str, field: Field, path: str = "TABLE") -> tuple[PairTable, ...]:
    """Read the text of a TABLE file; arguments and errors as in ``read_table``."""
    raw = plain_line_ends(text).split("\n")
    last = len(raw) - 1 if raw[-1] == "" and len(raw) > 1 else len(raw)
    lines = LineReader(content_lines(raw[1:], first=2), path, last)
    grid = _read_grid(lines)
    wanted = [pair.species for pair in field.pairs if pair.key == "tab"]
    tables: dict[tuple[str, ...], PairTable] = {}
    while lines.peek() is not None:
        table = _read_pair(lines, grid, field, wanted)
        same = tuple(sorted(table.species))
        if same in tables:
            told = f"the table of {' '.join(table.species)} is already given on line {tables[same].line}"
            lines.fail(told, table.line)
        tables[same] = table
    for species in wanted:
        if tuple(sorted(species)) not in tables:
            told = f"the file ends here; expected the table of {' '.join(species)}, which FIELD declares tab"
            lines.fail(told, lines.last_line)
    return tuple(tables[tuple(sorted(species))] for species in wanted)


def write_table(tables: Sequence[PairTable], title: str = "") -> str:
    """Return the text of a TABLE file, numbers with 17 significant digits.

    Raises:
        InputError: there is no table, or the tables do not share one grid, or a number is not finite.
    """
    if not tables:
        raise InputError("a TABLE file needs at least one pair")
    if "\n" in title or "\r" in title:
        raise InputError("the title must be one line", word=title)
    first = tables[0]
    points = len(first.energy)
    parts = [title, f"{float(first.spacing)!r} {float(first.cutoff)!r} {points}"]
    for table in tables:
        pair = " ".join(table.species)
        if (table.spacing, table.cutoff) != (first.spacing, first.cutoff):
            raise InputError(f"the table of {pair} has another spacing or cutoff than the first one")
        parts.append(f"{_name(table.species[0]):8s} {_name(table.species[1])}")
        for what, values in (("energy", table.energy), ("virial", table.virial)):
            if np.shape(values) != (points,):
                raise InputError(f"the {what} of {pair} must have {points} values, not {np.shape(values)}")
            if not np.isfinite(values).all():
                raise InputError(f"the {what} of {pair} has a number that is not finite")
            rows = (values[i : i + _COLUMNS].tolist() for i in range(0, points, _COLUMNS))
            parts.extend("".join(f"{value:25.16E}" for value in row) for row in rows)
    return "\n".join(parts) + "\n"


def _name(name: str) -> str:
    if not 1 <= len(name) <= WORD_LIMIT or split_words(name) != (name,):
        expected = f"1 to {WORD_LIMIT} characters without blanks, not beginning with # or !"
        raise InputError(f"this species name cannot be written; expected {expected}", word=name)
    return name


def _read_grid(lines: LineReader) -> _Grid:
    line = lines.next("the grid: spacing, cutoff and number of points")
    if len(line.words) < 3:
        lines.fail("the line is too short; expected the grid: spacing, cutoff and number of points", line)
    values = []
    for word, what in zip(line.words, ("spacing", "cutoff"), strict=False):
        value = parse_number(word)
        if value is None or value <= 0.0:
            lines.fail(f"expected the grid's {what}, a positive number", line, word)
        values.append(value)
    points = parse_integer(line.words[2])
    if points is None or points < _LEAST_POINTS:
        lines.fail(f"expected the number of grid points, at least {_LEAST_POINTS}", line, line.words[2])
    spacing, cutoff = values
    # A millionth of a spacing allows for the digits to which spacing and cutoff are written.
    if spacing * points < cutoff - 1e-6 * cutoff:
        told = f"{points} points of spacing {line.words[0]} end at {spacing * points:g}, before the cutoff"
        lines.fail(f"{told}; expected a grid that reaches it", line, line.words[1])
    return _Grid(spacing, cutoff, points)


def _read_pair(lines: LineReader, grid: _Grid, field: Field, wanted: Sequence[tuple[str, str]]) -> PairTable:
    line = lines.next("two species")
    if len(line.words) < 2:
        lines.fail("expected two species, which head the next table", line, line.words[0])
    a, b = line.words[0][:WORD_LIMIT], line.words[1][:WORD_LIMIT]
    if parse_number(a) is not None and parse_number(b) is not None and a not in _species(field):
        told = f"the numbers before make up the {grid.points} points of line 2"
        lines.fail(f"expected two species, which head the next table ({told})", line, a)
    for name in (a, b):
        if name not in _species(field):
            lines.fail(f"unknown species{suggest(name, _species(field))}", line, name)
    if (a, b) not in wanted and (b, a) not in wanted:
        told = ", ".join(" ".join(pair) for pair in wanted) or "none"
        lines.fail(f"FIELD does not declare the pair {a} {b} tab; it declares {told}", line)
    energy = _read_values(lines, grid, f"U of {a} {b}", line)
    virial = _read_values(lines, grid, f"-r dU/dr of {a} {b}", line)
    return PairTable((a, b), grid.spacing, grid.cutoff, energy, virial, lines.path, line.number)


def _species(field: Field) -> dict[str, None]:
    return {atom.name: None for molecule in field.molecules for atom in molecule.atoms}


def _read_values(lines: LineReader, grid: _Grid, what: str, head: Line) -> FloatArray:
    """Return one value for each grid point; a line never holds values of two blocks."""
    values: list[float] = []
    while len(values) < grid.points:
        line = lines.next(f"value {len(values) + 1} of {grid.points} of {what} (table on line {head.number})")
        for word in line.words:
            value = parse_number(word)
            if value is None:
                lines.fail(f"expected value {len(values) + 1} of {grid.points} of {what}, a finite number", line, word)
            if len(values) == grid.points:
                told = f"{what} has {grid.points} values on {ceil(grid.points / _COLUMNS)} lines"
                lines.fail(f"{told}, but the line goes on; expected its end", line, word)
            values.append(value)
    return np.array(values)
