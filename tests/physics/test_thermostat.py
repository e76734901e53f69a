"""The DPD thermostat: exact pair forces, temperature against the timestep, mixtures, weights, diffusion, frozen beads.

Numbers called "table" are those of an independent harness, cross-checked with LAMMPS: ρ = 3, N = 1536, γ = 4.5,
k_B T = 1, means over 40 τ, each ± 0.004. Seeds are fixed; errors stated are standard errors of the averages here.
"""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly import Scene, Simulation, _core
from pydlpoly.formats.records import FloatArray

from ..scene_builder import make_scene
from .averages import equilibrated, sample

EDGE, BEADS = 8.0, 1536
NO_NOISE: dict[str, str | None] = {"temperature": "0.0 K"}


def fluid(strength: float, timestep: float, drag: float = 4.5, **control: str) -> Scene:
    """ρ = 3 of one species."""
    line = f"A A dpd {strength} 1.0 {drag}"
    return make_scene({"A": BEADS}, [line], cell=EDGE, control={"timestep": f"{timestep} internal_t", **control})


# The noise of each precision, as numbers to calculate with.
NOISE = {"double": _core.word_noise, "reference": _core.pair_noise}


def two_beads(exponent: float, velocity: FloatArray, **control: str) -> Scene:
    """Beads of masses 1 and 3 at 0.5 from each other along a slanted line, without conservative force."""
    positions = np.array([[0.15, 0.1, -0.2], [-0.15, 0.1, 0.2]])
    settings = {"ensemble_dpd_exponent": f"{exponent}", "timestep": "0.02 internal_t", "fixed_com": "off", **control}
    return make_scene(
        {"A": 1, "B": 1},
        ["A A dpd 0.0 1.0 1.0", "A B dpd 0.0 0.9 6.0", "B B dpd 0.0 1.0 1.0"],
        cell=6.0,
        positions=positions,
        velocities=velocity,
        masses={"A": 1.0, "B": 3.0},
        control=settings,
    )


@pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0, 4.0])
@pytest.mark.parametrize("precision", ["double", "reference"])
def test_drag_and_noise_of_one_pair_are_the_formulas(exponent: float, precision: str) -> None:
    """F = −γ w^D (e·v) e + √(2γk_BT w^D/Δt) ζ e with w^D = (1 − r/r_c)^s, at the pair's own γ and r_c."""
    velocity = np.array([[0.3, -0.8, 0.4], [-0.2, 0.1, 0.9]])
    unit = np.array([0.6, 0.0, -0.8])
    weight = (1.0 - 0.5 / 0.9) ** exponent
    drag = -6.0 * weight * float(unit @ (velocity[0] - velocity[1])) * unit
    control = {"precision": precision}
    cold = Simulation(two_beads(exponent, velocity, temperature="0.0 K", **control), seed=3, threads=1)
    assert cold.state.forces == pytest.approx(np.array([drag, -drag]), rel=1e-10, abs=1e-10)
    for seed in (3, 2**64 - 1):
        warm = Simulation(two_beads(exponent, velocity, temperature="1.7 dpd_temp", **control), seed=seed, threads=1)
        zeta = float(NOISE[precision](seed, 0, 0, 1))
        noise = np.sqrt(2.0 * 6.0 * 1.7 * weight / 0.02) * zeta * unit
        assert warm.state.forces[0] == pytest.approx(drag + noise, rel=1e-10, abs=1e-10)
        parts = warm.observe().stress_parts
        separation = 0.5 * unit
        assert parts["drag"] * 216.0 == pytest.approx(np.outer(drag, separation), rel=1e-10, abs=1e-10)
        assert parts["noise"] * 216.0 == pytest.approx(np.outer(noise, separation), rel=1e-10, abs=1e-10)


@pytest.mark.parametrize("precision", ["double", "reference"])
def test_one_step_is_groot_and_warrens(precision: str) -> None:
    """r, v and the predicted velocity of one step written out, for λ = 1/2 and 0.65."""
    velocity = np.array([[0.3, -0.8, 0.4], [-0.2, 0.1, 0.9]])
    mass, dt, seed = np.array([[1.0], [3.0]]), 0.02, 17
    for prediction in (0.5, 0.65, 1.0):
        scene = two_beads(2.0, velocity, ensemble_dpd_lambda=f"{prediction}", precision=precision)
        simulation = Simulation(scene, seed=seed, threads=1)
        r, v, force = scene.beads.positions, velocity, simulation.state.forces
        expected_r = r + dt * v + 0.5 * dt**2 * force / mass
        guess = v + prediction * dt * force / mass
        separation = expected_r[0] - expected_r[1]
        distance = float(np.linalg.norm(separation))
        unit, weight = separation / distance, 1.0 - distance / 0.9
        pull = -6.0 * weight**2 * float(unit @ (guess[0] - guess[1]))
        pull += np.sqrt(2.0 * 6.0 / dt) * weight * float(NOISE[precision](seed, 1, 0, 1))
        new_force = np.array([pull * unit, -pull * unit])
        simulation.run(1)
        state = simulation.state
        assert state.positions == pytest.approx(expected_r, rel=1e-12, abs=1e-12)
        assert state.forces == pytest.approx(new_force, rel=1e-9, abs=1e-9)
        assert state.velocities == pytest.approx(v + 0.5 * dt * (force + new_force) / mass, rel=1e-9)


