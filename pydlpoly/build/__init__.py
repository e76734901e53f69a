"""Makes configurations: where beads and molecules stand at the start, and whole scenes from species and molecules.

Nothing here imports ``pydlpoly.scene`` when it is imported itself: the scene uses parts of this package.
"""

from __future__ import annotations

from pydlpoly.build.amounts import Component, Salt
from pydlpoly.build.assembly import Bilayer, Lamella
from pydlpoly.build.molecules import MoleculeType, Species, bead, chain, comb, graph, lipid, ring, star
from pydlpoly.build.regions import Cylinder, Everywhere, Outside, Region, Slab, Sphere
from pydlpoly.build.system import Built, build

__all__ = [
    "Bilayer",
    "Built",
    "Component",
    "Cylinder",
    "Everywhere",
    "Lamella",
    "MoleculeType",
    "Outside",
    "Region",
    "Salt",
    "Slab",
    "Species",
    "Sphere",
    "bead",
    "build",
    "chain",
    "comb",
    "graph",
    "lipid",
    "ring",
    "star",
]
