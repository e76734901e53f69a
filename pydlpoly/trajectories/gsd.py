"""GSD with HOOMD's schema, through the package gsd, in single precision.

HOOMD's box is centred at the origin with a along x and b in the plane of x and y; a cell of another orientation is
turned, and positions, velocities and forces with it. What the schema has no place for is logged: under ``pydlpoly/``
the cell as it is in the run, imcon, time and timestep, under ``particles/`` forces, masses and charges in double
precision, and the arrays of beads.
"""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from pydlpoly import __version__
from pydlpoly.errors import InputError, RunError
from pydlpoly.formats.frame import Frame
from pydlpoly.formats.records import FloatArray
from pydlpoly.trajectories import base
from pydlpoly.trajectories.cells import Upright, upright

_SCHEMA = [1, 4]  # the newest that all releases of HOOMD and OVITO since 2021 read
_GROUPS = {"bond": "bonds", "angle": "angles", "dihedral": "dihedrals", "inversion": "impropers"}
_LOG = "particles/"
_OWN = ("forces", "exact_mass", "exact_charge")
_HELD = ("velocities", "images")
_USER = "a trajectory in GSD"


class Writer(base.Writer):
    """Each frame is flushed with its entry in the file's index, without which it does not count."""

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
        base.package("gsd.hoomd", _USER)
        for name in like.arrays:
            if name in _OWN:
                raise InputError("is used by this format for something else", word=name)
        if np.any(like.cell):
            upright(like.cell)  # refused before anything is written
        self._topology = topology
        self._types = tuple(dict.fromkeys(like.names))
        number = {name: k for k, name in enumerate(self._types)}
        self._kinds = np.fromiter((number[name] for name in like.names), np.uint32, len(like.names))
        self._frames = _opened(path, append=append and Path(path).exists())
        if append:
            self._keep(keep_until)

    def write(self, frame: Frame) -> None:
        """Append one frame."""
        self.check(frame)
        try:
            self._frames.append(self._made(frame))
            self._frames.flush()
        except OSError as error:
            raise RunError(f"{self.path}: cannot be written: {error.strerror or error}") from error

    def sync(self) -> None:
        """Wait until all frames are on the disk."""
        with Path(self.path).open("rb") as handle, suppress(OSError):
            os.fsync(handle.fileno())

    def close(self) -> None:
        """Close the file."""
        if self._frames is not None:
            self._frames.close()
        self._frames = None

    def _keep(self, keep_until: int | None) -> None:
        """Drop the frames of later steps; the file layer cannot, so that the others are copied."""
        count = len(self._frames)
        if count:
            first = self._frames[0]
            made = self._made(self._like)
            same = [set(one.log) - _ONCE for one in (first, made)]
            if tuple(_names(first)) != self._like.names or same[0] != same[1]:
                message = "cannot be continued: it has other beads, or other numbers of them"
                raise InputError(message, path=self.path)
        kept = count
        while keep_until is not None and kept and _step(self._frames.file, kept - 1) > keep_until:
            kept -= 1
        if kept == count:
            return
        temporary = f"{self.path}.tmp"
        with _opened(temporary, append=False) as copy:
            for k in range(kept):
                _copy_frame(self._frames.file, k, copy.file)
        self._frames.close()
        Path(temporary).replace(self.path)
        self._frames = _opened(self.path, append=True)

    def _made(self, frame: Frame) -> Any:
        from gsd import hoomd

        made = hoomd.Frame()
        cell = _box_of(frame)
        made.configuration.step = frame.step
        made.configuration.box = _box(cell.cell)
        made.configuration.dimensions = 3
        beads = made.particles
        beads.N, beads.types, beads.typeid = len(frame.names), list(self._types), self._kinds
        beads.position = cell.turned(frame.positions).astype(np.float32)
        if frame.velocities is not None:
            beads.velocity = cell.turned(frame.velocities).astype(np.float32)
        if frame.images is not None:
            beads.image = frame.images.astype(np.int32)
        log = {
            "pydlpoly/cell": np.asarray(frame.cell, dtype=np.float64),
            "pydlpoly/imcon": np.array([frame.imcon], dtype=np.int32),
        }
        for name in ("time", "timestep"):
            if (value := getattr(frame, name)) is not None:
                log[f"pydlpoly/{name}"] = np.array([value], dtype=np.float64)
        if frame.forces is not None:
            log[f"{_LOG}forces"] = cell.turned(frame.forces).astype(np.float32)
        log |= {f"{_LOG}{name}": np.asarray(values, dtype=np.float64) for name, values in frame.arrays.items()}
        for name, values in (("mass", frame.masses), ("charge", frame.charges)):
            if base.known(values):
                setattr(beads, name, values.astype(np.float32))
                if not len(self._frames):
                    log[f"{_LOG}exact_{name}"] = values
        if not len(self._frames):
            self._once(log)
        for kind, links in self._topology.links.items():  # written once, since they are those of the first frame
            group = getattr(made, _GROUPS[kind])
            group.N, group.types = len(links.beads), list(links.names)
            group.typeid, group.group = links.kinds.astype(np.uint32), links.beads.astype(np.int32)
        made.log = log
        return made

    def _once(self, log: dict[str, Any]) -> None:
        """What the first frame alone says; it counts for all."""
        # The schema has zeros for what is not there.
        log["pydlpoly/holds"] = np.array([name in base.what_is_there(self._like) for name in _HELD], dtype=np.int8)
        log["pydlpoly/reduced"] = np.array([self._topology.reduced], dtype=np.int8)
        log["pydlpoly/title"] = np.frombuffer(self._topology.title.encode() or b" ", dtype=np.uint8)
        if self._topology.molecules is not None:
            log[f"{_LOG}molecule"] = self._topology.molecules.astype(np.int32)


