"""Numbers of beads, species and ranges, densities, and counters of steps."""

from __future__ import annotations

import tempfile
from functools import partial
from pathlib import Path

import numpy as np

from pydlpoly import Scene, Simulation, _core

from ..scene_builder import NVE, make_scene
from .framework import (
    MOMENTUM,
    PATHS,
    PRECISIONS,
    SEED,
    Cases,
    Seen,
    check_finite,
    momentum,
    on_path,
    refused,
    soft_forces,
)

CASES = Cases("count")
_TOLERANCE = {"double": 1e-10, "mixed": 1e-5, "reference": 1e-11}


def against_brute_force(
    scene: Scene, precision: str, strength: np.ndarray, cutoff: np.ndarray, tolerance: float = 0.0
) -> Seen:
    """Forces and energy against the sum over all pairs; (N, N) strengths and cutoffs."""
    simulation = Simulation(scene, seed=SEED, threads=1, precision=precision)  # type: ignore[arg-type]
    places = simulation.state.positions  # as the path has them
    energy, forces = soft_forces(places, scene.cell, strength, cutoff)
    tolerance = tolerance or _TOLERANCE[precision]
    assert abs(simulation.energy["pair"] - energy) <= tolerance * energy
    largest = max(np.abs(forces).max(), 1e-300)
    error = float(np.abs(simulation.state.forces - forces).max() / largest)
    simulation.run(10)
    check_finite(simulation)
    assert momentum(simulation) < MOMENTUM["fast, mixed" if precision == "mixed" else "reference"]
    return Seen("largest error of a force over the largest force:", error, 0.0, tolerance)


# Densities --------------------------------------------------------------------------------------------------------


def density(value: float, precision: str) -> Seen:
    edge = 20.0 if value < 0.1 else 10.0 if value < 1.0 else 4.0 if value > 20 else 5.0
    count = round(value * edge**3)
    scene = make_scene({"A": count}, cell=edge, control={**NVE, "timestep": "0.002 internal_t"})
    same = np.ones((count, count))
    return against_brute_force(scene, precision, 25.0 * same, same)


def dilute(precision: str) -> Seen:
    """Density 0.01: pairs rarely meet, and P = rho k_B T + rho^2 B with the second virial coefficient.

    A pair is met with the probability 4 pi/3 rho exp(-U): some 10 of 1000 beads in each of 4000 samples, of which each
    hundredth or so is independent: an error of some 5 to 10 %.
    """
    count, edge = 1000, 100.0 ** (1 / 3) * 1000 ** (1 / 3)
    scene = make_scene({"A": count}, cell=edge, control={"timestep": "0.02 internal_t"})
    simulation = Simulation(scene, seed=SEED, threads=1, precision=precision)  # type: ignore[arg-type]
    seen = []
    for _ in range(800):
        simulation.run(20)
        parts = simulation.observe().stress_parts
        kinetic = np.trace(parts["kinetic"]) / 3.0
        seen.append((kinetic / 0.01, np.trace(parts["conservative"]) / 3.0))
    check_finite(simulation)
    temperature, virial = np.mean(seen, axis=0)
    assert abs(temperature - 1.0) < 0.05
    # B = -2 pi int (exp(-U) - 1) r^2 dr of U = 12.5 (1 - r)^2 at k_B T = 1.
    r = np.linspace(0.0, 1.0, 20001)
    b = 2 * np.pi * np.trapezoid((1.0 - np.exp(-12.5 * (1.0 - r) ** 2)) * r**2, r)
    return Seen("excess pressure over rho^2 B", float(virial / (1e-4 * b)), 1.0, 0.2)


for _value in (0.01, 0.1, 1.0, 3.0, 10.0, 30.0):
    for _precision in PRECISIONS:
        CASES.add(f"density {_value:g}, {_precision}", partial(density, _value, _precision))
