"""What every trajectory format has: a writer of frames, a reader of frames, and what stays the same in all of them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from itertools import islice
from typing import Any

import numpy as np

from pydlpoly.errors import InputError
from pydlpoly.formats.atomic import Closing
from pydlpoly.formats.frame import Frame
from pydlpoly.formats.history_sample import HistorySample, chosen
from pydlpoly.formats.records import IntArray

LINKS = ("bond", "angle", "dihedral", "inversion")
"""Kinds of groups of beads, of 2, 3, 4 and 4 beads."""


@dataclass(frozen=True, eq=False)
class Links:
    """Groups of beads that a bonded law holds together.

    Attributes:
        names: what the groups are called, one name a kind of group.
        kinds: (n,) index into ``names``.
        beads: (n, k) ids from 0, in the order of the law.
    """

    names: tuple[str, ...]
    kinds: IntArray
    beads: IntArray


@dataclass(frozen=True, eq=False)
class Topology:
    """What a trajectory says once.

    Attributes:
        title: of the run.
        reduced: the numbers are in reduced units, not in Å, ps, Da and e.
        molecules: (N,) running number of the molecule of each bead, None where it is not known.
        links: groups of beads by kind, a key of ``LINKS``.
    """

    title: str = ""
    reduced: bool = False
    molecules: IntArray | None = None
    links: Mapping[str, Links] = field(default_factory=dict)


class Writer(Closing, ABC):
    """A trajectory that grows frame by frame. After a kill every finished frame can be read, and more can follow.

    Constructors take the file's path, a frame ``like`` those that will be written (its beads, level, periodicity and
    names of arrays; it is not written), a ``Topology``, and as keywords ``append``, to go on with an existing file,
    and ``keep_until``, to drop its frames of later steps first. They raise InputError where the format cannot hold
    such frames or the file is another one's, and RunError where it cannot be written.
    """

    def __init__(self, path: str, like: Frame) -> None:
        self.path = path
        self._like = like

    @abstractmethod
    def write(self, frame: Frame) -> None:
        """Append one frame. Raises InputError when it differs from the first in beads or in what it holds."""

    def accepts(self, step: int) -> None:  # most formats take any step
        """Raise InputError when the next frame cannot be of this step."""

    @abstractmethod
    def sync(self) -> None:
        """Wait until all frames are on the disk."""

    @abstractmethod
    def close(self) -> None:
        """Close the file; closing twice is harmless."""

    def check(self, frame: Frame) -> None:
        """Raise InputError for a frame that differs from the first in beads, periodicity or what it holds."""
        like = self._like
        same_beads = (frame.names is like.names or frame.names == like.names) and all(
            np.array_equal(one, other, equal_nan=True)
            for one, other in ((frame.masses, like.masses), (frame.charges, like.charges))
        )
        if not same_beads:
            raise InputError(f"the frame of step {frame.step} has other beads than the first", path=self.path)
        if frame.imcon != like.imcon:
            message = f"the frame of step {frame.step} has imcon {frame.imcon}, the first has {like.imcon}"
            raise InputError(message, path=self.path)
        held, expected = (sorted([*what_is_there(one), *one.arrays]) for one in (frame, like))
        if held != expected:
            words = [", ".join(one) or "positions alone" for one in (held, expected)]
            message = f"the frame of step {frame.step} holds {words[0]}, the first {words[1]}"
            raise InputError(message, path=self.path)


class Reader(ABC):
    """The frames of a trajectory, read when they are asked for, and its ``topology``."""

    topology: Topology = Topology()

    def __init__(self, path: str) -> None:
        self.path = path

    @abstractmethod
    def __iter__(self) -> Iterator[Frame]:
        """Iterate over the frames from the first on. Raises InputError where the file is not what it should be."""

    def frame(self, index: int) -> Frame:
        """Return one frame; −1 is the last. Raises InputError when there is no such frame."""
        if index >= 0:
            found = list(islice(iter(self), index, index + 1))
        else:
            last = deque(self, maxlen=-index)
            found = [last[0]] if len(last) == -index else []
        if not found:
            raise self.missing(index)
        return found[0]

    @abstractmethod
    def sample(self, most: int) -> HistorySample:
        """Return at most so many frames at equal distances, the last one among them; only these are held in memory.

        Raises InputError where the file is not what it should be.
        """

    def missing(self, index: int) -> InputError:
        """Return the error of a frame that is not there."""
        return InputError("there is no such frame", path=self.path, word=str(index))


class CountedReader(Reader):
    """A reader that knows the number of frames and reads any of them at once."""

    @abstractmethod
    def __len__(self) -> int:
        """Return the number of whole frames."""

    @abstractmethod
    def at(self, index: int) -> Frame:
        """Return the frame of this number, from 0 on."""

    def __iter__(self) -> Iterator[Frame]:
        """Iterate over the frames."""
        return (self.at(index) for index in range(len(self)))

    def left_out(self) -> str:
        """Return what of the file's end is no whole frame, in words; empty when nothing is."""
        return ""

    def sample(self, most: int) -> HistorySample:
        """Return at most so many frames at equal distances, the last one among them."""
        count = len(self)
        return HistorySample(tuple(self.at(index) for index in chosen(count, most)), count, self.left_out())

    def frame(self, index: int) -> Frame:
        """Return one frame; −1 is the last. Raises InputError when there is no such frame."""
        count = len(self)
        if not -count <= index < count:
            raise self.missing(index)
        return self.at(index % count)


