"""Dissolved species: exchange against closed forms and brute force, noise, sources, reactions, conserved sums."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm, null_space

from pydlpoly import Scene, Simulation
from pydlpoly.errors import InputError, RunError, SceneError
from pydlpoly.formats.output import balance_text
from pydlpoly.formats.records import FloatArray
from pydlpoly.runner import run_scene

from .scene_builder import NVE, make_scene

SEED = 20260101
STILL = {**NVE, "timestep": "0.01 internal_t"}
IDEAL = ("A A dpd 0.0 1.0 0.0",)


def block(*lines: str) -> str:
    return "\n".join(["extension transport", *lines, "end extension", ""])


def still(
    positions: Sequence[Sequence[float]] | FloatArray,
    *lines: str,
    timestep: float = 0.01,
    cell: object = 10.0,
    species: Mapping[str, int] | None = None,
    **more: object,
) -> Scene:
    """Beads that do not move and feel nothing."""
    places = np.asarray(positions, dtype=np.float64)
    beads = species or {"A": len(places)}
    pairs = [f"{a} {b} dpd 0.0 1.0 0.0" for a, b in itertools.combinations_with_replacement(beads, 2)]
    control = {**NVE, "timestep": f"{timestep!r} internal_t", **more.pop("control", {})}  # type: ignore[dict-item]
    return make_scene(
        beads,
        pairs,
        cell=cell,  # type: ignore[arg-type]
        positions=places,
        velocities=np.zeros_like(places),
        control=control,
        extensions=block(*lines),
        **more,  # type: ignore[arg-type]
    )


def amounts(simulation: Simulation) -> FloatArray:
    return np.asarray(simulation._engine.system.concentrations)


def started(scene: Scene, values: FloatArray, *, threads: int = 1) -> Simulation:
    """Return the simulation with these concentrations, (N, species)."""
    beads = replace(scene.beads, concentrations=np.asarray(values, dtype=np.float64))
    return Simulation(replace(scene, beads=beads), seed=SEED, threads=threads)


def brute_force(
    places: FloatArray, cell: FloatArray, reach: float, kappa: float, exponent: float, periodic: Sequence[bool]
) -> FloatArray:
    """(N, N) matrix M of dC/dt = M C from all images."""
    most = [math.ceil(reach / width) + 1 for width in 1.0 / np.linalg.norm(np.linalg.inv(cell), axis=0)]
    counts = [np.arange(-n, n + 1) if open_ else [0] for n, open_ in zip(most, periodic, strict=True)]
    matrix = np.zeros((len(places), len(places)))
    for shift in np.stack(np.meshgrid(*counts, indexing="ij"), axis=-1).reshape(-1, 3) @ cell:
        r = np.linalg.norm(places[:, None, :] - places[None, :, :] - shift, axis=-1)
        matrix += np.where(r < reach, kappa * np.clip(1.0 - r / reach, 0.0, None) ** exponent, 0.0)
    np.fill_diagonal(matrix, 0.0)
    return matrix - np.diag(matrix.sum(axis=1))


# Exchange -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("timestep", [0.01, 3.0])
@pytest.mark.parametrize("exponent", [2.0, 0.41, 3.0])
def test_two_beads_relax_exactly(exponent: float, timestep: float) -> None:
    lines = ("species a b", f"pair A A a kappa 1.5 range 1.2 exponent {exponent}", "pair A A b kappa 0.5 range 0.6")
    scene = still([[0.0, 0.0, 0.0], [0.3, 0.4, 0.0]], *lines, timestep=timestep)
    simulation = started(scene, np.array([[2.0, 0.0], [0.5, 1.0]]))
    simulation.run(3)
    a = 1.5 * math.exp(-2.0 * 1.5 * (1.0 - 0.5 / 1.2) ** exponent * 3 * timestep)
    b = math.exp(-2.0 * 0.5 * (1.0 - 0.5 / 0.6) ** 2 * 3 * timestep)
    wanted = [[1.25 + a / 2, 0.5 - b / 2], [1.25 - a / 2, 0.5 + b / 2]]
    assert amounts(simulation) == pytest.approx(np.array(wanted), rel=2e-15)


SHAPES = {
    "orthorhombic": ([4.0, 3.5, 5.0], (True, True, True), {}),
    "triclinic": ([[4.0, 0.0, 0.0], [1.7, 3.6, 0.0], [-1.1, 1.3, 4.0]], (True, True, True), {}),
    "below one range": ([1.1, 1.2, 1.0], (True, True, True), {}),
    "slab": ([4.0, 3.5, 5.0], (True, True, False), {"imcon": 6}),
    "open": ([4.0, 3.5, 5.0], (False, False, False), {"imcon": 0}),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_beads_that_stand_still_follow_the_matrix_to_second_order(shape: str) -> None:
    """A sweep forward and one backward: halving the timestep divides the error by four."""
    cell, periodic, more = SHAPES[shape]
    count = 12 if shape == "below one range" else 60
    box = np.diag(cell) if np.ndim(cell) == 1 else np.array(cell)
    places = (np.random.default_rng(3).random((count, 3)) - 0.5) @ box
    start = np.random.default_rng(4).random((count, 1))
    reach, kappa = 1.3, 0.7
    matrix = brute_force(places, box, reach, kappa, 2.0, periodic)
    errors = []
    for steps in (40, 80):
        lines = ("species a", f"pair A A a kappa {kappa} range {reach}")
        scene = still(places, *lines, timestep=1.0 / steps, cell=cell, **more)
        simulation = started(scene, start)
        simulation.run(steps)
        errors.append(float(np.abs(amounts(simulation) - expm(matrix) @ start).max()))
    assert errors[0] < 2e-3
    assert 3.5 < errors[0] / errors[1] < 4.5


MOVING = {
    "npt": {
        "ensemble": "npt",
        "ensemble_barostat_coupling": "1.0 internal_t",
        "ensemble_barostat_friction": "1.0 internal_t^-1",
        "pressure_hydrostatic": "10.0 dpd_p",
    },
    "shear": {"ensemble_dpd_order": "middle", "shear_rate": "2.0 ps^-1"},
    "walls": {"ensemble_dpd_order": "middle", "wall_method": "reflecting"},
    "berendsen": {"ensemble_method": "berendsen", "ensemble_dpd_order": None, "ensemble_thermostat_coupling": "1.0 ps"},
    "first": {"ensemble_dpd_order": "first"},
}


@pytest.mark.parametrize("name", MOVING)
def test_exchange_is_between_the_beads_as_they_are_after_a_step(name: str) -> None:
    """In whatever cell and with whatever integrator: one very short exchange against brute force."""
    kappa, reach = 1e-6, 1.4
    scene = make_scene(
        {"A": 120},
        ["A A dpd 25.0 1.0 4.5"],
        cell=[3.6, 3.4, 4.0],
        control=MOVING[name],
        extensions=block("species a", f"pair A A a kappa {kappa} range {reach}"),
    )
    values = np.random.default_rng(5).random((120, 1))
    simulation = started(scene, values)
    for _ in range(20):
        before = amounts(simulation)
        simulation.run(1)
    matrix = brute_force(simulation.positions, simulation.cell, reach, kappa, 2.0, scene.periodic)
    change = amounts(simulation) - before
    wanted = matrix @ before * scene.dynamics.timestep
    assert np.abs(change - wanted).max() < 2e-6 * np.abs(wanted).max()


def test_bonded_beads_exchange_and_frozen_ones_do() -> None:
    lines = ("species a", "pair A A a kappa 1.0 range 1.0", "start a 1.0 box -1 0.1 * * * *")
    scene = still([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0]], *lines, frozen=["A"])
    simulation = Simulation(scene, seed=1)
    simulation.run(1)
    assert amounts(simulation)[1, 0] == pytest.approx(0.5 * (1.0 - math.exp(-2.0 * 0.25 * 0.01)), rel=1e-14)


def test_species_that_no_line_names_stay_where_they_are() -> None:
    lines = ("species a", "pair A A a kappa 1.0 range 1.0", "start a 1.0 in B")
    scene = still([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0]], *lines, species={"A": 1, "B": 1})
    simulation = Simulation(scene, seed=1)
    simulation.run(10)
    assert amounts(simulation).tolist() == [[0.0], [1.0]]
    every = still(
        [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0]],
        lines[0],
        "pair * * a kappa 1.0 range 1.0",
        lines[2],
        species={"A": 1, "B": 1},
    )
    simulation = Simulation(every, seed=1)
    simulation.run(10)
    assert amounts(simulation)[0, 0] > 0.0


# Noise ----------------------------------------------------------------------------------------------------------------


def stationary(noise: str, precision: str = "double") -> tuple[float, float]:
    """Variance between beads after equilibration, and the mean, of 1500 beads that stand still."""
    count = 1500
    places = (np.random.default_rng(8).random((count, 3)) - 0.5) * 7.0
    lines = (
        "species a",
        "pair A A a kappa 4.0 range 1.5 noise 0.04",
        f"noise {noise}",
        "start a 2.0",
    )
    scene = still(places, *lines, cell=7.0, timestep=0.05, control={"precision": precision})
    simulation = Simulation(scene, seed=SEED, threads=2)
    simulation.run(60)
    seen = []
    for _ in range(80):
        simulation.run(2)
        seen.append(float(np.var(amounts(simulation))))
    return float(np.mean(seen)), float(np.mean(amounts(simulation)))


@pytest.mark.parametrize("precision", ["double", "reference"])
def test_root_noise_has_the_variance_of_counted_molecules(precision: str) -> None:
    """Var C = m C with the amount m = ε²/κ of one molecule; 80 dependent samples of 1500 beads: 1 % standard error."""
    variance, mean = stationary("sqrt", precision=precision)
    assert mean == pytest.approx(2.0, rel=1e-13)
    assert variance == pytest.approx(2.0 * 0.04**2 / 4.0 * (1.0 - 1.0 / 1500), rel=0.04)


def test_lammps_noise_has_a_variance_that_grows_as_the_square() -> None:
    """Var C = 2 ε² C²/κ where fluctuations are small; the same error as above."""
    variance, _ = stationary("lammps")
    assert variance == pytest.approx(2.0 * 0.04**2 * 2.0**2 / 4.0, rel=0.04)


def isolated_pairs(count: int) -> tuple[FloatArray, float]:
    """Places of pairs 0.4 apart, far from each other, the first beads of all pairs first; and the cell's edge."""
    side = math.ceil(count ** (1.0 / 3.0))
    places = 3.0 * np.stack(np.meshgrid(*[np.arange(side)] * 3), axis=-1).reshape(-1, 3)[:count] - 1.5 * side + 1.0
    return np.concatenate([places, places + np.array([0.4, 0.0, 0.0])]), 3.0 * side


