"""Reads CONFIG, REVCON and CFGMIN files: cell, names, positions, and by level velocities and forces."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, islice
from pathlib import Path
from typing import NoReturn

import numpy as np

from pydlpoly.errors import InputError
from pydlpoly.formats.config_writer import write_config, write_config_to
from pydlpoly.formats.lexing import (
    WORD_LIMIT,
    cannot_read,
    looks_like_number,
    parse_integer,
    parse_number,
    plain_line_ends,
)
from pydlpoly.formats.plain_lines import plain_heads, plain_vectors
from pydlpoly.formats.records import Configuration, FloatArray, IntArray

__all__ = ["parse_config", "read_config", "write_config", "write_config_to"]

_CHUNK = 1_000  # beads whose lines are held as words at the same time; more makes the garbage collector slow
_TITLE_LENGTH = 72
_INDEX = re.compile(r"[+-]?[0-9]+")
_KINDS = ("position", "velocity", "force")
_OLD_CELLS = {4: "truncated octahedron", 5: "rhombic dodecahedron", 7: "hexagonal prism"}
_NOT_AN_INDEX = -1
_Rows = Sequence[Sequence[str]]


def read_config(path: str | Path, ignore_indices: bool = False) -> Configuration:
    """Read a CONFIG, REVCON or CFGMIN file.

    Args:
        path: the file.
        ignore_indices: keep the order of the file; otherwise beads are sorted by the indices on their name lines. A
            bead without an index, or with index 0, counts as having its place in the file as its index.

    Raises:
        InputError: the file is not a CONFIG, is damaged or cut short, or its indices are not 1 to N once each.
    """
    try:
        try:
            return _read_encoded(path, "utf-8-sig", ignore_indices)
        except UnicodeDecodeError:  # an accent in the title; Latin-1 accepts every byte
            return _read_encoded(path, "latin-1", ignore_indices)
    except (OSError, ValueError) as error:
        raise cannot_read(path, error) from error


def _read_encoded(path: str | Path, encoding: str, ignore_indices: bool) -> Configuration:
    with Path(path).open(encoding=encoding) as file:
        return _ConfigReader(file, str(path), ignore_indices).read()


def parse_config(text: str, path: str = "CONFIG", ignore_indices: bool = False) -> Configuration:
    """Read the text of a CONFIG file; arguments and errors as in ``read_config``."""
    lines = plain_line_ends(text).split("\n")
    if lines[-1] == "":
        lines.pop()
    return _ConfigReader(lines, path, ignore_indices).read()


class _ConfigReader:
    """Reads one file front to back, in chunks of beads."""

    def __init__(self, lines: Iterable[str], path: str, ignore_indices: bool) -> None:
        self.lines: Iterator[str] = iter(lines)
        self.path, self.ignore_indices = path, ignore_indices
        self.line = 0  # number of the line read last
        self.warnings: list[str] = []
        self.names: list[str] = []
        self.full_names: dict[str, str] = {}
        self.indices: list[IntArray] = []  # one array a chunk
        self.level = 0
        self.first_line = 0

    def read(self) -> Configuration:
        title = next(self.lines, "")[:_TITLE_LENGTH].rstrip()
        header = self._header(title)
        self.level, imcon = self._level_and_imcon(header)
        cell = self._cell(imcon)
        self.first_line = self.line + 1
        vectors = self._beads()
        order = self._order()
        if order is not None:
            vectors = [v[order] for v in vectors]
            self.names = [self.names[i] for i in order]
        step, timestep, time = self._run_numbers(header)
        return Configuration(
            names=tuple(self.names),
            positions=vectors[0],
            title=title,
            imcon=imcon,
            cell=cell,
            velocities=vectors[1] if self.level > 0 else None,
            forces=vectors[2] if self.level > 1 else None,
            step=step,
            timestep=timestep,
            time=time,
            path=self.path,
            warnings=tuple(self.warnings),
        )

    def _fail(self, message: str, line: int | None = None, word: str | None = None) -> NoReturn:
        raise InputError(message, path=self.path, line=line, word=word)

    def _warn(self, message: str, line: int) -> None:
        self.warnings.append(f"{self.path}:{line}: {message}")

    def _next(self, expected: str) -> list[str]:
        text = next(self.lines, None)
        if text is None:
            self._fail(f"the file ends here; expected {expected}", max(self.line, 1))
        self.line += 1
        return text.split()

    def _peek(self, count: int) -> list[list[str]]:
        ahead = list(islice(self.lines, count))
        self.lines = chain(ahead, self.lines)
        return [text.split() for text in ahead]

    # --- the head of the file -----------------------------------------------------------------------------------------

    def _header(self, title: str) -> list[str]:
        """Return the words of line 2 after making sure that this is a CONFIG at all."""
        self.line = 1
        second, third = [*self._peek(2), [], []][:2]
        for number, words in ((2, second), (3, third)):
            if len(words) > 3 and words[0].lower() == "timestep":
                shown = " ".join(words)[:60]
                self._fail(f"not a DL_POLY CONFIG: line {number} is {shown!r}, as in a HISTORY trajectory", number)
        if not title and not second and not third:
            self._fail("not a DL_POLY CONFIG: the file is empty")
        if len(second) < 2 or any(_whole(word) is None for word in second[:2]):
            self._fail_header(title, second)
        self.line = 2
        next(self.lines)
        return second

    def _fail_header(self, title: str, second: list[str]) -> NoReturn:
        expected = "expected a title, then a line with levcfg and imcon (two whole numbers)"
        first = title.split()
        if len(first) in (2, 3) and all(_whole(word) is not None for word in first):
            self._fail(f"line 1 must be a title, but looks like levcfg and imcon; {expected}", 1)
        shown = " ".join(second)[:60]
        self._fail(f"not a DL_POLY CONFIG: line 2 is {shown!r}; {expected}", 2)

    def _level_and_imcon(self, header: list[str]) -> tuple[int, int]:
        level, imcon = int(header[0]), int(header[1])
        if level not in (0, 1, 2):
            self._fail("levcfg must be 0 (positions), 1 (and velocities) or 2 (and forces)", 2, header[0])
        if imcon in _OLD_CELLS:
            known = "expected 0, 1, 2, 3 or 6"
            self._fail(f"imcon {imcon} ({_OLD_CELLS[imcon]}) is not supported by DL_POLY 4 and later; {known}", 2)
        if imcon not in (0, 1, 2, 3, 6):
            known = "0 (none), 1 (cubic), 2 (orthorhombic), 3 (parallelepiped) or 6 (slab)"
            self._fail(f"imcon must be {known}", 2, header[1])
        return level, imcon

    def _cell(self, imcon: int) -> FloatArray:
        if imcon == 0:
            ahead = self._peek(4)
            # Some programs write a cell although nothing is periodic. Three vectors in a row cannot be beads; the
            # fourth line tells a cell from beads whose names are numbers.
            is_cell = len(ahead) == 4 and all(_is_vector(row) for row in ahead[:3]) and not _is_vector(ahead[3])
            if not is_cell:
                return np.zeros((3, 3))
            self._warn("imcon is 0, but the file has a cell; it is read and not used for periodicity", 3)
        rows = []
        for name in "abc":
            what = f"cell vector {name} (imcon {imcon})"
            words = self._next(what)
            rows.append(self._vector(words, what, self.line))
        return np.array(rows)

    def _run_numbers(self, header: list[str]) -> tuple[int, float, float]:
        """Check the bead count of line 2 and return step, timestep and time when the line carries them."""
        beads = len(self.names)
        if len(header) > 2:
            said = parse_number(header[2])
            if said is not None and said != beads:
                self._warn(f"line 2 says {header[2]} where the number of beads may stand; the file has {beads}", 2)
        if len(header) < 6:
            return 0, 0.0, 0.0
        step, timestep, time = parse_integer(header[3]), parse_number(header[4]), parse_number(header[5])
        if step is None or timestep is None or time is None or not self._is_run(step, timestep, time):
            self._warn("the last three numbers of line 2 are not step, timestep and time; they are not used", 2)
            return 0, 0.0, 0.0
        return step, timestep, time

    def _is_run(self, step: int, timestep: float, time: float) -> bool:
        """DL_POLY's minimiser writes its cycles and two energies instead (CFGMIN), always at level 0."""
        if step < 0 or timestep < 0.0:
            return False
        return self.level > 0 or abs(time - step * timestep) <= 1e-3 * abs(time)

    # --- the beads ----------------------------------------------------------------------------------------------------

    def _beads(self) -> list[FloatArray]:
        records = 2 + self.level
        parts: list[list[FloatArray]] = []
        while texts := list(islice(self.lines, _CHUNK * records)):
            start = self.line + 1
            self.line += len(texts)
            plain = self._plain_chunk(texts, start, records)
            if plain is not None:
                parts.append(plain)
                continue
            rows = [text.split() for text in texts]
            at_end = not all(rows)
            if at_end:
                rows = self._before_blank_end(rows, start)
            whole = len(rows) - len(rows) % records
            parts.append(self._chunk(rows[:whole], start, records))
            if len(rows) > whole:
                self._fail_cut_short(rows[whole:], start + len(rows) - 1)
            if at_end:
                break
        if not self.names:
            self._fail("the file ends here; expected the first bead's name", max(self.line, 1))
        return [np.concatenate([part[kind] for part in parts]) for kind in range(self.level + 1)]

    def _before_blank_end(self, rows: list[list[str]], start: int) -> list[list[str]]:
        """Return the rows before the first blank one, after which nothing but blank lines may follow."""
        blank = rows.index([])
        if any(rows[blank:]) or any(text.split() for text in self.lines):
            bead = len(self.names) + blank // (2 + self.level) + 1
            self._fail(f"blank line among the beads (bead {bead}); expected a name or three numbers", start + blank)
        return rows[:blank]

    def _fail_cut_short(self, rows: list[list[str]], last: int) -> NoReturn:
        missing = _KINDS[len(rows) - 1]
        bead = f"bead {len(self.names) + 1} ({rows[0][0]})"
        self._fail(f"the file ends inside {bead}; expected its {missing} ({self._lines_told()})", last)

    def _lines_told(self) -> str:
        return f"levcfg {self.level} means {2 + self.level} lines a bead"

    def _chunk(self, rows: list[list[str]], start: int, records: int) -> list[FloatArray]:
        """Take the names and indices of whole beads and return their vectors, one array a kind."""
        name_rows = rows[::records]
        vectors: list[FloatArray] = []
        careful = any(row[0][0] in "+-.0123456789" and _is_vector(row) for row in name_rows)
        for kind in range(1, records):
            array = None if careful else _fast_vectors(rows[kind::records])
            if array is None:
                vectors = self._careful_chunk(rows, start, records)
                break
            vectors.append(array)
        self._take_names([row[0] for row in name_rows], start, records)
        self.indices.append(np.array([_index(row) for row in name_rows], dtype=np.int64))
        return vectors

    def _plain_chunk(self, texts: list[str], start: int, records: int) -> list[FloatArray] | None:
        """As ``_chunk`` at the speed of large files; None, with nothing taken, where anything needs a careful look."""
        heads = plain_heads(texts[::records])
        if len(texts) % records or heads is None:
            return None
        vectors = [plain_vectors(texts[kind::records]) for kind in range(1, records)]
        whole = [v for v in vectors if v is not None]
        if len(whole) < len(vectors):
            return None
        names, *columns = heads
        if columns and not (all(map(str.isdecimal, columns[0])) and max(map(len, columns[0])) < 19):
            return None
        if len(columns) > 1 and any(name[0] in "+-.0123456789" for name in names):
            return None  # three numbers in place of a name
        self._take_names(names, start, records)
        indices = np.fromiter(map(int, columns[0]), np.int64, len(names)) if columns else np.zeros(len(names), np.int64)
        self.indices.append(indices)
        return whole

    def _careful_chunk(self, rows: list[list[str]], start: int, records: int) -> list[FloatArray]:
        """Read bead by bead, for numbers that only Fortran understands and for the place of an error."""
        array = np.empty((len(rows) // records, records - 1, 3))
        for bead in range(len(array)):
            at = bead * records
            name = rows[at][0]
            label = f"bead {len(self.names) + bead + 1}"
            if _is_vector(rows[at]) and not name.isdecimal():
                self._fail(
                    f"expected the name of {label}, found three numbers ({self._lines_told()})", start + at, name
                )
            for kind in range(1, records):
                what = f"{_KINDS[kind - 1]} of {label} ({name})"
                array[bead, kind - 1] = self._vector(rows[at + kind], what, start + at + kind)
        return [np.ascontiguousarray(array[:, kind]) for kind in range(records - 1)]

    def _vector(self, words: Sequence[str], what: str, line: int) -> tuple[float, float, float]:
        values = []
        for axis, word in zip("xyz", words, strict=False):
            value = parse_number(word)
            if value is None:
                told = "" if looks_like_number(word) or "bead" not in what else f" ({self._lines_told()})"
                self._fail(f"expected {axis} of the {what}, a finite number{told}", line, word)
            values.append(value)
        if len(values) < 3:
            self._fail(f"expected three numbers, the {what}; found {len(values)}", line)
        return values[0], values[1], values[2]

    def _take_names(self, names: list[str], start: int, records: int) -> None:
        full_names = self.full_names
        for name in dict.fromkeys(names):
            short = name[:WORD_LIMIT]
            if full_names.setdefault(short, name) != name:
                line = start + names.index(name) * records
                told = f"only {WORD_LIMIT} characters of a name count"
                self._fail(f"{told}, and {full_names[short]!r} has the same ones", line, name)
            if short != name and short not in self.names:
                self._warn(f"name {name!r} is cut to {short!r}", start + names.index(name) * records)
        shared = {full: short for short, full in full_names.items()}  # one string object a species, not one a bead
        self.names.extend(shared[name] for name in names)

    def _order(self) -> IntArray | None:
        """Return the order that sorts the beads by index, or None when they stand in it already."""
        if self.ignore_indices:
            return None
        indices: IntArray = np.concatenate(self.indices)
        places: IntArray = np.arange(1, len(indices) + 1, dtype=np.int64)
        unreadable = np.flatnonzero(indices == _NOT_AN_INDEX)
        if len(unreadable):
            told = f"the second word of {len(unreadable)} name lines is not an index"
            self._warn(f"{told}; these beads keep their place in the file", self._name_line(unreadable[0]))
        indices = np.where(indices <= 0, places, indices)
        if np.array_equal(indices, places):
            return None
        order: IntArray = np.argsort(indices, kind="stable")
        if not np.array_equal(indices[order], places):
            self._fail_indices(indices, order)
        return order

    def _fail_indices(self, indices: IntArray, order: IntArray) -> NoReturn:
        beads = len(indices)
        cure = f"expected 1 to {beads} once each (or ignore the indices, which takes the order of the file)"
        ranked = indices[order]
        twice = np.flatnonzero(ranked[1:] == ranked[:-1])
        if len(twice):
            first, second = order[twice[0]], order[twice[0] + 1]
            told = f"bead index {ranked[twice[0]]} is also on line {self._name_line(first)}"
            self._fail(f"{told}; {cure}", self._name_line(second))
        outside = order[np.flatnonzero(ranked > beads)[0]]
        self._fail(f"this bead index is larger than the number of beads; {cure}", self._name_line(outside))

    def _name_line(self, bead: int | np.int64) -> int:
        return self.first_line + int(bead) * (2 + self.level)


def _whole(word: str) -> int | None:
    return int(word) if _INDEX.fullmatch(word) and len(word) < 19 else None


def _index(row: Sequence[str]) -> int:
    """Return the index on a name line: its absolute value, 0 when there is none, or the mark of a word that is none."""
    if len(row) < 2:
        return 0
    if not _INDEX.fullmatch(row[1]):
        return _NOT_AN_INDEX
    return min(abs(int(row[1][:20])), 2**62)


def _is_vector(row: Sequence[str]) -> bool:
    return len(row) >= 3 and all(parse_number(word) is not None for word in row[:3])


def _fast_vectors(rows: _Rows) -> FloatArray | None:
    """Return (n, 3) numbers, or None when any line needs a careful look."""
    lengths = set(map(len, rows))
    if lengths and min(lengths) < 3:
        return None
    if lengths != {3}:
        rows = [row[:3] for row in rows]
    words = list(chain.from_iterable(rows))
    joined = "".join(words)
    if "_" in joined or not joined.isascii():  # float() would take 1_0 and digits of other scripts
        return None
    try:
        values = np.fromiter(map(float, words), dtype=np.float64, count=len(words))
    except ValueError:
        return None
    return values.reshape(-1, 3) if bool(np.isfinite(values).all()) else None
