"""H5MD 1.1 (de Buyl, Colberg and Höfling, Comput. Phys. Commun. 185, 1546 (2014)) in double precision, through h5py.

The beads are the group ``particles/trajectory``: ``position``, ``velocity``, ``force``, ``image`` and every array of
beads with their common ``step`` and ``time``; ``species`` (an enumeration of the names), ``mass`` and ``charge`` once.
Bonded groups are lists in ``connectivity``. Units are Å, ps, Da, e and, for forces, kJ/(mol Å); there are none in
reduced units.

The file is open while a frame is written and at no other time, in HDF5's SWMR mode, in which it is whole whenever the
writer is killed. A frame counts when its step is there, which comes last.
"""

from __future__ import annotations

import os
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pydlpoly import __version__
from pydlpoly.errors import InputError, RunError
from pydlpoly.formats.frame import Frame
from pydlpoly.formats.records import FloatArray
from pydlpoly.trajectories import base
from pydlpoly.trajectories.hdf5_flags import clear_open_flags

if TYPE_CHECKING:
    from collections.abc import Iterator

_USER = "a trajectory in H5MD"
_GROUP = "particles/trajectory"
_FORCE = 0.01  # one Da Å/ps² in kJ/(mol Å)
_UNITS = {
    "position": "Angstrom",
    "velocity": "Angstrom ps-1",
    "force": "kJ mol-1 Angstrom-1",
    "mass": "u",
    "charge": "e",
    "time": "ps",
}
_ELEMENTS = {"position": "positions", "velocity": "velocities", "force": "forces", "image": "images"}
_FIXED = ("box", "species", "mass", "charge", "molecule")
_LISTS = {"bond": "bonds", "angle": "angles", "dihedral": "dihedrals", "inversion": "impropers"}
_NONE = -1  # the step of a frame that is not finished
_STEPS = 256  # steps and times stored together


