"""Same inputs, same bits: whatever the threads, the link cells, the checkpoints and how often someone looks."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from pydlpoly import Scene, Simulation, State
from pydlpoly.scene.integrators import INTEGRATORS

from .scene_builder import NVE, make_scene

STEPS = 60
SEED = 20250705
MIXTURE = ["A A dpd 25.0 1.0 4.5", "A B dpd 40.0 0.9 9.0", "B B dpd 15.0 1.1 2.0"]


def mixture(**changes: object) -> Scene:
    """Two species with different masses, drags and ranges, in a cell of many link cells."""
    settings: dict[str, object] = {"cell": 5.0, "masses": {"A": 1.0, "B": 2.5}}
    return make_scene({"A": 220, "B": 150}, MIXTURE, **{**settings, **changes})  # type: ignore[arg-type]


def triclinic() -> Scene:
    return mixture(cell=[[5.0, 0.0, 0.0], [2.1, 4.6, 0.0], [-1.4, 1.7, 5.2]])


def below_three_cutoffs() -> Scene:
    return make_scene({"A": 30, "B": 20}, MIXTURE, cell=[2.5, 2.4, 3.2])


def below_one_cutoff() -> Scene:
    return make_scene({"A": 1, "B": 2}, MIXTURE, cell=[0.9, 1.0, 1.05], control={"timestep": "0.005 internal_t"})


def slab() -> Scene:
    return mixture(imcon=6, extern="grav 0.0 0.0 -0.1")


def predicted_with_other_weight() -> Scene:
    return mixture(control={"ensemble_dpd_lambda": "0.65", "ensemble_dpd_exponent": "1.0"})


def equilibrating() -> Scene:
    measures = {"time_equilibration": "50 steps", "rescale_frequency": "7 steps", "regauss_frequency": "20 steps"}
    return mixture(frozen=["B"], control={**measures, "equilibration_force_cap": "60.0 internal_f"})


def hard() -> Scene:
    """Lennard-Jones with the DPD thermostat, from a lattice."""
    places = 1.15 * (np.stack(np.meshgrid(*[np.arange(6)] * 3), axis=-1).reshape(-1, 3) - 2.5)
    lines = ["A A lj 1.0 1.0 1.0", "A B lj 0.7 1.1 1.0", "B B lj 1.2 0.95 2.0"]
    control: dict[str, str | None] = {"cutoff": "2.5 ang", "timestep": "0.004 internal_t"}
    return make_scene({"A": 116, "B": 100}, lines, cell=6.9, positions=places, control=control)


def hard_nve() -> Scene:
    places = 1.15 * (np.stack(np.meshgrid(*[np.arange(6)] * 3), axis=-1).reshape(-1, 3) - 2.5)
    control: dict[str, str | None] = {**NVE, "cutoff": "2.5 ang", "timestep": "0.004 internal_t"}
    return make_scene({"A": 216}, ["A A lj 1.0 1.0"], cell=6.9, positions=places, control=control)


def overlapping() -> Scene:
    """Forces far beyond the usual ones, which the sums must take without a trace on the other beads' bits."""
    places = 1.15 * (np.stack(np.meshgrid(*[np.arange(6)] * 3), axis=-1).reshape(-1, 3) - 2.5)
    places[[1, 77, 200]] = places[[0, 76, 199]] + [[0.35, 0.0, 0.1], [0.0, 0.2, 0.25], [0.05, 0.1, 0.15]]
    control = {"cutoff": "2.5 ang", "timestep": "0.001 internal_t", "time_equilibration": "40 steps"}
    cap = {"equilibration_force_cap": "500.0 internal_f"}
    return make_scene({"A": 216}, ["A A lj 1.0 1.0 2.0"], cell=6.9, positions=places, control={**control, **cap})


SCENES: dict[str, Callable[[], Scene]] = {
    build.__name__: build
    for build in (
        mixture,
        triclinic,
        below_three_cutoffs,
        below_one_cutoff,
        slab,
        predicted_with_other_weight,
        equilibrating,
        hard,
        hard_nve,
        overlapping,
    )
}


def of_order(order: str) -> Callable[[], Scene]:
    """The mixture with frozen beads stepped by another integrator; where it may, with the thermostat every 2 steps."""
    control = {"ensemble_dpd_order": order}
    if order in ("middle", "ou-middle"):
        control["ensemble_dpd_interval"] = "2"
    return lambda: mixture(control=control)