class Reader(base.CountedReader):
    """GSD as this module or HOOMD writes it; what is not given is NaN or None."""

    def __init__(self, path: str) -> None:
        super().__init__(path)
        base.package("gsd.hoomd", _USER)
        from gsd import hoomd

        try:
            self._frames = hoomd.open(path, "r")
        except (OSError, RuntimeError) as error:
            raise InputError(f"is not a GSD file with HOOMD's schema: {error}", path=path) from error
        self.topology = self._topology() if len(self._frames) else base.Topology()
        self._known: tuple[str, ...] = ()

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self._frames)

    def at(self, index: int) -> Frame:
        """Return the frame of this number."""
        found = self._frames[index]
        beads, log, count = found.particles, found.log, int(found.particles.N)
        box = _cell(found.configuration.box)
        own = np.array(log.get("pydlpoly/cell", box), dtype=np.float64)
        turn = upright(own) if np.any(own) else Upright(own)
        holds = log.get("pydlpoly/holds", [self._has("velocity"), self._has("image")])
        forces = log.get(f"{_LOG}forces")
        names = tuple(_names(found))
        self._known = names = self._known if self._known == names else names  # one tuple for all frames
        return Frame(
            names,
            np.arange(1, count + 1),
            self._given(log, beads, "mass"),
            self._given(log, beads, "charge"),
            np.full(count, np.nan),
            turn.back(np.array(beads.position, dtype=np.float64)),
            turn.back(np.array(beads.velocity, dtype=np.float64)) if holds[0] else None,
            None if forces is None else turn.back(np.array(forces, dtype=np.float64)),
            step=int(found.configuration.step),
            time=_number(log, "time"),
            timestep=_number(log, "timestep"),
            level=0 if not holds[0] else 1 if forces is None else 2,
            imcon=int(log["pydlpoly/imcon"][0]) if "pydlpoly/imcon" in log else base.imcon_of(box, (True, True, True)),
            cell=own,
            images=np.array(beads.image, dtype=np.int64) if holds[1] else None,
            arrays={
                name.removeprefix(_LOG): np.array(values, dtype=np.float64)
                for name, values in log.items()
                if name.startswith(_LOG) and values.shape == (count,) and name not in _NOT_ARRAYS
            },
        )

    def _has(self, name: str) -> bool:
        """Whether the first frame gives this quantity of beads."""
        return bool(self._frames.file.chunk_exists(frame=0, name=f"particles/{name}"))

    def _given(self, log: dict[str, Any], beads: Any, name: str) -> FloatArray:
        """Masses or charges: exact ones, those of the schema, or NaN where a file of ours has none."""
        exact = log.get(f"{_LOG}exact_{name}")
        if exact is None and "pydlpoly/holds" in log:
            return np.full(int(beads.N), np.nan)
        return np.array(getattr(beads, name) if exact is None else exact, dtype=np.float64)

    def _topology(self) -> base.Topology:
        first = self._frames[0]
        groups = {kind: getattr(first, name) for kind, name in _GROUPS.items()}
        links = {
            kind: base.Links(tuple(group.types), np.array(group.typeid, np.int64), np.array(group.group, np.int64))
            for kind, group in groups.items()
            if group.N
        }
        molecules = first.log.get(f"{_LOG}molecule")
        title = bytes(np.asarray(first.log.get("pydlpoly/title", []), dtype=np.uint8)).decode(errors="replace").strip()
        return base.Topology(
            title,
            bool(np.any(first.log.get("pydlpoly/reduced", False))),
            None if molecules is None else molecules.astype(np.int64),
            links,
        )