class Writer(base.Writer):
    """Each frame is written and flushed, and then its step."""

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
        self._force = 1.0 if topology.reduced else _FORCE
        self._h5py = base.package("h5py", _USER)
        taken = [name for name in like.arrays if name in (*_ELEMENTS, *_FIXED, "step", "time") or "/" in name]
        if taken:
            raise InputError("cannot be the name of an array of beads in H5MD", word=taken[0])
        if append and Path(path).exists():
            self._keep(keep_until)
        else:
            self._begin(topology)

    def write(self, frame: Frame) -> None:
        """Append one frame."""
        self.check(frame)
        with self._opened() as file:
            group = file[_GROUP]
            index = len(group["position/step"])
            for name, values in _values(frame, self._force).items():
                _put(group[name]["value"], index, values)
            file.flush()
            _put(group["position/time"], index, np.nan if frame.time is None else frame.time)
            _put(group["position/step"], index, frame.step)
            file.flush()

    def sync(self) -> None:
        """Wait until all frames are on the disk."""
        with Path(self.path).open("rb") as handle, suppress(OSError):
            os.fsync(handle.fileno())

    def close(self) -> None:
        """Do nothing: the file is closed between frames."""

    @contextmanager
    def _opened(self) -> Iterator[Any]:
        """The file in SWMR mode, from its opening on: h5py's own switch comes later, and a kill can come between."""
        h5f, h5p = self._h5py.h5f, self._h5py.h5p
        access = h5p.create(h5p.FILE_ACCESS)
        access.set_libver_bounds(h5f.LIBVER_V110, h5f.LIBVER_V110)
        access.set_fclose_degree(h5f.CLOSE_STRONG)
        access.set_file_locking(False, True)  # programs that look at the frames so far must not stop the run
        with self._failures():
            opened = h5f.open(os.fsencode(self.path), h5f.ACC_RDWR | h5f.ACC_SWMR_WRITE, access)
            with self._h5py.File(opened) as file:
                yield file

    @contextmanager
    def _failures(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise RunError(f"{self.path}: cannot be written: {error}") from error

    def _begin(self, topology: base.Topology) -> None:
        """Write everything but frames, and let it take the name of the file when it is whole."""
        temporary = f"{self.path}.tmp"
        with self._failures(), self._h5py.File(temporary, "w", libver=("v110", "v110")) as file:
            _head(file, topology, self._like)
            _elements(file, self._like, {} if topology.reduced else _UNITS)
            for kind, links in topology.links.items():
                made = file.create_dataset(f"connectivity/{_LISTS[kind]}", data=links.beads.astype(np.int64))
                made.attrs["particles_group"] = file[_GROUP].ref
                made.attrs["names"] = list(links.names)
                file[f"connectivity/{_LISTS[kind]}_kinds"] = links.kinds.astype(np.int32)
        Path(temporary).replace(self.path)

    def _keep(self, keep_until: int | None) -> None:
        """Drop unfinished frames and those of later steps."""
        with self._failures():
            clear_open_flags(self.path)
        with self._opened() as file:
            group = file.get(_GROUP)
            if (
                group is None
                or _names(group) != self._like.names
                or sorted(_moving(group)) != sorted({"box/edges", *_values(self._like, 1.0)})
            ):
                raise InputError("cannot be continued: it has other beads, or other numbers of them", path=self.path)
            steps = group["position/step"][:]
            wanted = steps != _NONE
            if keep_until is not None:
                wanted &= steps <= keep_until
            kept = len(steps) if wanted.all() else int(np.argmin(wanted))
            growing = [group[f"{name}/value"] for name in _moving(group)]
            for dataset in (group["position/step"], group["position/time"], *growing):
                if len(dataset) > kept:
                    dataset.resize(kept, axis=0)


class Reader(base.CountedReader):
    """H5MD as this module or another program writes it; the first group of particles, unfinished frames left out."""

    def __init__(self, path: str) -> None:
        super().__init__(path)
        h5py = base.package("h5py", _USER)
        try:
            self._file = _opened(h5py, path)
        except (OSError, InputError) as error:
            raise InputError(f"is not an HDF5 file that can be read: {error}", path=path) from error
        groups = list(self._file.get("particles", {}).values())
        if "h5md" not in self._file or not groups or "position" not in groups[0]:
            raise InputError("is not an H5MD file with positions", path=path)
        self._group = groups[0]
        self._names = _names(self._group)
        self._check_units()
        self._elements = [name for name in _moving(self._group) if self._goes_with_positions(name)]
        self._own = self._file.get("parameters/pydlpoly")
        self.topology = self._topology()

    def __len__(self) -> int:
        """Return the number of whole frames."""
        steps = self._group["position/step"]
        count: int = self._group["position/value"].shape[0]
        return min(count, int(np.count_nonzero(steps[:] != _NONE))) if steps.ndim else count

    def left_out(self) -> str:
        """Return how many frames were not finished."""
        rest = int(self._group["position/value"].shape[0]) - len(self)
        return f"{rest} frame{'s' * (rest > 1)} not finished after the first {len(self)}" if rest else ""

    def at(self, index: int) -> Frame:
        """Return the frame of this number."""
        count = len(self._names)
        unknown = np.full(count, np.nan)
        vectors = {name: self._element(name, index) for name in _ELEMENTS}
        cell, imcon = self._cell(index)
        time = _moment(self._group["position"], "time", index, np.nan)
        own = {} if self._own is None else dict(self._own.attrs)
        forces = vectors["force"]
        images = vectors["image"]
        positions = vectors["position"]
        assert positions is not None
        return Frame(
            self._names,
            np.arange(1, count + 1),
            self._once("mass", unknown),
            self._once("charge", unknown),
            unknown,
            positions,
            vectors["velocity"],
            None if forces is None else forces / _FORCE if self._in_kilojoules() else forces,
            step=int(_moment(self._group["position"], "step", index, index)),
            time=None if np.isnan(time) else float(time),
            timestep=float(own["timestep"]) if "timestep" in own else None,
            level=0 if vectors["velocity"] is None else 1 if forces is None else 2,
            imcon=int(own["imcon"]) if "imcon" in own else imcon,
            cell=cell,
            images=None if images is None else images.astype(np.int64),
            arrays={
                name: np.asarray(self._element(name, index))
                for name in self._elements
                if name not in (*_ELEMENTS, "box/edges") and self._group[name]["value"].shape[1:] == (count,)
            },
        )

    def _element(self, name: str, index: int) -> FloatArray | None:
        if name not in self._elements:
            return None
        return np.array(self._group[name]["value"][index], dtype=np.float64)

    def _check_units(self) -> None:
        """Refuse numbers in other units than ours; without a unit they are taken as they are."""
        there = [(name, self._group[name]) for name in ("mass", "charge") if name in self._group]
        there += [
            (name, self._group[name]["value"]) for name in ("position", "velocity", "force") if name in self._group
        ]
        there += [("time", self._group["position/time"])] if "time" in self._group["position"] else []
        for name, dataset in there:
            unit = dataset.attrs.get("unit", _UNITS[name])
            unit = unit.decode() if isinstance(unit, bytes) else str(unit)
            if unit != _UNITS[name]:
                message = f"the unit of {name} must be {_UNITS[name]} or none"
                raise InputError(message, path=self.path, word=unit)

    def _goes_with_positions(self, name: str) -> bool:
        """Whether an element has the positions' steps; others cannot be told which frame they belong to."""
        own, common = self._group[name].get("step"), self._group["position"].get("step")
        return own is None or common is None or own == common or np.array_equal(own[()], common[()])

    def _once(self, name: str, otherwise: FloatArray) -> FloatArray:
        there = self._group.get(name)
        return np.array(there[:], dtype=np.float64) if there is not None and hasattr(there, "shape") else otherwise

    def _in_kilojoules(self) -> bool:
        return bool(self._group["force/value"].attrs.get("unit", "") == _UNITS["force"])

    def _cell(self, index: int) -> tuple[FloatArray, int]:
        box = self._group["box"]
        bounds = [word.decode() if isinstance(word, bytes) else str(word) for word in box.attrs["boundary"]]
        edges = box.get("edges")
        if edges is None:
            return np.zeros((3, 3)), 0
        values = np.array(edges["value"][index] if hasattr(edges, "keys") else edges[:], dtype=np.float64)
        cell = np.diag(values) if values.ndim == 1 else values
        x, y, z = (word == "periodic" for word in bounds)
        return cell, base.imcon_of(cell, (x, y, z))

    def _topology(self) -> base.Topology:
        links = {}
        for kind, name in _LISTS.items():
            made = self._file.get(f"connectivity/{name}")
            kinds = self._file.get(f"connectivity/{name}_kinds")
            if made is not None and kinds is not None:
                names = tuple(str(word) for word in made.attrs["names"])
                links[kind] = base.Links(names, kinds[:].astype(np.int64), made[:])
        molecules = self._group.get("molecule")
        own = {} if self._own is None else dict(self._own.attrs)
        return base.Topology(
            str(own.get("title", "")),
            bool(own.get("reduced", False)),
            None if molecules is None else molecules[:].astype(np.int64),
            links,
        )


def _opened(h5py: Any, path: str) -> Any:
    """Open a file for reading; in SWMR mode where a writer, perhaps a killed one, has it marked as open.

    Not always so: HDF5 opens a file in one way at a time, and other packages of the same program use the usual one.
    A file that has lost its end is not opened in SWMR mode: HDF5 would wait for the rest for ever.
    """
    for way in ({}, {"locking": False}):
        with suppress(OSError), _whole_file():
            return h5py.File(path, "r", **way)
    return h5py.File(path, "r", swmr=True, locking=False)


@contextmanager
def _whole_file() -> Iterator[None]:
    """Turn HDF5's error at a file that has lost its end into InputError."""
    try:
        yield
    except OSError as error:
        if "truncated file" in str(error):
            raise InputError(f"it has lost its end: {error}") from error
        raise


def _head(file: Any, topology: base.Topology, like: Frame) -> None:
    """The groups ``h5md`` and ``parameters``, and what is said once of the beads."""
    from h5py import enum_dtype

    file.create_group("h5md").attrs["version"] = np.array([1, 1], dtype=np.int32)
    file.create_group("h5md/author").attrs["name"] = "unknown"
    creator = file.create_group("h5md/creator")
    creator.attrs["name"], creator.attrs["version"] = "pydlpoly", __version__
    if not topology.reduced:
        file.create_group("h5md/modules/units").attrs["version"] = np.array([1, 0], dtype=np.int32)
    own = file.create_group("parameters/pydlpoly")
    own.attrs["title"], own.attrs["reduced"], own.attrs["imcon"] = topology.title, topology.reduced, like.imcon
    if like.timestep is not None:
        own.attrs["timestep"] = like.timestep
    group = file.create_group(_GROUP)
    numbers = {name: k for k, name in enumerate(dict.fromkeys(like.names))}
    kinds = np.fromiter((numbers[name] for name in like.names), np.int32, len(like.names))
    group.create_dataset("species", data=kinds, dtype=enum_dtype(numbers, basetype="i4"))
    for name, values in (("mass", like.masses), ("charge", like.charges)):
        if base.known(values):
            group[name] = np.asarray(values, dtype=np.float64)
            if not topology.reduced:
                group[name].attrs["unit"] = _UNITS[name]
    if topology.molecules is not None:
        group["molecule"] = topology.molecules.astype(np.int64)


def _elements(file: Any, like: Frame, units: dict[str, str]) -> None:
    """The datasets that grow, without frames; all have the steps and times of the positions."""
    group = file[_GROUP]
    box = group.create_group("box")
    box.attrs["dimension"] = 3
    box.attrs["boundary"] = ["periodic" if on else "none" for on in base.periodic_of(like.imcon)]
    kind = {"shape": (0,), "maxshape": (None,), "chunks": (_STEPS,)}
    step = group.create_dataset("position/step", dtype="i8", fillvalue=_NONE, **kind)
    time = group.create_dataset("position/time", dtype="f8", **kind)
    if "time" in units:
        time.attrs["unit"] = units["time"]
    for name, values in _values(like, 1.0).items():
        made = group.require_group(name)
        if name != "position":
            made["step"], made["time"] = step, time  # hard links
        value = made.create_dataset(
            "value",
            shape=(0, *values.shape),
            maxshape=(None, *values.shape),
            chunks=(1, *values.shape),
            dtype=values.dtype,
        )
        unit = units.get("position" if name == "box/edges" else name)
        if unit:
            value.attrs["unit"] = unit


def _values(frame: Frame, force: float) -> dict[str, Any]:
    """What a frame puts into the datasets that grow; ``force`` is one Da Å/ps² in the file's unit."""
    values = {
        "box/edges": np.asarray(frame.cell, dtype=np.float64),
        "position": frame.positions,
        "velocity": frame.velocities,
        "force": None if frame.forces is None else frame.forces * force,
        "image": None if frame.images is None else frame.images.astype(np.int32),
        **{name: np.asarray(array, dtype=np.float64) for name, array in frame.arrays.items()},
    }
    return {name: array for name, array in values.items() if array is not None}


def _put(dataset: Any, index: int, values: Any) -> None:
    if len(dataset) <= index:
        dataset.resize(index + 1, axis=0)
    dataset[index] = values


def _moving(group: Any) -> list[str]:
    """Names of the elements of a group of particles that vary with time."""
    names = [name for name, one in group.items() if name != "box" and hasattr(one, "keys") and "value" in one]
    edges = group["box"].get("edges")
    return [*names, "box/edges"] if edges is not None and hasattr(edges, "keys") else names


def _moment(element: Any, name: str, index: int, otherwise: float) -> float:
    """The step or time of a frame: one each, or the spacing and an offset (H5MD's fixed intervals)."""
    dataset = element.get(name)
    if dataset is None:
        return otherwise
    if dataset.ndim:
        return float(dataset[index]) if name == "time" else int(dataset[index])
    return dataset[()] * index + dataset.attrs.get("offset", 0)  # type: ignore[no-any-return]


def _names(group: Any) -> tuple[str, ...]:
    """Names of the beads: those of the enumeration, else the numbers of the species, else X."""
    from h5py import check_enum_dtype

    species = group.get("species")
    if species is None or not hasattr(species, "dtype"):
        return ("X",) * int(group["position/value"].shape[1])
    words = check_enum_dtype(species.dtype) or {}
    known = {int(number): str(name) for name, number in words.items()}
    return tuple(known.setdefault(kind, str(kind)) for kind in species[:].tolist())
