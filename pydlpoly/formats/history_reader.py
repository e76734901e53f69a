"""Reading HISTORY back, frame by frame: DL_POLY 5, 4 and Classic, and what other programs write under that name."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import numpy as np

from pydlpoly.errors import InputError, InputWarning
from pydlpoly.formats.atomic import PathLike
from pydlpoly.formats.fortran import parse_real
from pydlpoly.formats.frame import Frame
from pydlpoly.formats.history_beads import Lines, careful_beads, join_beads, plain_beads, three_numbers
from pydlpoly.formats.history_compressed import compressed_frames
from pydlpoly.formats.records import FloatArray

__all__ = ["Frame", "HistoryHeader", "read_history", "read_history_header"]

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


def read_history_header(path: PathLike) -> HistoryHeader:
    """Read the first two lines of a HISTORY file.

    Raises:
        InputError: the file is missing or not a HISTORY file.
    """
    with _open(path) as handle:
        return _header(Lines(handle, os.fspath(path)))


def read_history(path: PathLike) -> Iterator[Frame]:
    """Read a formatted HISTORY file frame by frame.

    Second lines of 3, 4 or 5 fields and bead lines of 2 to 5 fields are understood, and the compressed form (level 3).
    Frames are told apart by their ``timestep`` lines alone, whose level and imcon win over the second line's; a cell is
    read where one stands, also with imcon 0. Where the second line says imcon 0 or a lower level and the frames look
    like it, it counts, and an ``InputWarning`` says so. Beads are put into the order of their indices where these are
    1 … N. A frame that a kill cut short, at the end or, after a restart, in the middle, is left out with an
    ``InputWarning``.

    Raises:
        InputError: the file is missing, is not a HISTORY file, or holds words where numbers should be.
    """
    with _open(path) as handle:
        yield from read_history_lines(handle, os.fspath(path))


def read_history_lines(handle: Iterable[str], name: str) -> Iterator[Frame]:
    """Read the lines of a HISTORY file, or of a part of one with its header, as ``read_history`` does."""
    lines = Lines(handle, name)
    header = _header(lines)
    if header.level == 3:
        yield from compressed_frames(lines, header.beads, header.imcon)
        return
    while (line := lines.next()) is not None:
        if not line.strip():
            continue
        if not line.startswith("timestep"):
            raise InputError("expected 'timestep'", path=name, line=lines.number, word=line.strip()[:20])
        frame = _frame(lines, line, header)
        if frame is None:
            warnings.warn(InputWarning(f"{name}:{lines.number}: a frame is cut short and left out"), stacklevel=3)
        else:
            yield frame


def _open(path: PathLike) -> IO[str]:
    try:
        return Path(path).open(encoding="latin-1", newline=None)  # only names and the title can hold other letters
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}", path=os.fspath(path)) from error


def _header(lines: Lines) -> HistoryHeader:
    title, second = lines.next(), lines.next()
    words = (second or "").split()
    try:
        numbers = [int(word) for word in words[:5]]
    except ValueError:
        numbers = []
    if title is not None and len(numbers) > 2 and numbers[0] == 3:
        return HistoryHeader(title.strip(), *numbers)  # compressed
    if title is None or len(numbers) < 2 or not 0 <= numbers[0] <= 2:
        message = "is not a formatted HISTORY file: expected level (0, 1 or 2), imcon and number of beads"
        raise InputError(message, path=lines.path, line=2, word=" ".join(words[:3]))
    return HistoryHeader(title.strip(), *numbers)


def _frame(lines: Lines, first: str, header: HistoryHeader) -> Frame | None:
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
    cell = _cell(lines, imcon if header.imcon != 0 else 0)
    if cell is None:
        return None
    if imcon != 0 and header.imcon == 0 and not cell.any():
        lines.warn("frames say imcon {}, line 2 says 0, and there is no cell: nothing is periodic", imcon)
        imcon = 0
    parts, left = plain_beads(lines, beads, level)
    if left:
        block = lines.block(left * (2 + level))
        torn = next((i for i, line in enumerate(block) if line.startswith("timestep")), None)
        if torn is not None:
            lines.give_back(block[torn:])
            del block[torn:]
        if not parts and header.level < level and _content(block) == beads * (2 + header.level):
            lines.warn("frames say level {}, but hold as many lines as line 2's " + str(header.level), level)
            level = header.level
            block = block[: beads * (2 + level)]
        elif torn is not None or len(block) < left * (2 + level):
            return None
        if _cut_short(block, first, level):
            return None
        parts.append(careful_beads(block, level, lines))
    timestep, time = [*reals, None, None][:2]
    beads_read = vars(join_beads(parts))
    return Frame(**beads_read, step=step, time=time, timestep=timestep, level=level, imcon=imcon, cell=cell)


def _content(block: list[str]) -> int:
    """Number of lines before the blank ones at the end."""
    count = len(block)
    while count and not block[count - 1].strip():
        count -= 1
    return count


def _cut_short(block: list[str], first: str, level: int) -> bool:
    """Whether the last line may have lost digits: no line feed, and no three numbers or shorter than its like."""
    last = block[-1]
    if last.endswith("\n"):
        return False
    others = {len(line.rstrip("\n")) for line in block[-(3 + level) :: -(2 + level)]}
    fixed = len(first.rstrip("\n")) == _RECORD
    shorter = len(last) < (_RECORD if fixed else min(others, default=0) if len(others) == 1 else 0)
    return three_numbers(last) is None or shorter


def _cell(lines: Lines, imcon: int) -> FloatArray | None:
    """The cell vectors where they stand next, zeros where there are none, None when they are cut short."""
    block = lines.block(3)
    rows = [three_numbers(line) for line in block]
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
