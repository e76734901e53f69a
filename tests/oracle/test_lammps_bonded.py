"""LAMMPS as a judge of bonds, angles and dihedrals with the pair forces they exclude."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from pydlpoly import Scene, single_point
from pydlpoly.formats.records import FloatArray

from ..molecule_builder import chains, molecule_scene
from .lammps_runs import Printed, run_lammps

EXACT = 1e-10
COPIES, LENGTH = 50, 5
PAIRS = ("H H dpd 25.0 1.0", "H T dpd 50.0 1.0", "T T dpd 25.0 1.0")
CELLS = {
    "orthorhombic": np.diag([6.0, 5.5, 6.3]),
    "triclinic": np.array([[6.0, 0, 0], [1.7, 5.5, 0], [-1.2, 2.1, 6.3]]),
}
BONDS = [f"harm {k} {k + 1} 64.0 0.5" for k in range(1, LENGTH)]
ANGLES = [f"harm {k} {k + 1} {k + 2} 12.0 140.0" for k in range(1, LENGTH - 1)]


def write_molecules(path: Path, scene: Scene, terms: dict[str, NDArray[np.int32]]) -> None:
    """Write a data file for atom_style molecular; one type of each term."""
    cell, beads = scene.cell, scene.beads
    low = -0.5 * cell.sum(axis=0)
    counts = [f"{len(beads)} atoms", f"{len(scene.species)} atom types"]
    counts += [f"{len(rows)} {name.lower()}\n1 {name.lower()[:-1]} types" for name, rows in terms.items()]
    box = [f"{low[k]:.17g} {low[k] + cell[k, k]:.17g} {axis}lo {axis}hi" for k, axis in enumerate("xyz")]
    if np.any(np.tril(cell, -1)):
        box.append(f"{cell[1, 0]:.17g} {cell[2, 0]:.17g} {cell[2, 1]:.17g} xy xz yz")
    atoms = [
        f"{k} {m + 1} {s + 1} " + " ".join(f"{x:.17g}" for x in place)
        for k, (m, s, place) in enumerate(zip(beads.molecule, beads.species, beads.positions, strict=True), 1)
    ]
    lines = [
        "molecules",
        "",
        *counts,
        "",
        *box,
        "",
        "Masses",
        "",
        "1 1.0",
        "2 1.0",
        "",
        "Atoms # molecular",
        "",
        *atoms,
    ]
    for name, rows in terms.items():
        lines += ["", name, "", *(f"{k} 1 " + " ".join(map(str, row + 1)) for k, row in enumerate(rows, 1))]
    path.write_text("\n".join([*lines, ""]))


def lammps_point(folder: Path, scene: Scene, terms: dict[str, NDArray[np.int32]], styles: str) -> Printed:
    write_molecules(folder / "data.molecules", scene, terms)
    script = f"""
units lj
atom_style molecular
comm_modify vel yes cutoff 3.0
newton on
box tilt large
{styles}
read_data data.molecules
pair_style dpd 0.0 1.0 34387
pair_coeff 1 1 25.0 4.5
pair_coeff 1 2 50.0 4.5
pair_coeff 2 2 25.0 4.5
include coefficients
neighbor 0.3 bin
velocity all set 0.0 0.0 0.0
thermo_style custom step evdwl ebond eangle edihed press pxx pyy pzz pxy pxz pyz
thermo_modify norm no format float %.17g
fix 1 all nve
dump 1 all custom 1 forces.dump id fx fy fz
dump_modify 1 format float %.17g
run 0
"""
    return run_lammps(folder, script)


def beads_of(scene: Scene, kind: str) -> NDArray[np.int32]:
    assert scene.bonded is not None
    return np.concatenate([term.beads for term in scene.bonded.terms if term.kind == kind])


def assert_same(scene: Scene, printed: Printed) -> None:
    point = single_point(scene)
    assert printed.forces is not None
    assert np.abs(point.forces - printed.forces).max() <= EXACT * np.abs(printed.forces).max()
    for kind, value in zip(("pair", "bond", "angle", "dihedral"), printed.thermo[0, 1:5], strict=True):
        assert point.energy[kind] == pytest.approx(value, rel=EXACT), kind
    xx, yy, zz, xy, xz, yz = printed.thermo[0, 6:12]
    stress = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    assert np.abs(point.stress - stress).max() <= EXACT * np.abs(stress).max()


def places(cell: FloatArray) -> FloatArray:
    return chains(COPIES, LENGTH, cell, seed=11)


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("restraint", [False, True], ids=["excluded", "restraints"])
def test_harmonic_bonds_and_angles(tmp_path: Path, cell: str, restraint: bool) -> None:
    bonds, angles = ([line.replace("harm", "-hrm") if restraint else line for line in rows] for rows in (BONDS, ANGLES))
    blocks = {"bonds": bonds, "angles": angles}
    scene = molecule_scene("HTTTT", blocks, places(CELLS[cell]), copies=COPIES, pairs=PAIRS, cell=CELLS[cell])
    special = "1.0 1.0 1.0" if restraint else "1.0e-50 1.0e-50 1.0"
    (tmp_path / "coefficients").write_text("bond_coeff 1 32.0 0.5\nangle_coeff 1 6.0 140.0\n")
    styles = f"bond_style harmonic\nangle_style harmonic\nspecial_bonds lj {special}"
    terms = {"Bonds": beads_of(scene, "bond"), "Angles": beads_of(scene, "angle")}
    assert_same(scene, lammps_point(tmp_path, scene, terms, styles))


def test_opls_dihedrals_with_scaled_pairs(tmp_path: Path) -> None:
    cell = CELLS["orthorhombic"]
    dihedrals = [f"opls {k} {k + 1} {k + 2} {k + 3} 0.0 3.0 -1.0 0.0 0.4 2.0 0.0" for k in range(1, LENGTH - 2)]
    blocks = {"bonds": BONDS, "angles": ANGLES, "dihedrals": dihedrals}
    scene = molecule_scene("HTTTT", blocks, places(cell), copies=COPIES, pairs=PAIRS, cell=cell)
    coefficients = "bond_coeff 1 32.0 0.5\nangle_coeff 1 6.0 140.0\ndihedral_coeff 1 3.0 -1.0 2.0 0.0\n"
    (tmp_path / "coefficients").write_text(coefficients)
    styles = "bond_style harmonic\nangle_style harmonic\ndihedral_style opls\nspecial_bonds lj 1.0e-50 1.0e-50 0.4"
    names = {"Bonds": "bond", "Angles": "angle", "Dihedrals": "dihedral"}
    terms = {name: beads_of(scene, kind) for name, kind in names.items()}
    assert_same(scene, lammps_point(tmp_path, scene, terms, styles))


def test_fene_bonds(tmp_path: Path) -> None:
    """bond_style fene/expand without its Lennard-Jones part; the pairs keep their forces."""
    cell = CELLS["orthorhombic"]
    bonds = [f"-fne {k} {k + 1} 30.0 1.5 0.1" for k in range(1, LENGTH)]
    scene = molecule_scene("HTTTT", {"bonds": bonds}, places(cell), copies=COPIES, pairs=PAIRS, cell=cell)
    (tmp_path / "coefficients").write_text("bond_coeff 1 30.0 1.5 0.0 1.0 0.1\n")
    styles = "bond_style fene/expand\nspecial_bonds lj 1.0 1.0 1.0"
    assert_same(scene, lammps_point(tmp_path, scene, {"Bonds": beads_of(scene, "bond")}, styles))