SCENES |= {order: of_order(order) for order in INTEGRATORS}
SCENES["middle on the general path"] = lambda: mixture(
    control={"ensemble_dpd_order": "middle", "ensemble_dpd_exponent": "1.0"}
)
SCENES["a temperature that varies"] = lambda: mixture(
    control={"temperature_times": "[ 0 1 ] internal_t", "temperature_values": "[ 1 3 ] dpd_temp"}
)


# Far from their pressure, so that the pair list has to follow a cell that changes by a fifth.
PISTON = {
    "timestep": "0.02 internal_t",
    "pressure_hydrostatic": "60 dpd_p",
    "ensemble_barostat_coupling": "0.5 internal_t",
    "ensemble_barostat_friction": "1 internal_t^-1",
}
SCENES["npt"] = lambda: mixture(control={**PISTON, "ensemble": "npt"})
SCENES["npt in a small cell"] = lambda: make_scene(
    {"A": 30, "B": 20}, MIXTURE, cell=[2.5, 2.4, 3.2], control={**PISTON, "ensemble": "npt"}
)
SCENES["nst middle"] = lambda: mixture(
    control={**PISTON, "ensemble": "nst", "ensemble_dpd_order": "middle", "ensemble_dpd_interval": "2"}
)
SCENES["nst of a square"] = lambda: mixture(
    control={
        **PISTON,
        "ensemble": "nst",
        "ensemble_dpd_order": "ou-middle",
        "ensemble_semi_isotropic": "tension",
        "ensemble_tension": "20 dpd_f/dpd_l",
        "ensemble_semi_orthorhombic": "on",
    }
)
SCENES["npt langevin"] = lambda: mixture(
    control={
        **PISTON,
        "ensemble": "npt",
        "ensemble_method": "langevin",
        "ensemble_dpd_order": None,
        "ensemble_thermostat_friction": "1 internal_t^-1",
    }
)


def assert_same_bits(a: State, b: State) -> None:
    for name in ("positions", "velocities", "forces", "images", "cell"):
        first, second = getattr(a, name), getattr(b, name)
        assert first.tobytes() == second.tobytes(), f"{name} differ by {np.abs(first - second).max():g}"
    assert (a.step, a.time) == (b.step, b.time)


def assert_same_observation(a: Simulation, b: Simulation) -> None:
    first, second = a.observe(), b.observe()
    assert first.energy == second.energy
    assert first.stress.tobytes() == second.stress.tobytes()
    for name, part in first.stress_parts.items():
        assert part.tobytes() == second.stress_parts[name].tobytes(), name
    assert first.momentum.tobytes() == second.momentum.tobytes()


@pytest.fixture(scope="module", params=SCENES)
def scene_and_reference(request: pytest.FixtureRequest) -> tuple[Scene, Simulation]:
    """A scene and its run with one thread and the usual cells."""
    scene = SCENES[request.param]()
    simulation = Simulation(scene, seed=SEED, threads=1)
    start = simulation.state
    simulation.run(STEPS)
    state = simulation.state
    assert np.isfinite(state.positions).all()
    assert not np.array_equal(state.positions, start.positions)
    return scene, simulation


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_threads_change_no_bit(scene_and_reference: tuple[Scene, Simulation], threads: int) -> None:
    scene, reference = scene_and_reference
    simulation = Simulation(scene, seed=SEED, threads=threads)
    simulation.run(STEPS)
    assert_same_bits(simulation.state, reference.state)
    assert_same_observation(simulation, reference)


@pytest.mark.parametrize("width", [0.45, 1.9, 100.0])
def test_cell_layout_changes_no_bit(scene_and_reference: tuple[Scene, Simulation], width: float) -> None:
    scene, reference = scene_and_reference
    simulation = Simulation(scene, seed=SEED, threads=2, cell_width=width)
    simulation.run(STEPS)
    assert_same_bits(simulation.state, reference.state)
    assert_same_observation(simulation, reference)


