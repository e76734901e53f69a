"""DCD as CHARMM, NAMD and VMD know it, and a PSF beside it that says which beads these are.

Positions are in single precision, a along x and b in the plane of x and y. Frames are equally spaced in steps, and
there is room for nothing else: no velocities, no images, no arrays. The records are written here, since no library that
writes DCD can go on with an existing file; MDAnalysis reads them.
"""

from __future__ import annotations

import os
import struct
from pathlib import Path
from typing import IO, Any

import numpy as np

from pydlpoly.errors import InputError
from pydlpoly.formats.atomic import FrameFile
from pydlpoly.formats.frame import Frame
from pydlpoly.formats.records import FloatArray
from pydlpoly.trajectories import FORMATS, base
from pydlpoly.trajectories.cells import Upright, upright
from pydlpoly.trajectories.psf import read_psf, write_psf

_TIME = 0.04888821  # CHARMM's unit of time in ps: Å √(Da mol/kcal)
_COUNTS, _INTERVAL, _FLAG = 8, 16, 48  # places of frames and first step, interval, and the mark of a unit cell
_LARGEST = 2**31 - 1
_TITLE = b"written by pydlpoly; the beads are described by the PSF file of the same name".ljust(80)
_HEADER = 92 + 12 + len(_TITLE) + 12
_CELL = 56  # bytes of a frame's cell


class Writer(base.Writer):
    """Each frame is one write, then the header is brought up to date; a run that goes on counts the frames anew."""

    def __init__(
        self,
        path: str,
        like: Frame,
        topology: base.Topology,
        *,
        append: bool = False,
        keep_until: int | None = None,
    ) -> None:
        super().__init__(path, like)
        self._has_cell = bool(np.any(like.cell)) and like.imcon != 0
        self._turn = upright(like.cell).turn if self._has_cell else None  # refused before anything is written
        self._first = self._interval = 0
        self._bytes = (_CELL if self._has_cell else 0) + 3 * (4 * len(like.names) + 8)
        header = _header(len(like.names), self._has_cell, like.timestep or 0.0)
        write_psf(str(Path(path).with_suffix(FORMATS["dcd"].companion)), like, topology)
        self._file = FrameFile(path, header, append=append, whole_length=lambda handle: self._whole(handle, keep_until))
        self._count = (self._file.length - _HEADER) // self._bytes
        if self._file.resumed:
            self._patch()

    def write(self, frame: Frame) -> None:
        """Append one frame. Raises InputError also when the steps are not equally spaced."""
        self.check(frame)
        self._space(frame.step)
        if self._count < 2:  # so that a kill leaves no frame whose step is not known
            self._patch()
        cell = self._turned(frame) if self._has_cell else Upright(frame.cell)
        parts = [_record(np.array(_edges(cell.cell)))] if self._has_cell else []
        parts += [_record(column) for column in cell.turned(frame.positions).T.astype("<f4")]
        self._file.write(b"".join(parts))
        self._count += 1
        self._patch()

    def sync(self) -> None:
        """Wait until all frames are on the disk."""
        self._file.sync()

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _turned(self, frame: Frame) -> Upright:
        """The cell of a frame. Only one rotation for all frames can be said, in the PSF."""
        cell = upright(frame.cell)
        if not _same(cell.turn, self._turn):
            raise InputError(f"DCD cannot hold a cell that turns, as it does before step {frame.step}", path=self.path)
        return Upright(cell.cell, self._turn)

    def _space(self, step: int) -> None:
        """Take the first step and the interval from the first two frames, and hold the others to them."""
        if self._count == 0:
            self._first, self._interval = step, 0
        elif self._count == 1:
            self._interval = step - self._first
        self.accepts(step)

    def accepts(self, step: int) -> None:
        """Raise InputError when the next frame cannot be of this step."""
        if step > _LARGEST:
            raise InputError(f"DCD has no room for step {step}: at most {_LARGEST}", path=self.path)
        expected = self._first + self._count * self._interval
        if self._count >= 1 and self._interval and (step != expected or self._interval < 0):
            message = f"DCD holds frames in equal intervals: frame {self._count + 1} is of step {expected}, not {step}"
            raise InputError(message, path=self.path)

    def _patch(self) -> None:
        last = self._first + max(self._count - 1, 0) * self._interval
        numbers = (self._count, self._first, max(self._interval, 1), last)
        self._file.patch(_COUNTS, struct.pack("<4i", *numbers))

    def _whole(self, handle: IO[bytes], keep_until: int | None) -> int:
        """How many bytes of an existing file are whole frames of steps up to ``keep_until``."""
        found = bytearray(handle.read(_HEADER))
        if len(found) < _HEADER:
            return 0
        _, self._first, self._interval = struct.unpack_from("<3i", found, _COUNTS)
        expected = bytearray(_header(len(self._like.names), self._has_cell, 0.0))
        for block in (found, expected):
            block[_COUNTS : _COUNTS + 16] = bytes(16)
            block[44:48] = bytes(4)  # the timestep
        if found != expected:
            raise InputError("cannot be continued: it is no DCD of such frames", path=self.path)
        size = handle.seek(0, os.SEEK_END)
        frames = (size - _HEADER) // self._bytes
        while frames and keep_until is not None and self._first + (frames - 1) * self._interval > keep_until:
            frames -= 1
        return _HEADER + frames * self._bytes


