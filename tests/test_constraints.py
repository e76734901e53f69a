"""Fixed distances: closed formulas, lengths in every step, energy, the virial, starts, stops, threads, restarts."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ellipk

from pydlpoly import RunError, Scene, Simulation
from pydlpoly.formats.records import FloatArray
from pydlpoly.reporters import OutputReporter, statistics_record
from pydlpoly.scene.integrators import WITH_CONSTRAINTS

from .molecule_builder import molecule_scene

CELL = 6.0
SIDE = 0.5
TRIANGLE = {"constraints": [f"1 2 {SIDE}", f"1 3 {SIDE}", f"2 3 {SIDE}"]}
MASSES = {"O": 2.0, "H": 0.5}
PAIRS = ("O O dpd 25.0 1.0 4.5", "O H dpd 25.0 1.0 4.5", "H H dpd 25.0 1.0 4.5")
FINE = {"shake_tolerance": "1e-11 ang"}
DPD = {"ensemble": "nvt", "ensemble_method": "dpd", "ensemble_dpd_order": "mdvv"}
INTEGRATORS: dict[str, dict[str, str]] = {
    "nve": {},
    "mdvv": DPD,
    "mdvv-lambda": {**DPD, "ensemble_dpd_lambda": "0.65"},
    "dpdvv": {**DPD, "ensemble_dpd_order": "dpdvv"},
    **{
        order: {**DPD, "ensemble_dpd_order": order}
        for order in (
            "zeroth",
            "first",
            "second",
            "peters",
            "peters-first",
            "lowe-andersen",
            "ou",
            "ou-middle",
            "middle",
        )
    },
    "interval": {**DPD, "ensemble_dpd_order": "middle", "ensemble_dpd_interval": "3"},
    "stoyanov-groot": {**DPD, "ensemble_dpd_order": "stoyanov-groot", "ensemble_dpd_coupling": "1.0 dpd_m/dpd_t"},
    "langevin": {"ensemble": "nvt", "ensemble_method": "langevin", "ensemble_thermostat_friction": "2.0 internal_t^-1"},
    "berendsen": {"ensemble": "nvt", "ensemble_method": "berendsen", "ensemble_thermostat_coupling": "1 internal_t"},
    "hoover": {"ensemble": "nvt", "ensemble_method": "hoover", "ensemble_thermostat_coupling": "1 internal_t"},
}
EVERY = pytest.mark.parametrize("integrator", INTEGRATORS)


def triangles(copies: int, seed: int = 1) -> FloatArray:
    """(3 · copies, 3) equilateral triangles in random places and directions."""
    rng = np.random.default_rng(seed)
    shape = SIDE * np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, np.sqrt(0.75), 0.0]])
    turns = [np.linalg.qr(rng.normal(size=(3, 3)))[0] for _ in range(copies)]
    return np.concatenate([(rng.random(3) - 0.5) * CELL + shape @ turn for turn in turns])


def waters(copies: int = 30, control: Mapping[str, str | None] | None = None, **changes: object) -> Scene:
    """Rigid triangles of unequal masses that repel each other."""
    settings = {**FINE, **(control or {})}
    given: dict[str, object] = {"pairs": PAIRS, "positions": triangles(copies), **changes}
    return molecule_scene("OHH", TRIANGLE, copies=copies, cell=CELL, masses=MASSES, control=settings, **given)  # type: ignore[arg-type]


def arms(scene: Scene, positions: FloatArray) -> FloatArray:
    """Shortest vectors between the beads of all constraints, from outside the core."""
    assert scene.constraints is not None
    i, j = scene.constraints.beads.T
    apart = positions[i] - positions[j]
    edges = np.diag(scene.cell)
    return np.asarray(apart - edges * np.rint(apart / edges))


def deviation(simulation: Simulation) -> float:
    constraints = simulation.scene.constraints
    assert constraints is not None
    lengths = np.linalg.norm(arms(simulation.scene, simulation.state.positions), axis=1)
    return float(np.abs(lengths - constraints.lengths).max())


def stretching(simulation: Simulation) -> float:
    """The largest speed at which a fixed distance would change."""
    constraints = simulation.scene.constraints
    assert constraints is not None
    i, j = constraints.beads.T
    v = simulation.state.velocities
    along = np.einsum("ka,ka->k", arms(simulation.scene, simulation.state.positions), v[i] - v[j])
    return float(np.abs(along / constraints.lengths).max())


def test_every_integrator_is_tried() -> None:
    assert set(WITH_CONSTRAINTS) == set(INTEGRATORS) - {"mdvv-lambda", "interval"}


def test_rotor() -> None:
    """A free dumbbell turns by arcsin(ω Δt) in every step and keeps its speed; its virial is that of μ ω² d."""
    speed, timestep, steps = 3.0, 0.01, 1000
    positions = np.array([[0.3, 2.9, 0.0], [-0.7, 2.9, 0.0]])  # through the cell's faces
    velocities = speed * np.array([[0.0, 1.0 / 3.0, 0.0], [0.0, -2.0 / 3.0, 0.0]])
    scene = molecule_scene(
        "AB",
        {"constraints": ["2 1 1.0"]},
        positions,
        masses={"A": 2.0, "B": 1.0},
        cell=CELL,
        velocities=velocities,
        control={**FINE, "timestep": f"{timestep} internal_t", "cutoff": "2.0 ang"},
    )
    simulation = Simulation(scene, threads=1)
    assert scene.degrees_of_freedom == 2
    for _ in range(2):
        seen = simulation.observe()
        energy = 0.5 * (2.0 / 3.0) * speed**2
        assert seen.energy["kinetic"] == pytest.approx(energy, rel=1e-10)
        assert seen.temperature == pytest.approx(energy, rel=1e-10)
        assert seen.constraint_virial == pytest.approx(2.0 * energy, rel=1e-10)
        assert seen.virial == seen.constraint_virial
        # A dumbbell at rest in its centre has no pressure: its rods pull as much as its beads push.
        assert seen.pressure == pytest.approx(0.0, abs=1e-10)
        simulation.run(steps)
    arm = -np.subtract(*simulation.state.unwrapped)
    angle = 2 * steps * np.arcsin(speed * timestep)
    assert -arm == pytest.approx([np.cos(angle), np.sin(angle), 0.0], abs=1e-8)


def test_pendulum() -> None:
    """A bead on a rod from a frozen one: the period of a wide swing, 4 √(L/g) K(sin ½θ), and its energy."""
    length, gravity, widest = 0.8, 5.0, 1.2
    period = 4.0 * np.sqrt(length / gravity) * float(ellipk(np.sin(0.5 * widest) ** 2))
    errors = []
    for steps in (200, 400):
        scene = molecule_scene(
            "AB",
            {"constraints": [f"1 2 {length}"]},
            [[0.0, 0.0, 0.0], [length * np.sin(widest), 0.0, -length * np.cos(widest)]],
            frozen=[0],
            extern=f"grav 0.0 0.0 {-gravity}",
            velocities=np.zeros((2, 3)),
            cell=CELL,
            control={**FINE, "timestep": f"{float(period / steps)!r} internal_t", "fixed_com": "off"},
        )
        assert scene.degrees_of_freedom == 2
        simulation = Simulation(scene, threads=1)
        heights, energies = [], []
        for _ in range(8):
            simulation.run(steps // 4)
            bead = simulation.state.positions[1]
            heights.append(bead[2])
            energies.append(simulation.observe().energy["kinetic"] + gravity * bead[2])
        lowest = -length + 0.0 * np.array(heights[::2])
        assert heights[::2] == pytest.approx(lowest, abs=1e-4)
        assert not simulation.state.positions[0].any()
        errors.append(max(abs(heights[-1] + length * np.cos(widest)), np.ptp(energies)))
    assert errors[0] < 2e-3
    assert errors[1] < 0.3 * errors[0]


@EVERY
@pytest.mark.parametrize("tolerance", [1e-4, 1e-9])
def test_lengths_in_every_step(integrator: str, tolerance: float) -> None:
    control = {**INTEGRATORS[integrator], "shake_tolerance": f"{tolerance} ang"}
    simulation = Simulation(waters(control=control), seed=2, threads=1)
    for step in range(60):
        assert deviation(simulation) <= tolerance * (1.0 + 1e-6) + 1e-14
        assert stretching(simulation) <= tolerance / 0.01 * (1.0 + 1e-6) + 1e-12
        simulation.run(1)
        assert simulation.step == step + 1
    assert np.abs(simulation.displacements()).max() > 0.3
    if integrator not in ("langevin",):
        assert np.abs(simulation.observe().momentum).max() < 1e-11


def test_energy_is_conserved_to_second_order_over_long_runs() -> None:
    """1e4 steps of a triangle that springs hold: the spread of the energy goes with Δt², without drift."""
    spreads = []
    for timestep in (0.01, 0.005):
        scene = molecule_scene(
            "OHH",
            {
                "constraints": ["1 2 0.5", "1 3 0.6", "2 3 0.7"],
                "teth": ["harm 1 200.0", "harm 2 90.0", "harm 3 50.0"],
            },
            [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.12, np.sqrt(0.36 - 0.12**2), 0.0]],
            cell=CELL,
            masses=MASSES,
            velocities=[[0.1, 0.2, 0.7], [0.5, -1.0, -0.8], [1.0, 0.3, 0.9]],
            control={**FINE, "timestep": f"{timestep} internal_t", "fixed_com": "off"},
        )
        simulation = Simulation(scene, threads=1)
        energies = []
        for _ in range(2000):
            simulation.run(5)
            energies.append(simulation.observe().energy["total"])
        assert simulation.step == 10000
        trend = np.polynomial.polynomial.polyfit(np.linspace(-0.5, 0.5, len(energies)), energies, 1)
        spreads.append(float(np.std(energies)))
        assert abs(trend[1]) < 0.2 * spreads[-1]
        assert deviation(simulation) <= 1.1e-11
    assert 1e-6 < spreads[0] / np.mean(energies) < 1e-3
    assert spreads[0] / spreads[1] == pytest.approx(4.0, rel=0.05)


def test_energy_of_triangles_that_collide() -> None:
    start = Simulation(waters(20, INTEGRATORS["langevin"]), seed=1, threads=1)
    start.run(500)
    state = start.state
    scene = waters(20, {"timestep": "0.005 internal_t"}, positions=state.positions, velocities=state.velocities)
    simulation = Simulation(scene, threads=1)
    before = simulation.observe().energy["total"]
    simulation.run(10000)
    assert simulation.observe().energy["total"] == pytest.approx(before, rel=1e-3)


def test_virial_of_constraints() -> None:
    """The forces that keep |r_i − r_j| from changing, from a solution of all equations at once with NumPy."""
    scene = waters(10)
    simulation = Simulation(scene, seed=3, threads=1)
    simulation.run(7)
    state, constraints = simulation.state, scene.constraints
    assert constraints is not None
    d, count = arms(scene, state.positions), scene.bead_count
    gradient = np.zeros((len(d), count, 3))
    for k, (i, j) in enumerate(constraints.beads):
        gradient[k, i], gradient[k, j] = d[k], -d[k]
    weighted = gradient / scene.beads.mass[:, None]
    i, j = constraints.beads.T
    apart = state.velocities[i] - state.velocities[j]
    right = -np.einsum("ka,ka->k", apart, apart) - np.einsum("kia,ia->k", weighted, state.forces)
    strength = np.linalg.solve(np.einsum("kia,lia->kl", gradient, weighted), right)
    wanted = np.einsum("k,ka,kb->ab", strength, d, d)
    seen = simulation.observe()
    found = seen.stress_parts["constraint"] * seen.volume
    assert found == pytest.approx(wanted, abs=1e-10 * np.abs(wanted).max())
    assert seen.constraint_virial == pytest.approx(-wanted.trace())
    assert seen.stress == pytest.approx(np.sum(list(seen.stress_parts.values()), axis=0))
    assert statistics_record(simulation).constraint_virial == seen.constraint_virial
    assert statistics_record(simulation).virial == pytest.approx(seen.pair_virial + seen.constraint_virial)


@pytest.mark.parametrize("integrator", ["nve", "hoover", "berendsen"])
def test_pressure_of_free_molecules(integrator: str) -> None:
    """Whatever holds their beads together, P V = ⅔ of the kinetic energy of the centres of mass, at every instant."""
    simulation = Simulation(waters(30, {**INTEGRATORS[integrator], "cutoff": "1.0 ang"}, pairs=()), seed=3, threads=1)
    mass = simulation.scene.beads.mass[:3, None]
    for _ in range(3):
        seen = simulation.observe()
        centres = (mass * simulation.state.velocities.reshape(-1, 3, 3)).sum(axis=1) / mass.sum()
        assert seen.pressure == pytest.approx(mass.sum() * (centres**2).sum() / (3.0 * seen.volume), rel=1e-9)
        assert seen.stress_parts["kinetic"].trace() / 3.0 > 1.3 * seen.pressure
        simulation.run(50)


def test_constraints_are_left_out_of_pair_forces_and_of_the_fast_path() -> None:
    scene = waters(10, DPD)
    assert scene.bonded is not None
    assert len(scene.bonded.excluded) == scene.constraint_count == 30
    assert scene.degrees_of_freedom == 3 * 30 - 3 - 30
    text = scene.explain()
    assert "constraints: 30 fixed at 0.5 (FIELD:11-13), by SHAKE and RATTLE" in text
    assert "general path: distances are fixed by constraints" in text
    assert "not in this scene, at no cost: bonded terms" in text


@pytest.mark.parametrize("start", ["clean", "rescale", "noscale"])
def test_starts(start: str) -> None:
    """Positions and velocities of the file need not be right; drawn and scaled velocities have the temperature."""
    rng = np.random.default_rng(4)
    positions = triangles(30) + rng.normal(scale=0.02, size=(90, 3))
    velocities = rng.normal(size=(90, 3))
    scene = waters(30, {"restart": start}, positions=positions, velocities=velocities)
    assert any("beads are moved to the lengths of constraints" in note.text for note in scene.notes)
    simulation = Simulation(scene, seed=1, threads=1)
    assert deviation(simulation) <= 1e-11
    assert stretching(simulation) <= 1e-9
    if start != "noscale":
        assert simulation.temperature == pytest.approx(1.0, rel=1e-12)
    assert np.abs(simulation.observe().momentum).max() < 1e-12
    assert not simulation.displacements().any()
    mass = scene.beads.mass[:, None]
    moves = simulation.state.positions - positions
    moves -= CELL * np.rint(moves / CELL)
    centres = (mass * moves).reshape(30, 3, 3).sum(axis=1)
    assert np.abs(centres).max() < 1e-13, "the centres of mass stay"


def test_equilibration_keeps_lengths_and_temperature() -> None:
    control = {"time_equilibration": "20 steps", "regauss_frequency": "5 steps", "rescale_frequency": "2 steps"}
    simulation = Simulation(waters(control=control), seed=1, threads=1)
    for _ in range(4):
        simulation.run(5)
        assert stretching(simulation) <= 2e-9  # scaling follows the projection
        assert simulation.temperature == pytest.approx(1.0, rel=1e-10)


def test_set_state_meets_the_constraints() -> None:
    simulation = Simulation(waters(), seed=1, threads=1)
    rng = np.random.default_rng(2)
    simulation.set_state(positions=triangles(30, seed=5) + rng.normal(scale=0.01, size=(90, 3)))
    simulation.set_state(velocities=rng.normal(size=(90, 3)))
    assert deviation(simulation) <= 1e-11
    assert stretching(simulation) <= 1e-9
    assert np.isnan(simulation.configurational_temperature)


@EVERY
def test_same_bits_for_any_threads_and_after_a_restart(integrator: str, tmp_path: Path) -> None:
    scene = waters(300, {**INTEGRATORS[integrator], "shake_tolerance": "1e-6 ang"})
    first, second = Simulation(scene, seed=3, threads=1), Simulation(scene, seed=3, threads=4)
    first.run(6)
    second.run(4)
    second.save(tmp_path / "REVIVE")
    third = Simulation.resume(tmp_path / "REVIVE", threads=3)
    assert third.observe().constraint_virial == second.observe().constraint_virial
    for simulation in (second, third):
        simulation.run(2)
        for name in ("positions", "velocities", "forces"):
            assert np.array_equal(getattr(simulation.state, name), getattr(first.state, name))
        assert np.array_equal(simulation.observe().stress, first.observe().stress)


def test_output(tmp_path: Path) -> None:
    simulation = Simulation(waters(10, {"stats_frequency": "1 steps", "print_frequency": "1 steps"}), seed=3, threads=1)
    reporter = OutputReporter(simulation, tmp_path / "OUTPUT")
    simulation.reporters.append(reporter)
    simulation.run(3)
    summary = reporter.finish(simulation, [], {})
    reporter.close()
    assert "constraint" in summary.pressure_parts
    assert "of which constraint" in (tmp_path / "OUTPUT").read_text()


@pytest.mark.parametrize(
    ("velocity", "control", "message"),
    [
        (
            200.0,
            {},
            "step 1: the constraint of beads 1 and 2 is not met: positions (SHAKE) are not found in 250 iterations "
            "(shake_max_iter) to 1e-11 (shake_tolerance); its length is 2.23607 instead of 1; the timestep is too long "
            "for the forces or velocities, or the lengths contradict each other",
        ),
        (
            20.0,
            {"shake_max_iter": "1"},
            "step 1: the constraint of beads 1 and 2 is not met: positions (SHAKE) are not found in 1 iterations "
            "(shake_max_iter) to 1e-11 (shake_tolerance); its length is 1.0002 instead of 1; the timestep is too long "
            "for the forces or velocities, or the lengths contradict each other",
        ),
    ],
    ids=["turned", "iterations"],
)
def test_constraints_that_are_not_met(velocity: float, control: dict[str, str], message: str) -> None:
    """DL_POLY's error 105."""
    scene = molecule_scene(
        "AA",
        {"constraints": ["1 2 1.0"]},
        [[0.5, 0.0, 0.0], [-0.5, 0.0, 0.0]],
        velocities=[[0.0, 0.5 * velocity, 0.0], [0.0, -0.5 * velocity, 0.0]],
        control={**FINE, "cutoff": "2.0 ang", **control},
    )
    with pytest.raises(RunError) as caught:
        Simulation(scene, threads=1).run(1)
    assert str(caught.value) == message


def test_lengths_that_contradict_each_other() -> None:
    """A triangle whose third side is longer than the other two together."""
    blocks = {"constraints": ["1 2 0.5", "2 3 0.5", "1 3 1.2"]}
    with pytest.raises(RunError, match=r"^step 0: the constraint of beads \d and \d is not met"):
        Simulation(
            molecule_scene("AAA", blocks, [[0, 0, 0], [0.5, 0, 0], [0.9, 0.3, 0]], control={"cutoff": "2.0 ang"})
        )
