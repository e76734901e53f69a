"""Without a thermostat: energy to second order in the timestep, momentum to round-off, flight, external fields."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly import Scene, Simulation
from pydlpoly.formats.records import FloatArray

from ..scene_builder import NVE, make_scene
from .averages import equilibrated

MASSES = {"A": 1.0, "B": 2.5}
LINES = ["A A dpd 25.0 1.0", "A B dpd 35.0 1.0", "B B dpd 25.0 1.0"]
CELL = [[5.0, 0.0, 0.0], [1.5, 5.0, 0.0], [-1.0, 1.2, 5.0]]


@pytest.fixture(scope="module")
def equilibria() -> list[tuple[FloatArray, FloatArray]]:
    """Positions and velocities of a thermalised mixture, at four times."""
    lines = [f"{line} 4.5" for line in LINES]
    simulation = equilibrated(make_scene({"A": 200, "B": 175}, lines, cell=CELL, masses=MASSES), seed=3, steps=400)
    states = []
    for _ in range(4):
        simulation.run(100)
        states.append((simulation.state.positions, simulation.state.velocities))
    return states


@pytest.fixture
def equilibrium(equilibria: list[tuple[FloatArray, FloatArray]]) -> tuple[FloatArray, FloatArray]:
    return equilibria[0]


def conserved(equilibrium: tuple[FloatArray, FloatArray], timestep: float) -> Scene:
    positions, velocities = equilibrium
    control = {**NVE, "timestep": f"{timestep} internal_t", "fixed_com": "off"}
    return make_scene(
        {"A": 200, "B": 175},
        LINES,
        cell=CELL,
        masses=MASSES,
        positions=positions,
        velocities=velocities,
        control=control,
    )


def test_energy_error_is_of_second_order(equilibria: list[tuple[FloatArray, FloatArray]]) -> None:
    """Verlet keeps an energy that differs from H by Δt²; over 1 τ from four starts, at steps of 0.02 to 0.0025.

    The kink of the soft force at its cutoff makes single starts scatter by a factor of 1.5 around the factor 4 a
    halving; over three halvings of pooled starts that leaves ± 0.1 in the order.
    """
    pooled = []
    for timestep in (0.02, 0.0025):
        squares = []
        for start in equilibria:
            simulation = Simulation(conserved(start, timestep), seed=1, threads=1)
            first, errors = simulation.energy["total"], []
            for _ in range(50):
                simulation.run(round(0.02 / timestep))
                errors.append(simulation.energy["total"] - first)
            squares.append(float(np.var([0.0, *errors])))
        pooled.append(float(np.sqrt(np.mean(squares))))
    assert pooled[0] < 1e-3 * simulation.energy["kinetic"]
    assert np.log2(pooled[0] / pooled[1]) / 3.0 == pytest.approx(2.0, abs=0.25)


def test_momentum_stays_at_round_off(equilibrium: tuple[FloatArray, FloatArray]) -> None:
    simulation = Simulation(conserved(equilibrium, 0.01), seed=1, threads=1)
    start = simulation.observe().momentum
    simulation.run(500)
    assert np.abs(simulation.observe().momentum - start).max() < 1e-12 * 375


def test_verlet_is_reversible(equilibrium: tuple[FloatArray, FloatArray]) -> None:
    simulation = Simulation(conserved(equilibrium, 0.01), seed=1, threads=1)
    start = simulation.state
    simulation.run(100)
    simulation.set_state(velocities=-simulation.state.velocities)
    simulation.run(100)
    state = simulation.state
    fractional = np.linalg.solve(state.cell.T, (state.positions - start.positions).T).T
    assert np.abs(fractional - np.round(fractional)).max() < 1e-9
    assert np.abs(state.velocities + start.velocities).max() < 1e-8


def test_free_flight_crosses_the_cell() -> None:
    """A bead alone moves on a straight line: wrapped positions, image counts and unwrapped positions agree."""
    velocity = np.array([[3.0, -7.0, 0.5]])
    control = {**NVE, "timestep": "0.01 internal_t", "fixed_com": "off"}
    scene = make_scene(
        {"A": 1}, ["A A dpd 25.0 1.0"], cell=CELL, positions=[[0.3, 0.2, 0.1]], velocities=velocity, control=control
    )
    simulation = Simulation(scene, seed=1, threads=1)
    simulation.run(1000)
    state = simulation.state
    assert state.unwrapped == pytest.approx(np.array([[0.3, 0.2, 0.1]]) + 10.0 * velocity, abs=1e-9)
    assert np.abs(np.linalg.solve(state.cell.T, state.positions[0])).max() <= 0.5
    assert np.abs(state.images).max() >= 10
    assert simulation.time == pytest.approx(10.0, rel=1e-12)


def test_gravity_is_free_fall_for_every_mass() -> None:
    control = {**NVE, "timestep": "0.01 internal_t", "fixed_com": "off"}
    scene = make_scene(
        {"A": 1, "B": 1},
        ["A A dpd 25.0 1.0"],
        cell=8.0,
        masses=MASSES,
        positions=[[-2.0, 0.0, 0.0], [2.0, 0.0, 0.0]],
        velocities=np.zeros((2, 3)),
        extern="grav 0.1 0.0 -0.7",
        control=control,
    )
    simulation = Simulation(scene, seed=1, threads=1)
    simulation.run(300)
    fall = np.array([0.1, 0.0, -0.7])
    state = simulation.state
    assert state.velocities == pytest.approx(np.array([3.0 * fall] * 2), rel=1e-12)
    displacement = state.unwrapped - scene.beads.positions
    assert displacement == pytest.approx(np.array([4.5 * fall] * 2), rel=1e-11)


def test_gravity_under_the_thermostat_accelerates_the_whole_fluid() -> None:
    """Drag and noise are pair forces: the centre of mass falls freely while they act."""
    scene = make_scene({"A": 192}, cell=4.0, extern="grav 0.0 0.0 -0.5")
    simulation = Simulation(scene, seed=1, threads=1)
    start = simulation.observe().momentum
    simulation.run(400)
    gained = simulation.observe().momentum - start
    assert gained == pytest.approx(np.array([0.0, 0.0, -0.5 * 4.0 * 192]), abs=1e-9)
