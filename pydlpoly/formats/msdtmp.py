"""MSDTMP: displacement and temperature of every bead, in DL_POLY's layout of 53-byte records.

record 1   title
record 2   (i10,2i21)          beads frames records
frame      (a8,2i10,2f12.6)    'timestep' step beads timestep time
bead       (a8,i10,1p,2e13.4)  name index √(r(t) − r(0))² and m v²/(3 k_B)
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import ArrayLike

from pydlpoly.errors import InputError
from pydlpoly.formats.atomic import FrameFile, PathLike, RecordWriter
from pydlpoly.formats.fortran import (
    fortran_e,
    fortran_f,
    fortran_i,
    integer_columns,
    parse_real,
    parse_reals,
    record,
    text_columns,
)
from pydlpoly.formats.records import FloatArray

RECORD_BYTES = 53


@dataclass(frozen=True, eq=False)
class DisplacementFrame:
    """One frame of MSDTMP.

    Attributes:
        step, time, timestep: of the frame; ps.
        names: species of every bead.
        displacements: (N,) distance from the start in Å; temperatures: (N,) in K.
    """

    step: int
    time: float
    timestep: float
    names: tuple[str, ...]
    displacements: FloatArray
    temperatures: FloatArray


class DisplacementWriter(RecordWriter):
    """Writes MSDTMP frame by frame; each frame is one write, then the counters of record 2 are brought up to date.

    Args:
        path: the file.
        title: the run's title (52 characters are kept).
        species: species name of every bead, at most 8 ASCII characters each.
        append: go on with an existing file; a frame that a kill cut short is dropped.
        keep_until: with ``append``, drop frames of later steps.

    Raises:
        InputError: a name is too long, or the file to be continued is of another kind.
        RunError: the file cannot be written.
    """

    def __init__(
        self, path: PathLike, title: str, species: Sequence[str], *, append: bool = False, keep_until: int | None = None
    ) -> None:
        """Open the file; see the class."""
        self._path, self._count = os.fspath(path), len(species)
        self._frame_bytes = RECORD_BYTES * (1 + self._count)
        self._beads = np.full((self._count, RECORD_BYTES), ord(" "), dtype=np.uint8)
        self._beads[:, -1] = ord("\n")
        if self._count:
            self._beads[:, :8] = text_columns(species, 8)
            self._beads[:, 8:18] = integer_columns(np.arange(1, self._count + 1), 10)
        header = record(title, RECORD_BYTES - 1) + self._counters(0)
        self._file = FrameFile(path, header, append=append, whole_length=lambda handle: self._whole(handle, keep_until))
        self._frames = (self._file.length - 2 * RECORD_BYTES) // self._frame_bytes
        if self._file.resumed:
            self._file.patch(RECORD_BYTES, self._counters(self._frames))

    def write(self, step: int, time: float, timestep: float, displacements: ArrayLike, temperatures: ArrayLike) -> None:
        """Append one frame; displacements in Å and temperatures in K are (N,)."""
        head = "timestep" + fortran_i(step, 10) + fortran_i(self._count, 10)
        head += fortran_f(timestep, 12, 6) + fortran_f(time, 12, 6)
        for start, column in ((18, displacements), (31, temperatures)):
            texts = [fortran_e(value, 13, 4) for value in np.asarray(column, dtype=np.float64).tolist()]
            if len(texts) != self._count:
                raise ValueError(f"expected {self._count} values")
            self._beads[:, start : start + 13] = text_columns(texts, 13)
        self._file.write(record(head, RECORD_BYTES - 1) + self._beads.tobytes())
        self._frames += 1
        self._file.patch(RECORD_BYTES, self._counters(self._frames))

    def _counters(self, frames: int) -> bytes:
        records = 2 + frames * (1 + self._count)
        text = fortran_i(self._count, 10) + fortran_i(frames, 21) + fortran_i(records, 21)
        return record(text, RECORD_BYTES - 1)

    def _whole(self, handle: IO[bytes], keep_until: int | None) -> int:
        """How many bytes of an existing file are whole frames of steps up to ``keep_until``."""
        header = handle.read(2 * RECORD_BYTES)
        if len(header) < 2 * RECORD_BYTES:
            return 0
        if header[RECORD_BYTES:].split()[:1] != [str(self._count).encode()]:
            raise InputError(f"cannot be continued: expected {self._count} beads", path=self._path, line=2)
        frames = (handle.seek(0, os.SEEK_END) - 2 * RECORD_BYTES) // self._frame_bytes
        while frames > 0:
            handle.seek(2 * RECORD_BYTES + (frames - 1) * self._frame_bytes)
            start = handle.read(18)
            if not start.startswith(b"timestep"):
                line = 3 + (frames - 1) * (1 + self._count)
                raise InputError("cannot be continued: expected 'timestep' here", path=self._path, line=line)
            if keep_until is None or int(start[8:]) <= keep_until:
                break
            frames -= 1
        return 2 * RECORD_BYTES + frames * self._frame_bytes


def read_displacements(path: PathLike) -> Iterator[DisplacementFrame]:
    """Read MSDTMP frame by frame; a last frame that a kill cut short is left out.

    Raises:
        InputError: the file is missing or not a MSDTMP file.
    """
    name = os.fspath(path)
    try:
        handle = Path(path).open(encoding="latin-1")  # noqa: SIM115 # closed below; only opening is judged here
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}", path=name) from error
    with handle:
        handle.readline()
        words = handle.readline().split()
        if len(words) != 3 or not all(word.isdigit() for word in words):
            message = "is not a MSDTMP file: expected numbers of beads, frames and records"
            raise InputError(message, path=name, line=2, word=" ".join(words))
        line = 2
        while head := handle.readline():
            line += 1
            frame = head.split()
            if len(frame) != 5 or frame[0] != "timestep":
                raise InputError("expected 'timestep'", path=name, line=line, word=head.strip()[:20])
            step, beads = int(frame[1]), int(frame[2])
            block = [handle.readline() for _ in range(beads)]
            if not block or not block[-1].endswith("\n"):
                return
            try:
                table = np.array([parse_reals(text[18:].split()) for text in block]).reshape(beads, 2)
            except ValueError:
                raise InputError("expected displacements and temperatures", path=name, line=line + 1) from None
            names = tuple(text[:8].strip() for text in block)
            timestep, time = parse_real(frame[3]), parse_real(frame[4])
            yield DisplacementFrame(step, time, timestep, names, table[:, 0], table[:, 1])
            line += beads