# Table of T_kin against Δt. Errors here ± 0.0025, the table's ± 0.004.
@pytest.mark.slow
@pytest.mark.parametrize(
    ("strength", "prediction", "timestep", "expected"),
    [
        (25.0, 0.5, 0.01, 1.001),
        (25.0, 0.5, 0.02, 1.007),
        (25.0, 0.5, 0.04, 1.033),
        (25.0, 0.5, 0.06, 1.052),
        (25.0, 0.65, 0.02, 1.002),
        (25.0, 0.65, 0.04, 1.003),
        (25.0, 0.65, 0.06, 1.016),
        (0.0, 0.5, 0.01, 1.003),
        (0.0, 0.5, 0.02, 1.015),
        (0.0, 0.5, 0.04, 1.037),
        (0.0, 0.5, 0.06, 1.060),
        (0.0, 0.65, 0.04, 1.014),
        (0.0, 0.65, 0.06, 1.028),
    ],
)
def test_temperature_against_timestep(strength: float, prediction: float, timestep: float, expected: float) -> None:
    scene = fluid(strength, timestep, ensemble_dpd_lambda=f"{prediction}")
    simulation = equilibrated(scene, seed=21, steps=round(5.0 / timestep))
    averages = sample(simulation, round(40.0 / timestep), round(0.12 / timestep))
    assert averages.temperature == pytest.approx(expected, abs=0.015)
    assert averages.largest_momentum < 1e-10 * BEADS


@pytest.mark.slow
def test_both_species_have_the_temperature_whatever_their_mass_and_drag() -> None:
    """Masses 1 and 3, drags 1, 7 and 20: equipartition, which a wrong σ_ij or mass factor would break.

    750 beads of each and 24 τ: ± 0.005 for the light species, which relaxes slowest; Δt heats by less than 0.005.
    """
    lines = ["A A dpd 25.0 1.0 1.0", "A B dpd 30.0 1.0 7.0", "B B dpd 25.0 1.0 20.0"]
    control: dict[str, str | None] = {"timestep": "0.004 internal_t"}
    scene = make_scene({"A": 750, "B": 750}, lines, cell=500.0 ** (1 / 3), masses={"A": 1.0, "B": 3.0}, control=control)
    averages = sample(equilibrated(scene, seed=31, steps=1000), 6000, 20)
    assert averages.species_temperature == pytest.approx((1.0, 1.0), abs=0.015)
    assert averages.largest_momentum < 1e-10 * 1500


# s = 1 has 2.5 times the friction of s = 2; s = 4 has 0.29 times, hence its longer run.
# ± 0.004 each; Δt heats by 0.005.
@pytest.mark.slow
@pytest.mark.parametrize(("exponent", "drag", "duration"), [("1.0", 4.5, 20.0), ("4.0", 9.0, 40.0)])
def test_other_weights_keep_the_temperature(exponent: str, drag: float, duration: float) -> None:
    scene = fluid(25.0, 0.005, drag, ensemble_dpd_exponent=exponent)
    averages = sample(equilibrated(scene, seed=42, steps=2500), round(duration / 0.005), 20)
    assert averages.temperature == pytest.approx(1.005, abs=0.015)


@pytest.mark.slow
def test_self_diffusion_of_the_bare_thermostat() -> None:
    """D = 0.5203 published for γ = 6.75, ρ = 3, k_B T = 1, Δt = 0.04 without conservative force (OpenMM, LAMMPS).

    6 windows of 20 τ with 1500 beads, slope of the mean square displacement from 4 to 20 τ: ± 2 %.
    """
    scene = make_scene(
        {"A": 1500}, ["A A dpd 0.0 1.0 6.75"], cell=500.0 ** (1 / 3), control={"timestep": "0.04 internal_t"}
    )
    simulation = equilibrated(scene, seed=51, steps=150)
    times, slopes = np.arange(0.0, 20.01, 0.4), []
    for _ in range(6):
        origin = simulation.state.unwrapped
        displacement = [0.0]
        for _ in times[1:]:
            simulation.run(10)
            displacement.append(float(np.mean(np.sum((simulation.state.unwrapped - origin) ** 2, axis=1))))
        late = times >= 4.0
        slopes.append(np.polyfit(times[late], np.array(displacement)[late], 1)[0] / 6.0)
    assert float(np.mean(slopes)) == pytest.approx(0.52, rel=0.08)


