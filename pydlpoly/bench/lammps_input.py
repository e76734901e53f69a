"""A scene in LAMMPS's words: the commands that make the same box and pair laws, and the ways to run them fast."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pydlpoly.scene.model import PairTerm, Scene

SKINS = (0.1, 0.2, 0.3, 0.4)
_CHECKED = "neigh_modify delay 0 every 1 check yes"
_VARIANTS = {"dpd": ("dpd", "dpd/omp"), "lj/cut": ("lj/cut", "lj/cut/opt", "lj/cut/omp")}


@dataclass(frozen=True)
class LammpsInput:
    """Commands for LAMMPS.

    Attributes:
        box: up to the box and its number of species; the beads are created after them.
        dynamics: after the beads, up to the first step, without pair style and neighbour list.
        pairs: by pair style: the commands that set it up.
        neighbours: ways to build the neighbour list, by name; all rebuild it before a bead has moved too far.
    """

    box: list[str]
    dynamics: list[str]
    pairs: dict[str, list[str]]
    neighbours: dict[str, list[str]]


def lammps_input(scene: Scene) -> LammpsInput | str:
    """Return the commands, or in words why the scene is not translated."""
    if not scene.units.reduced or not all(scene.periodic) or scene.external or scene.beads.frozen.any():
        return "only periodic scenes in reduced units without external fields or frozen beads are translated"
    if scene.beads.molecule.max() + 1 != scene.bead_count:
        return "bonded terms are not translated"
    if np.any(np.triu(scene.cell, 1) != 0.0):
        return "the cell is not lower triangular"
    laws = {term.law for term in scene.pairs}
    if laws == {"dpd"} and all(term.drag_cutoff == term.cutoff for term in scene.pairs if term.drag > 0.0):
        return _dpd(scene)
    if laws == {"lj"} and not any(term.drag > 0.0 or term.force_shift for term in scene.pairs):
        return _lennard_jones(scene)
    return f"the pair laws {', '.join(sorted(str(law) for law in laws))} are not translated"


def _dpd(scene: Scene) -> LammpsInput | str:
    if scene.dynamics.integrator == "nve" or scene.dynamics.prediction != 0.5:
        return "only DPD with lambda 1/2 is translated"
    largest = max(term.cutoff for term in scene.pairs)
    coefficients = [f"{_types(term)} {term.parameters[0]} {term.drag} {term.cutoff}" for term in scene.pairs]
    settings = f"{scene.dynamics.thermal_energy} {largest} 34387"
    return _input(scene, "dpd", settings, coefficients, {})


def _lennard_jones(scene: Scene) -> LammpsInput | str:
    if scene.dynamics.integrator != "nve":
        return "only nve is translated for lj"
    largest = max(term.cutoff for term in scene.pairs)
    coefficients = [f"{_types(t)} {t.parameters[0]} {t.parameters[1]} {t.cutoff}" for t in scene.pairs]
    # The list of LAMMPS' own Lennard-Jones benchmark: rebuilt every 20 steps without looking.
    usual = {"skin 0.3 every 20": ["neighbor 0.3 bin", "neigh_modify delay 0 every 20 check no"]}
    return _input(scene, "lj/cut", str(largest), coefficients, usual)


def _types(term: PairTerm) -> str:
    low, high = sorted(term.species)
    return f"{low + 1} {high + 1}"


def _input(
    scene: Scene, style: str, settings: str, coefficients: Sequence[str], more: dict[str, list[str]]
) -> LammpsInput:
    low = -0.5 * scene.cell.sum(axis=0)
    bounds = " ".join(f"{low[k]:.17g} {low[k] + scene.cell[k, k]:.17g}" for k in range(3))
    tilt = (scene.cell[1, 0], scene.cell[2, 0], scene.cell[2, 1])
    region = f"prism {bounds} {' '.join(f'{t:.17g}' for t in tilt)}" if any(tilt) else f"block {bounds}"
    masses = [f"mass {k + 1} {scene.beads.mass[scene.beads.species == k][0]:.17g}" for k in range(len(scene.species))]
    return LammpsInput(
        box=[
            "units lj",
            "atom_style atomic",
            "newton on",
            "comm_modify vel yes",
            "box tilt large",
            f"region cell {region}",
            f"create_box {len(scene.species)} cell",
            *masses,
        ],
        dynamics=[f"timestep {scene.dynamics.timestep}", "fix motion all nve", "thermo 100"],
        pairs={
            name: [
                f"pair_style {name} {settings}",
                *(f"pair_coeff {line}" for line in coefficients),
            ]
            for name in _VARIANTS[style]
        },
        neighbours={f"skin {skin}": [f"neighbor {skin} bin", _CHECKED] for skin in SKINS} | more,
    )