@pytest.mark.parametrize("noise", ["sqrt", "lammps"])
@pytest.mark.parametrize("kappa", [0.0, 0.8])
def test_noise_of_one_pair_in_one_step(noise: str, kappa: float) -> None:
    """20 000 pairs: variance of what moves, to 1 % standard error, and no mean."""
    count, epsilon, timestep = 20_000, 0.02, 0.3
    both, cell = isolated_pairs(count)
    lines = ("species a b", f"noise {noise}", *(f"pair A A {s} kappa {kappa} range 1.0 noise {epsilon}" for s in "ab"))
    simulation = started(still(both, *lines, cell=cell, timestep=timestep), np.tile([1.5, 0.4], (2 * count, 1)))
    simulation.run(1)
    after = amounts(simulation)
    w2 = 0.6**2
    shrink = math.exp(-4.0 * kappa * w2 * timestep)
    for s, total in ((0, 3.0), (1, 0.8)):
        moved = after[:count, s] - total / 2.0
        assert np.abs(after[:count, s] + after[count:, s] - total).max() < 1e-15 * total * 2
        size = total if noise == "sqrt" else total**2
        each = epsilon**2 * w2 * timestep if kappa == 0.0 else epsilon**2 * (1.0 - shrink) / (4.0 * kappa)
        assert np.var(moved) == pytest.approx(size * each, rel=0.04)
        assert abs(np.mean(moved)) < 4.0 * np.std(moved) / count**0.5
    assert abs(np.corrcoef(after[:count].T)[0, 1]) < 4.0 / count**0.5