for _precision in PRECISIONS:
    CASES.add(f"gas of density 0.01, {_precision}", partial(dilute, _precision), slow=True)

# Beads ------------------------------------------------------------------------------------------------------------


def few(count: int) -> Simulation:
    scene = make_scene({"A": count}, cell=6.0, control={"timestep": "0.01 internal_t"})
    return Simulation(scene, seed=SEED, threads=2)


def one_bead(path: str) -> Seen:
    """One bead has no momentum of its own, so it rests; with fixed_com off it flies straight on."""
    scene = make_scene(
        {"A": 1},
        cell=6.0,
        positions=[[1.0, 2.0, -1.0]],
        velocities=[[1.0, -2.0, 0.5]],
        control={"fixed_com": "off"},
    )
    simulation = on_path(scene, path)
    simulation.run(1000)
    check_finite(simulation)
    assert not simulation.state.forces.any()
    error = np.abs(simulation.displacements() - 10.0 * np.array([[1.0, -2.0, 0.5]])).max()
    return Seen("distance from v t:", float(error), 0.0, 1e-9 if path != "fast, mixed" else 1e-4)


def one_bead_at_rest(path: str) -> Seen:
    """With the centre of mass held there is no degree of freedom, and the temperature is 0 and no division by it."""
    simulation = on_path(make_scene({"A": 1}, cell=6.0), path)
    simulation.run(10)
    check_finite(simulation)
    return Seen("temperature", simulation.temperature, 0.0, 0.0)


def two_beads(path: str) -> Seen:
    """Two beads have three degrees of freedom, and their mean temperature is 1.

    A temperature of three degrees of freedom has the variance 2/3. Over a time of 4000, beads that meet every 15 or so
    in a box of 4 cutoffs give some 100 independent ones, an error of 0.08; in a box of 1.6 some 1000, 0.025.
    """
    wide = path.startswith("fast")
    control = {"timestep": "0.04 internal_t"}
    scene = make_scene({"A": 2}, ["A A dpd 0.0 1.0 4.5"], cell=4.0 if wide else 1.6, control=control)
    simulation = on_path(scene, path)
    seen = []
    for _ in range(4000):
        simulation.run(25)
        seen.append(simulation.temperature)
    check_finite(simulation)
    assert simulation.scene.degrees_of_freedom == 3
    assert momentum(simulation) < MOMENTUM[path]
    return Seen("mean temperature", float(np.mean(seen)), 1.0, 0.3 if wide else 0.1)


CASES.add("no bead", partial(refused, partial(few, 0), "no bead"))
for _path in PATHS:
    CASES.add(f"one bead in flight, {_path}", partial(one_bead, _path))
    CASES.add(f"one bead, centre of mass held, {_path}", partial(one_bead_at_rest, _path))
    CASES.add(f"two beads, {_path}", partial(two_beads, _path), slow=True)

# Species ----------------------------------------------------------------------------------------------------------


def empty_species(path: str) -> Seen:
    """A species without beads changes no bit."""
    with_it = make_scene({"A": 375, "B": 0}, ["A A dpd 25.0 1.0 4.5", "A B dpd 50.0 1.0 4.5"], cell=5.0, start_seed=4)
    without = make_scene({"A": 375}, cell=5.0, start_seed=4)
    found = [on_path(scene, path) for scene in (with_it, without)]
    for simulation in found:
        simulation.run(20)
        check_finite(simulation)
    difference = np.abs(found[0].state.velocities - found[1].state.velocities).max()
    return Seen("largest difference of a velocity:", float(difference), 0.0, 0.0)


