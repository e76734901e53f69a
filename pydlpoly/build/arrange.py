"""Where the molecules go: layers first, then what has a region or a number, then what fills the rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pydlpoly.build.amounts import Component
from pydlpoly.build.assembly import Bilayer, Lamella
from pydlpoly.build.crowd import Crowd
from pydlpoly.build.molecules import MoleculeType, circle
from pydlpoly.build.packing import Job, Packer
from pydlpoly.build.regions import Everywhere, Outside, Region
from pydlpoly.build.topology import Kind, Laws, bond_lengths, built_length, law_of
from pydlpoly.errors import SceneError
from pydlpoly.formats.records import FloatArray, IntArray

# Chains with angle laws start with no sharper turns than this, which keeps their energy small.
_TURN_OF_STIFF = 60.0
# The density that the length of bonds without one of their own is taken from when none is given: that of DPD.
_USUAL_DENSITY = 3.0


@dataclass
class Entry:
    """A kind of molecules with their number, how they are placed, and (count, beads, 3) places."""

    molecule: MoleculeType
    count: int
    how: Component | Bilayer | Lamella
    places: FloatArray = field(default_factory=lambda: np.zeros((0, 0, 3)))


class Arranger:
    """Places all molecules of a cell.

    Args:
        cell: (3, 3) cell vectors by row.
        names: of the species.
        laws: of bonds and angles by species.
        density: number density of beads, None when it is not given.
        rng: where the random numbers come from.
    """

    def __init__(
        self,
        cell: FloatArray,
        names: tuple[str, ...],
        laws: Mapping[Kind, Laws],
        density: float | None,
        rng: np.random.Generator,
    ) -> None:
        self.cell, self.names, self.laws, self.density, self.rng = cell, names, laws, density, rng
        self._crowd = Crowd(cell, np.zeros((len(names), len(names))))

    def place(self, entries: Sequence[Entry], least: FloatArray) -> None:
        """Give every entry its places: what is laid out, then what has a region or a number, then what fills.

        Args:
            entries: receive (count, beads, 3) places, molecules whole.
            least: (names, names) least distances.

        Raises:
            SceneError: there is no room, or a layer does not keep the distances.
        """
        self._crowd = Crowd(self.cell, least)
        packer = Packer(self._crowd, self.names, self.rng)
        taken: list[Region] = []
        for entry in entries:
            if not isinstance(entry.how, Component):
                taken += self._lay_out(entry)
            elif entry.how.fill and entry.how.region is not None:
                taken.append(entry.how.region)
        drawn = [(entry, entry.how) for entry in entries if isinstance(entry.how, Component)]
        drawn.sort(key=lambda both: both[1].fill and both[1].region is None)
        for entry, how in drawn:
            region: Region = how.region if how.region is not None else Everywhere()
            if how.region is None and how.fill and taken:
                region = Outside(tuple(taken))
            entry.places = packer.place(self._job(entry, how, region))

    def _lay_out(self, entry: Entry) -> list[Region]:
        """Place the molecules of layers; return the region that they keep for themselves."""
        lengths = bond_lengths(entry.molecule, self.laws["bonds"], self._spacing())
        regions: list[Region] = []
        if isinstance(entry.how, Bilayer):
            longest = float(lengths[1:].min(initial=self._spacing()))
            pitch = entry.how.pitch(self.cell, needed_density(self.density, entry.molecule), longest)
            regions.append(entry.how.region(self.cell, pitch))
            entry.places = entry.how.place(self.cell, pitch, lengths, self.rng)
        elif isinstance(entry.how, Lamella):
            entry.places = entry.how.place(self.cell, needed_density(self.density, entry.molecule), lengths, self.rng)
        beads, kinds = entry.places.reshape(-1, 3), np.tile(self._kinds(entry.molecule), entry.count)
        self._check_layer(entry, kinds, self._crowd.conflicts(beads, kinds))
        numbers = self._crowd.add(beads, kinds)
        rows, others, ratios = self._crowd.conflicts(beads, kinds)
        size = len(entry.molecule.beads)
        apart = rows // size != (others - numbers[0]) // size
        self._check_layer(entry, kinds, (rows[apart], others[apart], ratios[apart]))
        return regions

    def _check_layer(self, entry: Entry, kinds: IntArray, found: tuple[IntArray, IntArray, FloatArray]) -> None:
        rows, others, ratios = found
        if not len(ratios):
            return
        worst = int(ratios.argmin())
        first, second = int(kinds[rows[worst]]), int(self._crowd.kinds(others[worst : worst + 1])[0])
        least = float(self._crowd.least[first, second])
        message = f"in this layer beads {self.names[first]} and {self.names[second]} come as close as "
        message += f"{ratios[worst] * least:.3g}, and the least distance asked for is {least:.5g}"
        raise SceneError(message, word=entry.molecule.name)

    def _kinds(self, molecule: MoleculeType) -> IntArray:
        return np.array([self.names.index(name) for name in molecule.beads], dtype=np.int64)

    def _job(self, entry: Entry, how: Component, region: Region) -> Job:
        if how.shape not in (None, "grown", "rigid"):
            raise SceneError("a shape is grown or rigid", path=entry.molecule.name, word=str(how.shape))
        molecule, kinds, turn = entry.molecule, self._kinds(entry.molecule), self._turn(how, entry.molecule)
        if molecule.places is not None or molecule.closed:
            if how.shape == "grown":
                message = "rings and molecules with places of their own cannot be grown; they are rigid"
                raise SceneError(message, word=molecule.name)
            return Job(self._circle(molecule), entry.count, kinds, np.zeros(0), region, turn)
        lengths = bond_lengths(molecule, self.laws["bonds"], self._spacing())
        if how.shape == "rigid":
            alone = Packer(Crowd(self.cell, self._crowd.least), self.names, self.rng)
            walk = alone.place(Job(molecule, 1, kinds, lengths, Everywhere(), turn))[0]
            molecule = replace(molecule, places=tuple((x, y, z) for x, y, z in walk.tolist()))
        return Job(molecule, entry.count, kinds, lengths, region, turn)

    def _circle(self, molecule: MoleculeType) -> MoleculeType:
        """Return a ring with the places of a circle."""
        if molecule.places is not None:
            return molecule
        ends = [tuple(molecule.beads[k] for k in bond) for bond in molecule.bonds]
        lengths = {built_length(pair, self.laws["bonds"], molecule.name, self._spacing()) for pair in ends}
        if len(lengths) > 1:
            raise SceneError("a ring of bonds of unlike lengths needs places", word=molecule.name)
        return replace(molecule, places=circle(len(molecule.beads), lengths.pop()))

    def _turn(self, how: Component, molecule: MoleculeType) -> float:
        turn = how.turn
        if turn is None:
            threes = {tuple(molecule.beads[k] for k in beads) for beads in molecule.angles}
            stiff = any(law_of("angles", three, self.laws["angles"], molecule.name) for three in threes)
            turn = _TURN_OF_STIFF if stiff else 180.0
        if not 0.0 <= turn <= 180.0:
            raise SceneError(f"a turn lies between 0 and 180 degrees, not at {turn:g}", word=molecule.name)
        return float(np.deg2rad(turn))

    def _spacing(self) -> float:
        """Return the mean distance of beads, the length of bonds without one of their own."""
        return float((1.0 / (self.density or _USUAL_DENSITY)) ** (1.0 / 3.0))


def needed_density(density: float | None, molecule: MoleculeType) -> float:
    """Return the density that a layer needs. Raises SceneError when there is none."""
    if density is None:
        raise SceneError("a layer needs the number density", word=molecule.name)
    return density
