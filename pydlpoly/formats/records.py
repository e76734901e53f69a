"""What the readers return: frozen records in the files' own words and units, with the line each thing came from.

Records decide nothing: a number stays as written until ``pydlpoly.scene`` gives it a unit and a meaning. Line numbers
and paths do not take part in comparisons, so that reading, writing and reading again yields an equal record.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

SettingValue = bool | int | float | str | tuple[float, ...]


@dataclass(frozen=True)
class Remark:
    """Something a reader noticed that is no warning: a choice it had to make, or words without effect."""

    kind: Literal["choice", "ignored", "warning"]
    text: str
    line: int = 0


@dataclass(frozen=True)
class MesoControl:
    """What a CONTROL in DL_MESO's dialect says that no keyword of DL_POLY's can hold; lengths in its length unit.

    Attributes:
        edges: the box's edges from ``volume``, or None; ``volume_line`` is where they stand.
        without_config: ``no config``: beads are placed although there is a CONFIG.
        corner_origin: ``config origin``: CONFIG's coordinates count from the box's corner, not from its centre.
        cutoff: ``cutoff``, the range of all drags and of laws without one of their own; None where it is not given.
        drag_cutoff: ``thermostat cutoff``, the range of all drags where it differs; None where it is not given.
        charge_cutoff: ``electrostatic cutoff``, or None.
    """

    edges: tuple[float, float, float] | None = None
    volume_line: int = field(default=0, compare=False)
    without_config: bool = False
    corner_origin: bool = False
    cutoff: float | None = None
    drag_cutoff: float | None = None
    charge_cutoff: float | None = None


@dataclass(frozen=True)
class MesoField:
    """What a FIELD in DL_MESO's dialect says that no record of DL_POLY's can hold.

    Attributes:
        coordinates: for each molecule type of ``Field.molecules`` the places of its beads, for a start without CONFIG.
        mirrored: for each molecule type whether copies may be mirrored (without ``no isomer``).
        loose: number of beads outside molecules; they come first in CONFIG, in any order.
        thermal: ``units kt``: energies are in k_B T; ``units_line`` says where.
    """

    coordinates: tuple[tuple[tuple[float, float, float], ...], ...]
    mirrored: tuple[bool, ...]
    loose: int = 0
    thermal: bool = False
    units_line: int = field(default=0, compare=False)


@dataclass(frozen=True)
class Setting:
    """One keyword of CONTROL with its value, under the new-style name whatever style the file has.

    Attributes:
        keyword: canonical new-style keyword, lower case.
        value: bool for switches, int or float for numbers, str for options and strings, tuple for vectors.
        unit: the unit word as written, or None where the kind has none.
        line: line in the file, 0 when the setting was made by a program.
    """

    keyword: str
    value: SettingValue
    unit: str | None = None
    line: int = field(default=0, compare=False)


@dataclass(frozen=True)
class Control:
    """A CONTROL file: its title and its settings in file order (each keyword at most once).

    A file in DL_MESO's dialect has its settings under the new-style keywords too, and ``meso`` for the rest.
    """

    title: str = ""
    settings: tuple[Setting, ...] = ()
    style: Literal["new", "old"] = "new"
    path: str = field(default="CONTROL", compare=False)
    warnings: tuple[str, ...] = field(default=(), compare=False)
    remarks: tuple[Remark, ...] = field(default=(), compare=False)
    meso: MesoControl | None = None

    def get(self, keyword: str) -> Setting | None:
        """Return the setting of this keyword, or None when the file does not give it."""
        return next((s for s in self.settings if s.keyword == keyword), None)

    def __iter__(self) -> Iterator[Setting]:
        """Iterate over the settings in file order."""
        return iter(self.settings)


@dataclass(frozen=True)
class AtomLine:
    """One line of an ``atoms`` block: ``repeat`` beads of one species in a row."""

    name: str
    mass: float
    charge: float = 0.0
    repeat: int = 1
    frozen: int = 0
    line: int = field(default=0, compare=False)


@dataclass(frozen=True)
class BondedLine:
    """One line of a bonded block: a law's key, the 1-based local bead numbers, and the numbers that follow.

    ``constraints`` have the key ``""`` and the length as their parameter; ``teth`` has one bead number; ``rigid`` units
    have the key ``""`` and no parameters.
    """

    key: str
    beads: tuple[int, ...]
    parameters: tuple[float, ...] = ()
    line: int = field(default=0, compare=False)


@dataclass(frozen=True)
class MoleculeBlock:
    """One bonded block of a molecule, for example ``bonds`` (canonical directive name) and its lines in order."""

    directive: Literal["shells", "constraints", "pmf", "rigid", "tethers", "bonds", "angles", "dihedrals", "inversions"]
    lines: tuple[BondedLine, ...]
    line: int = field(default=0, compare=False)


@dataclass(frozen=True)
class Molecule:
    """One molecule type: its name, how many copies there are, its atom lines and its bonded blocks in file order."""

    name: str
    count: int
    atoms: tuple[AtomLine, ...]
    blocks: tuple[MoleculeBlock, ...] = ()
    line: int = field(default=0, compare=False)

    @property
    def beads_per_molecule(self) -> int:
        """Number of beads in one copy."""
        return sum(atom.repeat for atom in self.atoms)

    @property
    def bead_names(self) -> tuple[str, ...]:
        """Species of the beads of one copy, with the repeats of the atom lines written out."""
        return tuple(atom.name for atom in self.atoms for _ in range(atom.repeat))

    def block(self, directive: str) -> MoleculeBlock | None:
        """Return the block of this name, or None."""
        return next((b for b in self.blocks if b.directive == directive), None)


@dataclass(frozen=True)
class PairLine:
    """One line of the ``vdw`` block: two species, the law's key (first four letters, lower case) and all numbers."""

    species: tuple[str, str]
    key: str
    parameters: tuple[float, ...]
    line: int = field(default=0, compare=False)