@pytest.mark.parametrize("noise", ["sqrt", "lammps"])
def test_noise_that_would_take_more_than_there_is(noise: str) -> None:
    """Cut on both sides alike: nothing below 0, sums kept, and no mean current beside Fick's."""
    count = 20_000
    both, cell = isolated_pairs(count)
    lines = ("species a", f"noise {noise}", "pair A A a kappa 0.5 range 1.0 noise 3.0")
    start = np.concatenate([np.full((count, 1), 1.0), np.full((count, 1), 0.02)])
    simulation = started(still(both, *lines, cell=cell, timestep=0.1), start)
    simulation.run(1)
    after = amounts(simulation)
    assert after.min() == 0.0
    assert after.max() <= 1.02 * (1.0 + 1e-15)
    moved = after[count:, 0] - 0.51 + 0.49 * math.exp(-2.0 * 0.5 * 0.36 * 0.1)
    assert np.std(moved) > 0.02
    assert abs(np.mean(moved)) < 4.0 * np.std(moved) / count**0.5


def test_sums_are_kept_and_nothing_falls_below_zero() -> None:
    scene = make_scene(
        {"A": 300, "B": 300},
        ["A A dpd 25.0 1.0 4.5", "A B dpd 30.0 1.0 4.5", "B B dpd 25.0 1.0 4.5"],
        cell=5.85,
        extensions=block(
            "species a b c",
            "pair * * a kappa 2.0 range 1.5 noise 0.3",
            "pair * * b kappa 0.3 range 0.8 exponent 1.0 noise 0.1",
            "pair A B c kappa 50.0 range 1.1 noise 5.0",
            "start a 1.0 in A",
            "start b 1e-12 sphere 0 0 0 1.5",
            "start c 3.0 box * 0 * * * *",
        ),
    )
    simulation = Simulation(scene, seed=SEED, threads=2)
    before = [math.fsum(column) for column in amounts(simulation).T.tolist()]
    for _ in range(20):
        simulation.run(50)
        now = amounts(simulation)
        assert now.min() >= 0.0
        assert [math.fsum(column) for column in now.T.tolist()] == pytest.approx(before, rel=1e-13)


