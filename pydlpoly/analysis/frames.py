"""What analyses read: frames of a trajectory, one after the other, or of arrays.

An analysis takes frames one at a time, so that several share one pass over a file and no trajectory is held in memory.
"""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pydlpoly.errors import InputError
from pydlpoly.formats.atomic import PathLike
from pydlpoly.formats.blocks import BlockSums, standard_error
from pydlpoly.formats.history_reader import Frame
from pydlpoly.formats.records import FloatArray
from pydlpoly.trajectories import read

Source = PathLike | Iterable[Frame]
"""A trajectory in any format, or frames from elsewhere (``frames_of_arrays``, ``molecule_centres``, a list)."""

Result = TypeVar("Result", covariant=True)
_IMCON = {(True, True, True): 3, (True, True, False): 6, (False, False, False): 0}


class Analysis(ABC, Generic[Result]):
    """A quantity that is collected frame by frame."""

    @abstractmethod
    def add(self, frame: Frame) -> None:
        """Take one frame. Raises InputError when it lacks what the quantity needs."""

    @abstractmethod
    def result(self) -> Result:
        """Return the quantity over all frames so far. Raises InputError when there were too few."""

    def of(self, source: Source, *, start: int = 0, every: int = 1) -> Result:
        """Return the quantity of a trajectory or of frames, from frame ``start`` on, every so many."""
        analyse(source, self, start=start, every=every)
        return self.result()


def analyse(source: Source, *analyses: Analysis[Any], start: int = 0, every: int = 1) -> int:
    """Show every frame to each of the analyses in one pass, and return how many frames there were.

    Args:
        source: a trajectory in any format, or frames.
        analyses: what to collect; ask each for its ``result()`` afterwards.
        start: number of frames to leave out at the beginning.
        every: take every so many of the rest.
    """
    if start < 0 or every < 1:
        raise InputError(f"frames are taken from 0 or later and every 1 or more, not from {start} every {every}")
    count = 0
    for frame in islice(frames_of(source), start, None, every):
        for one in analyses:
            one.add(frame)
        count += 1
    return count


def frames_of(source: Source) -> Iterator[Frame]:
    """Return the frames of a trajectory in any format, or those given."""
    return read(source) if isinstance(source, (str, os.PathLike)) else iter(source)


def frames_of_arrays(
    positions: ArrayLike,
    cell: ArrayLike | None = None,
    *,
    species: str | Sequence[str] = "A",
    velocities: ArrayLike | None = None,
    masses: ArrayLike | None = None,
    times: ArrayLike | None = None,
    periodic: tuple[bool, bool, bool] | None = None,
) -> Iterator[Frame]:
    """Return frames made of arrays.

    Args:
        positions: (N, 3) or (frames, N, 3) in Å; need not lie inside the cell.
        cell: an edge, three edges, (3, 3) vectors by row, or (frames, 3, 3), in Å; None: nothing is periodic.
        species: one name for all beads, or (N,) names.
        velocities: shaped as the positions, in Å/ps.
        masses: (N,) in Da, 1 by default.
        times: (frames,) in ps, by default 0, 1, 2, …
        periodic: along which cell vectors; all (the default), the first two, or none.

    Raises:
        InputError: the shapes do not belong together.
    """
    places = np.asarray(positions, dtype=np.float64)
    places = places[None] if places.ndim == 2 else places
    if places.ndim != 3 or places.shape[2] != 3:
        raise InputError(f"positions must be (N, 3) or (frames, N, 3), not {np.shape(positions)}")
    count, beads, _ = places.shape
    moving = None if velocities is None else np.asarray(velocities, dtype=np.float64)
    if moving is not None and moving.size != places.size:
        raise InputError(f"velocities must be shaped as the positions, not {moving.shape}")
    axes = periodic if periodic is not None else (cell is not None,) * 3
    if axes not in _IMCON:
        raise InputError(f"a cell is periodic along all vectors, the first two, or none, not {axes}")
    cells = _cells(cell, count)
    names = (species,) * beads if isinstance(species, str) else tuple(species)
    weights = np.ones(beads) if masses is None else np.asarray(masses, dtype=np.float64)
    moments = np.arange(count, dtype=np.float64) if times is None else np.asarray(times, dtype=np.float64)
    if len(names) != beads or weights.shape != (beads,) or moments.shape != (count,):
        raise InputError(f"expected names and masses of {beads} beads and times of {count} frames")
    moving = None if moving is None else moving.reshape(places.shape)
    nothing = np.zeros(beads)
    for k in range(count):
        yield Frame(
            step=k,
            time=float(moments[k]),
            timestep=None,
            level=0 if moving is None else 1,
            imcon=_IMCON[axes],
            cell=cells[k],
            names=names,
            indices=np.arange(1, beads + 1),
            masses=weights,
            charges=nothing,
            displacements=nothing,
            positions=places[k],
            velocities=None if moving is None else moving[k],
        )