@pytest.mark.slow
def test_self_diffusion_of_water() -> None:
    """D = 0.293 ± 0.004 (a = 25, γ = 4.5); 5 windows of 10 τ, slope from 2 to 10 τ: ± 2 %."""
    simulation = equilibrated(fluid(25.0, 0.02), seed=52, steps=250)
    times, slopes = np.arange(0.0, 10.01, 0.4), []
    for _ in range(5):
        origin = simulation.state.unwrapped
        displacement = [0.0]
        for _ in times[1:]:
            simulation.run(20)
            displacement.append(float(np.mean(np.sum((simulation.state.unwrapped - origin) ** 2, axis=1))))
        late = times >= 2.0
        slopes.append(np.polyfit(times[late], np.array(displacement)[late], 1)[0] / 6.0)
    assert float(np.mean(slopes)) == pytest.approx(0.293, rel=0.07)


@pytest.mark.slow
def test_frozen_beads_stay_and_the_others_keep_the_temperature() -> None:
    """A third of the beads is frozen and takes part in drag and noise as a bath. 1000 mobile beads, 30 τ: ± 0.004."""
    lines = ["A A dpd 25.0 1.0 4.5", "A W dpd 25.0 1.0 4.5", "W W dpd 25.0 1.0 4.5"]
    scene = make_scene({"A": 1000, "W": 500}, lines, cell=500.0 ** (1 / 3), frozen=["W"])
    simulation = Simulation(scene, seed=61, threads=1)
    start = simulation.state
    assert not start.velocities[1000:].any()
    simulation.run(500)
    averages = sample(simulation, 3000, 10)
    state = simulation.state
    assert np.array_equal(state.positions[1000:], start.positions[1000:])
    assert not state.images[1000:].any()
    assert not state.velocities[1000:].any()
    assert not state.forces[1000:].any()
    assert averages.species_temperature == pytest.approx((1.0,), abs=0.012)
    assert averages.temperature == pytest.approx(1.0, abs=0.012)
    assert scene.degrees_of_freedom == 3 * 1000


@pytest.mark.slow
@pytest.mark.parametrize(("edge", "beads"), [(1.5, 10), (0.9, 3), (0.4, 2)])
def test_every_image_of_a_pair_has_its_own_noise(edge: float, beads: int) -> None:
    """Boxes below two cutoffs: drag adds up over the images of a pair, so their noises must be independent.

    One noise for all images cancels between opposite ones: T = 0.16 at an edge of 0.9 and 0.00 at 0.4 in a NumPy
    emulation. 300 τ and more: ± 0.015.
    """
    scene = make_scene({"A": beads}, ["A A dpd 1.0 1.0 1.5"], cell=edge, control={"timestep": "0.01 internal_t"})
    averages = sample(equilibrated(scene, seed=81, steps=1000), 30000 * 10 // beads, 20)
    assert averages.temperature == pytest.approx(1.0, abs=0.05)


def test_drag_alone_cools_in_every_step() -> None:
    scene = make_scene({"A": 600}, ["A A dpd 0.0 1.0 4.5"], cell=200.0 ** (1 / 3), control=NO_NOISE)
    simulation = Simulation(scene, seed=71, threads=1)
    simulation.set_state(velocities=zero_mean(np.random.default_rng(1).normal(size=(600, 3))))
    kinetic = [simulation.energy["kinetic"]]
    for _ in range(300):
        simulation.run(1)
        kinetic.append(simulation.energy["kinetic"])
    assert np.all(np.diff(kinetic) < 0.0)
    # A single bead's friction of 1.885 per τ would leave exp(−2·1.885·3) = 1e-5; collective motion decays later.
    assert kinetic[-1] < 0.1 * kinetic[0]
    assert np.abs(simulation.observe().momentum).max() < 1e-10 * 600
    assert not simulation.observe().stress_parts["noise"].any()


def test_temperature_0_takes_the_energy_out_of_a_soft_fluid() -> None:
    """From a random start at rest the total energy falls all the time, and most of what moved comes to rest."""
    simulation = Simulation(fluid(25.0, 0.005, temperature="0.0 K"), seed=72, threads=1)
    energies = [simulation.energy]
    for _ in range(80):
        simulation.run(10)
        energies.append(simulation.energy)
    assert np.all(np.diff([energy["total"] for energy in energies]) < 0.0)
    kinetic = [energy["kinetic"] for energy in energies]
    assert kinetic[0] == 0.0
    assert kinetic[-1] < 0.1 * max(kinetic)


def zero_mean(velocities: FloatArray) -> FloatArray:
    return np.asarray(velocities - velocities.mean(axis=0))