# Sources and held beads -----------------------------------------------------------------------------------------------


def test_sources_give_what_they_say_where_they_are() -> None:
    places = (np.random.default_rng(2).random((200, 3)) - 0.5) * [6.0, 5.0, 4.0]
    lines = (
        "species a b c d",
        "start b 0.05",
        "source a 0.2 box -1 2 * 0.5 * *",
        "source b -0.1 everywhere",
        "source c 1.0 sphere 2.9 2.4 -1.9 1.5",
        "source d 0.3 in B",
    )
    scene = still(places, *lines, cell=[6.0, 5.0, 4.0], species={"A": 150, "B": 50}, timestep=0.1)
    simulation = Simulation(scene, seed=1)
    simulation.run(10)
    now = amounts(simulation)
    box = (places[:, 0] >= -1) & (places[:, 0] < 2) & (places[:, 1] < 0.5)
    apart = places - [2.9, 2.4, -1.9]
    apart -= np.round(apart / [6.0, 5.0, 4.0]) * [6.0, 5.0, 4.0]
    ball = np.linalg.norm(apart, axis=1) <= 1.5
    assert 0 < box.sum() < 200
    assert 5 < ball.sum() < 50
    wanted = np.stack([0.2 * box, np.zeros(200), 1.0 * ball, np.repeat([0.0, 0.3], [150, 50])], axis=1)
    assert now == pytest.approx(wanted, abs=1e-14)
    balance = simulation.species_balance()
    assert [one.name for one in balance] == ["a", "b", "c", "d"]
    assert balance[0].sources == pytest.approx(0.2 * box.sum(), rel=1e-13)
    assert balance[1].sources == pytest.approx(-0.05 * 200, rel=1e-13)  # a sink takes what there is
    assert all(abs(one.remainder) < 1e-12 for one in balance)


