"""Reads and writes TABBND, TABANG, TABDIH and TABINV: tabulated bonded laws on regular grids, three columns a node.

The columns are the coordinate (Å or degrees), U, and −r dU/dr for bonds, −dU/dx for angles. A grid of n points has
nodes at 1 … n spacings from its start: 0, but −180 degrees for dihedrals. A line for the start itself may come first
(its third number is −dU/dx, for bonds, too); without it, that node is made from its neighbours: for dihedrals it is the
last one, for others U goes on with a slope that changes linearly.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
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
)
from pydlpoly.formats.records import BondedTable, Field, FloatArray

_LEAST_POINTS = 3  # the start is made from two of them
_TOLERANCE = 0.01  # of coordinates, in spacings: they may be written with few digits
_PERIOD_TOLERANCE = 1e-5  # of U at -180 and 180 degrees, relative to its range


class TableKind(NamedTuple):
    """What a file of one kind of bonded terms holds: its block in FIELD, its beads, and the range of its coordinate."""

    name: str
    directive: str
    beads: int
    start: float
    end: float | None  # None: the file says it
    unit: str


TABLE_KINDS: dict[str, TableKind] = {
    "bond": TableKind("TABBND", "bonds", 2, 0.0, None, "ang"),
    "angle": TableKind("TABANG", "angles", 3, 0.0, 180.0, "degrees"),
    "dihedral": TableKind("TABDIH", "dihedrals", 4, -180.0, 180.0, "degrees"),
    "inversion": TableKind("TABINV", "inversions", 4, 0.0, 180.0, "degrees"),
}
"""The files by kind of term."""


class _Grid(NamedTuple):
    start: float
    spacing: float
    points: int


def canonical_species(kind: str, names: Sequence[str]) -> tuple[str, ...]:
    """Return the names in the one order that stands for all orders with the same table.

    Bonds, angles and dihedrals may be read from either end; an inversion's centre is the first, its ends are equal.
    """
    given = tuple(names)
    return (given[0], *sorted(given[1:])) if kind == "inversion" else min(given, given[::-1])


def wanted_tables(kind: str, field: Field) -> tuple[tuple[str, ...], ...]:
    """Return the species of all terms of this kind that FIELD declares ``tab``, in order, each once."""
    found: dict[tuple[str, ...], None] = {}
    for molecule in field.molecules:
        block = molecule.block(TABLE_KINDS[kind].directive)
        if block is None or not molecule.count:
            continue
        names = molecule.bead_names
        for line in block.lines:
            if line.key in ("tab", "-tab"):
                found[canonical_species(kind, [names[bead - 1] for bead in line.beads])] = None
    return tuple(found)


def read_bonded_tables(path: str | Path, kind: str, field: Field) -> tuple[BondedTable, ...]:
    """Read the tables of all terms of one kind that FIELD declares ``tab``, in the order of FIELD.

    Args:
        path: the file.
        kind: "bond", "angle", "dihedral" or "inversion".
        field: the FIELD it belongs to.

    Raises:
        InputError: the file is damaged or cut short, its grid is unusable, it has a table that FIELD does not ask for,
            or lacks one that it does.
    """
    return parse_bonded_tables(read_text(path), kind, field, path=str(path))


def parse_bonded_tables(text: str, kind: str, field: Field, path: str = "TABBND") -> tuple[BondedTable, ...]:
    """Read the text of such a file; arguments and errors as in ``read_bonded_tables``."""
    raw = plain_line_ends(text).split("\n")
    last = len(raw) - 1 if raw[-1] == "" and len(raw) > 1 else len(raw)
    # Programs that plot them take lines that begin with # for comments; here they are the headings.
    plain = [re.sub(r"^(\s*)#", r"\1 ", line) for line in raw[1:]]
    lines = LineReader(content_lines(plain, first=2), path, last)
    grid = _read_grid(lines, kind)
    wanted = wanted_tables(kind, field)
    tables: dict[tuple[str, ...], BondedTable] = {}
    while lines.peek() is not None:
        table = _read_block(lines, kind, grid, field, wanted)
        same = canonical_species(kind, table.species)
        if same in tables:
            told = f"the table of {' '.join(table.species)} is already given on line {tables[same].line}"
            lines.fail(told, table.line)
        tables[same] = table
    for species in wanted:
        if species not in tables:
            told = f"the file ends here; expected the table of {' '.join(species)}, which FIELD declares tab"
            lines.fail(told, lines.last_line)
    return tuple(tables[species] for species in wanted)


def write_bonded_tables(tables: Sequence[BondedTable], title: str = "") -> str:
    """Return the text of such a file, numbers with 17 significant digits, the start of the grid left out.

    Raises:
        InputError: there is no table, they differ in kind or grid, or a number is not finite.
    """
    if not tables:
        raise InputError("a file of tables needs at least one")
    if "\n" in title or "\r" in title:
        raise InputError("the title must be one line", word=title)
    first = tables[0]
    spec, points = TABLE_KINDS[first.kind], len(first.energy) - 1
    end = f"{float(first.spacing * points)!r} " if spec.end is None else ""
    parts = [title, f"# {end}{points}"]
    for table in tables:
        words = " ".join(table.species)
        if (table.kind, table.start, table.spacing) != (first.kind, first.start, first.spacing):
            raise InputError(f"the table of {words} has another kind or grid than the first one")
        for what, values in (("energy", table.energy), ("slope", table.slope)):
            if np.shape(values) != (points + 1,) or not np.isfinite(values).all():
                raise InputError(f"the {what} of {words} must be {points + 1} finite numbers")
        at = table.start + table.spacing * np.arange(points + 1)
        third = -table.slope * (at if spec.end is None else 1.0)
        parts += ["", f"# {words}"]
        rows = zip(at[1:].tolist(), table.energy[1:].tolist(), third[1:].tolist(), strict=True)
        parts += [f"{x:25.16E}{u:25.16E}{f:25.16E}" for x, u, f in rows]
    return "\n".join(parts) + "\n"


def _read_grid(lines: LineReader, kind: str) -> _Grid:
    spec = TABLE_KINDS[kind]
    what = "the number of grid points" if spec.end is not None else "the cutoff and the number of grid points"
    line = lines.next(what)
    end, position = spec.end, 0
    if end is None:
        end, position = parse_number(line.words[0]), 1
        if end is None or end <= 0.0:
            lines.fail("expected the cutoff of the bonds, a positive number", line, line.words[0])
    if len(line.words) <= position:
        lines.fail(f"the line is too short; expected {what}", line)
    points = parse_integer(line.words[position])
    if points is None or points < _LEAST_POINTS:
        lines.fail(f"expected the number of grid points, at least {_LEAST_POINTS}", line, line.words[position])
    return _Grid(spec.start, (end - spec.start) / points, points)


def _read_block(
    lines: LineReader, kind: str, grid: _Grid, field: Field, wanted: Sequence[tuple[str, ...]]
) -> BondedTable:
    spec = TABLE_KINDS[kind]
    line = lines.next("species")
    names = tuple(word[:WORD_LIMIT] for word in line.words[: spec.beads])
    known = {atom.name: None for molecule in field.molecules for atom in molecule.atoms}
    if len(names) < spec.beads or (names[0] not in known and parse_number(names[0]) is not None):
        told = f"the lines before make up the {grid.points} points of line 2"
        lines.fail(f"expected {spec.beads} species, which head the next table ({told})", line, line.words[0])
    for name in names:
        if name not in known:
            lines.fail(f"unknown species{suggest(name, known)}", line, name)
    if canonical_species(kind, names) not in wanted:
        told = ", ".join(" ".join(species) for species in wanted) or "none"
        lines.fail(f"FIELD does not declare the {kind} {' '.join(names)} tab; it declares {told}", line)
    energy, slope = _read_nodes(lines, kind, grid, line, " ".join(names))
    return BondedTable(kind, names, grid.start, grid.spacing, energy, slope, lines.path, line.number)


def _read_nodes(lines: LineReader, kind: str, grid: _Grid, head: Line, words: str) -> tuple[FloatArray, FloatArray]:
    nodes = np.full((grid.points + 1, 2), np.nan)
    k = 1
    following = lines.peek()
    if following is not None and (first := parse_number(following.words[0])) is not None:
        k = 0 if abs(first - grid.start) <= _TOLERANCE * grid.spacing else 1
    for node in range(k, grid.points + 1):
        told = f"point {node} of {grid.points} of the table of {words} (line {head.number})"
        line = lines.next(told)
        numbers = [_number(lines, line, position, told) for position in range(3)]
        at = grid.start + node * grid.spacing
        if abs(numbers[0] - at) > _TOLERANCE * grid.spacing:
            unit = TABLE_KINDS[kind].unit
            lines.fail(f"expected {told} at {at:.9g} {unit}, as the grid of line 2 has it", line, line.words[0])
        # For bonds the third column is -r dU/dr, but at r = 0, where that says nothing, the force.
        by = numbers[0] if kind == "bond" and node else 1.0
        nodes[node] = numbers[1], -numbers[2] / by
    energy, slope = np.ascontiguousarray(nodes.T)
    if kind == "dihedral":
        if k == 0 and abs(energy[0] - energy[-1]) > _PERIOD_TOLERANCE * np.ptp(energy):
            lines.fail(f"U of {words} is {energy[0]:g} at -180 degrees and {energy[-1]:g} at 180", head)
        energy[0], slope[0] = energy[-1], slope[-1]
    elif k == 1:
        slope[0] = 2.0 * slope[1] - slope[2]
        energy[0] = energy[1] - 0.5 * grid.spacing * (slope[0] + slope[1])
    return energy, slope


def _number(lines: LineReader, line: Line, position: int, told: str) -> float:
    if position >= len(line.words):
        lines.fail(f"the line is too short; expected three numbers, {told}", line)
    value = parse_number(line.words[position])
    if value is None:
        lines.fail(f"expected a finite number, {told}", line, line.words[position])
    return value
