"""A scene in LAMMPS's words: the commands that make the same box and pair laws, and the ways to run them fast."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pydlpoly.bench.lammps_carried import CarriedCommands, heat_commands, many_body_commands, species_commands
from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.model import Bonded, PairTerm, Scene

SKINS = (0.1, 0.2, 0.3, 0.4)
_CHECKED = "neigh_modify delay 0 every 1 check yes"
_BONDED = {("bond", "harm"): "harmonic", ("angle", "hcos"): "cosine/squared"}
_SECTIONS = {"bond": "Bonds", "angle": "Angles"}
_VARIANTS = {
    "dpd": ("dpd", "dpd/omp"),
    "lj/cut": ("lj/cut", "lj/cut/opt", "lj/cut/omp"),
}


@dataclass(frozen=True)
class MoleculeData:
    """A data file of ``atom_style molecular`` but for the beads' places and velocities.

    Attributes:
        header: the box and the masses.
        terms: rows of type and beads, counted from 1, by section ("Bonds", "Angles").
        molecules: (N,) number of each bead's molecule.
    """

    header: tuple[list[str], list[str]]
    terms: dict[str, list[tuple[int, ...]]]
    molecules: NDArray[np.integer]

    def text(self, positions: FloatArray, velocities: FloatArray, types: NDArray[np.int32]) -> str:
        """Return the file with these beads; positions and velocities (N, 3), types counted from 1."""
        box, masses = self.header
        counts = [f"{len(types)} atoms", f"{len(masses)} atom types"]
        for name, rows in self.terms.items():
            counts += [f"{len(rows)} {name.lower()}", f"{max(row[0] for row in rows)} {name.lower()[:-1]} types"]
        beads = zip(self.molecules, types, positions.tolist(), strict=True)
        sections = {
            "Masses": masses,
            "Atoms # molecular": [f"{k} {m + 1} {t} {x!r} {y!r} {z!r}" for k, (m, t, (x, y, z)) in enumerate(beads, 1)],
            "Velocities": [f"{k} {x!r} {y!r} {z!r}" for k, (x, y, z) in enumerate(velocities.tolist(), 1)],
        }
        for name, rows in self.terms.items():
            sections[name] = [f"{k} {' '.join(map(str, row))}" for k, row in enumerate(rows, 1)]
        lines = ["beads and their bonded terms", "", *counts, *box]
        for name, content in sections.items():
            lines += ["", name, "", *content]
        return "\n".join([*lines, ""])


@dataclass(frozen=True)
class LammpsInput:
    """Commands for LAMMPS.

    Attributes:
        box: up to the box and its number of species; the beads are created after them, or read from a data file.
        dynamics: after the beads, up to the first step, without pair style and neighbour list.
        pairs: by pair style: the commands that set it up.
        neighbours: ways to build the neighbour list, by name; all rebuild it before a bead has moved too far.
        data: of scenes with bonded terms, which LAMMPS takes from a data file only.
    """

    box: list[str]
    dynamics: list[str]
    pairs: dict[str, list[str]]
    neighbours: dict[str, list[str]]
    data: MoleculeData | None = None


def lammps_input(scene: Scene) -> LammpsInput | str:
    """Return the commands, or in words why the scene is not translated."""
    if not scene.units.reduced or not all(scene.periodic) or scene.external or scene.beads.frozen.any():
        return "only periodic scenes in reduced units without external fields or frozen beads are translated"
    if scene.dynamics.barostat is not None:
        return "a cell that moves is not translated"
    if scene.dynamics.shear_rate != 0.0:
        return "a sheared cell is not translated"
    if scene.electrostatics is not None:
        return "electrostatics are not translated"
    if scene.bonded is not None and (reason := _not_translated(scene.bonded)):
        return reason
    if np.any(np.triu(scene.cell, 1) != 0.0):
        return "the cell is not lower triangular"
    if scene.heat is not None:
        return _carried(scene, heat_commands(scene, scene.heat))
    laws = {term.law for term in scene.pairs}
    if laws == {"dpd"} and all(term.drag_cutoff == term.cutoff for term in scene.pairs if term.drag > 0.0):
        return _dpd(scene)
    if laws == {"lj"} and not any(term.drag > 0.0 or term.force_shift for term in scene.pairs):
        return _lennard_jones(scene)
    if laws == {"mdpd"}:
        return _carried(scene, many_body_commands(scene, scene.many_body))
    return f"the pair laws {', '.join(sorted(str(law) for law in laws))} are not translated"


def _dpd(scene: Scene) -> LammpsInput | str:
    if scene.dynamics.integrator != "mdvv" or scene.dynamics.prediction != 0.5:
        return "only DPD with lambda 1/2 is translated"
    if scene.transport is not None:
        return _carried(scene, species_commands(scene, scene.transport))
    largest = max(term.cutoff for term in scene.pairs)
    coefficients = [f"{_types(term)} {term.parameters[0]} {term.drag} {term.cutoff}" for term in scene.pairs]
    settings = f"{scene.dynamics.thermal_energy} {largest} 34387"
    return _input(scene, "dpd", settings, coefficients, {})


def _carried(scene: Scene, commands: CarriedCommands | str) -> LammpsInput | str:
    """Return the input of a scene whose beads carry something, as ``lammps_carried`` has it."""
    if isinstance(commands, str):
        return commands
    plain = _input(scene, "", "", [], {})
    kind, where = commands.atom_style, "atom_style atomic"
    timestep, motion, *rest = plain.dynamics
    return replace(
        plain,
        box=[f"atom_style {kind}" if line == where else line for line in plain.box],
        dynamics=[timestep, *commands.states, motion.replace("nve", commands.motion), *rest],
        pairs={kind.split()[0]: commands.pairs},
    )


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
    ends = [(f"{low[k]:.17g}", f"{low[k] + scene.cell[k, k]:.17g}") for k in range(3)]
    tilt = [f"{t:.17g}" for t in (scene.cell[1, 0], scene.cell[2, 0], scene.cell[2, 1])]
    skewed = any(float(t) for t in tilt)
    masses = [f"{k + 1} {scene.beads.mass[scene.beads.species == k][0]:.17g}" for k in range(len(scene.species))]
    box = ["units lj", f"atom_style {'atomic' if scene.bonded is None else 'molecular'}", "newton on"]
    box += ["comm_modify vel yes", "box tilt large"]
    dynamics = [f"timestep {scene.dynamics.timestep}", "fix motion all nve", "thermo 100"]
    data = None
    if scene.bonded is None:
        bounds = " ".join(f"{start} {end}" for start, end in ends)
        region = f"prism {bounds} {' '.join(tilt)}" if skewed else f"block {bounds}"
        box += [f"region cell {region}", f"create_box {len(scene.species)} cell", *(f"mass {m}" for m in masses)]
    else:
        header = [f"{start} {end} {axis}lo {axis}hi" for (start, end), axis in zip(ends, "xyz", strict=True)]
        header += [f"{' '.join(tilt)} xy xz yz"] if skewed else []
        terms, styles, constants = _bonded(scene.bonded)
        box += [*styles, "special_bonds lj 1.0 1.0 1.0"]
        dynamics += constants
        data = MoleculeData((header, masses), terms, scene.beads.molecule)
    return LammpsInput(
        box=box,
        dynamics=dynamics,
        pairs={
            name: [
                f"pair_style {name} {settings}",
                *(f"pair_coeff {line}" for line in coefficients),
            ]
            for name in _VARIANTS.get(style, ())
        },
        neighbours={f"skin {skin}": [f"neighbor {skin} bin", _CHECKED] for skin in SKINS} | more,
        data=data,
    )


def _not_translated(bonded: Bonded) -> str:
    """Return in words what LAMMPS is not given, or nothing."""
    for term in bonded.terms:
        if (term.kind, term.law) not in _BONDED:
            return f"the {term.kind} law {term.law} is not translated"
    return "pairs that bonds exclude are not translated" if len(bonded.excluded) else ""


def _bonded(bonded: Bonded) -> tuple[dict[str, list[tuple[int, ...]]], list[str], list[str]]:
    """Return the rows of the data file by section, the commands that choose the styles and those with the numbers."""
    rows: dict[str, list[tuple[int, ...]]] = {}
    styles: list[str] = []
    constants: list[str] = []
    types = dict.fromkeys(_SECTIONS, 0)
    for term in bonded.terms:
        types[term.kind] += 1
        style = f"{term.kind}_style {_BONDED[term.kind, term.law]}"
        if style not in styles:
            styles.append(style)
        strength, rest = term.parameters
        # DL_POLY has half the strength in front of the square. Angles rest at degrees in LAMMPS.
        rest = float(np.degrees(rest)) if term.kind == "angle" else rest
        constants.append(f"{term.kind}_coeff {types[term.kind]} {0.5 * strength:.17g} {rest:.17g}")
        rows.setdefault(_SECTIONS[term.kind], []).extend(
            (types[term.kind], *(int(bead) + 1 for bead in beads)) for beads in term.beads
        )
    return rows, styles, constants