def what_is_there(frame: Frame) -> tuple[str, ...]:
    """Return which of the numbers that not all frames have a frame holds."""
    names = ("time", "timestep", "velocities", "forces", "images")
    given = {name: getattr(frame, name) for name in names}
    return tuple(name for name, array in given.items() if array is not None)


def known(values: Any) -> bool:
    """Whether a frame's masses, charges or displacements are given."""
    return not bool(np.isnan(values).any())


def package(name: str, user: str, install: str = "pydlpoly[trajectories]") -> Any:
    """Import a package that is not always there. Raises InputError that says how to install it."""
    try:
        return import_module(name)
    except ImportError:
        message = f"{user} needs the package {name.split('.')[0]}: pip install '{install}'"
        raise InputError(message) from None


def imcon_of(cell: Any, periodic: tuple[bool, bool, bool]) -> int:
    """Return DL_POLY's periodicity key of a cell; InputError for a periodicity it has no key for."""
    if periodic == (False, False, False):
        return 0
    if periodic == (True, True, False):
        return 6
    if periodic != (True, True, True):
        axes = " ".join("FT"[on] for on in periodic)
        raise InputError(f"periodicity along {axes} has no imcon; only none, all three, or the first two")
    edges = np.diag(cell)
    if np.any(cell != np.diag(edges)):
        return 3
    return 1 if edges[0] == edges[1] == edges[2] else 2


PERIODIC = {0: (False, False, False), 6: (True, True, False)}
"""Periodicity along the cell vectors by imcon; all three for those not named."""


def periodic_of(imcon: int) -> tuple[bool, bool, bool]:
    """Return along which cell vectors a frame of this imcon is periodic."""
    return PERIODIC.get(imcon, (True, True, True))


def named_links(beads: Any, kinds_of_beads: tuple[Any, Any]) -> Links:
    """Return groups named after their beads' species, A-B.

    Args:
        beads: (n, k) ids from 0.
        kinds_of_beads: names of the species, and (N,) index into them.
    """
    species, of_bead = kinds_of_beads
    rows, kinds = np.unique(np.asarray(of_bead)[beads], axis=0, return_inverse=True)
    names = tuple("-".join(str(species[k]) for k in row) for row in rows.tolist())
    return Links(names, np.ravel(kinds).astype(np.int64), np.asarray(beads, dtype=np.int64))
