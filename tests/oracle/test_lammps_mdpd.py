"""LAMMPS as a judge of many-body DPD with Lucy's kernel: densities, forces and pressure of given configurations."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike

from pydlpoly import Scene, single_point
from pydlpoly.engines.native import NativeEngine
from pydlpoly.formats.records import FloatArray

from ..scene_builder import NVE, make_scene
from .lammps_runs import Printed, run_lammps, write_data

LUCY = NVE | {"mdpd_kernel": "lucy", "cutoff": "1.2 ang"}


def lammps_point(folder: Path, scene: Scene, coefficients: Sequence[str]) -> tuple[Printed, FloatArray]:
    """Thermo (energy, pressure), forces and densities at rest; coefficients are ``1 1 A B γ rc rd``."""
    beads = scene.beads
    write_data(folder / "data.beads", scene.cell, beads.positions, beads.species, [1.0] * len(scene.species))
    rho = [f"pair_coeff {c.split()[0]} {c.split()[1]} mdpd/rhosum {c.split()[-1]}" for c in coefficients]
    force = [f"pair_coeff {c.split()[0]} {c.split()[1]} mdpd {' '.join(c.split()[2:])}" for c in coefficients]
    # The data file's column of densities comes before the places in atom_style mdpd; they are computed anew.
    text = (folder / "data.beads").read_text().split("Atoms # atomic")
    rows = [line.split() for line in text[1].splitlines() if line.strip()]
    lines = [f"{k} {kind} 0.0 {x} {y} {z}" for k, kind, x, y, z in rows]
    (folder / "data.beads").write_text("\n".join([text[0] + "Atoms # mdpd", "", *lines, ""]))
    script = f"""
units lj
atom_style mdpd
comm_modify vel yes cutoff 1.6
newton on
box tilt large
read_data data.beads
pair_style hybrid/overlay mdpd/rhosum mdpd 0.0 1.2 9872598
{chr(10).join(rho)}
{chr(10).join(force)}
neighbor 0.3 bin
velocity all set 0.0 0.0 0.0
compute rho all property/atom rho
compute pressure all pressure NULL virial
thermo_style custom step pe c_pressure c_pressure[1] c_pressure[2] c_pressure[3] c_pressure[4]
thermo_modify norm no format float %.17g
fix 1 all mvv/dpd 0.5
dump 1 all custom 1 forces.dump id fx fy fz c_rho
dump_modify 1 format float %.17g
run 0
"""
    printed = run_lammps(folder, script)
    table = (folder / "forces.dump").read_text().splitlines()
    start = next(k for k, line in enumerate(table) if line.startswith("ITEM: ATOMS")) + 1
    rows = np.array([[float(word) for word in line.split()] for line in table[start:]])
    return printed, rows[np.argsort(rows[:, 0])][:, 4]


@pytest.mark.parametrize(
    "cell", [[6.0, 5.5, 6.3], [[6.0, 0, 0], [1.7, 5.5, 0], [-1.2, 2.1, 6.3]]], ids=["orthorhombic", "triclinic"]
)
@pytest.mark.parametrize("species", [1, 2])
def test_densities_and_forces(tmp_path: Path, cell: ArrayLike, species: int) -> None:
    """Densities to 1e-12 and forces to 1e-10 of the largest; A, rc and, with two species, rd differ by pair."""
    if species == 1:
        beads, lines, coefficients = {"A": 900}, ["A A mdpd -40 25 1 0.75 18"], ["1 1 -40 25 18 1 0.75"]
    else:
        beads = {"A": 500, "B": 420}
        lines = ["A A mdpd -40 25 1 0.75 18", "A B mdpd -20 25 0.9 0.6 18", "B B mdpd -10 25 1.2 0.9 18"]
        coefficients = ["1 1 -40 25 18 1 0.75", "1 2 -20 25 18 0.9 0.6", "2 2 -10 25 18 1.2 0.9"]
    scene = make_scene(beads, lines, cell=cell, control=LUCY, start_seed=5)
    printed, rho = lammps_point(tmp_path, scene, coefficients)
    engine = NativeEngine(scene, seed=0, threads=1)
    engine.initialise()
    assert rho.max() > 5.0
    assert np.abs(engine.local_densities() - rho).max() <= 1e-12 * rho.max()
    point = single_point(scene)
    assert printed.forces is not None
    assert np.abs(point.forces - printed.forces).max() <= 1e-10 * np.abs(printed.forces).max()
    pressure = printed.thermo[0, 2]
    assert point.stress.trace() / 3.0 == pytest.approx(pressure, rel=1e-10)
    assert np.diag(point.stress) == pytest.approx(printed.thermo[0, 3:6], rel=1e-10)


def test_warren_kernel_is_another_fluid(tmp_path: Path) -> None:
    """The same configuration with the default kernel has other densities: 15/(2π) against 105/(16π) at contact."""
    lines = ["A A mdpd -40 25 1 0.75 18"]
    places = [[0.0, 0.0, 0.0], [0.01, 0.0, 0.0]]
    scenes = [make_scene({"A": 2}, lines, cell=6.0, positions=places, control=control) for control in (LUCY, NVE)]
    found = []
    for scene in scenes:
        engine = NativeEngine(scene, seed=0, threads=1)
        engine.initialise()
        found.append(engine.local_densities()[0] * 0.75**3)
    _, rho = lammps_point(tmp_path, scenes[0], ["1 1 -40 25 18 1 0.75"])
    assert found[0] == pytest.approx(rho[0] * 0.75**3, rel=1e-12)
    assert found == pytest.approx([105.0 / (16.0 * math.pi), 15.0 / (2.0 * math.pi)], rel=0.03)
