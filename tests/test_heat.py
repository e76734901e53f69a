"""Beads that carry heat: exchange, energy balance, fluctuations, sources and walls against closed formulas."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pydlpoly import InputError, RunError, SceneError, Simulation
from pydlpoly.formats.diagnostics import read_diagnostics
from pydlpoly.runner import run_scene
from pydlpoly.scene.heat import LIMITED, WITH_HEAT
from pydlpoly.tradeoff import tradeoff

from .heat_scenes import fluid, heat, resting_pairs, set_temperatures, temperatures

CONDUCTING = ("capacity A 60", "pair A A kappa 0.05 range 1.3 exponent 2.0")


def test_two_beads_relax_as_the_differential_equation_says() -> None:
    """C dT_i/dt = C² κ(T̄) T̄² w² (1/T_i − 1/T_j); noise is of order 1e-5 at this heat capacity."""
    capacity, kappa, distance, reach, exponent = 1e10, 0.3e-10, 0.4, 1.2, 1.7
    terms = (0.5, -0.8, 0.3, 0.2)
    block = heat(
        f"capacity A {capacity} temperature 1.6",
        f"capacity B {capacity} temperature 0.7",
        f"pair A B kappa {kappa} range {reach} exponent {exponent} conductivity {' '.join(map(str, terms))}",
    )
    simulation = Simulation(resting_pairs(1, distance, block, 0.01), seed=3)
    weight = (1 - distance / reach) ** exponent

    def rate(_time: float, t: np.ndarray) -> list[float]:
        mean = t.mean()
        factor = 1 + sum(c * (mean - 1) ** k for k, c in enumerate(terms, 1))
        flow = capacity * kappa * factor * mean**2 * weight * (1 / t[0] - 1 / t[1])
        return [flow, -flow]

    solution = solve_ivp(rate, (0, 4), [1.6, 0.7], rtol=1e-10, atol=1e-12, t_eval=[1, 2, 4]).y
    found = []
    for steps in (100, 100, 200):
        simulation.run(steps)
        found.append(temperatures(simulation))
    np.testing.assert_allclose(np.transpose(found), solution, atol=2e-4)
    assert 0.1 < found[-1][0] - found[-1][1] < 0.6  # neither still far away nor at the end


def test_long_steps_do_not_overshoot() -> None:
    block = heat("capacity A 1e12 temperature 3.0", "capacity B 1e12 temperature 0.01", "pair A B kappa 1e-6 range 1.0")
    simulation = Simulation(resting_pairs(1, 0.3, block, 1.0), seed=3)
    simulation.run(1)
    np.testing.assert_allclose(temperatures(simulation), 1.505, rtol=1e-4)


@pytest.mark.parametrize("precision", ["double", "reference"])
def test_pairs_of_unequal_beads_share_their_energy_as_counting_says(precision: str) -> None:
    """ε_A/E of a pair has the density x^C_A (1 − x)^C_B: a beta distribution. Error of the mean 0.0004."""
    a, b = 8.0, 30.0
    block = heat(f"capacity A {a}", f"capacity B {b}", "pair A B kappa 0.1 range 1.0 conductivity 0.6 0 0 0")
    scene = resting_pairs(900, 0.3, block, 0.02, start_seed=1)
    simulation = Simulation(scene, seed=11, precision=precision)  # type: ignore[arg-type]
    simulation.run(400)
    samples = []
    for _ in range(60):
        simulation.run(40)
        t = temperatures(simulation)
        samples.append(a * t[:900] / (a * t[:900] + b * t[900:]))
    share = np.concatenate(samples)
    n = a + b + 2
    mean, variance = (a + 1) / n, (a + 1) * (b + 1) / (n * n * (n + 1))
    assert share.mean() == pytest.approx(mean, abs=0.0012)
    assert share.var() == pytest.approx(variance, rel=0.03)


@pytest.mark.parametrize("capacity", [1e-3, 0.5, 1e8])
def test_exchange_keeps_the_energy_of_every_pair(capacity: float) -> None:
    block = heat(f"capacity A {capacity} temperature 1e-5", f"capacity B {3 * capacity}", "pair A B kappa 2 range 1")
    simulation = Simulation(resting_pairs(50, 0.2, block, 0.05), seed=5)
    before = capacity * temperatures(simulation)[:50] + 3 * capacity * temperatures(simulation)[50:]
    simulation.run(300)
    after = capacity * temperatures(simulation)[:50] + 3 * capacity * temperatures(simulation)[50:]
    np.testing.assert_allclose(after, before, rtol=2e-13)
    assert (temperatures(simulation) > 0).all()


@pytest.mark.parametrize("order", [name for name in WITH_HEAT if name != "nve"])
def test_drag_and_noise_conserve_the_energy(order: str) -> None:
    """Without a potential nothing but round-off is left, whatever γ, s and κ do with the temperature."""
    drag = "" if order in LIMITED else "drag -0.4 0.1 0 0"
    block = heat(
        "capacity A 60",
        f"pair A A kappa 0.05 range 1.3 exponent 1.5 power 0.7 -0.2 0.1 0 conductivity 0.5 0 0 0 {drag}",
    )
    scene = fluid(block, order=order, laws=("A A dpd 0.0 1.0 4.5",), timestep=0.02)
    simulation = Simulation(scene, seed=2)
    rng = np.random.default_rng(1)
    set_temperatures(simulation, rng.uniform(1.0, 2.0, 375))
    start = simulation.observe().energy
    simulation.run(1)
    first = simulation.observe().energy["conserved"]
    simulation.run(299)
    end = simulation.observe().energy
    assert end["conserved"] == pytest.approx(start["conserved"], rel=2e-13)
    assert first == pytest.approx(start["conserved"], rel=2e-13)
    assert start["internal"] - end["internal"] > 100.0  # energy did change its form


@pytest.mark.parametrize("order", ["mdvv", "first", "ou-middle"])
def test_transverse_drag_and_exponent_are_part_of_the_balance(order: str) -> None:
    control = {"ensemble_dpd_exponent": "1.0"}
    if order != "mdvv":
        control["ensemble_dpd_transverse_drag"] = "0.7"
    scene = fluid(heat(*CONDUCTING), order=order, laws=("A A dpd 0.0 1.0 9.0",), control=control)
    simulation = Simulation(scene, seed=2)
    start = simulation.observe().energy["conserved"]
    simulation.run(200)
    assert simulation.observe().energy["conserved"] == pytest.approx(start, rel=2e-13)


@pytest.mark.parametrize("order", ["mdvv", "ou", "ou-middle"])
def test_total_energy_has_no_drift(order: str) -> None:
    """With a constant repulsion what is left is the error of velocity Verlet, which does not grow."""
    scene = fluid(heat(*CONDUCTING), order=order)
    simulation = Simulation(scene, seed=4)
    simulation.run(300)
    energies = []
    for _ in range(20):
        simulation.run(50)
        energies.append(simulation.observe().energy["conserved"])
    energies = np.array(energies)
    assert abs(np.polyfit(np.arange(20.0), energies, 1)[0] * 19) / energies.mean() < 3e-5


def test_bead_temperatures_fluctuate_as_their_heat_capacity_says() -> None:
    """⟨T⟩ = (C + 1)/C and Var T = (C + 1)/C² of the temperature that drag and noise see; stated error 2 %."""
    capacity = 40.0
    block = heat(f"capacity A {capacity}", "pair A A kappa 0.1 range 1.2")
    simulation = Simulation(fluid(block, timestep=0.02), seed=7)
    simulation.run(500)
    samples, kinetic = [], []
    for _ in range(200):
        simulation.run(20)
        samples.append(temperatures(simulation))
        kinetic.append(simulation.temperature)
    t = np.array(samples)
    inverse = 1 / (1 / t).mean()
    assert t.mean() == pytest.approx(inverse * (capacity + 1) / capacity, rel=1e-3)
    assert t.var() == pytest.approx(inverse**2 * (capacity + 1) / capacity**2, rel=0.04)
    assert np.mean(kinetic) == pytest.approx(inverse, rel=0.01)


def test_sources_bring_what_they_say() -> None:
    block = heat(
        "capacity A 50", "region hot layer y 1.0 2.0", "source region hot 0.3", "source sphere 0 0 0 1.5 -0.2",
        "source box -2.5 0 -1 1 -2.5 2.5 0.1", "source species A 0.05",
    )  # fmt: skip
    scene = fluid(block, order="nve", laws=("A A dpd 0.0 1.0",))
    simulation = Simulation(scene, seed=1)
    expected = np.ones(375)
    for _ in range(20):
        simulation.run(1)
        x, y, z = simulation.positions.T
        rate = 0.3 * ((y >= 1) & (y < 2)) - 0.2 * (x**2 + y**2 + z**2 < 1.5**2) + 0.05
        rate += 0.1 * ((x < 0) & (y >= -1) & (y < 1))
        expected += 0.01 * rate
    np.testing.assert_allclose(temperatures(simulation), expected, rtol=1e-13)
    energy = simulation.observe().energy
    assert energy["internal"] == pytest.approx(50 * expected.sum(), rel=1e-13)
    assert energy["conserved"] == pytest.approx(50 * 375 + energy["kinetic"], rel=1e-13)


def test_walls_keep_their_temperature_and_the_balance_closes() -> None:
    block = heat("capacity A 30", "capacity W 10", "wall W 2.0", "pair A A kappa 0.1 range 1.0",
                 "pair A W kappa 0.3 range 1.0")  # fmt: skip
    from .scene_builder import make_scene

    laws = ("A A dpd 0.0 1.0 4.5", "A W dpd 0.0 1.0 4.5", "W W dpd 0.0 1.0")
    for order in ("ou", "mdvv"):
        control = {"ensemble_dpd_order": order}
        scene = make_scene({"A": 300, "W": 75}, laws, cell=5.0, frozen=["W"], control=control, extensions=block)
        simulation = Simulation(scene, seed=3)
        start = simulation.observe().energy
        simulation.run(300)
        end = simulation.observe().energy
        t = temperatures(simulation)
        assert set(t[300:].tolist()) == {2.0}
        assert 1.2 < t[:300].mean() < 2.0
        assert end["conserved"] == pytest.approx(start["conserved"], rel=1e-12)


def test_restart_and_threads_give_the_same_bits(tmp_path) -> None:  # type: ignore[no-untyped-def]
    block = heat(
        "capacity A 60", "pair A A kappa 0.05 range 1.3 exponent 1.5 power 0.7 -0.2 0.1 0 drag -0.4 0.1 0 0",
        "source layer x 0 2 0.1", "repulsion scaled",
    )  # fmt: skip
    for order in ("mdvv", "ou-middle"):
        runs = []
        for threads in (1, 4):
            simulation = Simulation(fluid(block, order=order, beads=2200, cell=9.0), seed=8, threads=threads)
            simulation.run(15)
            simulation.save(tmp_path / "checkpoint")
            simulation.run(15)
            again = Simulation.resume(tmp_path / "checkpoint", threads=threads)
            assert again.observe().energy == pytest.approx(again.observe().energy)
            again.run(15)
            runs += [simulation, again]
        for first, second in pairwise(runs):
            assert temperatures(first).tobytes() == temperatures(second).tobytes()
            assert first.positions.tobytes() == second.positions.tobytes()
            assert first.velocities.tobytes() == second.velocities.tobytes()
            assert first.observe().energy == second.observe().energy


def test_a_checkpoint_remembers_the_energy_account(tmp_path) -> None:  # type: ignore[no-untyped-def]
    simulation = Simulation(fluid(heat(*CONDUCTING, "source species A 0.1"), order="mdvv"), seed=8)
    simulation.run(30)
    simulation.save(tmp_path / "checkpoint")
    again = Simulation.resume(tmp_path / "checkpoint")
    assert again.observe().energy == simulation.observe().energy


def test_mdvv_names_the_bead_that_has_too_little_heat() -> None:
    block = heat("capacity A 1e-3")
    simulation = Simulation(fluid(block, order="mdvv", timestep=0.05), seed=1)
    with pytest.raises(RunError, match=r"drag and noise take more heat from bead \d+ than it has"):
        simulation.run(50)


def test_a_scaled_repulsion_follows_the_mean_temperature_of_a_pair() -> None:
    scenes = [fluid(heat("capacity A 50", f"repulsion {word}"), order="nve") for word in ("constant", "scaled")]
    constant, scaled = (Simulation(scene, seed=1) for scene in scenes)
    assert scaled.observe().energy["pair"] == constant.observe().energy["pair"]
    set_temperatures(scaled, np.full(375, 1.7))
    assert scaled.observe().energy["pair"] == pytest.approx(1.7 * constant.observe().energy["pair"])
    np.testing.assert_allclose(scaled.state.forces, 1.7 * constant.state.forces, atol=1e-9)


def test_diagnostics_and_output_report_what_is_conserved(tmp_path) -> None:  # type: ignore[no-untyped-def]
    control = {"diagnostics_frequency": "5 steps", "print_frequency": "10 steps"}
    scene = fluid(heat(*CONDUCTING, "source species A 0.3"), order="mdvv", control=control)
    result = run_scene(scene, tmp_path, steps=20, seed=1, threads=1)
    columns = read_diagnostics(tmp_path / "DIAGNOSTICS")
    energy = result.simulation.energy
    assert columns["conserved_energy"][-1] == pytest.approx(energy["conserved"] / 375, rel=1e-14)
    assert columns["internal_energy"][-1] == pytest.approx(60 * columns["internal_temperature"][-1], rel=1e-8)
    drift = columns["conserved_energy"] - columns["conserved_energy"][0]
    np.testing.assert_allclose(columns["conserved_drift"], drift, atol=1e-9)
    assert abs(drift[-1]) < 0.01 < columns["internal_energy"][-1] - columns["internal_energy"][0]
    assert energy["conserved"] == pytest.approx(
        energy["total"] + energy["internal"] - 60 * 375 * 0.3 * 0.2, abs=30.0
    )  # what drag and noise do in half a kick
    printed = re.findall(r"conserved energy +(\S+)", (tmp_path / "OUTPUT").read_text())
    assert float(printed[-1]) == pytest.approx(energy["conserved"], rel=1e-14)


def test_a_checkpoint_goes_on_with_the_same_beads_only(tmp_path) -> None:  # type: ignore[no-untyped-def]
    warm, colder, none = (fluid(text) for text in (heat("capacity A 60"), heat("capacity A 50"), ""))
    for scene, other, message in (
        (warm, colder, "holds other heat capacities than"),
        (warm, none, "holds beads that carry heat, but the scene to go on with has beads that carry none"),
        (none, warm, "holds beads that carry none, but the scene to go on with has beads that carry heat"),
    ):
        Simulation(scene, seed=1).save(tmp_path / "checkpoint")
        with pytest.raises(InputError, match=message):
            Simulation.resume(tmp_path / "checkpoint", scene=other)


def test_a_scene_that_was_changed_is_checked_again() -> None:
    scene = fluid(heat("capacity A 60"))
    changed = replace(scene, dynamics=replace(scene.dynamics, integrator="middle"))
    with pytest.raises(SceneError, match="middle is not modelled with beads that carry heat"):
        Simulation(changed, seed=1)
    with pytest.raises(SceneError, match="no temperature that is the same for all integrators"):
        tradeoff(scene)
