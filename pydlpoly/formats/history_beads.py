"""The bead lines of HISTORY: names, indices and numbers, quickly where they are plain, and with care where not."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from dataclasses import fields
from itertools import islice
from typing import Any

import numpy as np

from pydlpoly.errors import InputError, InputWarning
from pydlpoly.formats.fortran import is_real, parse_reals
from pydlpoly.formats.frame import Beads
from pydlpoly.formats.plain_lines import plain_heads, plain_vectors
from pydlpoly.formats.records import FloatArray, IntArray

_NAME = 8  # characters of a name
_CHUNK = 2_000  # beads whose lines are held at the same time


class Lines:
    """Lines of a file with their numbers, and room to give some back."""

    def __init__(self, handle: Iterable[str], path: str) -> None:
        self.path, self.number = path, 0
        self._handle = iter(handle)
        self._returned: list[str] = []
        self._warned: set[str] = set()

    def next(self) -> str | None:
        """Return the next line, None at the end."""
        block = self.block(1)
        return block[0] if block else None

    def block(self, count: int) -> list[str]:
        """The next ``count`` lines with their ends, fewer at the end of the file."""
        taken, self._returned = self._returned[:count], self._returned[count:]
        if len(taken) < count:
            taken += islice(self._handle, count - len(taken))
        self.number += len(taken)
        return taken

    def give_back(self, lines: list[str]) -> None:
        """Have these lines, the last that were taken, come next."""
        self._returned = lines + self._returned
        self.number -= len(lines)

    def warn(self, message: str, value: int) -> None:
        """Say something about the file at the present line, once."""
        if message not in self._warned:
            self._warned.add(message)
            warnings.warn(InputWarning(f"{self.path}:{self.number}: {message.format(value)}"), stacklevel=5)


def plain_beads(lines: Lines, count: int, level: int) -> tuple[list[Beads], int]:
    """Read beads in chunks as long as their lines are plain; return them and how many are left to ``careful_beads``."""
    parts: list[Beads] = []
    stride = 2 + level
    left = count
    while left:
        block = lines.block(min(left, _CHUNK) * stride)
        part = _plain_part(block, level) if len(block) == min(left, _CHUNK) * stride else None
        if part is None:
            lines.give_back(block)
            break
        parts.append(part)
        left -= len(part.names)
    return parts, left


def _plain_part(block: list[str], level: int) -> Beads | None:
    stride = 2 + level
    heads = plain_heads(block[::stride])
    if heads is None or len(heads) < 2 or not block[-1].endswith("\n"):
        return None
    names, numbers, *columns = heads
    if max(map(len, names)) > _NAME or not all(map(str.isdecimal, numbers)):
        return None
    vectors = [plain_vectors(block[place::stride]) for place in range(1, stride)]
    whole = [v for v in vectors if v is not None]
    if len(whole) < len(vectors):
        return None
    try:
        extra = [np.array(column, dtype=np.float64) for column in columns[:3]]
    except ValueError:
        return None
    extra += [np.full(len(names), np.nan)] * (3 - len(extra))
    indices = np.fromiter(map(int, numbers), np.int64, len(names))
    return Beads(tuple(names), indices, *extra, *whole)


def careful_beads(block: list[str], level: int, lines: Lines) -> Beads:
    """Read the last lines that were taken, for numbers that only Fortran understands and for the place of an error."""
    stride = 2 + level
    first_line = lines.number - len(block) + 1
    heads = [_bead_words(line) for line in block[::stride]]
    vectors = [_vectors(block, place, stride, lines.path, first_line) for place in range(1, stride)]
    names = tuple(words[0] if words else "" for words in heads)
    indices = _indices(heads, lines.path, first_line, stride)
    extra = [_column(heads, place, lines.path, first_line, stride) for place in (2, 3, 4)]
    return Beads(names, indices, *extra, *vectors)


def join_beads(parts: list[Beads]) -> Beads:
    """Return one set of arrays, in the order of the indices where these are 1 … N."""
    known: dict[str, str] = {}  # one string object a species, not one a bead
    names = [known.setdefault(name, name) for part in parts for name in part.names]
    indices = np.concatenate([part.indices for part in parts])
    rest = [column.name for column in fields(Beads)[2:]]
    columns: list[list[Any]] = [[getattr(part, name) for part in parts] for name in rest]
    parts.clear()
    arrays: list[FloatArray | None] = []
    for column in columns:
        arrays.append(None if column[0] is None else np.concatenate(column))
        column.clear()  # so that no more than one column is there twice
    places = np.arange(1, len(indices) + 1)
    if not np.array_equal(indices, places):
        order = np.argsort(indices, kind="stable")
        if np.array_equal(indices[order], places):
            names = [names[i] for i in order]
            indices = places
            arrays = [None if array is None else array[order] for array in arrays]
    return Beads(tuple(names), indices, *arrays)  # type: ignore[arg-type]  # only the last two may be missing


def _bead_words(line: str) -> list[str]:
    """Name, index, mass, charge and displacement as words; a name of eight letters may touch a long index."""
    words = line.split()
    if words and len(words[0]) > _NAME:
        words = [line[:_NAME].strip(), *line[_NAME:].split()]
    return words


def _vectors(block: list[str], place: int, stride: int, path: str, first_line: int) -> FloatArray:
    rows = block[place::stride]
    try:
        return parse_reals(" ".join(rows).split()).reshape(len(rows), 3)
    except ValueError:
        pass
    for index, row in enumerate(rows):
        if three_numbers(row) is None:
            line = first_line + place + index * stride
            raise InputError("expected three numbers", path=path, line=line, word=row.strip())
    raise InputError("expected three numbers a line", path=path, line=first_line + place)


def _indices(heads: list[list[str]], path: str, first_line: int, stride: int) -> IntArray:
    numbers = []
    for index, words in enumerate(heads):
        if not words or (len(words) > 1 and not words[1].lstrip("-").isdigit()):
            place = first_line + index * stride
            raise InputError("expected name, index, mass and charge", path=path, line=place, word=" ".join(words))
        numbers.append(int(words[1]) if len(words) > 1 else index + 1)
    return np.array(numbers, dtype=np.int64)


def _column(heads: list[list[str]], place: int, path: str, first_line: int, stride: int) -> FloatArray:
    """One number of every bead line, NaN where the line does not have it."""
    words = [head[place] if len(head) > place else "nan" for head in heads]
    try:
        return parse_reals(words)
    except ValueError:
        index = next(i for i, word in enumerate(words) if not is_real(word))
        line = first_line + index * stride
        raise InputError("expected a number", path=path, line=line, word=words[index]) from None


def three_numbers(line: str) -> FloatArray | None:
    """Return the three numbers of a line, or None when it is anything else."""
    words = line.split()
    if len(words) != 3:
        return None
    try:
        return parse_reals(words)
    except ValueError:
        return None