def test_held_beads_feed_their_neighbours() -> None:
    """A bead beside a held one approaches it as 1 − exp(−κw²t), and what flowed in is counted."""
    lines = ("species a", "pair * * a kappa 2.0 range 1.0", "hold a 1.5 in W")
    scene = still([[0.0, 0.0, 0.0], [0.4, 0.0, 0.0]], *lines, species={"W": 1, "A": 1}, timestep=0.2)
    simulation = Simulation(scene, seed=1)
    assert amounts(simulation).tolist() == [[1.5], [0.0]]
    simulation.run(5)
    wanted = 1.5 * (1.0 - math.exp(-2.0 * 0.36 * 1.0))
    assert amounts(simulation)[:, 0] == pytest.approx([1.5, wanted], rel=1e-14)
    (balance,) = simulation.species_balance()
    assert balance.held == pytest.approx(wanted, rel=1e-14)
    assert abs(balance.remainder) < 1e-15


def test_held_beads_with_noise_keep_their_value_and_nothing_falls_below_zero() -> None:
    places = (np.random.default_rng(2).random((600, 3)) - 0.5) * 5.0
    lines = ("species a", "pair * * a kappa 1.0 range 1.3 noise 0.6", "hold a 0.01 in W", "reaction 0.1 a -> none")
    simulation = Simulation(still(places, *lines, species={"W": 100, "A": 500}, cell=5.0, timestep=0.1), seed=1)
    simulation.run(100)
    now = amounts(simulation)
    assert (now[:100] == 0.01).all()
    assert now.min() >= 0.0
    (balance,) = simulation.species_balance()
    assert balance.held > 0.0 > balance.reactions
    assert abs(balance.remainder) < 1e-13


# Reactions ------------------------------------------------------------------------------------------------------------

A0, B0, K, TIME = 1.3, 0.4, 0.9, 2.0
SINGLE = {
    "a -> b": (A0 * math.exp(-K * TIME), B0 + A0 - A0 * math.exp(-K * TIME)),
    "2 a -> b": (A0 / (1 + 2 * K * A0 * TIME), B0 + 0.5 * (A0 - A0 / (1 + 2 * K * A0 * TIME))),
    "a + b -> c": (
        (A0 - B0) * A0 / (A0 - B0 * math.exp(-(A0 - B0) * K * TIME)),
        (A0 - B0) * B0 * math.exp(-(A0 - B0) * K * TIME) / (A0 - B0 * math.exp(-(A0 - B0) * K * TIME)),
    ),
    "a + b -> 2 b": (
        (A0 + B0) * A0 / (A0 + B0 * math.exp((A0 + B0) * K * TIME)),
        (A0 + B0) * B0 / (B0 + A0 * math.exp(-(A0 + B0) * K * TIME)),
    ),
    "b + a -> 2 b": (
        (A0 + B0) * A0 / (A0 + B0 * math.exp((A0 + B0) * K * TIME)),
        (A0 + B0) * B0 / (B0 + A0 * math.exp(-(A0 + B0) * K * TIME)),
    ),
    "a + b -> b": (A0 * math.exp(-K * B0 * TIME), B0),
    "a + b -> a + 3 b": (A0, B0 * math.exp(2 * K * A0 * TIME)),
    "a -> 2 a": (A0 * math.exp(K * TIME), B0),
    "a -> a + b": (A0, B0 + K * A0 * TIME),
    "2 a -> 2 a + b": (A0, B0 + K * A0**2 * TIME),
    "2 a -> a + c": (A0 / (1 + K * A0 * TIME), B0),
    "a -> none": (A0 * math.exp(-K * TIME), B0),
}


def one_bead(*lines: str, start: Sequence[float], timestep: float, steps: int) -> Simulation:
    simulation = started(still([[0.0, 0.0, 0.0]], *lines, timestep=timestep), np.array([start]))
    simulation.run(steps)
    return simulation


