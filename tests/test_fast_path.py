"""The fast path of every instruction set that this processor has: against the general path, and by its own promises."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import combinations_with_replacement

import numpy as np
import pytest

from pydlpoly import Scene, Simulation
from pydlpoly.errors import PydlpolyError, RunError
from pydlpoly.formats.records import FloatArray
from pydlpoly.scene.model import Precision

from .scene_builder import NVE, make_scene

SEED = 77
SETS = ("plain", "avx2", "avx512")
PRECISIONS: tuple[Precision, ...] = ("double", "mixed")
TOLERANCE = {"double": 1e-12, "mixed": 1e-6}  # of forces, relative to the largest one


def dyadic_positions(count: int, edges: FloatArray, seed: int) -> FloatArray:
    """(count, 3) uniform positions at multiples of edge/2²⁰, which every path represents exactly."""
    steps = np.random.default_rng(seed).integers(-(2**19), 2**19, size=(count, 3))
    return np.asarray(steps * edges / 2.0**20)


def fluid(
    density: float = 3.0,
    cell: tuple[float, float, float] = (6.0, 6.0, 6.0),
    kinds: int = 1,
    frozen: int = 0,
    place: Callable[[FloatArray], FloatArray] = lambda positions: positions,
    control: dict[str, str | None] | None = None,
) -> Scene:
    """Random beads of several species, the last ``frozen`` of which do not move."""
    names = [f"S{k}" for k in range(kinds)]
    each = round(density * math.prod(cell) / kinds)
    if kinds == 1:
        pairs = ["S0 S0 dpd 25.0 1.0 4.5"]
    else:
        pairs = [
            f"{a} {b} dpd {20.0 + 3.0 * i + 2.0 * j} {1.0 - 0.02 * ((i + j) % 5)} {3.0 + 0.5 * i + 0.25 * j}"
            for (i, a), (j, b) in combinations_with_replacement(enumerate(names), 2)
        ]
    return make_scene(
        dict.fromkeys(names, each),
        pairs,
        cell=np.array(cell),
        positions=place(dyadic_positions(each * kinds, np.array(cell), 5)),
        masses={name: 1.0 + 0.5 * k for k, name in enumerate(names)},
        frozen=names[kinds - frozen :],
        control={"timestep": "0.02 internal_t", **(control or {})},
    )


def clusters(*sizes: int) -> Callable[[FloatArray], FloatArray]:
    """Puts that many beads each into balls of diameter 0.87 around two points a cell's width from two faces."""

    def place(positions: FloatArray) -> FloatArray:
        first = 0
        for k, size in enumerate(sizes):
            ball = dyadic_positions(size, np.full(3, 0.5), 9 + k)
            positions[first : first + size] = ball + (-2.0 if k % 2 else 2.0)
            first += size
        return positions

    return place


def coincident(positions: FloatArray) -> FloatArray:
    positions[1::7] = positions[0::7][: len(positions[1::7])]
    return positions


def squeezed(positions: FloatArray) -> FloatArray:
    return positions * np.array([0.5, 1.0, 1.0])


SCENES: dict[str, Callable[[], Scene]] = {
    "cubic": lambda: fluid(),
    "cubic, cells wider than the cutoff": lambda: fluid(cell=(4.9, 4.9, 4.9)),
    "edges 1 : 1.5 : 1.2": lambda: fluid(cell=(5.0, 7.5, 6.0)),
    "edges 4 : 7.9 : 16.3": lambda: fluid(cell=(4.0, 7.9, 16.3)),
    "density 1": lambda: fluid(1.0, (9.0, 8.0, 8.0)),
    "density 6": lambda: fluid(6.0),
    "density 7, blocks of one cell": lambda: fluid(7.0, (5.0, 5.0, 6.0)),
    "half the box empty, density 10 in the other": lambda: fluid(5.0, (8.0, 5.0, 6.0), place=squeezed),
    "three kinds": lambda: fluid(kinds=3),
    "three kinds, one frozen, not cubic": lambda: fluid(kinds=3, frozen=1, cell=(5.0, 7.5, 6.0)),
    "six kinds": lambda: fluid(kinds=6),
    "twelve kinds, two frozen": lambda: fluid(kinds=12, frozen=2),
    "balls of 64, 65 and 66 beads": lambda: fluid(place=clusters(64, 65, 66)),
    "balls of 150 and 257 beads": lambda: fluid(place=clusters(150, 257)),
    "all beads in one ball": lambda: fluid(place=clusters(648)),
    "coincident beads": lambda: fluid(place=coincident),
    "no drag": lambda: fluid(control=NVE),
    "no drag, three kinds": lambda: fluid(kinds=3, control=NVE),
}