def one_of_many(precision: str) -> Seen:
    """One bead of B in 10 000: the force on it, by hand, is that of its own laws."""
    count, edge = 10_000, 15.0
    pairs = ["A A dpd 25.0 1.0 4.5", "A B dpd 400.0 1.5 4.5", "B B dpd 1.0 1.0 4.5"]
    scene = make_scene({"A": count - 1, "B": 1}, pairs, cell=edge, control={**NVE, "precision": precision})
    simulation = Simulation(scene, seed=SEED, threads=1)
    places = simulation.state.positions
    apart = places[-1] - places[:-1]
    apart -= edge * np.round(apart / edge)
    r = np.linalg.norm(apart, axis=1)
    force = ((400.0 * np.clip(1.0 - r / 1.5, 0.0, None) / r)[:, None] * apart).sum(axis=0)
    error = np.abs(simulation.state.forces[-1] - force).max() / np.abs(force).max()
    simulation.run(5)
    check_finite(simulation)
    return Seen("largest error of its force, relative:", float(error), 0.0, 1e-10 if precision != "mixed" else 2e-6)


def many_species(count: int, precision: str) -> Seen:
    """Hundreds of species, each pair with its own strength and cutoff."""
    names = [f"T{k}" for k in range(count)]
    strength = np.array([[20.0 + (i * j) % 17 for j in range(count)] for i in range(count)])
    cutoff = np.array([[1.0 - 0.02 * ((i + j) % 9) for j in range(count)] for i in range(count)])
    pairs = [
        f"{names[i]} {names[j]} dpd {strength[i, j]} {float(cutoff[i, j])!r} 4.5"
        for i in range(count)
        for j in range(i, count)
    ]
    each = max(2, 600 // count)
    scene = make_scene(dict.fromkeys(names, each), pairs, cell=6.0, control={**NVE, "timestep": "0.01 internal_t"})
    kinds = np.repeat(np.arange(count), each)
    return against_brute_force(scene, precision, strength[np.ix_(kinds, kinds)], cutoff[np.ix_(kinds, kinds)])


def unlike_ranges(largest: float, precision: str) -> Seen:
    """Cutoffs that differ by a hundred."""
    count = 300
    pairs = [
        f"A A dpd 25.0 {largest!r} 4.5",
        f"A B dpd 25.0 {largest / 10!r} 4.5",
        f"B B dpd 25.0 {largest / 100!r} 4.5",
    ]
    edge = 5.0 * largest
    # B beads in a ball, so that they meet within their short range.
    rng = np.random.default_rng(6)
    places = np.concatenate([(rng.random((count, 3)) - 0.5) * edge, rng.normal(size=(count, 3)) * 0.01 * largest])
    control = {**NVE, "timestep": "0.001 internal_t", "cutoff": f"{largest} ang"}
    scene = make_scene({"A": count, "B": count}, pairs, cell=edge, positions=places, control=control)
    kinds = np.repeat([0, 1], count)
    cutoff = np.array([[largest, largest / 10], [largest / 10, largest / 100]])[np.ix_(kinds, kinds)]
    apart = np.linalg.norm(places[count:, None] - places[None, count:], axis=-1)
    assert np.count_nonzero(apart < largest / 100) > 2 * count, "no short pair"
    # Impulses are multiples of a unit that belongs to the energy of contact, 25 cutoff/2.
    tolerance = (1e-4 if precision == "mixed" else 1e-9) if largest > 10 else 0.0
    return against_brute_force(scene, precision, np.full(cutoff.shape, 25.0), cutoff, tolerance)


for _path in PATHS:
    CASES.add(f"a species without beads, {_path}", partial(empty_species, _path))
for _precision in PRECISIONS:
    CASES.add(f"one bead of a species in 10 000, {_precision}", partial(one_of_many, _precision))
    CASES.add(f"cutoffs 1, 0.1 and 0.01, {_precision}", partial(unlike_ranges, 1.0, _precision))
    CASES.add(f"cutoffs 100, 10 and 1, {_precision}", partial(unlike_ranges, 100.0, _precision))
    for _count in (16, 17, 300):
        CASES.add(f"{_count} species, {_precision}", partial(many_species, _count, _precision))

# Steps and seeds --------------------------------------------------------------------------------------------------


def late_step(step: int, precision: str, order: str) -> Seen:
    """Five steps from a late one: counted, with noise that is new, the same after a restart in the middle."""
    control = {"precision": precision, "ensemble_dpd_order": order}
    scene = make_scene({"A": 375}, cell=5.0, control=control)

    def at(first: int) -> Simulation:
        simulation = Simulation(scene, seed=SEED, threads=1)
        simulation._engine.system.step = first
        simulation._engine.system.time = first * 0.01
        simulation._engine.initialise()
        return simulation

    least = 1e-9 if order == "nose-hoover-langevin" else 1e-3  # there the noise is that of one number
    late, early = at(step), at(step - 2**31 if step >= 2**31 else step + 2**31)
    for simulation in (late, early):
        simulation.run(3)
    assert np.abs(late.state.velocities - early.state.velocities).max() > least, "the noise repeats itself"
    with tempfile.TemporaryDirectory() as folder:
        late.save(Path(folder) / "checkpoint")
        again = Simulation.resume(Path(folder) / "checkpoint", threads=1)
    late.run(3)
    again.run(3)
    check_finite(late)
    assert 0.8 < late.temperature < 3.0, late.temperature  # random places
    assert late.state.velocities.tobytes() == again.state.velocities.tobytes()
    assert late.state.positions.tobytes() == again.state.positions.tobytes()
    assert again.step == late.step
    return Seen("step", float(late.step), float(step + 6), 0.0)


for _step in (2**31 - 3, 2**32 - 3, 2**40):
    for _precision in PRECISIONS:
        CASES.add(f"step {_step}, mdvv, {_precision}", partial(late_step, _step, _precision, "mdvv"))
    for _order in ("ou", "second", "lowe-andersen", "middle", "nose-hoover-langevin"):
        CASES.add(f"step {_step}, {_order}", partial(late_step, _step, "double", _order))


def noise_period(kind: str) -> Seen:
    """No step repeats the noise of one that is a power of two later, up to the steps that are counted, 2^48."""
    draw = {"double": _core.word_noise, "reference": _core.pair_noise}[kind]
    k = np.arange(20_000, dtype=np.uint32)
    base = np.asarray(draw(SEED, 12345, 2 * k, 2 * k + 1))
    worst = 0.0
    for power in range(48):
        later = np.asarray(draw(SEED, 12345 ^ (1 << power), 2 * k, 2 * k + 1))
        worst = max(worst, abs(float(np.mean(base * later))) * len(k) ** 0.5)
    return Seen("largest correlation in standard errors:", worst, 0.0, 4.5)


for _kind in ("double", "reference"):
    CASES.add(f"noise of steps 2^k apart, {_kind}", partial(noise_period, _kind))


def extreme_seed(seed: int, precision: str) -> Seen:
    """A seed at the end of its range gives a fluid like any other, and differs from its neighbours."""
    scene = make_scene({"A": 1029}, cell=7.0, control={"precision": precision})
    simulation, other = (Simulation(scene, seed=s, threads=1) for s in (seed, seed ^ 1))
    start = simulation.state.velocities
    assert abs(float(np.mean(start * other.state.velocities))) < 5 / (3 * 1029) ** 0.5
    seen = []
    for _ in range(100):
        simulation.run(10)
        seen.append(simulation.temperature)
    check_finite(simulation)
    return Seen("mean temperature of steps 500 to 1000", float(np.mean(seen[50:])), 1.0, 0.03)


for _seed in (0, 2**63, 2**64 - 1):
    for _precision in PRECISIONS:
        CASES.add(f"seed {_seed}, {_precision}", partial(extreme_seed, _seed, _precision))
for _seed in (-1, 2**64):
    CASES.add(
        f"seed {_seed}",
        partial(
            refused, partial(Simulation, make_scene({"A": 2}, cell=6.0), seed=_seed), "seed must lie between 0 and"
        ),
    )
