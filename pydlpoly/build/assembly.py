"""Arrangements that molecules are placed in as they stand: layers of molecules side by side, normal to z.

A molecule in a layer begins at its first bead and goes along z. Its bonds have their lengths and the layer the density
asked for: where the bonds are longer than the distance between levels of beads, the molecules of a layer tilt together.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pydlpoly.build.molecules import MoleculeType
from pydlpoly.build.regions import Slab
from pydlpoly.errors import SceneError
from pydlpoly.formats.records import FloatArray

# Chains that hang on one bead leave it at an angle to z whose sine this is, at least, so that they do not coincide, and
# within this angle of the tilt.
_SPLAY, _FAN = 0.6, 2.0 / 3.0 * math.pi


@dataclass(frozen=True)
class Bilayer:
    """A flat membrane: two leaflets of molecules, their first beads outwards, normal to z.

    Attributes:
        molecule: a lipid, its outermost head bead first.
        area: per lipid of one leaflet.
        count: number of lipids of both leaflets together, in place of ``area``.
        centre: height of the middle plane.
    """

    molecule: MoleculeType
    area: float | None = None
    count: int | None = None
    centre: float = 0.0

    def leaflet(self, cell: FloatArray) -> int:
        """Return the number of lipids in one leaflet. Raises SceneError for numbers that make no bilayer."""
        _check_upright(cell, "a bilayer")
        name = self.molecule.name
        if (self.area is None) == (self.count is None):
            raise SceneError("a bilayer needs either the area per lipid or the number of lipids", word=name)
        if self.count is not None:
            if self.count < 2 or self.count % 2:
                raise SceneError(f"a bilayer has an even number of lipids, not {self.count}", word=name)
            return self.count // 2
        area = float(self.area or 0.0)
        number = round(float(cell[0, 0] * cell[1, 1]) / area) if area > 0.0 else 0
        if number < 1:
            raise SceneError(
                f"the area per lipid must lie above 0 and below that of the cell, not at {area:g}", word=name
            )
        return number

    def pitch(self, cell: FloatArray, density: float, longest: float) -> float:
        """Return the distance between levels of beads, at most ``longest``."""
        share = len(self.molecule.beads) * self.leaflet(cell) / (density * float(cell[0, 0] * cell[1, 1]))
        return min(longest, share / (max(levels(self.molecule)) + 1))

    def region(self, cell: FloatArray, pitch: float) -> Slab:
        """Return the slab that the membrane takes up. Raises SceneError when it does not fit the cell."""
        half = pitch * (max(levels(self.molecule)) + 1)
        slab = Slab(self.centre - half, self.centre + half)
        slab.volume(cell)
        return slab

    def place(self, cell: FloatArray, pitch: float, lengths: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Return (count, beads, 3) places, the upper leaflet first."""
        number = self.leaflet(cell)
        depth = pitch * (max(levels(self.molecule)) + 1)
        leaves = []
        for side in (1.0, -1.0):
            leaf = _leaf(self.molecule, number, cell, pitch, lengths, rng)
            leaf[:, :, 2] = self.centre + side * (depth - 0.5 * pitch + leaf[:, :, 2])
            leaves.append(leaf)
        return np.concatenate(leaves)


