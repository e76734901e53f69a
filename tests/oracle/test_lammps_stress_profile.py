"""LAMMPS' compute stress/cartesian as a judge of the stress in layers: momenta, and pairs along straight lines."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pydlpoly import Simulation
from pydlpoly.formats.records import FloatArray

from ..scene_builder import make_scene
from .lammps_runs import run_lammps, write_data

CELL = np.array([5.0, 4.5, 6.0])
LAYERS = 12
LAWS = {
    "dpd": (["A A dpd 25.0 1.0 4.5", "A B dpd 41.3 0.8 4.5", "B B dpd 17.9 1.3 4.5"],
            ["pair_style dpd 0.0 1.3 34387", "pair_coeff 1 1 25.0 4.5 1.0", "pair_coeff 1 2 41.3 4.5 0.8",
             "pair_coeff 2 2 17.9 4.5 1.3"]),
}  # fmt: skip


def of_lammps(folder: Path, axis: str, cell: FloatArray, simulation: Simulation) -> FloatArray:
    """(layers, 8): middle, density, and the diagonals of momenta and pairs, for the simulation's present state."""
    scene, state = simulation.scene, simulation.state
    write_data(folder / "data.beads", cell, state.positions, scene.beads.species, [1.0, 2.0])
    lines = ["", "Velocities", ""]
    lines += [f"{k} " + " ".join(f"{x:.17g}" for x in row) for k, row in enumerate(state.velocities, 1)]
    with (folder / "data.beads").open("a") as file:
        file.write("\n".join([*lines, ""]))
    width = float(cell["xyz".index(axis), "xyz".index(axis)]) / LAYERS
    script = f"""
units lj
atom_style atomic
comm_modify vel yes cutoff 1.7
newton on
read_data data.beads
{chr(10).join(LAWS["dpd"][1])}
neighbor 0.3 bin
compute layers all stress/cartesian {axis} {width:.17g} NULL 0
fix 1 all nve
fix out all ave/time 1 1 1 c_layers[*] mode vector file layers.txt format " %.15g"
thermo 1
run 0
"""
    run_lammps(folder, script)
    rows = [line.split() for line in (folder / "layers.txt").read_text().splitlines() if not line.startswith("#")]
    return np.array([[float(word) for word in row[1:]] for row in rows[1:] if len(row) > 2])


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_momenta_and_pairs_in_layers(tmp_path: Path, axis: str) -> None:
    scene = make_scene(
        {"A": 240, "B": 160}, LAWS["dpd"][0], cell=CELL, masses={"A": 1.0, "B": 2.0}, control={"cutoff": "1.3 ang"}
    )
    simulation = Simulation(scene, seed=5)
    simulation.run(5)
    judge = of_lammps(tmp_path, axis, simulation.cell, simulation)
    k = "xyz".index(axis)
    kinetic, pairs, _, beads = simulation.layer_sums(k, LAYERS)
    volume = float(np.prod(CELL)) / LAYERS
    assert len(judge) == LAYERS
    np.testing.assert_allclose(
        judge[:, 0] - judge[:, 0].mean(), (np.arange(LAYERS) - 5.5) * CELL[k] / LAYERS, atol=1e-9
    )
    np.testing.assert_allclose(judge[:, 1] * volume, beads.sum(axis=1), atol=1e-9)
    np.testing.assert_allclose(judge[:, 2:5] * volume, kinetic[:, :3], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(judge[:, 5:8] * volume, pairs[:, :3], rtol=1e-9, atol=1e-8)