_ONCE = {f"{_LOG}{name}" for name in ("exact_mass", "exact_charge", "molecule")} | {
    f"pydlpoly/{name}" for name in ("holds", "reduced", "title")
}
_NOT_ARRAYS = [f"{_LOG}{name}" for name in (*_OWN, "molecule")]


def _opened(path: str, *, append: bool) -> Any:
    """Open a file for appending, or a new one."""
    from gsd import fl, hoomd

    mode = "r+" if append else "w"
    try:
        file = fl.open(
            name=path, mode=mode, application=f"pydlpoly {__version__}", schema="hoomd", schema_version=_SCHEMA
        )
        return hoomd.HOOMDTrajectory(file)
    except RuntimeError as error:
        raise InputError(f"cannot be continued: {error}", path=path) from error
    except OSError as error:
        raise RunError(f"{path}: cannot be opened for writing: {error.strerror or error}") from error


def _copy_frame(source: Any, index: int, target: Any) -> None:
    """Copy the chunks of one frame as they are."""
    for name in source.find_matching_chunk_names(""):
        if source.chunk_exists(frame=index, name=name):
            target.write_chunk(name, source.read_chunk(frame=index, name=name))
    target.end_frame()
    target.flush()


def _step(file: Any, index: int) -> int:
    name = "configuration/step"
    for frame in (index, 0):
        if file.chunk_exists(frame=frame, name=name):
            return int(file.read_chunk(frame=frame, name=name)[0])
    return 0


def _number(log: dict[str, Any], name: str) -> float | None:
    value = log.get(f"pydlpoly/{name}")
    return None if value is None else float(value[0])


def _names(frame: Any) -> list[str]:
    types = np.array(frame.particles.types, dtype=object)
    names: list[str] = types[np.asarray(frame.particles.typeid, dtype=np.int64)].tolist()
    return names


def _box_of(frame: Frame) -> Upright:
    """The cell, or a cube around the beads where there is none: HOOMD knows no frame without a box."""
    if np.any(frame.cell):
        return upright(frame.cell)
    reach = 2.0 * float(np.max(np.abs(frame.positions), initial=0.0)) + 1.0
    return Upright(np.diag([reach] * 3))


def _box(cell: FloatArray) -> list[float]:
    """HOOMD's Lx, Ly, Lz and tilts xy, xz, yz of an upright cell."""
    (lx, _, _), (bx, ly, _), (cx, cy, lz) = cell.tolist()
    return [lx, ly, lz, bx / ly, cx / lz, cy / lz]


def _cell(box: Any) -> FloatArray:
    lx, ly, lz, xy, xz, yz = (float(value) for value in box)
    return np.array([[lx, 0.0, 0.0], [xy * ly, ly, 0.0], [xz * lz, yz * lz, lz]])
