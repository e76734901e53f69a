"""Noise beyond tests/test_word_noise.py and tests/test_noise.py: one pair in time, and the pair maps of splittings."""

from __future__ import annotations

from functools import partial

import numpy as np

from pydlpoly import Simulation, _core
from pydlpoly.scene.integrators import INTEGRATORS

from ..scene_builder import make_scene
from .framework import SEED, Cases, Seen, check_finite, refused

CASES = Cases("noise")
_DRAWS = {"double": _core.word_noise, "reference": _core.pair_noise}


def in_time(kind: str, first: int) -> Seen:
    """One pair over 10^4 steps: mean, variance, and correlations of values and squares over 1 to 200 steps."""
    steps = 10_000
    draw = _DRAWS[kind]
    one = np.array([7], dtype=np.uint32)
    z = np.array([float(draw(SEED, first + step, one, one + 1000)[0]) for step in range(steps)])
    kurtosis = 1.8 if kind == "double" else 3.0
    errors = [abs(z.mean()) * steps**0.5, abs(np.mean(z**2) - 1.0) * (steps / (kurtosis - 1.0)) ** 0.5]
    squares = (z**2 - 1.0) / (kurtosis - 1.0) ** 0.5
    for lag in range(1, 201):
        errors += [abs(np.mean(x[lag:] * x[:-lag])) * (steps - lag) ** 0.5 for x in (z, squares)]
    # 400 numbers: the largest is beyond 4.5 once in 400 such tests.
    return Seen("largest error of 402 moments and correlations, in standard errors:", float(max(errors)), 0.0, 4.5)


for _kind in _DRAWS:
    for _first in (0, 2**32 - 5000):
        CASES.add(f"one pair over 10 000 steps from {_first}, {_kind}", partial(in_time, _kind, _first))

# Pair maps --------------------------------------------------------------------------------------------------------

_DISTANCE = 0.3
_TIMESTEP = 1e-9  # beads hardly move, so that the distance is that of the start
_PAIRS = 100_000


def isolated_pairs(order: str, relaxation: float, precision: str, masses: tuple[float, float]) -> Simulation:
    """Pairs of a bead of each species, 0.3 apart along x and far from all other pairs."""
    side = 47
    places = np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)[:_PAIRS] * 2.5
    offset = np.array([_DISTANCE / 2, 0.0, 0.0])
    edge = side * 2.5
    positions = np.concatenate([places + offset, places - offset]) - edge / 2 + 1.25
    inverse_mass = 1.0 / masses[0] + 1.0 / masses[1]
    drag = relaxation / (_TIMESTEP * inverse_mass * (1.0 - _DISTANCE) ** 2)
    control = {
        "ensemble_dpd_order": order,
        "timestep": f"{_TIMESTEP!r} internal_t",
        "precision": precision,
        "ensemble_dpd_coupling": "0.0 Da/ps",
    }
    if order in ("lowe-andersen", "stoyanov-groot"):
        control["ensemble_dpd_rate"] = f"{relaxation / _TIMESTEP!r} ps^-1"
    scene = make_scene(
        {"A": _PAIRS, "B": _PAIRS},
        [f"A A dpd 0.0 1.0 {0.1 * drag!r}", f"A B dpd 0.0 1.0 {drag!r}", f"B B dpd 0.0 1.0 {0.1 * drag!r}"],
        cell=edge,
        positions=positions,
        velocities=np.zeros((2 * _PAIRS, 3)),
        masses={"A": masses[0], "B": masses[1]},
        control=control,
    )
    return Simulation(scene, seed=SEED, threads=2)


def along(simulation: Simulation) -> np.ndarray:
    velocities = simulation.state.velocities
    return velocities[:_PAIRS, 0] - velocities[_PAIRS:, 0]


def keeps(order: str, h: float) -> float:
    """What a step keeps of the relative velocity, from the formulas of the maps."""
    if order in ("ou", "ou-middle", "peters"):
        return float(np.exp(-h))
    if order == "zeroth":
        return 1.0 / (1.0 + h)
    if order == "peters-first":
        return 1.0 - h
    if order == "first":
        return (1.0 - h / 2) / (1.0 + h / 2)
    if order == "second":
        return ((1.0 - h / 4) / (1.0 + h / 4)) ** 2
    return 1.0 - h  # on average, where pairs are chosen with the probability h