@dataclass(frozen=True)
class ExternalLine:
    """The record of the ``extern`` block: the field's key (lower case) and its numbers."""

    key: str
    parameters: tuple[float, ...]
    line: int = field(default=0, compare=False)


@dataclass(frozen=True)
class OtherBlock:
    """A block that is read whole but has no record of its own (metal, tersoff, tbp, fbp, crd, kim_init, …)."""

    directive: str
    lines: tuple[str, ...]
    line: int = field(default=0, compare=False)


@dataclass(frozen=True)
class Extension:
    """A block after ``close``, where DL_POLY stops reading: its name and its lines with their numbers, comments gone.

    Two are equal when their texts are, wherever they stand.
    """

    name: str
    lines: tuple[tuple[int, str], ...]
    line: int = field(default=0, compare=False)

    def __eq__(self, other: object) -> bool:
        """Compare names and texts."""
        if not isinstance(other, Extension):
            return NotImplemented
        return self.name == other.name and [t for _, t in self.lines] == [t for _, t in other.lines]

    def __hash__(self) -> int:
        """Hash of name and texts."""
        return hash((self.name, tuple(text for _, text in self.lines)))


@dataclass(frozen=True)
class Field:
    """A FIELD file, in DL_POLY's words; one in DL_MESO's dialect has ``meso`` for what they cannot say.

    Attributes:
        units: the energy unit's word in canonical form: ``ev``, ``kcal``, ``kj``, ``k``, ``internal`` or ``dpd``.
        rdf_pairs: pairs named in an ``rdf`` block, in order; empty when there is none.
        extensions: blocks after ``close``, which DL_POLY does not read.
    """

    title: str = ""
    units: str = "internal"
    molecules: tuple[Molecule, ...] = ()
    pairs: tuple[PairLine, ...] = ()
    externals: tuple[ExternalLine, ...] = ()
    rdf_pairs: tuple[tuple[str, str], ...] = ()
    others: tuple[OtherBlock, ...] = ()
    path: str = field(default="FIELD", compare=False)
    warnings: tuple[str, ...] = field(default=(), compare=False)
    remarks: tuple[Remark, ...] = field(default=(), compare=False)
    meso: MesoField | None = None
    extensions: tuple[Extension, ...] = ()

    @property
    def bead_count(self) -> int:
        """Total number of beads that the molecules add up to."""
        return sum(m.count * m.beads_per_molecule for m in self.molecules)


