"""Reading HISTORY back, frame by frame: DL_POLY 5, 4 and Classic, and what other programs write under that name."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import IO, NamedTuple

import numpy as np

from pydlpoly.errors import InputError, InputWarning
from pydlpoly.formats.atomic import PathLike
from pydlpoly.formats.fortran import parse_real, parse_reals
from pydlpoly.formats.records import FloatArray, IntArray

_RECORD = 72  # characters of DL_POLY's records


@dataclass(frozen=True)
class HistoryHeader:
    """The two header records of a HISTORY file.

    Attributes:
        level, imcon: as the file's second line has them; each frame repeats them, and the frame's count.
        beads, frames, records: 0 where the file does not say.
    """

    title: str
    level: int
    imcon: int
    beads: int = 0
    frames: int = 0
    records: int = 0


@dataclass(frozen=True, eq=False)
class Frame:
    """One configuration of a trajectory, beads in the order of their indices.

    Attributes:
        step: number of the step; time, timestep: in ps, None where the file does not give them.
        level, imcon: of this frame.
        cell: (3, 3) one cell vector a row in Å; zeros where the frame has none.
        names: species names; indices: (N,) as in the file, 1 … N where it has none.
        masses: (N,) in Da; charges: (N,) in e; displacements: (N,) in Å. NaN where the file does not give them.
        positions: (N, 3) in Å; velocities: (N, 3) in Å/ps or None; forces: (N, 3) in Da Å/ps² or None.
    """

    step: int
    time: float | None
    timestep: float | None
    level: int
    imcon: int
    cell: FloatArray
    names: tuple[str, ...]
    indices: IntArray
    masses: FloatArray
    charges: FloatArray
    displacements: FloatArray
    positions: FloatArray
    velocities: FloatArray | None = None
    forces: FloatArray | None = None


def read_history_header(path: PathLike) -> HistoryHeader:
    """Read the first two lines of a HISTORY file.

    Raises:
        InputError: the file is missing or not a HISTORY file.
    """
    with _open(path) as handle:
        return _header(_Lines(handle, os.fspath(path)))


def read_history(path: PathLike) -> Iterator[Frame]:
    """Read a formatted HISTORY file frame by frame.

    Second lines of 3, 4 or 5 fields and bead lines of 2 to 5 fields are understood; frames are told apart by their
    ``timestep`` lines alone, whose level and imcon win over the second line's; a cell is read where one stands, also
    with imcon 0; beads are put into the order of their indices where these are 1 … N. A frame that a kill cut short, at
    the end or, after a restart, in the middle, is left out with an ``InputWarning``.

    Raises:
        InputError: the file is missing, is not a HISTORY file, or holds words where numbers should be.
    """
    name = os.fspath(path)
    with _open(path) as handle:
        lines = _Lines(handle, name)
        header = _header(lines)
        while (line := lines.next()) is not None:
            if not line.strip():
                continue
            if not line.startswith("timestep"):
                raise InputError("expected 'timestep'", path=name, line=lines.number, word=line.strip()[:20])
            frame = _frame(lines, line, header)
            if frame is None:
                warnings.warn(InputWarning(f"{name}:{lines.number}: a frame is cut short and left out"), stacklevel=2)
            else:
                yield frame


class _Lines:
    """Lines of a file with their numbers, and room to give some back."""

    def __init__(self, handle: IO[str], path: str) -> None:
        self.path, self.number = path, 0
        self._handle = handle
        self._returned: list[str] = []

    def next(self) -> str | None:
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
        self._returned = lines + self._returned
        self.number -= len(lines)


def _open(path: PathLike) -> IO[str]:
    try:
        return Path(path).open(encoding="latin-1", newline=None)  # only names and the title can hold other letters
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}", path=os.fspath(path)) from error


def _header(lines: _Lines) -> HistoryHeader:
    title, second = lines.next(), lines.next()
    words = (second or "").split()
    try:
        numbers = [int(word) for word in words[:5]]
    except ValueError:
        numbers = []
    if title is None or len(numbers) < 2 or not 0 <= numbers[0] <= 2:
        message = "is not a formatted HISTORY file: expected level (0, 1 or 2), imcon and number of beads"
        raise InputError(message, path=lines.path, line=2, word=" ".join(words[:3]))
    return HistoryHeader(title.strip(), *numbers)


def _frame(lines: _Lines, first: str, header: HistoryHeader) -> Frame | None:
    """The frame that begins with this ``timestep`` line, or None when it is cut short."""
    start = lines.number
    words = first[8:].split()
    try:
        whole = [int(word) for word in words[:4]]
        reals = [parse_real(word) for word in words[4:6]]
    except ValueError:
        whole, reals = [], []
    if len(whole) < 2:
        if not first.endswith("\n"):
            return None
        message = "expected step, number of beads, level, imcon, timestep and time"
        raise InputError(message, path=lines.path, line=start, word=first.strip())
    step, beads = whole[0], whole[1]
    level, imcon = (whole[2], whole[3]) if len(whole) == 4 else (header.level, header.imcon)
    if not 0 <= level <= 2 or beads < 1:
        raise InputError("expected at least one bead and level 0, 1 or 2", path=lines.path, line=start)
    cell = _cell(lines, imcon)
    block = lines.block(beads * (2 + level)) if cell is not None else []
    torn = next((i for i, line in enumerate(block) if line.startswith("timestep")), None)
    if torn is not None:
        lines.give_back(block[torn:])
        return None
    if cell is None or len(block) < beads * (2 + level) or _cut_short(block, first):
        return None
    timestep, time = [*reals, None, None][:2]
    return Frame(step, time, timestep, level, imcon, cell, *_beads(block, level, lines))


def _cut_short(block: list[str], first: str) -> bool:
    """Whether the last line may have lost digits: no line feed, and shorter than records of fixed length are."""
    last = block[-1]
    if last.endswith("\n"):
        return False
    fixed = len(first.rstrip("\n")) == _RECORD
    return len(last.split()) < 3 or (fixed and len(last) < _RECORD)


def _cell(lines: _Lines, imcon: int) -> FloatArray | None:
    """The cell vectors where they stand next, zeros where there are none, None when they are cut short."""
    block = lines.block(3)
    rows = [_three_numbers(line) for line in block]
    if len(rows) == 3 and all(row is not None for row in rows):
        return np.array(rows, dtype=np.float64)
    torn = next((i for i, line in enumerate(block) if line.startswith("timestep")), None)
    if len(block) < 3 or torn is not None:
        lines.give_back(block[torn:] if torn is not None else [])
        return None
    if imcon != 0 or rows[0] is not None:
        message = "expected three cell vectors of three numbers each"
        raise InputError(message, path=lines.path, line=lines.number - 2, word=block[0].strip())
    lines.give_back(block)
    return np.zeros((3, 3))


def _three_numbers(line: str) -> FloatArray | None:
    words = line.split()
    if len(words) != 3:
        return None
    try:
        return parse_reals(words)
    except ValueError:
        return None


class _Beads(NamedTuple):
    names: tuple[str, ...]
    indices: IntArray
    masses: FloatArray
    charges: FloatArray
    displacements: FloatArray
    positions: FloatArray
    velocities: FloatArray | None = None
    forces: FloatArray | None = None


def _beads(block: list[str], level: int, lines: _Lines) -> _Beads:
    """The arrays of a frame from its bead lines, in the order of the indices."""
    stride = 2 + level
    first_line = lines.number - len(block) + 1
    heads = [_bead_words(line) for line in block[::stride]]
    vectors = [_vectors(block, place, stride, lines.path, first_line) for place in range(1, stride)]
    names = [words[0] if words else "" for words in heads]
    indices = _indices(heads, lines.path, first_line, stride)
    order = np.argsort(indices, kind="stable")
    if np.array_equal(indices[order], np.arange(1, len(indices) + 1)):
        names = [names[i] for i in order]
        indices, vectors = indices[order], [vector[order] for vector in vectors]
    else:
        order = np.arange(len(indices))
    extra = [_column(heads, place, lines.path, first_line, stride)[order] for place in (2, 3, 4)]
    return _Beads(tuple(names), indices, extra[0], extra[1], extra[2], *vectors)


def _bead_words(line: str) -> list[str]:
    """Name, index, mass, charge and displacement as words; a name of eight letters may touch a long index."""
    words = line.split()
    if words and len(words[0]) > 8:
        words = [line[:8].strip(), *line[8:].split()]
    return words


def _vectors(block: list[str], place: int, stride: int, path: str, first_line: int) -> FloatArray:
    rows = block[place::stride]
    try:
        return parse_reals(" ".join(rows).split()).reshape(len(rows), 3)
    except ValueError:
        pass
    for index, row in enumerate(rows):
        if _three_numbers(row) is None:
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
        index = next(i for i, word in enumerate(words) if not _is_real(word))
        line = first_line + index * stride
        raise InputError("expected a number", path=path, line=line, word=words[index]) from None


def _is_real(word: str) -> bool:
    try:
        parse_real(word)
    except ValueError:
        return False
    return True