@pytest.mark.parametrize("steps", [1, 50])
@pytest.mark.parametrize("equation", SINGLE)
def test_one_reaction_is_exact_for_any_timestep(equation: str, steps: int) -> None:
    lines = ("species a b c", f"reaction {K} {equation}")
    simulation = one_bead(*lines, start=(A0, B0, 0.0), timestep=TIME / steps, steps=steps)
    assert amounts(simulation)[0, :2] == pytest.approx(SINGLE[equation], rel=1e-13)


def test_two_species_of_equal_amounts_meet() -> None:
    simulation = one_bead("species a b", f"reaction {K} a + b -> none", start=(A0, A0), timestep=TIME, steps=1)
    assert amounts(simulation)[0] == pytest.approx([A0 / (1 + K * A0 * TIME)] * 2, rel=1e-14)


def test_extreme_amounts_and_rates_of_reactions() -> None:
    for start in ((1e-300, 1.0), (1.0, 1e-300), (0.0, 1.0), (1.0, 0.0), (1e-18, 1.0), (1.0, 1e-18), (1e150, 1.0)):
        for equation in ("a + b -> 2 b", "b + a -> 2 b", "a + b -> none", "2 a -> b", "a -> b"):
            for rate in (1e-30, 1.0, 1e30):
                simulation = one_bead("species a b", f"reaction {rate} {equation}", start=start, timestep=1.0, steps=1)
                now = amounts(simulation)[0]
                assert (now >= 0.0).all(), (start, equation, rate)
                if equation.startswith(("a + b -> 2", "b + a")):
                    assert now.sum() == pytest.approx(sum(start), rel=1e-15)
    simulation = one_bead("species a b", "reaction 1.0 a + b -> 2 b", start=(1.0, 1e-18), timestep=50.0, steps=1)
    grown = 1e-18 * math.exp(50.0)
    assert amounts(simulation)[0, 1] == pytest.approx(grown / (1.0 + grown), rel=1e-12)


NETWORK = (
    "reaction 1.2 a + b -> c",
    "reaction 0.7 c -> a + b",
    "reaction 0.9 2 a -> d",
    "reaction 0.4 b + d -> 2 b + a",
)
START = (1.0, 0.6, 0.2, 0.1)


def network_rates(_: float, c: FloatArray) -> list[float]:
    a, b, ab, d = c
    r1, r2, r3, r4 = 1.2 * a * b, 0.7 * ab, 0.9 * a * a, 0.4 * b * d
    return [-r1 + r2 - 2 * r3 + r4, -r1 + r2 + r4, r1 - r2, r3 - r4]


def test_a_network_is_of_second_order_and_keeps_what_it_keeps() -> None:
    exact = solve_ivp(network_rates, (0.0, 3.0), START, rtol=1e-12, atol=1e-14).y[:, -1]
    errors = []
    for steps in (30, 60):
        simulation = one_bead("species a b c d", *NETWORK, start=START, timestep=3.0 / steps, steps=steps)
        errors.append(np.abs(amounts(simulation)[0] - exact).max())
    assert errors[0] < 3e-3
    assert 3.5 < errors[0] / errors[1] < 4.5
    changes = np.array([[-1, -1, 1, 0], [1, 1, -1, 0], [-2, 0, 0, 1], [1, 1, 0, -1]], dtype=float)
    kept = null_space(changes)
    assert kept.shape[1] == 4 - np.linalg.matrix_rank(changes)
    assert kept.T @ amounts(simulation)[0] == pytest.approx(kept.T @ np.array(START), abs=1e-13)
    for one in simulation.species_balance():
        assert abs(one.remainder) < 1e-14


def test_reactions_happen_in_the_beads_they_are_said_to() -> None:
    lines = ("species a", "start a 1.0", "reaction 1.0 a -> none in B")
    simulation = Simulation(still([[0, 0, 0], [3, 0, 0]], *lines, species={"A": 1, "B": 1}, timestep=0.5), seed=1)
    simulation.run(2)
    assert amounts(simulation)[:, 0] == pytest.approx([1.0, math.exp(-1.0)], rel=1e-14)


