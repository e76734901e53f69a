"""LAMMPS as a judge of electrostatics: smeared charges in a soft fluid, point charges, excluded pairs, other cells.

LAMMPS in units lj takes q = z sqrt(Bjerrum length · kT).
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from pydlpoly import Scene, single_point
from pydlpoly.formats.records import FloatArray
from pydlpoly.units import galamost_charge

from ..molecule_builder import chains, molecule_scene
from ..scene_builder import NVE, make_scene
from .lammps_runs import Printed, run_lammps

BJERRUM = 1.1
CELLS = {
    "orthorhombic": np.diag([6.0, 5.5, 6.3]),
    "triclinic": np.array([[6.0, 0, 0], [1.7, 5.5, 0], [-1.2, 2.1, 6.3]]),
}
CHARGES = {"P": 1.0, "M": -1.0, "W": 0.0}
BEADS = {"P": 60, "M": 60, "W": 200}
PRECISE = {
    "coul_method": "spme",
    "coul_bjerrum_length": f"{BJERRUM} ang",
    "cutoff": "2.5 ang",
    "spme_precision": "1e-8",
    "spme_nsplines": "10",
}


def write_charged(path: Path, scene: Scene, bonds: FloatArray | None = None) -> None:
    """Write a data file for atom_style full."""
    cell, beads = scene.cell, scene.beads
    low = -0.5 * cell.sum(axis=0)
    lines = ["charges", "", f"{len(beads)} atoms", f"{len(scene.species)} atom types"]
    lines += [f"{len(bonds)} bonds", "1 bond types"] if bonds is not None else []
    lines += [f"{low[k]:.17g} {low[k] + cell[k, k]:.17g} {axis}lo {axis}hi" for k, axis in enumerate("xyz")]
    if np.any(np.tril(cell, -1)):
        lines.append(f"{cell[1, 0]:.17g} {cell[2, 0]:.17g} {cell[2, 1]:.17g} xy xz yz")
    lines += ["", "Masses", "", *(f"{k} 1.0" for k in range(1, len(scene.species) + 1)), "", "Atoms # full", ""]
    for k, place in enumerate(beads.positions):
        charge = galamost_charge(float(beads.charge[k]), BJERRUM)
        words = f"{k + 1} {beads.molecule[k] + 1} {beads.species[k] + 1} {charge:.17g}"
        lines.append(words + "".join(f" {x:.17g}" for x in place))
    if bonds is not None:
        lines += ["", "Bonds", "", *(f"{k} 1 {int(i) + 1} {int(j) + 1}" for k, (i, j) in enumerate(bonds, 1))]
    path.write_text("\n".join([*lines, ""]))


def lammps_point(folder: Path, scene: Scene, styles: str, kspace: str, bonds: FloatArray | None = None) -> Printed:
    write_charged(folder / "data.charges", scene, bonds)
    script = f"""
units lj
atom_style full
comm_modify vel yes cutoff 3.2
newton on
box tilt large
{"bond_style zero" if bonds is not None else ""}
special_bonds lj 1.0e-50 1.0 1.0 coul 1.0e-50 1.0 1.0
read_data data.charges
{styles}
{"bond_coeff 1" if bonds is not None else ""}
kspace_style {kspace}
neighbor 0.3 bin
velocity all set 0.0 0.0 0.0
thermo_style custom step evdwl ecoul elong press pxx pyy pzz pxy pxz pyz
thermo_modify norm no format float %.17g
fix 1 all nve
dump 1 all custom 1 forces.dump id fx fy fz
dump_modify 1 format float %.17g
run 0
"""
    return run_lammps(folder, script)


def assert_same(scene: Scene, printed: Printed, error: float) -> None:
    point = single_point(scene)
    assert printed.forces is not None
    assert np.abs(point.forces - printed.forces).max() <= error * np.abs(printed.forces).max()
    evdwl, ecoul, elong = printed.thermo[0, 1:4]
    assert point.energy["charge"] == pytest.approx(ecoul + elong, abs=error * (abs(ecoul) + abs(elong)))
    assert point.energy["pair"] == pytest.approx(evdwl, rel=1e-9)
    xx, yy, zz, xy, xz, yz = printed.thermo[0, 5:11]
    stress = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    assert np.abs(point.stress - stress).max() <= 3.0 * error * np.abs(stress).max()


@pytest.mark.parametrize("kspace", ["ewald 1.0e-8", "pppm 1.0e-7"])
@pytest.mark.parametrize("cell", CELLS)
def test_slater_charges_in_a_soft_fluid(tmp_path: Path, cell: str, kspace: str) -> None:
    names = list(BEADS)
    pairs = [f"{a} {b} dpd 25.0 1.0" for k, a in enumerate(names) for b in names[k:]]
    scene = make_scene(
        BEADS,
        pairs,
        cell=CELLS[cell],
        charges=CHARGES,
        control={**NVE, **PRECISE, "charge_smearing_method": "slater", "charge_smearing_length": "0.9 ang"},
    )
    coefficients = []
    for k, a in enumerate(names):
        for j in range(k, 3):
            charged = "yes" if CHARGES[a] and CHARGES[names[j]] else "no"
            coefficients.append(f"pair_coeff {k + 1} {j + 1} 25.0 4.5 {charged}")
    styles = "\n".join(["pair_style dpd/coul/slater/long 0.0 1.0 34387 0.9 2.5", *coefficients])
    assert_same(scene, lammps_point(tmp_path, scene, styles, kspace), 1e-5)


@pytest.mark.parametrize("cell", CELLS)
def test_point_charges_with_excluded_bonds(tmp_path: Path, cell: str) -> None:
    positions = chains(60, 2, CELLS[cell], seed=5, step=0.8)
    scene = molecule_scene(
        "PM",
        {"bonds": ["harm 1 2 0.0 0.8"]},
        positions,
        copies=60,
        cell=CELLS[cell],
        charges=(1.0, -1.0),
        control=PRECISE,
    )
    bonds = np.arange(120).reshape(60, 2)
    styles = "pair_style coul/long 2.5\npair_modify table 0\npair_coeff * *"
    assert_same(scene, lammps_point(tmp_path, scene, styles, "ewald 1.0e-8", bonds), 1e-6)


def test_damped_shifted_charges(tmp_path: Path) -> None:
    """LAMMPS's coul/dsf has DL_POLY's damped force shift, and a self energy −(e_shift/2 + α/√π) Σq² besides."""
    scene = make_scene(
        {"P": 60, "M": 60},
        (),
        cell=6.0,
        charges=CHARGES,
        control={
            **NVE,
            "coul_method": "force_shifted",
            "coul_damping": "0.7 ang^-1",
            "coul_bjerrum_length": f"{BJERRUM} ang",
            "cutoff": "2.5 ang",
        },
    )
    printed = lammps_point(tmp_path, scene, "pair_style coul/dsf 0.7 2.5\npair_coeff * *", "none")
    point = single_point(scene)
    assert printed.forces is not None
    assert np.abs(point.forces - printed.forces).max() <= 1e-6 * np.abs(printed.forces).max()
    end = math.erfc(0.7 * 2.5) / 2.5
    force = end / 2.5 + 1.4 / math.sqrt(math.pi) * math.exp(-((0.7 * 2.5) ** 2)) / 2.5
    self_energy = -(0.5 * (end + 2.5 * force) + 0.7 / math.sqrt(math.pi)) * 120 * BJERRUM
    assert point.energy["charge"] + self_energy == pytest.approx(printed.thermo[0, 2], rel=1e-5)
