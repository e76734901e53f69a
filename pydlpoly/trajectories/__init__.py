"""Trajectories in formats that other programs open: how each is written, and how frames are read back.

``FORMATS`` is the one list of them; each is a module of this package with a ``Writer`` and a ``Reader``.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from pydlpoly.errors import InputError
from pydlpoly.formats.atomic import PathLike
from pydlpoly.formats.frame import Frame
from pydlpoly.formats.records import BeadTable, Configuration
from pydlpoly.trajectories.base import Reader, Topology, Writer

__all__ = [
    "FORMATS",
    "Format",
    "Frame",
    "Reader",
    "Topology",
    "Writer",
    "bead_table_of",
    "configuration_of",
    "format_of",
    "open_reader",
    "open_writer",
    "read",
    "read_frame",
]


@dataclass(frozen=True)
class Format:
    """A trajectory format.

    Attributes:
        name: the word after ``traj_format`` and ``--to``.
        description: one phrase for the documentation.
        extension: of its files, with the point; empty for HISTORY.
        needs: the package that writes it, empty when none beside pydlpoly's own is needed.
        reads: the package that reads it.
        upright: cells are turned so that a lies along x and b in the plane of x and y; they must be right-handed.
        companion: extension of the second file that belongs to it, empty when there is none.
    """

    name: str
    description: str
    extension: str
    needs: str = ""
    reads: str = ""
    upright: bool = False
    companion: str = ""

    def files(self, stem: str) -> tuple[str, ...]:
        """Return the names of the files of a trajectory."""
        return (stem + self.extension, *([stem + self.companion] if self.companion else []))

    @property
    def can_write(self) -> bool:
        """Whether the package that writes it is installed."""
        return not self.needs or find_spec(self.needs) is not None


FORMATS: dict[str, Format] = {
    one.name: one
    for one in (
        Format("history", "DL_POLY's HISTORY", ""),
        Format("extxyz", "extended XYZ, for ASE and OVITO", ".extxyz"),
        Format("gsd", "GSD with HOOMD's schema, for HOOMD, OVITO and MDAnalysis", ".gsd", "gsd", "gsd", upright=True),
        Format("h5md", "H5MD 1.1 (HDF5), for MDAnalysis and VMD", ".h5md", "h5py", "h5py"),
        Format("dcd", "DCD with a PSF beside it, for VMD and MDAnalysis", ".dcd", "", "MDAnalysis", True, ".psf"),
    )
}
"""Every format by its name."""

_SUFFIXES = {one.extension: one for one in FORMATS.values() if one.extension} | {".h5": FORMATS["h5md"]}


def format_of(path: PathLike) -> Format | None:
    """Return the format that a file's name ends with; None for HISTORY, which has no ending, and for other files."""
    return _SUFFIXES.get(Path(path).suffix.lower())


def open_reader(path: PathLike) -> Reader:
    """Return a reader of a trajectory; files without a known ending are taken as HISTORY.

    Raises:
        InputError: the file is missing or not what its name says, or the package that reads it is.
    """
    name = os.fspath(path)
    if not Path(path).is_file():
        raise InputError("cannot be read: there is no such file; expected a trajectory", path=name)
    found = format_of(path) or FORMATS["history"]
    reader: Reader = import_module(f"pydlpoly.trajectories.{found.name}").Reader(name)
    return reader


def open_writer(
    name: str,
    path: PathLike,
    like: Frame,
    topology: Topology | None = None,
    *,
    append: bool = False,
    keep_until: int | None = None,
) -> Writer:
    """Open a trajectory for writing; see ``Writer``.

    Args:
        name: a key of ``FORMATS``.
        path: the file; a second one that belongs to it stands beside it.
        like: a frame with the beads and the kinds of numbers that all frames have; it is not written.
        topology: what the file says once.
        append: go on with an existing file; a frame that a kill cut short is dropped.
        keep_until: with ``append``, drop frames of later steps first.
    """
    module = import_module(f"pydlpoly.trajectories.{name}")
    topology = topology or Topology()
    writer: Writer = module.Writer(os.fspath(path), like, topology, append=append, keep_until=keep_until)
    return writer


def read(path: PathLike) -> Iterator[Frame]:
    """Read a trajectory of any format frame by frame; see ``open_reader``."""
    return iter(open_reader(path))


def read_frame(path: PathLike, index: int = -1) -> Frame:
    """Return one frame of a trajectory, by default the last. Raises InputError when there is no such frame."""
    return open_reader(path).frame(index)


def bead_table_of(frame: Frame, *, title: str = "", path: str = "") -> BeadTable | None:
    """Return the temperatures and concentrations of a frame's beads as the record of a BEADS file, None without any."""
    names = tuple(name for name in frame.arrays if name == "temperature" or name.startswith("concentration_"))
    if not names:
        return None
    return BeadTable(names, np.column_stack([frame.arrays[name] for name in names]), title, path=path)


def configuration_of(frame: Frame, *, title: str = "", path: str = "") -> Configuration:
    """Return a frame as the record of a CONFIG file: names, positions, cell, and velocities where there are some."""
    return Configuration(
        names=frame.names,
        positions=frame.positions,
        title=title,
        imcon=frame.imcon,
        cell=frame.cell,
        velocities=frame.velocities,
        step=frame.step,
        timestep=frame.timestep or 0.0,
        time=frame.time or 0.0,
        path=path,
    )
