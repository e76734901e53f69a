"""LAMMPS judges what internal temperatures do to the pair forces and to conduction (pair style edpd).

Its noise cannot be switched off. Runs with the same seed and different velocities differ by the drag alone; and heat
capacities of 1e20 leave conduction without visible noise.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pydlpoly import Scene, Simulation

from ..heat_scenes import heat, set_temperatures, temperatures
from ..scene_builder import NVE, make_scene
from .lammps_runs import run_lammps

COUNT, EDGE, RANGE, DRAG, EXPONENT = 200, 5.0, 1.58, 4.5, 0.41
POWER, KAPPA = (10.54, -3.66, 3.44, -4.10), (-0.44, -3.21, 5.04, 0.0)
CAPACITY, REPULSION, KAPPA_0, HEAT_EXPONENT = 1e20, 18.75, 1.41e-20, 2.0
SHORT = 1e-4
# LAMMPS leaves numbers undefined between the range of conduction and that of forces: here they are the same.
REACH = RANGE
FORCES = """units lj
atom_style edpd
boundary p p p
comm_modify vel yes
read_data data
pair_style edpd 1.58 7312
pair_coeff 1 1 {repulsion} {drag} {exponent} 1.58 {kappa} {heat_exponent} {reach} power {power} kappa {conduction}
timestep {timestep}
fix 1 all mvv/edpd 0.5
compute t all edpd/temp/atom
run {steps}
write_dump all custom forces.dump id {columns} modify format float %.17g
"""


def state() -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Positions, velocities and temperatures between 0.9 and 1.2, where the exponents stay above LAMMPS's least."""
    rng = np.random.default_rng(5)
    positions = EDGE * (rng.random((COUNT, 3)) - 0.5)
    return positions, rng.normal(size=(COUNT, 3)), rng.uniform(0.97, 1.2, COUNT)


def lammps(folder: Path, velocities: NDArray[np.float64], steps: int, drag: float = DRAG) -> NDArray[np.float64]:
    """Forces of the state, or temperatures after so many steps."""
    positions, _, temperature = state()
    half = 0.5 * EDGE
    lines = ["heat", "", f"{COUNT} atoms", "1 atom types", "", *(f"{-half} {half} {x}lo {x}hi" for x in "xyz"), ""]
    lines += ["Masses", "", "1 1.0", "", "Atoms # edpd", ""]
    for k in range(COUNT):
        place = " ".join(f"{x:.17g}" for x in positions[k])
        lines.append(f"{k + 1} 1 {temperature[k]:.17g} {CAPACITY} {place}")
    lines += ["", "Velocities", "", *(f"{k + 1} " + " ".join(f"{v:.17g}" for v in velocities[k]) for k in range(COUNT))]
    folder.mkdir()
    (folder / "data").write_text("\n".join([*lines, ""]))
    columns = "fx fy fz" if steps == 0 else "c_t c_t c_t"
    script = FORCES.format(
        repulsion=REPULSION, drag=drag, exponent=EXPONENT, kappa=KAPPA_0, heat_exponent=HEAT_EXPONENT, reach=REACH,
        power=" ".join(map(str, POWER)), conduction=" ".join(map(str, KAPPA)), timestep=SHORT, columns=columns,
        steps=steps,
    )  # fmt: skip
    printed = run_lammps(folder, script)
    assert printed.forces is not None
    return printed.forces


def scene(order: str, repulsion: float, velocities: NDArray[np.float64], **control: str | None) -> Scene:
    block = heat(
        f"capacity A {CAPACITY}",
        f"pair A A kappa {KAPPA_0} range {REACH} exponent {HEAT_EXPONENT} power {' '.join(map(str, POWER))} "
        f"conductivity {' '.join(map(str, KAPPA))}",
        "repulsion scaled",
    )
    settings: dict[str, str | None] = {"cutoff": f"{RANGE} ang", "timestep": f"{SHORT} internal_t", "fixed_com": "off"}
    settings |= NVE if order == "nve" else {"ensemble_dpd_order": order, "ensemble_dpd_exponent": str(EXPONENT)}
    positions, _, _ = state()
    laws = (f"A A dpd {repulsion} {RANGE} {DRAG}",)
    return make_scene({"A": COUNT}, laws, cell=EDGE, positions=positions, velocities=velocities,
                      control={**settings, **control}, extensions=block)  # fmt: skip


def forces(scene: Scene) -> NDArray[np.float64]:
    simulation = Simulation(scene, seed=1)
    set_temperatures(simulation, state()[2])
    return simulation.state.forces


def test_drag_and_repulsion_of_warm_beads_are_lammpss(tmp_path: Path) -> None:
    _, velocities, _ = state()
    rest = np.zeros_like(velocities)
    theirs = lammps(tmp_path / "moving", velocities, 0) - lammps(tmp_path / "resting", rest, 0)
    ours = forces(scene("mdvv", 0.0, velocities)) - forces(scene("mdvv", 0.0, rest))
    np.testing.assert_allclose(ours, theirs, atol=2e-12 * np.abs(theirs).max())
    theirs = lammps(tmp_path / "repulsion", rest, 0, drag=0.0)  # and no noise
    np.testing.assert_allclose(forces(scene("nve", REPULSION, rest)), theirs, atol=2e-12 * np.abs(theirs).max())


def test_conduction_is_lammpss(tmp_path: Path) -> None:
    """Changes of temperature in one short step; the noise is 1e-7 of them, the step's error 1e-4."""
    _, _, start = state()
    rest = np.zeros((COUNT, 3))
    theirs = lammps(tmp_path / "conduction", rest, 1)[:, 0] - start
    simulation = Simulation(scene("nve", REPULSION, rest), seed=1)
    set_temperatures(simulation, start)
    simulation.run(1)
    ours = temperatures(simulation) - start
    np.testing.assert_allclose(ours, theirs, atol=3e-4 * np.abs(theirs).max())
