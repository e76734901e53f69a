"""The exchange of heat written out once more, pair after pair, and what the core does to do it in batches.

All beads of the oracle's scene lie in one link cell, where pairs take their turn by the ids of their beads.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import ndtri

from pydlpoly import Simulation, _core
from pydlpoly.formats.records import FloatArray

from .heat_scenes import STEP, heat, set_temperatures, temperatures
from .instruction_sets import printed_by_set
from .scene_builder import NVE, make_scene

SEED, STREAM, TIMESTEP = 5, 10, 0.05
RANGE = 3.0


@dataclass(frozen=True)
class Line:
    """What two species exchange."""

    kappa: float
    exponent: float
    conductivity: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)

    def coefficient(self, mean: float) -> tuple[float, float]:
        """Return kappa and its slope at a mean temperature; the reference is 1."""
        x, powers = mean - 1.0, range(1, 5)
        value = 1 + sum(c * x**n for c, n in zip(self.conductivity, powers, strict=True))
        slope = sum(n * c * x ** (n - 1) for c, n in zip(self.conductivity, powers, strict=True))
        return (self.kappa * value, self.kappa * slope) if value > 0 else (0.0, 0.0)


@dataclass(frozen=True)
class Case:
    """Species A, B and perhaps a wall W; lines by their letters."""

    capacities: dict[str, float]
    lines: dict[str, Line]
    beads: int = 40
    spread: float = 0.4  # of temperatures


CASES = {
    "one species": Case({"A": 60.0}, {"AA": Line(0.002, 2.0, (-0.4, 0.2, 0.1, 0.05))}),
    "long steps": Case({"A": 60.0}, {"AA": Line(0.4, 2.0)}),
    "another exponent": Case({"A": 60.0}, {"AA": Line(0.004, 1.3)}),
    "unequal capacities": Case(
        {"A": 60.0, "B": 25.0},
        {"AA": Line(0.002, 2.0), "AB": Line(0.005, 2.0, (0.5, 0.0, 0.0, 0.0)), "BB": Line(0.003, 2.0)},
    ),
    "unlike exponents": Case(
        {"A": 60.0, "B": 25.0}, {"AA": Line(0.002, 2.0), "AB": Line(0.3, 1.5), "BB": Line(0.003, 0.7)}
    ),
    "a wall": Case({"A": 60.0, "W": 10.0}, {"AA": Line(0.01, 2.0), "AW": Line(0.02, 2.0), "WW": Line(0.02, 2.0)}),
    "next to nothing": Case({"A": 2.0}, {"AA": Line(0.4, 2.0)}, spread=0.9),
}


def philox_2x32(ids: np.ndarray, key: tuple[int, int, int]) -> np.ndarray:
    """Return the words of beads, as core/bead_words.hpp has them."""
    mask = np.uint64(0xFFFFFFFF)
    low, high, round_key = ids.astype(np.uint64) ^ np.uint64(key[1]), np.full(len(ids), key[2], np.uint64), key[0]
    for _ in range(10):
        product = np.uint64(0xD256D193) * low
        low, high = (product >> np.uint64(32)) ^ np.uint64(round_key) ^ high, product & mask
        round_key = (round_key + 0x9E3779B9) & 0xFFFFFFFF
    return low


def mixed_words(a: int, b: int) -> int:
    x = (a + b) & 0xFFFFFFFF
    x ^= x >> 16
    x = x * 0x7FEB352D & 0xFFFFFFFF
    x ^= x >> 15
    return x * 0x846CA68B & 0xFFFFFFFF


def normals(beads: int, step: int, precision: str) -> FloatArray:
    """(beads, beads) numbers of the pairs i < j."""
    found = np.zeros((beads, beads))
    if precision == "reference":
        for i, j in combinations(range(beads), 2):
            w = [int(n) for n in _core.philox([step, STREAM << 16, i, j], SEED)]
            first, second = ((((high << 32) | low) >> 12) + 0.5 for high, low in (w[:2], w[2:]))
            found[i, j] = np.sqrt(-2 * np.log(first * 2.0**-52)) * np.cos(2 * np.pi * second * 2.0**-52)
        return found
    w = [int(n) for n in _core.philox([0, STREAM << 16, 0, 0], SEED)]
    words = philox_2x32(np.arange(beads), (w[0], w[1], w[2] ^ step))
    quantiles = np.float32(ndtri(np.arange(1, 2048) / 2048)).astype(float)
    for i, j in combinations(range(beads), 2):
        word = mixed_words(int(words[i]), int(words[j]))
        piece, part = divmod(word + 0.5, 2.0**21)
        if 16 <= piece < 2048 - 16:
            low, high = quantiles[int(piece) - 1 : int(piece) + 1]
            found[i, j] = low + (high - low) * part / 2.0**21
        else:
            found[i, j] = ndtri((word + 0.5) * 2.0**-32)
    return found


def reflected(energy: float, total: float) -> float:
    inside = abs(energy)
    if inside >= total:
        inside %= 2 * total
        inside = min(inside, 2 * total - inside)
    return inside


def one_after_the_other(case: Case, species: str, places: FloatArray, t: FloatArray, noise: FloatArray) -> None:
    """One step of all pairs, as docs/heat.md has it."""
    for i, j in combinations(range(len(species)), 2):
        line = case.lines["".join(sorted((species[i], species[j])))]
        ci, cj = (case.capacities[species[k]] for k in (i, j))
        inverse_i, inverse_j = (0.0 if species[k] == "W" else 1 / case.capacities[species[k]] for k in (i, j))
        mean = (t[i] + t[j]) / 2
        kappa, slope = line.coefficient(mean)
        if inverse_i + inverse_j == 0:
            continue
        w = (1 - np.linalg.norm(places[i] - places[j]) / RANGE) ** line.exponent
        c = 1 / (inverse_i + inverse_j)
        k = ci * cj * kappa * mean**2
        x = k * w * TIMESTEP / (c * t[i] * t[j])
        gain = -np.expm1(-x) * c * (t[j] - t[i]) + np.sqrt(-np.expm1(-2 * x) * c * t[i] * t[j]) * noise[i, j]
        gain += 0.5 * TIMESTEP * w * (inverse_i - inverse_j) * ci * cj * (2 * mean * kappa + mean**2 * slope)
        if inverse_j == 0:
            gain = reflected(ci * t[i] + gain, np.inf) - ci * t[i]
        elif inverse_i == 0:
            gain = cj * t[j] - reflected(cj * t[j] - gain, np.inf)
        else:
            gain = reflected(ci * t[i] + gain, ci * t[i] + cj * t[j]) - ci * t[i]
        t[i] += gain * inverse_i
        t[j] -= gain * inverse_j


@pytest.mark.parametrize("precision", ["double", "reference"])
@pytest.mark.parametrize("name", CASES)
def test_rounds_are_the_pairs_one_after_the_other(name: str, precision: str) -> None:
    case = CASES[name]
    letters = list(case.capacities)
    counts = {letter: case.beads // len(letters) for letter in letters}
    species = "".join(letter * n for letter, n in counts.items())
    lines = [f"capacity {letter} {capacity}" for letter, capacity in case.capacities.items()]
    lines += ["wall W 2.0"] if "W" in letters else []
    for pair, line in case.lines.items():
        numbers = " ".join(str(c) for c in line.conductivity)
        lines.append(f"pair {pair[0]} {pair[1]} kappa {line.kappa} range {RANGE} exponent {line.exponent} "
                     f"conductivity {numbers}")  # fmt: skip
    random = np.random.default_rng(11)
    places = random.uniform(-0.45, 0.45, (len(species), 3))
    scene = make_scene(
        counts,
        [f"{pair[0]} {pair[1]} dpd 0.0 1.0" for pair in case.lines],
        cell=10.0,
        positions=places,
        velocities=np.zeros_like(places),
        frozen=["W"] if "W" in letters else [],
        control={**NVE, STEP: f"{TIMESTEP} internal_t"},
        extensions=heat(*lines),
    )
    simulation = Simulation(scene, seed=SEED, precision=precision)
    expected = np.where(
        np.array(list(species)) == "W", 2.0, random.uniform(1 - case.spread, 1 + case.spread, len(species))
    )
    set_temperatures(simulation, expected)
    for step in (1, 2, 3):
        simulation.run(1)
        one_after_the_other(case, species, places, expected, normals(len(species), step, precision))
        exact = 1e-10 if precision == "reference" else 1e-6  # the oracle's table is another one
        np.testing.assert_allclose(temperatures(simulation), expected, rtol=exact)


@settings(max_examples=60, deadline=None)
@given(st.integers(2, 12), st.data())
def test_rounds_share_no_bead_and_keep_every_beads_order(beads: int, data: st.DataObject) -> None:
    one = st.tuples(st.integers(0, beads - 1), st.integers(0, beads - 1)).filter(lambda pair: pair[0] != pair[1])
    pairs = data.draw(st.lists(one, max_size=40))
    places, starts = _core.pair_rounds([i for i, _ in pairs], [j for _, j in pairs])
    assert sorted(places) == list(range(len(pairs)))
    assert starts[0] == 0
    assert starts[-1] == len(pairs)
    round_of = [int(np.searchsorted(starts, place, side="right")) for place in places]
    latest = [0] * beads
    for (i, j), number in zip(pairs, round_of, strict=True):
        # The first round in which both are free: later than all before, and none is waited for in vain.
        assert number == max(latest[i], latest[j]) + 1
        latest[i] = latest[j] = number


PROGRAM = """
import hashlib, sys
sys.path.append(sys.argv[1])  # an installed package before the source folder
import numpy as np
from pydlpoly import Simulation
from tests.heat_scenes import fluid, heat, temperatures