@pytest.fixture(params=SETS)
def instruction_set(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Simulations made while this fixture lives use these instructions; skipped where they cannot be had."""
    name = str(request.param)
    monkeypatch.setenv("PYDLPOLY_SIMD", name)
    try:
        simulation = Simulation(fluid(1.0, (4.0, 4.0, 4.0)), seed=1)
    except (PydlpolyError, ValueError) as error:
        if name == "plain" or "expected plain, avx2 or avx512" not in str(error):
            raise
        pytest.skip(f"this processor or this build has no {name}")
    assert plan_of(simulation) == f"fast: {name}"
    return name


def plan_of(simulation: Simulation) -> str:
    return simulation._engine.system.plan()


def general(scene: Scene, precision: Precision) -> Simulation:
    """The scene on the general path: an exponent that is 2 but for one bit changes forces by rounding only."""
    dynamics = replace(scene.dynamics, weight_exponent=math.nextafter(2.0, 3.0))
    if dynamics.integrator == "nve":
        precision, dynamics = "reference", scene.dynamics  # without noise, precision changes nothing there
    simulation = Simulation(replace(scene, dynamics=dynamics), seed=SEED, precision=precision, threads=1)
    assert plan_of(simulation).startswith("general: ")
    return simulation


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("name", SCENES)
def test_forces_and_totals_are_those_of_the_general_path(instruction_set: str, name: str, precision: Precision) -> None:
    scene = SCENES[name]()
    fast = Simulation(scene, seed=SEED, precision=precision, threads=1)
    assert plan_of(fast) == f"fast: {instruction_set}"
    slow = general(scene, precision)
    largest = np.abs(slow.state.forces).max()
    assert largest > 10.0
    assert np.abs(fast.state.forces - slow.state.forces).max() < TOLERANCE[precision] * largest
    first, second = fast.observe(), slow.observe()
    assert first.energy["pair"] == pytest.approx(second.energy["pair"], rel=TOLERANCE[precision])
    scale = max(np.abs(part).max() for part in second.stress_parts.values())
    for key, part in second.stress_parts.items():
        assert np.abs(first.stress_parts[key] - part).max() < TOLERANCE[precision] * scale, key


STEPPERS: dict[str, dict[str, str | None]] = {
    "mdvv": {},
    "mdvv, lambda 0.85": {"ensemble_dpd_lambda": "0.85"},
    "mdvv, lambda 0.4, half-step temperature": {"ensemble_dpd_lambda": "0.4", "ensemble_dpd_kinetic": "half"},
    "middle": {"ensemble_dpd_order": "middle"},
    "middle, 1 pass": {"ensemble_dpd_order": "middle", "ensemble_dpd_passes": "1"},
    "middle, 2 passes, every 2": {
        "ensemble_dpd_order": "middle",
        "ensemble_dpd_passes": "2",
        "ensemble_dpd_interval": "2",
    },
    "middle, every 3": {"ensemble_dpd_order": "middle", "ensemble_dpd_interval": "3"},
    "nve": {**NVE, "fixed_com": "off"},
}


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize("kinds", [1, 3])
def test_steps_are_those_of_the_general_path(
    instruction_set: str, kinds: int, stepper: str, precision: Precision
) -> None:
    """Ten steps, after which rounding has grown to some hundred times its size and physics would be far away."""
    scene = fluid(kinds=kinds, frozen=kinds // 3, cell=(5.0, 7.5, 6.0), control=STEPPERS[stepper])
    fast = Simulation(scene, seed=SEED, precision=precision, threads=1)
    slow = general(scene, precision)
    assert plan_of(fast) == f"fast: {instruction_set}"
    fast.run(6)
    fast.run(4)
    slow.run(10)
    bound = 1000 * TOLERANCE[precision]
    assert fast.observe().temperature == pytest.approx(slow.observe().temperature, rel=10 * bound)
    for part, tensor in slow.observe().stress_parts.items():
        difference = np.abs(fast.observe().stress_parts[part] - tensor).max()
        assert difference < 100 * bound * np.abs(slow.observe().stress).max(), part
    assert fast.step == slow.step == 10
    assert np.abs(fast.state.positions - slow.state.positions).max() < bound, instruction_set
    assert np.abs(fast.state.velocities - slow.state.velocities).max() < 10 * bound
    assert np.array_equal(fast.state.images, slow.state.images)


def total_momentum(simulation: Simulation) -> FloatArray:
    """(3,) Σ m v, summed without rounding."""
    each = simulation.state.velocities * simulation.scene.beads.mass[:, None]
    return np.array([math.fsum(each[:, axis]) for axis in range(3)])


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("cell", [(4.0, 4.0, 4.0), (4.0, 5.5, 4.7)], ids=["cubic", "not cubic"])
@pytest.mark.parametrize("kinds", [1, 3])
@pytest.mark.parametrize("stepper", ["mdvv", "mdvv, lambda 0.85", "middle, every 3"])
def test_momentum_never_changes(
    instruction_set: str, stepper: str, cell: tuple[float, float, float], kinds: int, precision: Precision
) -> None:
    scene = fluid(kinds=kinds, cell=cell, control=STEPPERS[stepper])
    simulation = Simulation(scene, seed=SEED, precision=precision, threads=1)
    simulation.run(1)
    before = total_momentum(simulation)
    simulation.run(1000 if instruction_set != "plain" else 200)
    # Each velocity is rounded once when it is converted to a double.
    assert np.abs(total_momentum(simulation) - before).max() < 1e-12


def test_a_random_start_conserves_momentum(instruction_set: str) -> None:
    scene = make_scene({"A": 12288}, cell=16.0, control={"timestep": "0.04 internal_t"})
    simulation = Simulation(scene, seed=SEED, threads=2)
    simulation.run(20 if instruction_set == "plain" else 100)
    assert np.abs(total_momentum(simulation)).max() < 1e-10
    assert 0.9 < simulation.temperature < 3.0


@pytest.mark.parametrize("precision", PRECISIONS)
def test_faces_are_crossed_and_counted(instruction_set: str, precision: Precision) -> None:
    """Beads in rows two cutoffs apart, neighbouring rows flying in opposite directions, never meet."""
    edges = np.array([8.0, 8.0, 8.0])
    for axis in range(3):
        places = np.stack(np.meshgrid(*[np.arange(4)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
        across = places[:, (axis + 1) % 3] + places[:, (axis + 2) % 3]
        velocities = np.zeros(places.shape)
        velocities[:, axis] = np.where(across % 2 == 0, 7.5, -7.5)
        starts = 2.0 * places - 3.5
        control = {**NVE, "timestep": "0.015625 internal_t"}
        scene = make_scene({"A": 64}, cell=edges, positions=starts, velocities=velocities, control=control)
        simulation = Simulation(scene, seed=SEED, precision=precision)
        for steps in (1, 63, 137):
            simulation.run(steps)
        state = simulation.state
        assert np.array_equal(state.forces, np.zeros((64, 3)))
        travelled = state.positions + state.images * edges - starts
        assert np.allclose(travelled, velocities * simulation.time, rtol=0.0, atol=1e-5), instruction_set
        assert np.abs(state.images[:, axis]).min() >= 2
        assert np.abs(state.positions).max() <= 4.0


@pytest.mark.parametrize("precision", PRECISIONS)
def test_threads_and_chunks_change_no_bit(instruction_set: str, precision: Precision) -> None:
    scene = fluid(kinds=3, frozen=1, cell=(11.0, 9.5, 13.0))
    results: list[list[bytes]] = []
    for threads, chunks in ((1, (12,)), (2, (1, 4, 7)), (3, (5, 7))):
        simulation = Simulation(scene, seed=SEED, precision=precision, threads=threads)
        for steps in chunks:
            simulation.run(steps)
        state = simulation.state
        arrays = [state.positions, state.velocities, state.forces, *simulation.observe().stress_parts.values()]
        results.append([array.tobytes() for array in arrays] + [state.images.tobytes()])
    assert results[0] == results[1] == results[2], instruction_set


@pytest.mark.parametrize("precision", PRECISIONS)
def test_momenta_out_of_range_stop_the_run(instruction_set: str, precision: Precision) -> None:
    scene = fluid(place=clusters(648), control={"timestep": "0.4 internal_t"})
    with pytest.raises(RunError, match=r"momentum of .* left its range"):
        Simulation(scene, seed=SEED, precision=precision).run(10)
    assert instruction_set in SETS


@pytest.mark.parametrize("precision", PRECISIONS)
def test_water(instruction_set: str, precision: Precision) -> None:
    """k_B T = 1 and the pressure of a = 25 at density 3: 23.7 ± 0.1 (Groot and Warren's equation of state: 23.65)."""
    scene = make_scene({"A": 1029}, cell=7.0, control={"timestep": "0.02 internal_t"})
    simulation = Simulation(scene, seed=SEED, precision=precision)
    simulation.run(200)
    seen = []
    for _ in range(200 if instruction_set != "plain" else 100):
        simulation.run(10)
        seen.append((simulation.temperature, simulation.pressure))
    temperature, pressure = np.mean(seen, axis=0)
    assert temperature == pytest.approx(1.005, abs=0.015)
    assert pressure == pytest.approx(23.7, abs=0.25)


def test_unknown_instructions_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYDLPOLY_SIMD", "avx3")
    with pytest.raises((PydlpolyError, ValueError), match=r"avx3.*expected plain, avx2 or avx512"):
        Simulation(fluid(1.0, (4.0, 4.0, 4.0)), seed=1)


def test_dense_fluids_take_the_general_path() -> None:
    """With more neighbours than its buffers hold on average, the fast path would go pair after pair."""
    assert "fast" in Simulation(fluid(7.0, (5.0, 5.0, 6.0)), seed=1)._engine.system.plan()
    assert "too many neighbours" in Simulation(fluid(9.0, (5.0, 5.0, 6.0)), seed=1)._engine.system.plan()