def pair_map(order: str, h: float, precision: str) -> Seen:
    """Maxwell in, Maxwell out, from 10^6 draws: ten times 10^5 pairs of masses 1 and 3.

    The standard error of the variance is sqrt(2/10^6) = 0.14 %; part of it is common to the velocities given, from
    which it is taken away: they have the variance k_B T/mu to all digits. Also: pairs at rest get the variance
    k_B T/mu (1 - keep^2), the step keeps what its formula says, and nothing happens across the axis or to the momentum.
    """
    masses = (1.0, 3.0)
    simulation = isolated_pairs(order, h, precision, masses)
    assert simulation.step == 0
    wanted = 1.0 / masses[0] + 1.0 / masses[1]
    keep = keeps(order, h)
    rng = np.random.default_rng(11)
    after, product, at_rest, fourth = [], [], [], []
    for turn in range(10):
        velocities = np.concatenate([rng.normal(size=(_PAIRS, 3)), rng.normal(size=(_PAIRS, 3)) / 3.0**0.5])
        u = velocities[:_PAIRS, 0] - velocities[_PAIRS:, 0]
        velocities[:_PAIRS, 0] *= (wanted / np.mean(u**2)) ** 0.5
        velocities[_PAIRS:, 0] *= (wanted / np.mean(u**2)) ** 0.5
        simulation.set_state(velocities=velocities)
        before = along(simulation)
        simulation.run(1)
        u = along(simulation)
        after.append(np.mean(u**2) / wanted)
        fourth.append(np.mean(u**4) / (3.0 * wanted**2))
        product.append(np.mean(u * before) / wanted)
        if turn < 3:
            assert np.abs(simulation.state.velocities[:, 1:] - velocities[:, 1:]).max() < 1e-6
            sums = simulation.state.velocities[:_PAIRS, 0] + 3.0 * simulation.state.velocities[_PAIRS:, 0]
            given = velocities[:_PAIRS, 0] + 3.0 * velocities[_PAIRS:, 0]
            assert np.abs(sums - given).max() < 1e-13
            simulation.set_state(velocities=np.zeros_like(velocities))
            simulation.run(1)
            at_rest.append(np.mean(along(simulation) ** 2) / wanted)
    check_finite(simulation)
    noise = h if order in ("lowe-andersen", "stoyanov-groot") else 1.0 - keep**2
    assert abs(np.mean(at_rest) - noise) < 5.0 * noise * (2.0 / 3e5) ** 0.5 * max(1.0, 1.3 / max(h, 0.1) ** 0.5)
    assert abs(np.mean(product) - keep) < 5.0 * 1e-3, np.mean(product)
    assert abs(np.mean(fourth) - 1.0) < 5.0 * (96.0 / 9.0 / 1e6) ** 0.5, "the distribution is not normal"
    return Seen("variance of u over k_B T/mu", float(np.mean(after)), 1.0, 0.003)


_MAPS = ("zeroth", "first", "second", "peters", "ou", "ou-middle")
assert set(_MAPS) < set(INTEGRATORS)
for _order in _MAPS:
    for _h in (0.01, 1.0, 10.0):
        CASES.add(f"map of a pair, relaxation {_h:g}, {_order}", partial(pair_map, _order, _h, "double"), slow=True)
    CASES.add(
        f"map of a pair, relaxation 1, {_order}, reference", partial(pair_map, _order, 1.0, "reference"), slow=True
    )
for _order in ("lowe-andersen", "stoyanov-groot"):
    for _h in (0.01, 0.5):
        CASES.add(f"map of a pair, probability {_h:g}, {_order}", partial(pair_map, _order, _h, "double"), slow=True)
for _h in (0.01, 0.9):
    CASES.add(
        f"map of a pair, relaxation {_h:g}, peters-first", partial(pair_map, "peters-first", _h, "double"), slow=True
    )
CASES.add(
    "map of a pair, relaxation 10, peters-first",
    partial(
        refused, partial(isolated_pairs, "peters-first", 10.0, "double", (1.0, 3.0)), "below 2; peters has no such"
    ),
)
