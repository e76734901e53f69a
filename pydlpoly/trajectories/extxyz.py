"""Extended XYZ: a line with the number of beads, a line of ``key=value``, and a line a bead, frame after frame.

The columns are those that ASE understands, in ASE's units (Å, Da, e, eV; see ``pydlpoly.ase``): ``type`` and
``bead_types`` hold the names, the first for OVITO, the second for ASE, which is told by ``Z`` 0 that a bead is no
element (there is no ``species``, in which ASE expects elements); then ``masses``, ``initial_charges``, ``momenta``,
``forces``, ``images`` and one column for each array of beads. ASE's functions read and write the line of keys; the
lines of beads are written here, since ASE's writer keeps eight decimals, and here every number reads back to its last
bit.
"""

# mypy: allow-untyped-calls
# ASE's functions have no annotations.

from __future__ import annotations

import io
import os
from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path
from typing import IO, Any

import numpy as np
from ase.io.extxyz import key_val_dict_to_str, key_val_str_to_dict
from numpy.typing import NDArray

from pydlpoly.ase import ENERGY, VELOCITY
from pydlpoly.errors import InputError
from pydlpoly.formats.atomic import FrameFile
from pydlpoly.formats.frame import Frame
from pydlpoly.formats.history_sample import HistorySample, chosen
from pydlpoly.formats.records import FloatArray, IntArray
from pydlpoly.trajectories import base

_ROWS = 10_000  # beads whose lines are held at the same time
_BLOCK = 1 << 22  # bytes looked at together when lines are counted
_TYPES = {"R": "f8", "I": "i8", "S": "U64", "L": "U8"}
_OWN = ("type", "species", "pos", "Z", "bead_types", "masses", "initial_charges", "momenta", "forces", "images")
_TITLE = str.maketrans(dict.fromkeys("\"'{}[]\\=\n", " "))  # not all programs agree on how to quote these


class Writer(base.Writer):
    """Each frame is one write; a run that goes on drops the frame that a kill cut short."""

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
        if like.velocities is not None and not base.known(like.masses):
            raise InputError("extxyz holds momenta; velocities cannot be written without the masses of all beads")
        for name in (*like.arrays, *dict.fromkeys(like.names)):
            if name in _OWN or name.split() != [name] or (name in like.arrays and ":" in name):
                raise InputError("cannot be the name of a column or a bead of extxyz", word=name)
        self._title = " ".join(topology.title.translate(_TITLE).split())
        self._reduced = topology.reduced
        count = len(like.names)
        self._file = FrameFile(
            path, b"", append=append, whole_length=lambda handle: _whole(handle, path, count, keep_until)
        )

    def write(self, frame: Frame) -> None:
        """Append one frame."""
        self.check(frame)
        if frame.velocities is not None and np.any(frame.velocities[frame.masses <= 0.0]):
            message = f"extxyz holds momenta: the velocity of a bead without mass is lost in step {frame.step}"
            raise InputError(message, path=self.path)
        columns = _columns(frame)
        head = f"{len(frame.names)}\n{self._keys(frame, columns)}\n".encode()
        self._file.write(b"".join([head, *_rows(columns, len(frame.names))]))

    def sync(self) -> None:
        """Wait until all frames are on the disk."""
        self._file.sync()

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _keys(self, frame: Frame, columns: dict[str, tuple[str, Any]]) -> str:
        words = []
        if np.any(frame.cell):
            words.append(f'Lattice="{_numbers(frame.cell)}"')
            words.append(f'Origin="{_numbers(-0.5 * frame.cell.sum(axis=0))}"')
        width = {name: 1 if np.ndim(values) == 1 else np.shape(values)[1] for name, (_, values) in columns.items()}
        words.append("Properties=" + ":".join(f"{name}:{kind}:{width[name]}" for name, (kind, _) in columns.items()))
        keys: dict[str, Any] = {"step": frame.step}
        keys |= {name: value for name in ("time", "timestep") if (value := getattr(frame, name)) is not None}
        keys["imcon"] = frame.imcon
        if self._reduced:
            keys["units"] = "reduced"
        if self._title:
            keys["title"] = self._title
        keys["pbc"] = np.array(base.periodic_of(frame.imcon))
        return " ".join([*words, str(key_val_dict_to_str(keys))])


