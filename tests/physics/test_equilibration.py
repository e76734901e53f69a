"""Equilibration measures and starts: force cap, rescaling, new velocities, and where they end."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly import Scene, Simulation, single_point
from pydlpoly.formats.records import FloatArray

from ..scene_builder import NVE, make_scene

LINES = ["A A dpd 25.0 1.0 4.5", "A B dpd 35.0 1.0 4.5", "B B dpd 25.0 1.0 4.5"]
MASSES = {"A": 1.0, "B": 3.0}


def fluid(**control: str | None) -> Scene:
    return make_scene({"A": 100, "B": 92}, LINES, cell=4.0, masses=MASSES, control={**NVE, **control})


def conservative(scene: Scene, positions: FloatArray) -> FloatArray:
    """Forces without any cap, of other positions."""
    other = Simulation(scene, seed=1, threads=1)
    other.set_state(positions=positions)
    return other.state.forces


def test_force_cap_limits_every_bead_during_equilibration_only() -> None:
    cap = 30.0
    scene = fluid(time_equilibration="10 steps", equilibration_force_cap=f"{cap} internal_f")
    free = fluid()
    uncapped = single_point(scene).forces
    assert np.linalg.norm(uncapped, axis=1).max() > 1.5 * cap
    simulation = Simulation(scene, seed=1, threads=1)
    for _ in range(10):
        state = simulation.state
        expected = conservative(free, state.positions)
        size = np.linalg.norm(expected, axis=1, keepdims=True)
        expected = expected * np.minimum(1.0, cap / size)
        # As in DL_POLY, the force that the cap leaves on the whole is taken out again.
        assert state.forces == pytest.approx(expected - expected.mean(axis=0), rel=1e-9, abs=1e-9)
        simulation.run(1)
    simulation.run(1)
    state = simulation.state
    assert state.step == 11
    assert state.forces == pytest.approx(conservative(free, state.positions), rel=1e-9, abs=1e-9)


def test_a_force_cap_in_temperature_units() -> None:
    """DL_POLY's own unit: multiples of k_B T per Å, with the run's temperature."""
    scene = fluid(time_equilibration="5 steps", equilibration_force_cap="15.0 k_b.temp/ang", temperature="2.0 dpd_temp")
    assert scene.run.force_cap == pytest.approx(30.0)


def test_a_cap_that_is_never_reached_changes_nothing() -> None:
    capped = Simulation(
        fluid(time_equilibration="40 steps", equilibration_force_cap="1e6 internal_f"), seed=1, threads=1
    )
    free = Simulation(fluid(), seed=1, threads=1)
    capped.run(40)
    free.run(40)
    # Taking out the mean force of exact sums subtracts round-off at most.
    assert np.abs(capped.state.positions - free.state.positions).max() < 1e-10


def test_a_cap_tames_overlaps_of_a_hard_law() -> None:
    positions = 1.15 * (np.stack(np.meshgrid(*[np.arange(5)] * 3), axis=-1).reshape(-1, 3) - 2.0)
    positions[1] = positions[0] + [0.05, 0.02, 0.0]
    control = {"cutoff": "2.5 ang", "timestep": "0.002 internal_t", "time_equilibration": "600 steps"}
    cap = {"equilibration_force_cap": "200.0 internal_f"}
    scene = make_scene({"A": 125}, ["A A lj 1.0 1.0 5.0"], cell=5.75, positions=positions, control={**control, **cap})
    simulation = Simulation(scene, seed=1, threads=1)
    simulation.run(900)
    state = simulation.state
    distance = np.linalg.norm(state.positions[1] - state.positions[0])
    assert distance > 0.85
    assert simulation.temperature < 2.0
    assert np.linalg.norm(single_point(scene).forces, axis=1).max() > 1e10


def test_rescaling_sets_the_temperature_in_its_steps_only() -> None:
    scene = fluid(time_equilibration="30 steps", rescale_frequency="5 steps", temperature="1.5 dpd_temp")
    simulation = Simulation(scene, seed=1, threads=1)
    for step in range(1, 61):
        simulation.run(1)
        exact = abs(simulation.temperature / 1.5 - 1.0) < 1e-10
        assert exact == (step % 5 == 0 and step <= 30), step
        assert np.abs(simulation.observe().momentum).max() < 1e-10


def test_new_velocities_come_in_their_steps_only() -> None:
    scene = fluid(time_equilibration="24 steps", regauss_frequency="8 steps")
    simulation = Simulation(scene, seed=1, threads=1)
    drawn = []
    for step in range(1, 41):
        before = simulation.state.velocities
        simulation.run(1)
        after = simulation.state.velocities
        kept = float(np.corrcoef(before.ravel(), after.ravel())[0, 1])
        if step in (8, 16, 24):
            assert abs(kept) < 0.2, step
            assert simulation.temperature == pytest.approx(1.0, rel=1e-10)
            assert np.abs(simulation.observe().momentum).max() < 1e-10
            drawn.append(after)
        else:
            assert kept > 0.5, step
    for a, b in ((0, 1), (0, 2), (1, 2)):
        assert abs(np.corrcoef(drawn[a].ravel(), drawn[b].ravel())[0, 1]) < 0.2


def test_drawn_velocities_suit_the_masses() -> None:
    """A clean start: exact temperature, no drift, and each species with its own width (2000 beads each: ± 0.013)."""
    scene = make_scene({"A": 2000, "B": 2000}, LINES, cell=11.0, masses=MASSES, control={"temperature": "0.7 dpd_temp"})
    simulation = Simulation(scene, seed=5, threads=1)
    assert simulation.temperature == pytest.approx(0.7, rel=1e-12)
    assert np.abs(simulation.observe().momentum).max() < 1e-10
    velocities = simulation.state.velocities
    assert np.var(velocities[:2000]) == pytest.approx(0.7, rel=0.065)
    assert np.var(velocities[2000:]) == pytest.approx(0.7 / 3.0, rel=0.065)
    assert scene.degrees_of_freedom == 3 * 4000 - 3


@pytest.mark.parametrize("start", ["rescale", "noscale"])
def test_starts_from_given_velocities(start: str) -> None:
    velocities = np.random.default_rng(2).normal(size=(192, 3))
    mass = np.array([1.0] * 100 + [3.0] * 92)
    velocities -= mass @ velocities / mass.sum()
    scene = make_scene(
        {"A": 100, "B": 92}, LINES, cell=4.0, masses=MASSES, velocities=velocities, control={**NVE, "restart": start}
    )
    found = Simulation(scene, seed=1, threads=1)
    if start == "noscale":
        assert found.state.velocities == pytest.approx(velocities, abs=1e-12)
        return
    assert found.temperature == pytest.approx(1.0, rel=1e-12)
    ratio = found.state.velocities / velocities
    assert ratio == pytest.approx(np.full((192, 3), ratio[0, 0]), rel=1e-9)
    assert ratio[0, 0] > 0.0