def test_well_mixed_water_follows_the_rate_equations() -> None:
    """Moving, exchanging beads of equal concentrations are one reactor."""
    scene = make_scene(
        {"A": 375},
        cell=5.0,
        control={"timestep": "0.05 internal_t", "ensemble_dpd_order": "middle"},
        extensions=block(
            "species a b c d",
            *NETWORK,
            *(f"start {n} {x}" for n, x in zip("abcd", START, strict=True)),
            *(f"pair A A {n} kappa 0.5 range 1.0" for n in "abcd"),
        ),
    )
    simulation = Simulation(scene, seed=SEED)
    simulation.run(60)
    exact = solve_ivp(network_rates, (0.0, 3.0), START, rtol=1e-12, atol=1e-14).y[:, -1]
    now = amounts(simulation)
    assert np.ptp(now, axis=0) == pytest.approx(np.zeros(4), abs=1e-14)
    assert now[0] == pytest.approx(exact, abs=1e-3)


def test_growth_without_bound_stops_the_run_with_the_bead() -> None:
    with pytest.raises(RunError, match=r"step 1: the concentration of dissolved species 1 in bead 1 is not a number"):
        one_bead("species a", "reaction 1e6 a -> 2 a", start=(1.0,), timestep=1.0, steps=5)


# Bits -----------------------------------------------------------------------------------------------------------------

EVERYTHING = (
    "species a b",
    "pair * * a kappa 1.0 range 1.4 noise 0.05",
    "pair A B b kappa 2.0 range 0.9 exponent 1.5 noise 0.02",
    "start a 1.0",
    "start b 0.2 in B",
    "source a 0.1 box * 0 * * * *",
    "source b -0.05 sphere 1 1 1 2",
    "hold b 0.7 in W",
    "reaction 0.3 a + b -> 2 b",
    "reaction 0.1 b -> a",
)


def everything(**control: str) -> Scene:
    return make_scene(
        {"A": 1200, "B": 800, "W": 100},
        [f"{pair} dpd 25.0 1.0 4.5" for pair in ("A A", "A B", "B B", "A W", "B W")],
        cell=[9.0, 8.0, 9.7],
        frozen=["W"],
        control=control,
        extensions=block(*EVERYTHING),
    )


def bits(simulation: Simulation) -> list[bytes]:
    transport = simulation._engine.transport
    assert transport is not None
    return [amounts(simulation).tobytes(), np.asarray(transport.tally).tobytes(), simulation.positions.tobytes()]


def test_same_bits_for_threads_chunks_and_restarts(tmp_path: Path) -> None:
    simulation = Simulation(everything(), seed=SEED, threads=1)
    simulation.run(24)
    wanted = bits(simulation)
    other = Simulation(everything(), seed=SEED, threads=4)
    for steps in (1, 2, 8):
        other.run(steps)
    other.save(tmp_path / "REVIVE")
    balance = other.species_balance()
    other = Simulation.resume(tmp_path / "REVIVE", threads=3)
    assert other.species_balance() == balance
    other.run(13)
    assert bits(other) == wanted
    assert simulation.species_balance() == other.species_balance()


@pytest.mark.parametrize("precision", ["double", "mixed", "reference"])
def test_dynamics_do_not_feel_what_is_dissolved(precision: str) -> None:
    plain = make_scene({"A": 300}, cell=4.7, control={"precision": precision, "ensemble_dpd_exponent": "2.5"})
    extension = block("species a", "pair A A a kappa 1.0 range 1.0 noise 0.1", "start a 1.0")
    with_species = make_scene(
        {"A": 300}, cell=4.7, control={"precision": precision, "ensemble_dpd_exponent": "2.5"}, extensions=extension
    )
    states = []
    for scene in (plain, with_species):
        simulation = Simulation(scene, seed=3)
        simulation.run(20)
        states.append((simulation.positions.tobytes(), simulation.velocities.tobytes()))
    assert states[0] == states[1]


