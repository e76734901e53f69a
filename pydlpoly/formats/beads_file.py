"""BEADS and REVBEADS: what beads carry beside position and velocity, as plain columns. DL_POLY does not read them.

line 1        title
line 2        number of beads, names of the columns: temperature, concentration_<species>
line 3 …      index of the bead, one number a column

Numbers have 17 significant digits, so that they are read as they were.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import NoReturn

import numpy as np

from pydlpoly.errors import InputError
from pydlpoly.formats.atomic import PathLike, atomic_file
from pydlpoly.formats.lexing import cannot_read, parse_number, plain_line_ends
from pydlpoly.formats.records import BeadTable, FloatArray, IntArray

_CHUNK = 20_000  # beads whose text is held at the same time
_TITLE_LENGTH = 72
_MOST_BEADS = 2**31 - 1


def read_beads(path: str | Path) -> BeadTable:
    """Read a BEADS file.

    Beads may come in any order; the table has them in the order of their indices.

    Raises:
        InputError: the file is missing, is no BEADS file, is cut short, or its indices are not 1 to N once each.
    """
    try:
        try:
            with Path(path).open(encoding="utf-8-sig") as file:
                return _BeadsReader(file, str(path)).read()
        except UnicodeDecodeError:  # an accent in the title
            with Path(path).open(encoding="latin-1") as file:
                return _BeadsReader(file, str(path)).read()
    except (OSError, ValueError) as error:
        raise cannot_read(path, error) from error


def parse_beads(text: str, path: str = "BEADS") -> BeadTable:
    """Read the text of a BEADS file; errors as in ``read_beads``."""
    return _BeadsReader(plain_line_ends(text).splitlines(), path).read()


def write_beads(path: PathLike, title: str, names: Sequence[str], columns: Sequence[FloatArray]) -> None:
    """Replace a BEADS file in one instant.

    Args:
        path: the file.
        title: 72 characters are kept.
        names: of the columns; no blanks.
        columns: (N,) each, finite.

    Raises:
        ValueError: names and columns do not belong together, or a number is not finite.
        RunError: the file cannot be written.
    """
    arrays = [np.asarray(column, dtype=np.float64) for column in columns]
    if not arrays or len(arrays) != len(names) or any(array.shape != arrays[0].shape for array in arrays):
        raise ValueError("expected one column of equal length for each name")
    if any(name.split() != [name] for name in names) or not all(np.isfinite(array).all() for array in arrays):
        raise ValueError("names must be words and numbers finite")
    count = len(arrays[0])
    line = "%d" + " %.16E" * len(arrays) + "\n"
    with atomic_file(path) as file:
        file.write(f"{' '.join(title.split())[:_TITLE_LENGTH]}\n{count} {' '.join(names)}\n".encode())
        for start in range(0, count, _CHUNK):
            end = min(start + _CHUNK, count)
            table = np.column_stack([np.arange(start + 1, end + 1), *(array[start:end] for array in arrays)])
            file.write((line * (end - start) % tuple(table.ravel().tolist())).encode("ascii"))


class _BeadsReader:
    """Reads one file front to back, in chunks of beads."""

    def __init__(self, lines: Iterable[str], path: str) -> None:
        self.lines: Iterator[str] = iter(lines)
        self.path = path

    def read(self) -> BeadTable:
        title = next(self.lines, "")[:_TITLE_LENGTH].strip()
        count, names = self._header()
        chunks: list[FloatArray] = []
        done = 0
        while texts := list(islice(self.lines, _CHUNK)):
            texts = self._without_blank_end(texts, done + 3)
            if done + len(texts) > count:
                self._fail(f"line 2 says {count} beads, but there are more lines", count + 3)
            chunks.append(self._chunk(texts, len(names), done + 3))
            done += len(texts)
        if done < count:
            self._fail(f"the file ends after {done} of the {count} beads that line 2 says", done + 2)
        indices = np.concatenate([chunk[:, 0] for chunk in chunks]).astype(np.int64)
        values: FloatArray = np.concatenate([chunk[:, 1:] for chunk in chunks])
        order = self._order(indices)
        if order is not None:
            values = values[order]
        return BeadTable(names, values, title, order, self.path, first_line=3)

    def _fail(self, message: str, line: int, word: str | None = None) -> NoReturn:
        raise InputError(message, path=self.path, line=line, word=word)

    def _header(self) -> tuple[int, tuple[str, ...]]:
        words = next(self.lines, "").split()
        expected = "expected the number of beads and the names of the columns"
        if not words or not words[0].isdecimal() or len(words[0]) > 10 or not 1 <= int(words[0]) <= _MOST_BEADS:
            self._fail(f"not a BEADS file: {expected}", 2, " ".join(words)[:60])
        names = tuple(words[1:])
        if not names:
            self._fail(f"there is no column; {expected}", 2, words[0])
        for name in names:
            if names.count(name) > 1:
                self._fail("this column is given twice", 2, name)
            if parse_number(name) is not None:
                self._fail(f"a number is no name of a column; {expected}", 2, name)
        return int(words[0]), names

    def _without_blank_end(self, texts: list[str], first: int) -> list[str]:
        """Return the lines before the first blank one, after which nothing but blank lines may follow."""
        blank = next((k for k, text in enumerate(texts) if not text.strip()), None)
        if blank is None:
            return texts
        if any(text.strip() for text in texts[blank:]) or any(text.strip() for text in self.lines):
            self._fail("blank line among the beads", first + blank)
        return texts[:blank]

    def _chunk(self, texts: list[str], columns: int, first: int) -> FloatArray:
        """Return (lines, 1 + columns) numbers, the indices in front."""
        if not texts:
            return np.empty((0, 1 + columns))
        try:
            table = np.loadtxt(texts, dtype=np.float64, comments=None, ndmin=2)
        except ValueError:
            table = np.empty((0, 0))
        shape = (len(texts), 1 + columns)
        plain = table.shape == shape and bool(np.isfinite(table).all())
        if not plain or not np.array_equal(table[:, 0], np.rint(table[:, 0])):
            table = np.array([self._line(text, columns, first + k) for k, text in enumerate(texts)])
        return table

    def _line(self, text: str, columns: int, line: int) -> list[float]:
        """Read one line with Fortran's numbers, or say what is wrong with it."""
        words = text.split()
        if len(words) != 1 + columns:
            told = f"a bead's index and {columns} number{'s' * (columns > 1)}"
            self._fail(f"expected {told}, found {len(words)} words", line)
        if not words[0].isdecimal() or len(words[0]) > 10:
            self._fail("expected a bead's index", line, words[0])
        numbers = [parse_number(word) for word in words[1:]]
        for word, number in zip(words[1:], numbers, strict=True):
            if number is None:
                self._fail("expected a finite number", line, word)
        return [float(words[0]), *(number for number in numbers if number is not None)]

    def _order(self, indices: IntArray) -> IntArray | None:
        """Return the order that sorts the beads by index, or None when they stand in it already."""
        count = len(indices)
        expected = f"expected 1 to {count} once each"
        outside = np.flatnonzero((indices < 1) | (indices > count))
        if len(outside):
            self._fail(f"no bead has this index; {expected}", 3 + int(outside[0]), str(indices[outside[0]]))
        if np.array_equal(indices, np.arange(1, count + 1)):
            return None
        order: IntArray = np.argsort(indices, kind="stable")
        ranked = indices[order]
        twice = np.flatnonzero(ranked[1:] == ranked[:-1])
        if len(twice):
            first, second = (3 + int(order[twice[0] + k]) for k in (0, 1))
            self._fail(f"this bead is also on line {first}; {expected}", second, str(ranked[twice[0]]))
        return order
