"""Thermostats of single beads, and temperatures that vary: against the canonical ensemble and against the settings."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly import Scene, Simulation

from .scene_builder import make_scene

KEYWORDS = {
    "langevin": {"ensemble_thermostat_friction": "2.0 internal_t^-1"},
    "berendsen": {"ensemble_thermostat_coupling": "0.2 internal_t"},
    "hoover": {"ensemble_thermostat_coupling": "0.2 internal_t"},
}


def fluid(method: str, **control: str | None) -> Scene:
    """A soft fluid of two masses without drag."""
    settings: dict[str, str | None] = {"ensemble_method": method, "ensemble_dpd_order": None, **KEYWORDS[method]}
    return make_scene(
        {"A": 150, "B": 150},
        ["A A dpd 25.0 1.0", "A B dpd 25.0 1.0", "B B dpd 25.0 1.0"],
        cell=(300 / 3.0) ** (1 / 3),
        masses={"A": 1.0, "B": 4.0},
        control={"timestep": "0.02 internal_t", **settings, **control},
    )


@pytest.mark.parametrize("method", KEYWORDS)
def test_temperature_and_its_fluctuations(method: str) -> None:
    """2000 samples 0.1 apart, correlated over some tenths: T is known to 0.003, its fluctuations to a twentieth."""
    simulation = Simulation(fluid(method), seed=5, threads=1)
    simulation.run(500)
    temperatures = []
    for _ in range(2000):
        simulation.run(5)
        temperatures.append(simulation.temperature)
    canonical = np.sqrt(2.0 / simulation.scene.degrees_of_freedom)
    assert np.mean(temperatures) == pytest.approx(1.0, abs=0.01)
    if method == "berendsen":
        assert np.std(temperatures) < 0.75 * canonical
    else:
        assert np.std(temperatures) == pytest.approx(canonical, rel=0.15)
    assert np.abs(simulation.observe().momentum).max() < 1e-10


def test_hoover_conserves_its_energy() -> None:
    simulation = Simulation(fluid("hoover", timestep="0.005 internal_t"), seed=5, threads=1)
    simulation.run(1000)
    energies = []
    for _ in range(200):
        simulation.run(10)
        energy = simulation.energy
        energies.append(energy["total"] + energy["thermostat"])
    potential = simulation.energy["potential"]
    assert np.ptp(energies) < 1e-3 * potential
    assert abs(simulation.energy["thermostat"]) > 0.0


def test_langevin_damps_a_single_bead_exactly() -> None:
    """Without forces and noise the velocity decays as exp(-friction t)."""
    scene = make_scene(
        {"A": 1},
        ["A A dpd 25.0 1.0"],
        cell=10.0,
        positions=np.zeros((1, 3)),
        control={
            "ensemble_method": "langevin",
            "ensemble_dpd_order": None,
            "ensemble_thermostat_friction": "2.0 internal_t^-1",
            "temperature": "0 dpd_temp",
            "fixed_com": "off",
        },
    )
    simulation = Simulation(scene, seed=1)
    simulation.set_state(velocities=np.array([[1.0, -2.0, 0.5]]))
    simulation.run(100)
    expected = np.exp(-2.0 * simulation.time) * np.array([[1.0, -2.0, 0.5]])
    assert simulation.state.velocities == pytest.approx(expected, rel=1e-12)


def test_a_temperature_follows_its_points() -> None:
    """The ideal DPD gas with strong drag follows within its relaxation time, some hundredths."""
    scene = make_scene(
        {"A": 1200},
        ["A A dpd 0.0 1.0 40.0"],
        cell=(1200 / 6.0) ** (1 / 3),
        control={
            "ensemble_dpd_order": "ou",
            "timestep": "0.02 internal_t",
            "temperature_times": "[ 1.0 3.0 5.0 ] internal_t",
            "temperature_values": "[ 1.0 3.0 0.5 ] dpd_temp",
        },
    )
    simulation = Simulation(scene, seed=2)
    found, expected = [], []
    for _ in range(60):
        simulation.run(5)
        found.append(simulation.temperature)
        expected.append(np.interp(simulation.time, [1.0, 3.0, 5.0], [1.0, 3.0, 0.5]))
    # Fluctuations are 2.4 % of the temperature; on the slopes it lags by a step of relaxation.
    assert np.abs(np.array(found) - expected).max() < 0.25
    assert np.mean(found) == pytest.approx(np.mean(expected), rel=0.02)


def test_a_sine() -> None:
    scene = make_scene(
        {"A": 1200},
        ["A A dpd 0.0 1.0 40.0"],
        cell=(1200 / 6.0) ** (1 / 3),
        control={
            "timestep": "0.005 internal_t",
            "temperature_amplitude": "0.5 dpd_temp",
            "temperature_period": "4.0 internal_t",
        },
    )
    simulation = Simulation(scene, seed=2)
    simulation.run(200)
    times, found = [], []
    for _ in range(160):
        simulation.run(10)
        times.append(simulation.time)
        found.append(simulation.temperature)
    sine = np.sin(2.0 * np.pi * np.array(times) / 4.0)
    assert 2.0 * np.mean(np.array(found) * sine) == pytest.approx(0.5, abs=0.06)


@pytest.mark.parametrize("order", ["first", "ou", "lowe-andersen"])
def test_drag_across_the_line_of_pairs_keeps_the_temperature(order: str) -> None:
    """An ideal gas whose pairs are damped and shaken across their lines six times as much as along them.

    1500 beads, 150 samples 0.1 apart: the error of the mean is below 0.021/√75 = 0.0025. Noise across lines that does
    not belong to its drag makes the gas too hot or too cold.
    """
    scene = make_scene(
        {"A": 1500},
        ["A A dpd 0.0 1.0 4.5"],
        cell=(1500 / 3.0) ** (1 / 3),
        control={
            "ensemble_dpd_order": order,
            "ensemble_dpd_transverse_drag": "6.0",
            "timestep": "0.05 internal_t",
        },
    )
    simulation = Simulation(scene, seed=4)
    simulation.run(40)
    temperatures = []
    for _ in range(150):
        simulation.run(2)
        temperatures.append(simulation.temperature)
    assert np.mean(temperatures) == pytest.approx(1.0, abs=0.01)
    assert np.abs(simulation.observe().momentum).max() < 1e-10