class Reader(base.CountedReader):
    """DCD with a PSF beside it; velocities, images and arrays are not there."""

    def __init__(self, path: str) -> None:
        super().__init__(path)
        libdcd = base.package("MDAnalysis.lib.formats.libdcd", "reading a DCD", "MDAnalysis")
        self._fixed, self.topology = read_psf(str(Path(path).with_suffix(FORMATS["dcd"].companion)))
        try:
            self._file = libdcd.DCDFile(path)
        except OSError as error:
            raise InputError(f"is not a DCD file: {error}", path=path) from error
        header = self._file.header
        self._first, self._interval = int(header["istart"]), max(int(header["nsavc"]), 1)
        self._timestep = self._fixed["timestep"]
        if self._timestep is None:
            self._timestep = float(header["delta"]) * _TIME
        self._has_cell = bool(header["is_periodic"])
        first = self._fixed["cell"]
        self._turn = upright(first).turn if self._has_cell and first is not None else None
        if header["natoms"] != len(self._fixed["names"]):
            message = f"has {header['natoms']} beads, its PSF {len(self._fixed['names'])}"
            raise InputError(message, path=path)

    def __len__(self) -> int:
        """Return the number of whole frames."""
        return int(self._file.n_frames)

    def left_out(self) -> str:
        """Return whether the file ends in the middle of a frame."""
        frame = (_CELL if self._has_cell else 0) + 3 * (4 * len(self._fixed["names"]) + 8)
        with Path(self.path).open("rb") as handle:
            handle.seek(92)
            titles = struct.unpack("<i", handle.read(4))[0]
            size = handle.seek(0, os.SEEK_END) - (92 + 8 + titles + 12)
        rest = size - frame * len(self)
        return f"a frame is cut short after the first {len(self)}" if rest else ""

    def at(self, index: int) -> Frame:
        """Return the frame of this number."""
        self._file.seek(index)
        read = self._file.read()
        count = len(self._fixed["names"])
        cell = Upright(_cell(read.unitcell) if self._has_cell else np.zeros((3, 3)), self._turn)
        step = self._first + index * self._interval
        imcon = self._fixed["imcon"]
        return Frame(
            self._fixed["names"],
            np.arange(1, count + 1),
            self._fixed["masses"],
            self._fixed["charges"],
            np.full(count, np.nan),
            cell.back(np.array(read.xyz, dtype=np.float64)),
            step=step,
            time=step * self._timestep,
            timestep=self._timestep,
            level=0,
            imcon=base.imcon_of(cell.cell, (self._has_cell,) * 3) if imcon is None else imcon,
            cell=cell.back(cell.cell),
        )


def _same(turn: FloatArray | None, other: FloatArray | None) -> bool:
    if turn is None or other is None:
        return turn is other
    return bool(np.allclose(turn, other, rtol=0.0, atol=1e-9))


def _header(count: int, has_cell: bool, timestep: float) -> bytes:
    numbers = [0] * 20
    numbers[10], numbers[19] = int(has_cell), 24  # CHARMM's version, which has the cell in angles
    first = bytearray(struct.pack("<i4s20ii", 84, b"CORD", *numbers, 84))
    struct.pack_into("<f", first, 44, timestep / _TIME)
    title = struct.pack("<ii", 4 + len(_TITLE), 1) + _TITLE + struct.pack("<i", 4 + len(_TITLE))
    return bytes(first) + title + struct.pack("<3i", 4, count, 4)


def _record(values: Any) -> bytes:
    content: bytes = values.astype(values.dtype.newbyteorder("<")).tobytes()
    mark = struct.pack("<i", len(content))
    return mark + content + mark


def _edges(cell: FloatArray) -> list[float]:
    """A, γ, B, β, α, C with angles in degrees: the order of the file."""
    a, b, c = np.linalg.norm(cell, axis=1)

    def angle(i: int, j: int) -> float:
        cosine = float(cell[i] @ cell[j]) / float(np.linalg.norm(cell[i]) * np.linalg.norm(cell[j]))
        return 90.0 if cosine == 0.0 else float(np.degrees(np.arccos(cosine)))

    return [a, angle(0, 1), b, angle(0, 2), angle(1, 2), c]


def _cell(edges: Any) -> FloatArray:
    """The upright cell of A, γ, B, β, α, C; right angles give exact zeros."""
    a, gamma, b, beta, alpha, c = (float(value) for value in edges)
    cosines = [0.0 if angle == 90.0 else float(np.cos(np.radians(angle))) for angle in (alpha, beta, gamma)]
    cos_a, cos_b, cos_c = cosines
    sin_c = float(np.sqrt(1.0 - cos_c**2))
    y = (cos_a - cos_b * cos_c) / sin_c
    return np.array(
        [
            [a, 0.0, 0.0],
            [b * cos_c, b * sin_c, 0.0],
            [c * cos_b, c * y, c * float(np.sqrt(1.0 - cos_b**2 - y**2))],
        ]
    )