@pytest.mark.parametrize("chunk", [1, 10, 17])
def test_looking_changes_no_bit(scene_and_reference: tuple[Scene, Simulation], chunk: int) -> None:
    scene, reference = scene_and_reference
    simulation = Simulation(scene, seed=SEED, threads=1)
    while simulation.step < STEPS:
        simulation.run(min(chunk, STEPS - simulation.step))
        simulation.observe()
    assert_same_bits(simulation.state, reference.state)
    assert_same_observation(simulation, reference)


@pytest.mark.parametrize("first", [1, 30, 59])
def test_a_checkpoint_changes_no_bit(scene_and_reference: tuple[Scene, Simulation], first: int, tmp_path: Path) -> None:
    scene, reference = scene_and_reference
    simulation = Simulation(scene, seed=SEED, threads=1)
    simulation.run(first)
    simulation.save(tmp_path / "checkpoint")
    resumed = Simulation.resume(tmp_path / "checkpoint", threads=2)
    assert_same_bits(resumed.state, simulation.state)
    resumed.run(STEPS - first)
    simulation.run(STEPS - first)
    assert_same_bits(simulation.state, reference.state)
    assert_same_bits(resumed.state, reference.state)
    assert_same_observation(resumed, reference)
    assert np.array_equal(resumed.start_positions, reference.start_positions)


def test_a_checkpoint_observes_the_same(scene_and_reference: tuple[Scene, Simulation], tmp_path: Path) -> None:
    """A resumed simulation says the same about the step it was saved in."""
    _, reference = scene_and_reference
    reference.save(tmp_path / "checkpoint")
    resumed = Simulation.resume(tmp_path / "checkpoint", threads=1)
    assert resumed.energy == reference.energy
    assert resumed.temperature == reference.temperature
    assert resumed.observe().momentum.tobytes() == reference.observe().momentum.tobytes()
    conservative = resumed.observe().stress_parts["conservative"]
    assert conservative.tobytes() == reference.observe().stress_parts["conservative"].tobytes()


@pytest.mark.parametrize(("seed", "other"), [(0, 1), (0, 2**64 - 1), (1, 2**32 + 1), (2**64 - 1, 2**64 - 2)])
def test_seeds_matter_and_repeat(seed: int, other: int) -> None:
    def run(number: int) -> State:
        simulation = Simulation(mixture(), seed=number, threads=2)
        assert simulation.seed == number
        simulation.run(5)
        return simulation.state

    first, second = run(seed), run(other)
    assert_same_bits(first, run(seed))
    assert_same_bits(second, run(other))
    assert np.abs(first.velocities - second.velocities).min() > 0.0


@pytest.mark.parametrize("seed", [0, 2**64 - 1])
def test_extreme_seeds_survive_a_checkpoint(seed: int, tmp_path: Path) -> None:
    simulation = Simulation(mixture(), seed=seed, threads=1)
    simulation.run(5)
    simulation.save(tmp_path / "checkpoint")
    resumed = Simulation.resume(tmp_path / "checkpoint", threads=1)
    assert resumed.seed == seed
    simulation.run(5)
    resumed.run(5)
    assert_same_bits(simulation.state, resumed.state)


def test_noise_differs_in_every_step() -> None:
    """Two steps with the same positions and velocities must not feel the same noise."""
    scene = mixture()
    simulation = Simulation(scene, seed=SEED, threads=1)
    start = simulation.state
    simulation.run(1)
    later = Simulation(scene, seed=SEED, threads=1)
    later.run(1)
    later.set_state(positions=start.positions, velocities=start.velocities)
    assert not np.array_equal(later.state.forces, start.forces)


def test_distance_counts_survive_a_checkpoint_and_do_not_depend_on_threads(tmp_path: Path) -> None:
    scene = mixture(control={"rdf_calculate": "on", "rdf_frequency": "5 steps", "cutoff": "1.6 ang"})
    whole = Simulation(scene, seed=SEED, threads=1)
    whole.run(40)
    half = Simulation(scene, seed=SEED, threads=2)
    half.run(22)
    half.save(tmp_path / "checkpoint")
    resumed = Simulation.resume(tmp_path / "checkpoint", threads=3)
    resumed.run(18)
    (counts, samples), (other_counts, other_samples) = whole.distance_counts(), resumed.distance_counts()
    assert samples == other_samples == 8
    assert counts.sum() > 0
    assert np.array_equal(counts, other_counts)