def test_a_checkpoint_of_other_species_is_refused(tmp_path: Path) -> None:
    simulation = Simulation(still([[0, 0, 0]], "species a"), seed=1)
    simulation.save(tmp_path / "REVIVE")
    with pytest.raises(InputError, match="other dissolved species"):
        Simulation.resume(tmp_path / "REVIVE", scene=still([[0, 0, 0]], "species b"))
    with pytest.raises(InputError, match="other dissolved species"):
        Simulation.resume(tmp_path / "REVIVE", scene=make_scene({"A": 1}, cell=10.0, positions=[[0, 0, 0]]))


# Scene ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("pair A C a kappa 1 range 1", r"FIELD:\d+: 'C': is no species of beads; there are A"),
        ("start a 1.0 in C", r"FIELD:\d+: 'C': is no species of beads"),
        ("reaction 1 a -> none in C", r"FIELD:\d+: 'C': is no species of beads"),
        ("source a 1 sphere 0 0 0 6", r"FIELD:\d+: '6': the sphere is wider than the cell, 10 ang"),
        ("pair A A a kappa 1 range 26 noise 0.1", r"FIELD:\d+: '26': the cell is 10 ang wide, less than 2/5"),
    ],
)
def test_scenes_that_make_no_sense_are_refused_with_file_line_and_word(line: str, says: str) -> None:
    with pytest.raises(SceneError, match=says):
        still([[0, 0, 0]], "species a", line)


def test_an_unknown_extension_is_refused() -> None:
    with pytest.raises(InputError, match=r"'transprot': unknown extension.*did you mean transport\?"):
        make_scene({"A": 1}, cell=10.0, extensions="extension transprot\nend extension\n")


def test_explain_says_everything_and_notes_what_has_no_effect() -> None:
    text = everything().explain()
    for words in (
        "Dissolved species",
        "A-B   b",
        "random fluxes grow as the root of the concentrations",
        "source: a 0.1 a bead and time where x < 0",
        "source: b -0.05 a bead and time within 2 of (1 1 1)",
        "held: b 0.7 in W",
        "reaction: a + b -> 2 b, rate 0.3 C(a) C(b)",
        "start: a 1 in every bead, 2100 in all",
        "(noise sqrt)",
    ):
        assert words in text, words
    quiet = still([[0, 0, 0]], "species a b", "pair A A a kappa 80 range 1 noise 0.1", "noise off", "reaction 1 a -> a")
    text = quiet.explain()
    for words in (
        "noise off: the noise of the lines 'pair' has no effect",
        "b stays in its beads",
        "two close beads share what they have within a step (2 kappa dt = 1.6)",
        "the reaction a -> a changes nothing",
    ):
        assert words in " ".join(text.split()), words
    assert "Dissolved species" not in make_scene({"A": 1}, cell=10.0).explain()


def test_the_balance_is_a_table_of_output() -> None:
    simulation = Simulation(everything(), seed=SEED)
    simulation.run(3)
    lines = balance_text(simulation.species_balance()).splitlines()
    assert lines[1].split() == ["at", "start", "sources", "reactions", "held", "now", "remainder"]
    name, start, *_, now, remainder = lines[2].split()
    assert (name, float(start)) == ("a", 2100.0)
    assert float(now) == pytest.approx(amounts(simulation)[:, 0].sum(), rel=1e-8)
    assert abs(float(remainder)) < 1e-11
    assert balance_text(()) == ""


def test_a_run_writes_the_amounts_and_continues(tmp_path: Path) -> None:
    scene = everything()
    run_scene(scene, tmp_path, steps=4, seed=SEED, threads=1)
    run_scene(scene, tmp_path, steps=8, threads=2, checkpoint=tmp_path / "REVIVE")
    text = (tmp_path / "OUTPUT").read_text()
    assert text.count("Amounts of dissolved species, all beads together:") == 2
    simulation = Simulation(scene, seed=SEED)
    simulation.run(8)
    assert balance_text(simulation.species_balance()).splitlines()[2] in text
