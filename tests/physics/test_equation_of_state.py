"""Pressure and energy of soft fluids against published numbers: every integrator at one point, one at many points.

Targets at A = 25, ρ = 3, k_B T = 1: P = 23.65 ± 0.02 (Monte Carlo, P. B. Warren's pyHNC) and 4.551 per bead (LAMMPS;
long runs at short steps give 4.5465 ± 0.0005). The other points have A ρ / k_B T = 75. They come from the example `dpd`
of M. P. Allen and D. J. Tildesley, Computer Simulation of Liquids (2017): mean of its results with the thermostats of
Lowe and Shardlow, which differ by 0.008 at most.
"""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly import Simulation
from pydlpoly.bench.scenes import cube, single_beads

from .test_timesteps import WATER, script

# k_B T, density and pressure.
POINTS = [
    (0.5, 3.0, 11.817),
    (1.0, 3.0, 23.636),
    (1.5, 3.0, 35.452),
    (2.0, 3.0, 47.261),
    (1.0, 2.0, 14.318),
    (1.0, 4.0, 32.625),
    (1.0, 5.0, 41.536),
]


@pytest.mark.slow
@pytest.mark.parametrize("row", [*WATER, "stoyanov-groot", "nose-hoover-langevin"])
def test_pressure_and_energy_of_every_integrator(row: str) -> None:
    """60 τ of 1536 beads: standard errors of 0.005 and 0.002; the schemes' own shares at Δt = 0.01 are smaller."""
    cell = script().measure(row, 0.01, 25.0, duration=60.0, seed=5)
    assert cell.pressure_error < 0.01
    assert cell.pressure == pytest.approx(23.65, abs=0.05)
    assert cell.energy == pytest.approx(4.5465, abs=0.008)


@pytest.mark.slow
@pytest.mark.parametrize(("thermal_energy", "density", "expected"), POINTS)
def test_pressures_of_allen_and_tildesley(thermal_energy: float, density: float, expected: float) -> None:
    """50 τ of 3000 beads with ``middle`` at Δt = 0.01: standard errors up to 0.01."""
    control = {
        "ensemble_dpd_order": "middle",
        "timestep": "0.01 dpd_t",
        "temperature": f"{thermal_energy!r} dpd_temp",
    }
    pairs = {("W", "W"): ("dpd", 75.0 * thermal_energy / density, 1.0, 4.5)}
    scene = single_beads("water", {"W": 3000}, pairs, cube(3000, density), control=control)
    simulation = Simulation(scene, seed=9, threads=1)
    simulation.run(1000)
    pressures = []
    for _ in range(500):
        simulation.run(10)
        seen = simulation.observe()
        conservative = float(np.trace(seen.stress_parts["conservative"])) / 3.0
        pressures.append(density * thermal_energy + conservative)
    blocks = [block.mean() for block in np.array_split(np.array(pressures), 20)]
    assert np.std(blocks, ddof=1) / np.sqrt(20) < 0.02
    assert np.mean(pressures) == pytest.approx(expected, abs=0.05)