@dataclass(frozen=True)
class Lamella:
    """Layers of linear block copolymers that fill the whole cell, normal to z; neighbours touch with equal ends.

    Attributes:
        molecule: a chain, for example A5B5.
        periods: how often the pattern (two layers of molecules) is repeated along z.
    """

    molecule: MoleculeType
    periods: int = 1

    def per_layer(self, cell: FloatArray, density: float) -> int:
        """Return the number of molecules in one of the 2 periods layers. Raises SceneError when none fits."""
        _check_upright(cell, "a lamella")
        if self.periods < 1:
            raise SceneError(f"a lamella has at least one period, not {self.periods}", word=self.molecule.name)
        number = round(density * float(np.prod(np.diag(cell))) / (2 * self.periods * len(self.molecule.beads)))
        if number < 1:
            raise SceneError("the cell is too small for one molecule in a layer", word=self.molecule.name)
        return number

    def place(self, cell: FloatArray, density: float, lengths: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Return (count, beads, 3) places, layer after layer. Raises SceneError when the molecules do not reach."""
        number = self.per_layer(cell, density)
        thickness = float(cell[2, 2]) / (2 * self.periods)
        depth = max(levels(self.molecule)) + 1
        pitch = thickness / depth
        if len(lengths) > 1 and pitch > float(lengths[1:].min()):
            least = math.ceil(float(cell[2, 2]) / (2.0 * depth * float(lengths[1:].min())))
            message = f"the molecules do not reach through layers of {thickness:g}: at least {least} periods are needed"
            raise SceneError(message, word=self.molecule.name)
        layers = []
        for layer in range(2 * self.periods):
            leaf = _leaf(self.molecule, number, cell, pitch, lengths, rng)
            sign = 1.0 if layer % 2 else -1.0  # a leaf hangs down from its first bead
            bottom = -0.5 * float(cell[2, 2]) + thickness * layer
            leaf[:, :, 2] = bottom + (thickness if layer % 2 else 0.0) + sign * (leaf[:, :, 2] - 0.5 * pitch)
            layers.append(leaf)
        return np.concatenate(layers)


def levels(molecule: MoleculeType) -> tuple[int, ...]:
    """Return how many bonds each bead is away from the first one. Raises SceneError for rings."""
    if molecule.places is not None:
        raise SceneError("a molecule with places of its own cannot be laid out in a layer", word=molecule.name)
    depth = [0] * len(molecule.beads)
    for bead, parent in molecule.tree():
        depth[bead] = 0 if parent < 0 else depth[parent] + 1
    return tuple(depth)


def _leaf(
    molecule: MoleculeType, number: int, cell: FloatArray, pitch: float, lengths: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """Return (number, beads, 3) places of molecules that hang down from z = 0, spread evenly over the cell's area."""
    x, y, z = _hanging(molecule, pitch, lengths).T
    turn = 2.0 * math.pi * float(rng.random())
    shape = np.stack([math.cos(turn) * x - math.sin(turn) * y, math.sin(turn) * x + math.cos(turn) * y, z], axis=1)
    leaf = np.repeat(shape[None, :, :], number, axis=0)
    leaf[:, :, :2] += _spread(number, float(cell[0, 0]), float(cell[1, 1]), rng)[:, None, :]
    return leaf


def _hanging(molecule: MoleculeType, pitch: float, lengths: FloatArray) -> FloatArray:
    """Return (beads, 3) places of one molecule: each bond one level down and along x by what its length leaves."""
    tree = molecule.tree()
    children: dict[int, list[int]] = {}
    for bead, parent in tree:
        children.setdefault(parent, []).append(bead)
    places = np.zeros((len(tree), 3))
    for order, (bead, parent) in enumerate(tree):
        if parent < 0:
            continue
        length = float(lengths[order])
        side, turn = math.sqrt(max(0.0, length**2 - pitch**2)), 0.0
        siblings = children[parent]
        if len(siblings) > 1:
            side = max(side, _SPLAY * length)
            turn = _FAN * ((siblings.index(bead) + 0.5) / len(siblings) - 0.5)
        down = math.sqrt(length**2 - side**2)
        places[bead] = places[parent] + [side * math.cos(turn), side * math.sin(turn), -down]
    return places


def _spread(number: int, x: float, y: float, rng: np.random.Generator) -> FloatArray:
    """Return (number, 2) points in rows, evenly over a rectangle around the origin; rows are shifted at random."""
    rows = max(1, round(math.sqrt(number * y / x)))
    places = []
    for row in range(rows):
        inside = (row + 1) * number // rows - row * number // rows
        along = (np.arange(inside) + rng.random()) / max(inside, 1)
        places.append(np.stack([(along - 0.5) * x, np.full(inside, ((row + 0.5) / rows - 0.5) * y)], axis=1))
    return np.concatenate(places)


def _check_upright(cell: FloatArray, what: str) -> None:
    if np.any(cell != np.diag(np.diag(cell))):
        raise SceneError(f"{what} needs an orthorhombic cell")