digest = hashlib.sha256()
blocks = {
    "mdvv": [("viscous_heating lammps", "repulsion scaled"), ("viscous_heating conserving",)],
    "ou": [()],
}
for order, choices in blocks.items():
    for more in choices:
        for exponent, drag in (("2.0", "0 0 0 0"), ("1.4", "0.3 0 0 0")):
            pair = f"pair A A kappa 0.05 range 1.3 exponent {exponent} power 0.7 -0.2 0.1 0 drag {drag}"
            simulation = Simulation(fluid(heat("capacity A 60", pair, *more), order=order), seed=8, threads=1)
            simulation.run(5)
            for part in (temperatures(simulation), simulation.positions, simulation.velocities):
                digest.update(np.ascontiguousarray(part).tobytes())
print(digest.hexdigest())
"""


def test_every_instruction_set_gives_the_same_bits(tmp_path: Path) -> None:
    digests = printed_by_set(PROGRAM, tmp_path)
    assert len(set(digests.values())) == 1, digests


@pytest.mark.parametrize(("speed", "timestep"), [(3.0, 1e-3), (3e4, 1e-6)])
def test_heat_of_two_beads_in_lammpss_form(speed: float, timestep: float) -> None:
    """(γ w² u² − 2γ w² T/m − σ w u ζ) Δt/(C_i + C_j) for each; such heat at 3e4 needs a coarser grid than most."""
    drag, capacity, distance = 4.5, 60.0, 0.5
    block = heat(f"capacity A {capacity}", "viscous_heating lammps")
    scene = make_scene(
        {"A": 2},
        [f"A A dpd 0.0 1.0 {drag}"],
        cell=9.0,
        positions=np.array([[0.0, 0.0, 0.0], [distance, 0.0, 0.0]]),
        velocities=np.array([[speed / 2, 0.0, 0.0], [-speed / 2, 0.0, 0.0]]),
        control={"ensemble_dpd_order": "mdvv", STEP: f"{timestep} internal_t"},
        extensions=block,
    )
    simulation = Simulation(scene, seed=SEED)
    before = simulation.state
    simulation.run(1)
    # The velocity that the drag sees is that between the two half kicks.
    u = speed + timestep * (before.forces[0, 0] - before.forces[1, 0]) / 2
    apart = distance - timestep * u
    near = 1 - apart
    sigma = np.sqrt(2 * drag)
    # r_i − r_j points from the second to the first: they approach, e·v = −u.
    zeta = float(_core.word_noise(SEED, 1, np.array([0], np.uint32), np.array([1], np.uint32))[0])
    more = 1 + 1 / (2 * capacity)  # of the drag, for the heat capacities
    power = more * drag * near**2 * (u**2 - 2) + sigma * near * zeta * u
    expected = timestep * power / (2 * capacity) / capacity  # as LAMMPS does
    np.testing.assert_allclose(temperatures(simulation) - 1.0, expected, rtol=1e-6)
