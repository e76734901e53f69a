"""LAMMPS' fix rattle as a judge of constraints: one trajectory of rigid triangles that repel each other."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pydlpoly import Simulation

from ..test_constraints import CELL, MASSES, PAIRS, SIDE, deviation, waters
from .lammps_runs import run_lammps

COPIES, STEPS, TIMESTEP = 40, 200, 0.005
TIGHT = {"shake_tolerance": "1e-12 ang", "timestep": f"{TIMESTEP} internal_t", "fixed_com": "off"}


def test_trajectory_of_rigid_triangles(tmp_path: Path) -> None:
    """Both solve RATTLE's equations, LAMMPS three coupled ones at once and this code by iteration."""
    drawn = Simulation(waters(COPIES, TIGHT), seed=1, threads=1).state
    scene = waters(COPIES, TIGHT, positions=drawn.positions, velocities=drawn.velocities)
    lines = ["triangles", "", f"{3 * COPIES} atoms", "2 atom types", f"{2 * COPIES} bonds", "1 bond types"]
    lines += [f"{COPIES} angles", "1 angle types", ""]
    lines += [f"{-0.5 * CELL} {0.5 * CELL} {axis}lo {axis}hi" for axis in "xyz"]
    lines += ["", "Masses", "", f"1 {MASSES['O']}", f"2 {MASSES['H']}", "", "Atoms # molecular", ""]
    for k, (place, species) in enumerate(zip(drawn.positions, scene.beads.species, strict=True)):
        lines.append(f"{k + 1} {k // 3 + 1} {species + 1} " + " ".join(f"{x:.17g}" for x in place))
    lines += ["", "Velocities", ""]
    lines += [f"{k + 1} " + " ".join(f"{x:.17g}" for x in v) for k, v in enumerate(drawn.velocities)]
    lines += ["", "Bonds", ""]
    lines += [f"{2 * m + b} 1 {3 * m + 1} {3 * m + b + 1}" for m in range(COPIES) for b in (1, 2)]
    lines += ["", "Angles", "", *(f"{m + 1} 1 {3 * m + 2} {3 * m + 1} {3 * m + 3}" for m in range(COPIES)), ""]
    (tmp_path / "data.triangles").write_text("\n".join(lines))
    strengths = {line.split()[0] + line.split()[1]: line.split()[3] for line in PAIRS}
    script = f"""
units lj
atom_style molecular
comm_modify vel yes cutoff 3.0
newton on
bond_style harmonic
angle_style harmonic
special_bonds lj 1.0e-50 1.0e-50 1.0e-50
read_data data.triangles
pair_style dpd 0.0 1.0 34387
pair_coeff 1 1 {strengths["OO"]} 0.0
pair_coeff 1 2 {strengths["OH"]} 0.0
pair_coeff 2 2 {strengths["HH"]} 0.0
bond_coeff 1 100.0 {SIDE}
angle_coeff 1 100.0 60.0
neighbor 0.3 bin
neigh_modify every 1 delay 0 check yes
timestep {TIMESTEP}
fix 1 all nve
fix 2 all rattle 1.0e-12 500 0 b 1 a 1
thermo_style custom step pe ke
thermo_modify norm no format float %.17g
thermo {STEPS}
run {STEPS}
write_dump all custom forces.dump id xu yu zu modify format float %.17g
"""
    printed = run_lammps(tmp_path, script)
    simulation = Simulation(scene, threads=1)
    first = simulation.observe()
    assert printed.thermo[0, 2] == pytest.approx(first.energy["kinetic"], rel=1e-9)
    simulation.run(STEPS)
    last = simulation.observe()
    assert deviation(simulation) <= 1.1e-12
    assert printed.forces is not None
    moved = simulation.state.unwrapped - drawn.positions
    assert np.abs(moved).max() > 1.0
    apart = printed.forces - simulation.state.unwrapped
    assert np.abs(apart).max() < 1e-6
    # The velocities that LAMMPS prints still change the lengths: it takes that out of them later.
    assert printed.thermo[-1, 1] == pytest.approx(last.energy["pair"], rel=1e-6)