class Reader(base.Reader):
    """extxyz as this module or ASE writes it; what is not given is NaN, None, or for steps the number of the frame."""

    def __init__(self, path: str) -> None:
        super().__init__(path)
        with _open(path) as handle:
            keys = _keys(_Lines(handle, path), handle.readline()) if handle.readline().strip() else {}
        self.topology = base.Topology(str(keys.get("title", "")), keys.get("units") == "reduced")

    def __iter__(self) -> Iterator[Frame]:
        """Iterate over the frames; one that is cut short at the end is left out."""
        with _open(self.path) as handle:
            lines = _Lines(handle, self.path)
            number = 0
            while (first := lines.next()).strip():
                frame = _frame(lines, first, number)
                if frame is None:
                    return
                yield frame
                number += 1

    def sample(self, most: int) -> HistorySample:
        """Return at most so many frames at equal distances, the last one among them; the others' lines are counted."""
        frames = []
        with Path(self.path).open("rb") as handle:
            places, end = _places(handle)
            cut = f"a frame is cut short after the first {len(places)}" if end < handle.seek(0, os.SEEK_END) else ""
            for number in chosen(len(places), most):
                handle.seek(places[number])
                text = io.TextIOWrapper(handle, encoding="utf-8", errors="surrogateescape")
                lines = _Lines(text, self.path)
                frame = _frame(lines, lines.next(), number)
                text.detach()
                assert frame is not None  # its lines have been counted
                frames.append(frame)
        return HistorySample(tuple(frames), len(places), cut)


class _Lines:
    """Lines of a file and how many have been taken."""

    def __init__(self, handle: IO[str], path: str) -> None:
        self.handle, self.path, self.number = handle, path, 0

    def next(self) -> str:
        self.number += 1
        return self.handle.readline()


def _open(path: str) -> IO[str]:
    try:
        return Path(path).open(encoding="utf-8", errors="surrogateescape")
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}", path=path) from error


# -- Writing ----------------------------------------------------------------------------------------------------------


def _numbers(values: FloatArray) -> str:
    return " ".join(repr(value) for value in np.ravel(values).tolist())


def _columns(frame: Frame) -> dict[str, tuple[str, Any]]:
    """The columns in order: name, type and values."""
    names = np.array(frame.names, dtype=object)
    columns: dict[str, tuple[str, Any]] = {
        "type": ("S", names),
        "pos": ("R", frame.positions),
        "Z": ("I", np.zeros(len(names), dtype=np.int64)),
        "bead_types": ("S", names),
    }
    if base.known(frame.masses):
        columns["masses"] = ("R", frame.masses)
    if base.known(frame.charges):
        columns["initial_charges"] = ("R", frame.charges)
    if frame.velocities is not None:
        columns["momenta"] = ("R", frame.velocities * VELOCITY * frame.masses[:, None])
    if frame.forces is not None:
        columns["forces"] = ("R", frame.forces * ENERGY)
    if frame.images is not None:
        columns["images"] = ("I", frame.images)
    return columns | {name: ("R", np.asarray(values, dtype=np.float64)) for name, values in frame.arrays.items()}


def _rows(columns: dict[str, tuple[str, Any]], count: int) -> Iterator[bytes]:
    """The lines of the beads, some thousand at a time."""
    values: list[Any] = []
    for _, array in columns.values():
        values += [array] if np.ndim(array) == 1 else list(np.asarray(array).T)
    line = " ".join(["%s"] * len(values)) + "\n"  # of a number: the shortest text that reads back as it
    for start in range(0, count, _ROWS):
        part = [array[start : start + _ROWS].tolist() for array in values]
        yield "".join([line % row for row in zip(*part, strict=True)]).encode()


def _whole(handle: IO[bytes], path: str, count: int, keep_until: int | None) -> int:
    """How many bytes of an existing file are whole frames of steps up to ``keep_until``."""
    kept = 0
    while first := handle.readline():
        if not first.endswith(b"\n"):
            break
        if first.strip() != str(count).encode():
            message = f"cannot be continued: expected {count} beads in each frame"
            raise InputError(message, path=path, word=first[:20].decode(errors="replace").strip())
        keys = handle.readline()
        if not keys.endswith(b"\n") or not _skip(handle, count):
            break
        if keep_until is not None and int(key_val_str_to_dict(keys.decode()).get("step", 0)) > keep_until:
            break
        kept = handle.tell()
    return kept


def _skip(handle: IO[bytes], lines: int) -> bool:
    """Pass so many whole lines; False when there are fewer."""
    left = lines
    while left:
        start = handle.tell()
        block = handle.read(_BLOCK)
        found = block.count(b"\n")
        if found >= left:
            ends = np.flatnonzero(np.frombuffer(block, dtype=np.uint8) == ord("\n"))
            handle.seek(start + int(ends[left - 1]) + 1, os.SEEK_SET)
            return True
        if not block:
            return False
        left -= found
    return True


# -- Reading ----------------------------------------------------------------------------------------------------------


def _places(handle: IO[bytes]) -> tuple[list[int], int]:
    """Where each whole frame of a file begins, and where the last one ends."""
    starts: list[int] = []
    end = 0
    while first := handle.readline():
        count = first.strip()
        if not count:  # blank lines at the end
            end = handle.tell()
            continue
        whole = first.endswith(b"\n") and count.isdigit() and handle.readline().endswith(b"\n")
        if not whole or not _skip(handle, int(count)):
            break
        starts.append(end)
        end = handle.tell()
    return starts, end


