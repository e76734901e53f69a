"""HISTORY: the trajectory, in DL_POLY's formatted layout of fixed 73-byte records, levels 0, 1 and 2.

record 1   title
record 2   (3i10,2i21)           level imcon beads frames records
frame      (a8,2i10,2i2,2f20.6)  'timestep' step beads level imcon timestep time
           3 x (3f20.10)         cell vectors, always
bead       (a8,i10,3f12.6)       name index mass charge displacement
           (3g20.10)             position, velocity from level 1, force at level 2
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import IO

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pydlpoly.errors import InputError
from pydlpoly.formats.atomic import FrameFile, PathLike, RecordWriter
from pydlpoly.formats.fortran import (
    fortran_f,
    fortran_f_columns,
    fortran_g20_10,
    fortran_i,
    integer_columns,
    record,
    text_columns,
)
from pydlpoly.formats.history_reader import Frame, HistoryHeader, read_history, read_history_header

__all__ = ["Frame", "HistoryHeader", "HistoryWriter", "frame_records", "read_history", "read_history_header"]

RECORD_BYTES = 73
_LINE_FEED = ord("\n")


class HistoryWriter(RecordWriter):
    """Writes HISTORY frame by frame; each frame is one write, then the counters of record 2 are brought up to date.

    A kill between the two leaves whole frames with counters that are one behind; re-opening counts the frames anew.

    Args:
        path: the file.
        title: the run's title (72 characters are kept).
        level: 0 positions, 1 and velocities, 2 and forces.
        imcon: DL_POLY's periodicity key.
        species: species name of every bead, at most 8 ASCII characters each.
        masses: (N,) in Da; charges: (N,) in e.
        append: go on with an existing file; a frame that a kill cut short is dropped.
        keep_until: with ``append``, drop frames of later steps, so that a run that continues from a checkpoint older
            than its last frame has no step twice.

    Raises:
        InputError: a species name is too long, or the file to be continued is of another kind.
        RunError: the file cannot be written.
    """

    def __init__(
        self,
        path: PathLike,
        title: str,
        level: int,
        imcon: int,
        species: Sequence[str],
        masses: ArrayLike,
        charges: ArrayLike,
        *,
        append: bool = False,
        keep_until: int | None = None,
    ) -> None:
        """Open the file; see the class."""
        if level not in (0, 1, 2):
            raise ValueError(f"the trajectory level is 0, 1 or 2, not {level}")
        self._path, self._level, self._imcon, self._count = os.fspath(path), level, imcon, len(species)
        self._frame_bytes = RECORD_BYTES * frame_records(self._count, level)
        self._frame = self._template(species, masses, charges)
        header = record(title) + self._counters(0)
        self._file = FrameFile(path, header, append=append, whole_length=lambda handle: self._whole(handle, keep_until))
        self._frames = (self._file.length - 2 * RECORD_BYTES) // self._frame_bytes
        if self._file.resumed:
            self._file.patch(RECORD_BYTES, self._counters(self._frames))

    @property
    def frames(self) -> int:
        """Number of frames in the file."""
        return self._frames

    def write(
        self,
        step: int,
        time: float,
        timestep: float,
        cell: ArrayLike,
        positions: ArrayLike,
        velocities: ArrayLike | None = None,
        forces: ArrayLike | None = None,
        displacements: ArrayLike | None = None,
    ) -> None:
        """Append one frame.

        Args:
            step: number of the step.
            time, timestep: in ps.
            cell: (3, 3), one cell vector a row, in Å; written whatever imcon is.
            positions: (N, 3) in Å; velocities: (N, 3) in Å/ps; forces: (N, 3) in Da Å/ps².
            displacements: (N,) distance of each bead from its start in Å; 0 where not given.

        Raises:
            ValueError: an array that the level needs is missing or has another shape.
            RunError: the file cannot be written.
        """
        head = "timestep" + fortran_i(step, 10) + fortran_i(self._count, 10) + fortran_i(self._level, 2)
        head += fortran_i(self._imcon, 2) + fortran_f(timestep, 20, 6) + fortran_f(time, 20, 6)
        rows = fortran_f_columns(np.asarray(cell, dtype=np.float64).reshape(3, 3), 20, 10, shrink=True)
        lattice = b"".join(rows[i].tobytes().ljust(72) + b"\n" for i in range(3))
        beads = self._frame
        if displacements is not None:
            moved = np.asarray(displacements, dtype=np.float64).reshape(self._count)
            beads[:, 0, 42:54] = fortran_f_columns(moved, 12, 6, shrink=True)
        else:
            beads[:, 0, 42:54] = np.frombuffer(b"    0.000000", dtype=np.uint8)
        vectors = [("positions", positions), ("velocities", velocities), ("forces", forces)]
        for place, (name, vector) in enumerate(vectors[: self._level + 1], 1):
            if vector is None:
                raise ValueError(f"a trajectory of level {self._level} needs {name}")
            array = np.asarray(vector, dtype=np.float64).reshape(self._count, 3)
            beads[:, place, :60] = fortran_g20_10(array).reshape(self._count, 60)
        self._file.write(record(head) + lattice + beads.tobytes())
        self._frames += 1
        self._file.patch(RECORD_BYTES, self._counters(self._frames))

    def _template(self, species: Sequence[str], masses: ArrayLike, charges: ArrayLike) -> NDArray[np.uint8]:
        """The bytes of a frame's bead records, (N, records a bead, 73), with what never changes filled in."""
        beads = np.full((self._count, 2 + self._level, RECORD_BYTES), ord(" "), dtype=np.uint8)
        beads[:, :, -1] = _LINE_FEED
        if self._count:
            beads[:, 0, 0:8] = text_columns(species, 8)
            beads[:, 0, 8:18] = integer_columns(np.arange(1, self._count + 1), 10)
        for start, values in ((18, masses), (30, charges)):
            numbers = np.asarray(values, dtype=np.float64).reshape(self._count)
            beads[:, 0, start : start + 12] = fortran_f_columns(numbers, 12, 6, shrink=True)
        return beads

    def _counters(self, frames: int) -> bytes:
        records = 2 + frames * frame_records(self._count, self._level)
        numbers = (self._level, self._imcon, self._count)
        return record("".join(fortran_i(n, 10) for n in numbers) + fortran_i(frames, 21) + fortran_i(records, 21))

    def _whole(self, handle: IO[bytes], keep_until: int | None) -> int:
        """How many bytes of an existing file are whole frames of steps up to ``keep_until``."""
        header = handle.read(2 * RECORD_BYTES)
        if len(header) < 2 * RECORD_BYTES:
            return 0
        words = header[RECORD_BYTES:].split()
        expected = [self._level, self._imcon, self._count]
        fixed = header[RECORD_BYTES - 1] == header[2 * RECORD_BYTES - 1] == _LINE_FEED
        if not fixed or [int(w) for w in words[:3] if w.isdigit()] != expected:
            message = "cannot be continued: level, imcon and number of beads must be "
            raise InputError(message + f"{expected}, in records of {RECORD_BYTES} bytes", path=self._path, line=2)
        size = handle.seek(0, os.SEEK_END)
        frames = (size - 2 * RECORD_BYTES) // self._frame_bytes
        while frames > 0:
            handle.seek(2 * RECORD_BYTES + (frames - 1) * self._frame_bytes)
            start = handle.read(18)
            if not start.startswith(b"timestep"):
                line = 3 + (frames - 1) * frame_records(self._count, self._level)
                raise InputError("cannot be continued: expected 'timestep' here", path=self._path, line=line)
            if keep_until is None or int(start[8:18]) <= keep_until:
                break
            frames -= 1
        return 2 * RECORD_BYTES + frames * self._frame_bytes


def frame_records(beads: int, level: int) -> int:
    """Number of records in one frame: the frame's head, three cell vectors, and 2 + level records a bead."""
    return 4 + beads * (2 + level)
