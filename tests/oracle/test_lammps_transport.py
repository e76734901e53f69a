"""LAMMPS as a judge of transport DPD: the fluxes of one frame, and the profiles of its own example system."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pydlpoly import Scene, Simulation
from pydlpoly.formats.records import FloatArray

from ..scene_builder import make_scene
from .lammps_runs import run_lammps

KAPPA, EXPONENT, REACH = (1.0, 3.0), (2.0, 0.7), 1.3  # of two dissolved species; LAMMPS has one range a pair
EDGES = [6.0, 5.5, 6.3]


def write_data(path: Path, scene: Scene, values: FloatArray) -> None:
    """Write a data file for atom_style tdpd."""
    half = 0.5 * np.diag(scene.cell)
    lines = ["beads with dissolved species", "", f"{scene.bead_count} atoms", f"{len(scene.species)} atom types", ""]
    lines += [f"{-h:.17g} {h:.17g} {axis}lo {axis}hi" for h, axis in zip(half, "xyz", strict=True)]
    lines += ["", "Masses", "", *(f"{k} 1.0" for k in range(1, len(scene.species) + 1)), "", "Atoms # tdpd", ""]
    for k, (kind, place, held) in enumerate(zip(scene.beads.species, scene.beads.positions, values, strict=True), 1):
        lines.append(f"{k} {kind + 1} " + " ".join(f"{x:.17g}" for x in (*place, *held)))
    path.write_text("\n".join([*lines, ""]))


def dumped(path: Path) -> FloatArray:
    """(N, columns) of the last frame of a dump, in the order of the ids."""
    frames = path.read_text().split("ITEM: ATOMS")
    rows = np.array([[float(word) for word in line.split()] for line in frames[-1].splitlines()[1:]])
    return np.asarray(rows[np.argsort(rows[:, 0])][:, 1:])


def test_fluxes_of_one_frame(tmp_path: Path) -> None:
    """LAMMPS's q of a random frame, from a step so short that nothing else happens, against one exchange."""
    timestep = 1e-9
    scene = make_scene(
        {"A": 400, "B": 200},
        ["A A dpd 0.0 1.3 0.0", "A B dpd 0.0 1.3 0.0", "B B dpd 0.0 1.3 0.0"],
        cell=EDGES,
        velocities=np.zeros((600, 3)),
        control={"timestep": f"{timestep!r} internal_t", "ensemble": "nve", "ensemble_method": None,
                 "ensemble_dpd_order": None, "cutoff": "1.3 ang"},
        extensions="\n".join([
            "extension transport", "species a b", "start a 1e3 box * 0 * * * *", "start b 1e3 in B",
            f"pair * * a kappa {KAPPA[0]} range {REACH} exponent {EXPONENT[0]}",
            f"pair A A b kappa {KAPPA[1]} range {REACH} exponent {EXPONENT[1]}",
            f"pair A B b kappa {2 * KAPPA[1]} range {REACH} exponent {EXPONENT[1]}",
            f"pair B B b kappa {KAPPA[1]} range {REACH} exponent 1.0", "end extension", "",
        ]),
    )  # fmt: skip
    simulation = Simulation(scene, seed=1)
    start = np.asarray(simulation._engine.system.concentrations)
    simulation.run(1)
    change = (np.asarray(simulation._engine.system.concentrations) - start) / timestep
    write_data(tmp_path / "data.beads", scene, start)
    common = f"{KAPPA[0]} 0.0 {EXPONENT[0]}"
    script = f"""
units lj
atom_style tdpd 2
comm_modify vel yes
newton on
read_data data.beads
pair_style tdpd 0.0 {REACH} 34387
pair_coeff 1 1 0.0 0.0 2.0 {REACH} {REACH} {common} {KAPPA[1]} 0.0 {EXPONENT[1]}
pair_coeff 1 2 0.0 0.0 2.0 {REACH} {REACH} {common} {2 * KAPPA[1]} 0.0 {EXPONENT[1]}
pair_coeff 2 2 0.0 0.0 2.0 {REACH} {REACH} {common} {KAPPA[1]} 0.0 1.0
neighbor 0.3 bin
velocity all set 0.0 0.0 0.0
fix motion all mvv/tdpd 0.5
timestep {timestep}
compute first all tdpd/cc/atom 1
compute second all tdpd/cc/atom 2
dump cc all custom 1 cc.dump id c_first c_second
dump_modify cc format float %.17g
run 1
"""
    run_lammps(tmp_path, script)
    seen = (dumped(tmp_path / "cc.dump") - start) / timestep
    # Both lose digits in C(Δt) − C(0): an ulp of 1e3 is 1e-13, over 1e-9 it is 1e-4 of rates of some 1e3.
    assert (np.abs(seen).max(axis=0) > 1e3).all()
    assert np.abs(change - seen).max() < 2e-3