@dataclass(frozen=True, eq=False)
class Configuration:
    """A CONFIG or REVCON file: names, positions and, by level, velocities and forces, in the order of the bead indices.

    Attributes:
        imcon: DL_POLY's periodicity key (0 none, 1 cubic, 2 orthorhombic, 3 parallelepiped, 6 slab in x and y).
        names: species names, one a bead.
        positions: (N, 3) in Å (FIELD ``units dpd``: in the DPD length unit), as in the file, not wrapped.
        velocities: (N, 3) in Å/ps, or None at level 0.
        forces: (N, 3) in Da Å/ps², or None below level 2.
        cell: (3, 3), one cell vector a row; zeros when imcon is 0 and the file has none.
        step, timestep, time: numbers of line 2 when it carries them (as REVCON does), else 0.
    """

    names: tuple[str, ...]
    positions: FloatArray
    title: str = ""
    imcon: int = 0
    cell: FloatArray = field(default_factory=lambda: np.zeros((3, 3)))
    velocities: FloatArray | None = None
    forces: FloatArray | None = None
    step: int = 0
    timestep: float = 0.0
    time: float = 0.0
    path: str = "CONFIG"
    warnings: tuple[str, ...] = ()
    remarks: tuple[Remark, ...] = ()

    @property
    def level(self) -> int:
        """DL_POLY's levcfg: 0 positions, 1 and velocities, 2 and forces."""
        return 0 if self.velocities is None else 1 if self.forces is None else 2

    def __eq__(self, other: object) -> bool:
        """Compare everything but path and warnings."""
        if not isinstance(other, Configuration):
            return NotImplemented
        return (
            (self.names, self.title, self.imcon, self.step, self.timestep, self.time)
            == (other.names, other.title, other.imcon, other.step, other.timestep, other.time)
            and np.array_equal(self.positions, other.positions)
            and np.array_equal(self.cell, other.cell)
            and _same(self.velocities, other.velocities)
            and _same(self.forces, other.forces)
        )

    __hash__ = None  # type: ignore[assignment]  # arrays are not hashable


@dataclass(frozen=True, eq=False)
class PairTable:
    """One pair of a TABLE file: U and G = −r dU/dr at r = delta, 2 delta, …, in FIELD energy units."""

    species: tuple[str, str]
    spacing: float
    cutoff: float
    energy: FloatArray
    virial: FloatArray
    path: str = "TABLE"
    line: int = 0


@dataclass(frozen=True, eq=False)
class BondedTable:
    """One block of TABBND, TABANG, TABDIH or TABINV: U and dU/dx at regular nodes, in FIELD energy units.

    Attributes:
        kind: "bond", "angle", "dihedral" or "inversion".
        species: as the file has them, one name a bead.
        start, spacing: node k lies at x = start + k spacing; Å, degrees for angles.
        energy, slope: (n,) U and dU/dx, per Å or per degree.
    """

    kind: str
    species: tuple[str, ...]
    start: float
    spacing: float
    energy: FloatArray
    slope: FloatArray
    path: str = "TABBND"
    line: int = 0


@dataclass(frozen=True, eq=False)
class BeadTable:
    """A BEADS file: what beads carry beside position and velocity, in the order of the bead indices.

    Attributes:
        names: of the columns, "temperature" or "concentration_" and the name of a dissolved species.
        values: (N, columns), temperatures in K (reduced numbers with FIELD's ``units dpd``).
        rows: (N,) where in its source each bead stands, from 0; None when the beads stand in order.
        first_line: line of the first bead in the file, 0 when the table was made by a program.
    """

    names: tuple[str, ...]
    values: FloatArray
    title: str = ""
    rows: IntArray | None = None
    path: str = "BEADS"
    first_line: int = 0

    def place_of(self, bead: int) -> tuple[int, int | None]:
        """Return the number that the source gives to a bead counted from 0, and its line if there are lines."""
        row = bead if self.rows is None else int(self.rows[bead])
        return (bead + 1, self.first_line + row) if self.first_line else (row + 1, None)

    def __eq__(self, other: object) -> bool:
        """Compare title, names and values."""
        if not isinstance(other, BeadTable):
            return NotImplemented
        same = (self.title, self.names) == (other.title, other.names)
        return same and np.array_equal(self.values, other.values)

    __hash__ = None  # type: ignore[assignment]  # arrays are not hashable


def _same(a: FloatArray | None, b: FloatArray | None) -> bool:
    if a is None or b is None:
        return a is b
    return np.array_equal(a, b)
