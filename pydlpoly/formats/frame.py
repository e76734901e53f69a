"""One configuration of a trajectory, whatever file it comes from or goes to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from pydlpoly.formats.records import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Beads:
    """What a frame says of some or all of its beads.

    Attributes:
        names: species names; indices: (N,) as in the file, 1 … N where it has none.
        masses: (N,) in Da; charges: (N,) in e; displacements: (N,) in Å. NaN where the file does not give them.
        positions: (N, 3) in Å; velocities: (N, 3) in Å/ps or None; forces: (N, 3) in Da Å/ps² or None.
    """

    names: tuple[str, ...]
    indices: IntArray
    masses: FloatArray
    charges: FloatArray
    displacements: FloatArray
    positions: FloatArray
    velocities: FloatArray | None = None
    forces: FloatArray | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Frame(Beads):
    """One configuration of a trajectory, beads in the order of their indices.

    Attributes:
        step: number of the step; time, timestep: in ps, None where the file does not give them.
        level, imcon: of this frame.
        cell: (3, 3) one cell vector a row in Å; zeros where the frame has none.
        images: (N, 3) cells crossed since the start, None where the file does not give them.
        arrays: further numbers of every bead by name, (N,) each.
    """

    step: int
    time: float | None
    timestep: float | None
    level: int
    imcon: int
    cell: FloatArray
    images: IntArray | None = None
    arrays: Mapping[str, FloatArray] = field(default_factory=dict)
