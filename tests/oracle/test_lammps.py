"""LAMMPS as a judge: forces, energies and pressures of given configurations, and the statistics of DPD water."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike

from pydlpoly import Scene, Simulation, single_point

from ..scene_builder import NVE, make_scene
from .lammps_runs import Printed, run_lammps, write_data

EXACT = 1e-10  # of the largest force; LAMMPS prints 17 digits here
TRICLINIC = [[6.0, 0.0, 0.0], [1.7, 5.5, 0.0], [-1.2, 2.1, 6.3]]


def lammps_point(folder: Path, scene: Scene, pair_lines: Sequence[str], cutoff: float) -> Printed:
    """Energy, pressure and forces of the scene's configuration with beads at rest, in LAMMPS's units lj (k_B = 1)."""
    beads = scene.beads
    masses = [float(beads.mass[beads.species == kind][0]) for kind in range(len(scene.species))]
    write_data(folder / "data.beads", scene.cell, beads.positions, beads.species, masses)
    script = f"""
units lj
atom_style atomic
atom_modify map array
comm_modify vel yes cutoff {cutoff + 0.4}
newton on
box tilt large
read_data data.beads
{chr(10).join(pair_lines)}
neighbor 0.3 bin
velocity all set 0.0 0.0 0.0
thermo_style custom step pe press pxx pyy pzz pxy pxz pyz
thermo_modify norm no format float %.17g
fix 1 all nve
dump 1 all custom 1 forces.dump id fx fy fz
dump_modify 1 format float %.17g
run 0
"""
    return run_lammps(folder, script)


def assert_same_point(scene: Scene, printed: Printed) -> None:
    point = single_point(scene)
    assert printed.forces is not None
    largest = np.abs(printed.forces).max()
    assert largest > 1.0
    assert np.abs(point.forces - printed.forces).max() <= EXACT * largest
    energy, pressure = printed.thermo[0, 1:3]
    assert point.energy["pair"] == pytest.approx(energy, rel=EXACT)
    assert point.stress.trace() / 3.0 == pytest.approx(pressure, rel=EXACT)
    xx, yy, zz, xy, xz, yz = printed.thermo[0, 3:9]
    stress = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    assert np.abs(point.stress - stress).max() <= EXACT * np.abs(stress).max()


@pytest.mark.parametrize("cell", [[6.0, 5.5, 6.3], TRICLINIC], ids=["orthorhombic", "triclinic"])
def test_forces_of_a_dpd_mixture(tmp_path: Path, cell: ArrayLike) -> None:
    lines = ["A A dpd 25.0 1.0 4.5", "A B dpd 41.3 0.8 4.5", "B B dpd 17.9 1.3 4.5"]
    scene = make_scene(
        {"A": 330, "B": 290}, lines, cell=cell, masses={"A": 1.0, "B": 2.0}, control={"cutoff": "1.3 ang"}, start_seed=5
    )
    # At T = 0 and at rest, drag and noise of pair_style dpd vanish.
    pairs = ["pair_style dpd 0.0 1.3 34387", "pair_coeff 1 1 25.0 4.5 1.0", "pair_coeff 1 2 41.3 4.5 0.8"]
    assert_same_point(scene, lammps_point(tmp_path, scene, [*pairs, "pair_coeff 2 2 17.9 4.5 1.3"], 1.3))


@pytest.mark.parametrize("shifted", [False, True], ids=["cut", "force shifted"])
@pytest.mark.parametrize(
    "cell", [[6.9, 6.9, 6.9], [[6.9, 0, 0], [2.3, 6.9, 0], [-2.3, 1.15, 6.9]]], ids=["cube", "tilted"]
)
def test_forces_of_a_lennard_jones_mixture(tmp_path: Path, cell: ArrayLike, shifted: bool) -> None:
    vectors = np.array(cell, dtype=float) if np.ndim(cell) == 2 else np.diag(np.array(cell, dtype=float))
    places = (np.stack(np.meshgrid(*[np.arange(6)] * 3), axis=-1).reshape(-1, 3) - 2.5) / 6.0
    rng = np.random.default_rng(8)
    positions = rng.permutation(places @ vectors + 0.2 * (rng.random((216, 3)) - 0.5))
    lines = ["A A lj 1.0 1.0", "A B lj 0.7 1.1", "B B lj 1.4 0.9"]
    options = {"vdw_force_shift": "on"} if shifted else {"vdw_long_range_correction": "off"}
    scene = make_scene(
        {"A": 120, "B": 96}, lines, cell=vectors, positions=positions, control={**NVE, "cutoff": "2.5 ang", **options}
    )
    style = "lj/smooth/linear" if shifted else "lj/cut"
    pairs = [f"pair_style {style} 2.5", "pair_coeff 1 1 1.0 1.0", "pair_coeff 1 2 0.7 1.1", "pair_coeff 2 2 1.4 0.9"]
    assert_same_point(scene, lammps_point(tmp_path, scene, pairs, 2.5))


def test_long_range_correction(tmp_path: Path) -> None:
    positions = 1.15 * (np.stack(np.meshgrid(*[np.arange(6)] * 3), axis=-1).reshape(-1, 3) - 2.5)
    positions = positions + 0.2 * (np.random.default_rng(9).random(positions.shape) - 0.5)
    lines = ["A A lj 1.0 1.0", "A B lj 0.7 1.1", "B B lj 1.4 0.9"]
    scene = make_scene({"A": 120, "B": 96}, lines, cell=6.9, positions=positions, control={**NVE, "cutoff": "2.5 ang"})
    pairs = ["pair_style lj/cut 2.5", "pair_coeff 1 1 1.0 1.0", "pair_coeff 1 2 0.7 1.1", "pair_coeff 2 2 1.4 0.9"]
    assert_same_point(scene, lammps_point(tmp_path, scene, [*pairs, "pair_modify tail yes"], 2.5))


@pytest.mark.slow
def test_statistics_of_dpd_water(tmp_path: Path) -> None:
    """T, P and energy per bead at Δt = 0.02; 1536 beads, 60 τ in both programs.

    Standard errors of each program: T ± 0.002, P ± 0.03, energy ± 0.003; bounds are four times that of the difference.
    """
    scene = make_scene({"A": 1536}, cell=8.0, control={"timestep": "0.02 internal_t"})
    beads = scene.beads
    write_data(tmp_path / "data.beads", scene.cell, beads.positions, beads.species, [1.0])
    script = """
units lj
atom_style atomic
comm_modify vel yes
newton on
read_data data.beads
pair_style dpd 1.0 1.0 34387
pair_coeff * * 25.0 4.5
neighbor 0.3 bin
neigh_modify every 1 delay 0 check yes
velocity all create 1.0 4928459 mom yes
timestep 0.02
fix 1 all nve
run 300
thermo_style custom step temp press pe
thermo 5
run 3000
"""
    judge = run_lammps(tmp_path, script).thermo[:, 1:4]
    assert len(judge) == 601
    simulation = Simulation(scene, seed=5, threads=1)
    simulation.run(300)
    ours = []
    for _ in range(600):
        simulation.run(5)
        seen = simulation.observe()
        ours.append((seen.temperature, seen.pressure, seen.energy["pair"] / 1536))
    difference = np.abs(np.mean(ours, axis=0) - judge.mean(axis=0))
    assert difference[0] < 0.012
    assert difference[1] < 0.17
    assert difference[2] < 0.017
    # The spread of single values is a property of the ensemble too: 1/√N_independent is about 0.1 here.
    spread = np.std(ours, axis=0) / np.std(judge, axis=0)
    assert np.all(np.abs(np.log(spread)) < 0.35)
