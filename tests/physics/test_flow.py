"""Viscosity of DPD water (A = 25, γ = 4.5, ρ = 3, k_B T = 1) by steady shear and by periodic Poiseuille flow.

Groot and Warren's fluid has η = 0.84 ± 0.03 at low shear rates; at 0.2 it is said to be 0.95 with velocity Verlet.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from pydlpoly import Simulation
from tests.scene_builder import make_scene

TIMESTEP = 0.04
CONTROL = {"ensemble_dpd_order": "middle", "timestep": f"{TIMESTEP} internal_t"}
RATE = 0.1
PUSH, HALF = 0.015, 10.0


@cache
def by_shear() -> tuple[float, float, float]:
    """Viscosity from the stress, its standard error, and the temperature; also looks at the profile of the flow."""
    scene = make_scene({"A": 1536}, cell=8.0, control=CONTROL | {"shear_rate": f"{RATE} dpd_t^-1"})
    simulation = Simulation(scene, seed=7, threads=1)
    simulation.run(500)
    stress, temperature, flow, counts = [], [], np.zeros(8), np.zeros(8)
    for look in range(12000):
        simulation.run(5)
        seen = simulation.observe()
        stress.append((seen.stress - seen.stress_parts["noise"])[0, 1])  # the noise's part has the mean 0
        temperature.append(seen.temperature)
        if look % 10 == 0:
            state = simulation.state
            y = state.positions[:, 1]
            counts += np.histogram(y, bins=8, range=(-4.0, 4.0))[0]
            flow += np.histogram(y, bins=8, range=(-4.0, 4.0), weights=state.velocities[:, 0])[0]
    assert np.abs(seen.momentum).max() < 1e-9
    # 1200 looks at 192 beads a bin, two time units apart: error 0.003
    np.testing.assert_allclose(flow / counts, RATE * (np.arange(8) - 3.5), rtol=0, atol=0.012)
    blocks = [-block.mean() / RATE for block in np.array_split(stress, 20)]
    return float(np.mean(blocks)), float(np.std(blocks) / np.sqrt(19.0)), float(np.mean(temperature))


@cache
def by_poiseuille_flow() -> tuple[float, float]:
    """Viscosity from the mean flow ρ g D²/(12η) of the two halves, and its standard error."""
    scene = make_scene({"A": 960}, cell=[4.0, 2.0 * HALF, 4.0], control=CONTROL, extern=f"pois {PUSH}")
    simulation = Simulation(scene, seed=7, threads=1)
    simulation.run(5000)  # the flow grows with ρ D²/(π² η) = 36 time units
    means = []
    for _ in range(5000):
        simulation.run(10)
        state = simulation.state
        means.append(np.mean(np.sign(state.positions[:, 1]) * state.velocities[:, 0]))
    blocks = [block.mean() for block in np.array_split(means, 14)]
    mean, error = float(np.mean(blocks)), float(np.std(blocks) / np.sqrt(13.0))
    viscosity = 3.0 * PUSH * HALF**2 / (12.0 * mean)
    return viscosity, viscosity * error / mean


@pytest.mark.slow
def test_viscosity_by_shear() -> None:
    viscosity, error, temperature = by_shear()
    assert error < 0.02  # 0.012 is usual
    assert viscosity == pytest.approx(0.84, abs=0.04)
    assert temperature == pytest.approx(1.0, abs=0.01)


@pytest.mark.slow
@pytest.mark.long
def test_viscosity_by_periodic_poiseuille_flow() -> None:
    viscosity, error = by_poiseuille_flow()
    assert error < 0.03  # 0.015 is usual
    assert viscosity == pytest.approx(0.84, abs=0.05)


@pytest.mark.slow
@pytest.mark.long
def test_both_agree() -> None:
    shear, poiseuille = by_shear(), by_poiseuille_flow()
    assert abs(shear[0] - poiseuille[0]) < 3.0 * np.hypot(shear[1], poiseuille[1])