def _cells(cell: ArrayLike | None, count: int) -> FloatArray:
    given = np.zeros((3, 3)) if cell is None else np.asarray(cell, dtype=np.float64)
    if given.ndim < 2:
        given = np.diag(np.broadcast_to(given, 3))
    if given.shape[-2:] != (3, 3) or given.ndim > 3:
        raise InputError(f"a cell is an edge, three edges, (3, 3) or (frames, 3, 3), not {given.shape}")
    return np.asarray(np.broadcast_to(given, (count, 3, 3)))


# What analyses ask of a frame


def periodic_axes(frame: Frame) -> tuple[bool, bool, bool]:
    """Return along which cell vectors a frame is periodic."""
    return frame.imcon != 0, frame.imcon != 0, frame.imcon not in (0, 6)


def fully_periodic(frame: Frame) -> float:
    """Return the cell's volume, Å³. Raises InputError when the frame is not periodic along all three vectors."""
    if not all(periodic_axes(frame)):
        raise InputError(f"a cell that is periodic along all vectors is needed, not imcon {frame.imcon}")
    return abs(float(np.linalg.det(frame.cell)))


def widths(cell: FloatArray) -> FloatArray:
    """Return the distances between opposite faces of a cell, (3,) in Å."""
    return np.asarray(1.0 / np.linalg.norm(np.linalg.inv(cell), axis=0))


def minimum_image(vectors: FloatArray, frame: Frame) -> FloatArray:
    """Return vectors (..., 3) between beads by the nearest image; right for all shorter than half the cell's width."""
    axes = list(periodic_axes(frame))
    if not any(axes):
        return vectors
    shifts = np.round(vectors @ _inverse(frame))
    shifts[..., ~np.array(axes)] = 0.0
    return np.asarray(vectors - shifts @ frame.cell)


def fractional(positions: FloatArray, frame: Frame) -> FloatArray:
    """Return fractional coordinates, (N, 3), from −1/2 up to 1/2 along periodic vectors."""
    places = positions @ _inverse(frame)
    axes = np.array(periodic_axes(frame))
    places[:, axes] -= np.floor(places[:, axes] + 0.5)
    return places


def _inverse(frame: Frame) -> FloatArray:
    try:
        return np.asarray(np.linalg.inv(frame.cell))
    except np.linalg.LinAlgError:
        raise InputError(f"the cell of step {frame.step} has no volume") from None


def velocities_of(frame: Frame) -> FloatArray:
    """Return the velocities. Raises InputError when the frame has none."""
    if frame.velocities is None:
        raise InputError("the frames have no velocities; traj_key pos-vel writes them")
    return frame.velocities


def masses_of(frame: Frame) -> FloatArray:
    """Return the masses, (N,); 1 for all where the frame does not give positive ones."""
    known = np.isfinite(frame.masses) & (frame.masses > 0.0)
    return frame.masses if bool(known.all()) else np.ones(len(frame.masses))


def time_of(frame: Frame) -> float:
    """Return the time in ps. Raises InputError when the frame does not say it."""
    if frame.time is not None:
        return frame.time
    if frame.timestep is None:
        raise InputError("the frames do not say their time; give frames with times")
    return frame.step * frame.timestep


def beads_of(frame: Frame, species: str) -> NDArray[np.int64]:
    """Return the ids of the beads of a species. Raises InputError when there are none, with the names there are."""
    found = np.flatnonzero(np.array(frame.names, dtype=object) == species)
    if not len(found):
        there = ", ".join(dict.fromkeys(frame.names))
        raise InputError(f"there are no beads of this species; there are {there}", word=species)
    return found


class Mean:
    """Averages of arrays over frames, with errors from blocks of frames (``pydlpoly.formats.blocks``)."""

    def __init__(self) -> None:
        """Start without samples."""
        self._sums: BlockSums | None = None
        self._shape: tuple[int, ...] = ()

    def add(self, values: ArrayLike) -> None:
        """Take one sample; all have the shape of the first."""
        sample = np.asarray(values, dtype=np.float64)
        if self._sums is None:
            self._sums, self._shape = BlockSums(max(sample.size, 1)), sample.shape
        if sample.shape != self._shape:
            raise InputError(f"the frames differ in what they hold: {sample.shape} after {self._shape}")
        self._sums.add(sample.ravel())

    @property
    def taken(self) -> int:
        """Number of samples."""
        return 0 if self._sums is None else self._sums.taken

    @property
    def value(self) -> FloatArray:
        """The mean, shaped as a sample. Raises InputError without samples."""
        return self._held().mean().reshape(self._shape)

    @property
    def error(self) -> FloatArray:
        """The standard error of the mean, shaped as a sample; not a number for fewer than four samples."""
        blocks = self._held().means()
        return np.array([standard_error(column) for column in blocks.T]).reshape(self._shape)

    def _held(self) -> BlockSums:
        if self._sums is None:
            raise InputError("there are no frames to analyse")
        return self._sums