def _keys(lines: _Lines, line: str) -> dict[str, Any]:
    try:
        keys: dict[str, Any] = key_val_str_to_dict(line)
    except ValueError as error:
        raise InputError(f"is no line of keys: {error}", path=lines.path, line=2) from error
    return keys


def _frame(lines: _Lines, first: str, number: int) -> Frame | None:
    """The frame that begins with this line, or None when it is cut short."""
    start = lines.number
    if not first.strip().isdecimal():
        message = "expected the number of beads of the next frame"
        raise InputError(message, path=lines.path, line=start, word=first.strip()[:20])
    count = int(first)
    second = lines.next()
    if not second.endswith("\n"):
        return None
    keys = _keys(lines, second)
    table = _table(lines, _dtype(str(keys.get("Properties", "species:S:1:pos:R:3")), lines), count)
    if table is None:
        return None
    lattice = keys.get("Lattice")
    cell = np.zeros((3, 3)) if lattice is None else np.ascontiguousarray(np.asarray(lattice, dtype=np.float64).T)
    x, y, z = (bool(on) for on in keys.get("pbc", [lattice is not None] * 3))
    imcon = int(keys["imcon"]) if "imcon" in keys else base.imcon_of(cell, (x, y, z))
    return _made(table, keys, number, cell, imcon)


def _made(table: NDArray[Any], keys: dict[str, Any], number: int, cell: FloatArray, imcon: int) -> Frame:
    there = table.dtype.names or ()
    count = len(table)
    names = next(
        (table[name] for name in ("bead_types", "names", "species", "type") if name in there), np.full(count, "X")
    )
    unknown = np.full(count, np.nan)
    masses, charges = (_column(table, name) if name in there else unknown for name in ("masses", "initial_charges"))
    velocities = _velocities(_column(table, "momenta"), masses) if "momenta" in there else None
    forces = _column(table, "forces") / ENERGY if "forces" in there else None
    known: dict[str, str] = {}  # one string object a species, not one a bead
    further = [name for name in there if name not in (*_OWN, "names", "move_mask") and table[name].dtype.kind in "fi"]
    return Frame(
        tuple(known.setdefault(name, name) for name in names.tolist()),
        np.arange(1, count + 1),
        masses,
        charges,
        unknown,
        _column(table, "pos"),
        velocities,
        forces,
        step=int(keys.get("step", number)),
        time=float(keys["time"]) if "time" in keys else None,
        timestep=float(keys["timestep"]) if "timestep" in keys else None,
        level=0 if velocities is None else 1 if forces is None else 2,
        imcon=imcon,
        cell=cell,
        images=_images(table) if "images" in there else None,
        arrays={name: _column(table, name) for name in further if table[name].ndim == 1},
    )


def _velocities(momenta: FloatArray, masses: FloatArray) -> FloatArray:
    """Velocities in Å/ps; beads without mass are frozen."""
    heavy = (masses > 0.0)[:, None]
    return np.divide(momenta, masses[:, None] * VELOCITY, out=np.zeros_like(momenta), where=heavy)


def _column(table: NDArray[Any], name: str) -> FloatArray:
    return np.array(table[name], dtype=np.float64)


def _images(table: NDArray[Any]) -> IntArray:
    return np.array(table["images"], dtype=np.int64)


def _dtype(properties: str, lines: _Lines) -> np.dtype[Any]:
    fields = properties.split(":")
    kinds = list(zip(fields[::3], fields[1::3], fields[2::3], strict=False))
    understood = len(fields) % 3 == 0 and all(kind in _TYPES and width.isdecimal() for _, kind, width in kinds)
    if not understood or "pos" not in fields[::3]:
        message = "expected name:type:columns for all properties, and positions (pos) among them"
        raise InputError(message, path=lines.path, line=lines.number, word=properties)
    shapes = [() if width == "1" else (int(width),) for _, _, width in kinds]
    return np.dtype([(name, _TYPES[kind], shape) for (name, kind, _), shape in zip(kinds, shapes, strict=True)])


def _table(lines: _Lines, dtype: np.dtype[Any], count: int) -> NDArray[Any] | None:
    """The lines of the beads; None when the file ends before the last one does."""
    table = np.empty(count, dtype=dtype)
    for start in range(0, count, _ROWS):
        rows = list(islice(lines.handle, min(_ROWS, count - start)))
        lines.number += len(rows)
        if len(rows) < min(_ROWS, count - start) or not rows[-1].endswith("\n"):
            return None
        try:
            table[start : start + len(rows)] = _loaded(rows, dtype)
        except ValueError as error:
            message = f"is no table of beads: {error}"
            raise InputError(message, path=lines.path, line=lines.number - len(rows) + 1) from error
    return table


def _loaded(rows: Iterable[str], dtype: np.dtype[Any]) -> NDArray[Any]:
    return np.loadtxt(rows, dtype=dtype, comments=None, ndmin=1)
