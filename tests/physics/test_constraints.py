"""Rigid triangles at equilibrium: temperature of 3N − N_c momenta, its parts of translation and rotation, pressure."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly import Simulation
from pydlpoly.formats.records import FloatArray

from ..test_constraints import CELL, INTEGRATORS, waters

COPIES = 216


def samples(simulation: Simulation, count: int, every: int) -> FloatArray:
    """(count, 4): temperature, those of translation and rotation of the molecules, and pressure."""
    mass = simulation.scene.beads.mass[:3, None]
    rows = []
    for _ in range(count):
        simulation.run(every)
        seen = simulation.observe()
        velocities = simulation.state.velocities.reshape(-1, 3, 3)
        centre = (mass * velocities).sum(axis=1, keepdims=True) / mass.sum()
        translation = mass.sum() * (centre**2).sum() / (3 * COPIES - 3)
        rotation = (mass * (velocities - centre) ** 2).sum() / (3 * COPIES)
        rows.append((seen.temperature, translation, rotation, seen.pressure))
    return np.array(rows)


def error(series: FloatArray) -> float:
    """Standard error of the mean from ten blocks."""
    means = [block.mean() for block in np.array_split(series, 10)]
    return float(np.std(means, ddof=1) / np.sqrt(10))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("integrator", "timestep", "tolerated"),
    # Expected errors are 0.002 to 0.004; the drag of half-step velocities makes mdvv too hot to first order in Δt.
    [("mdvv", 0.005, 0.02), ("dpdvv", 0.01, 0.01), ("langevin", 0.02, 0.005), ("middle", 0.02, 0.005)],
)
def test_equipartition(integrator: str, timestep: float, tolerated: float) -> None:
    control = {**INTEGRATORS[integrator], "timestep": f"{timestep} internal_t", "shake_tolerance": "1e-8 ang"}
    simulation = Simulation(waters(COPIES, control), seed=11, threads=1)
    simulation.run(int(10.0 / timestep))
    series = samples(simulation, 1000, max(1, int(0.04 / timestep)))
    for column, name in enumerate(("all", "translation", "rotation")):
        spread = error(series[:, column])
        assert spread < 0.01, name
        assert abs(series[:, column].mean() - 1.0) < tolerated + 4.0 * spread, name


@pytest.mark.slow
def test_pressure_of_molecules_that_do_not_meet() -> None:
    """P V = k_B T for every molecule, whatever holds its beads together."""
    control = {**INTEGRATORS["langevin"], "timestep": "0.01 internal_t", "cutoff": "1.0 ang"}
    simulation = Simulation(waters(COPIES, control, pairs=()), seed=11, threads=1)
    simulation.run(500)
    series = samples(simulation, 1500, 10)
    spread = error(series[:, 3])
    assert spread < 0.01
    assert abs(series[:, 3].mean() - COPIES / CELL**3) < 0.003 + 4.0 * spread


@pytest.mark.slow
@pytest.mark.parametrize("integrator", ["second", "peters", "ou-middle"])
def test_splittings_with_a_strong_drag_are_exact(integrator: str) -> None:
    """γΔt = 2: the temperature would be 7 % too low if pairs were thermalised without their forbidden velocities."""
    control = {**INTEGRATORS[integrator], "timestep": "0.02 internal_t", "shake_tolerance": "1e-8 ang"}
    pairs = [f"{pair} dpd 0.0 1.0 100.0" for pair in ("O O", "O H", "H H")]
    simulation = Simulation(waters(COPIES, control, pairs=pairs), seed=11, threads=1)
    simulation.run(200)
    series = samples(simulation, 750, 2)
    for column in range(3):
        spread = error(series[:, column])
        assert spread < 0.007
        assert abs(series[:, column].mean() - 1.0) < 0.003 + 4.0 * spread
