"""The default noise: one random word a bead and step, mixed for every pair; moments and independence.

A sum of two bead words says less than the two words, so what could go wrong sits in pairs that share beads: triangles
and closed walks over four beads, where the sums of the words are tied together. The samples are pure functions of their
arguments, so these tests have no luck; the bounds are five standard errors of what is estimated.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from numpy.typing import NDArray

from pydlpoly import Simulation, _core

from .scene_builder import make_scene

SAMPLES = 1_000_000
SIGMAS = 5.0
LAST_SEED = 2**64 - 1
UNIT = np.sqrt(3.0) / 2**31
Sample = NDArray[np.float64]


def noise(i: object, j: object, *, seed: int = 1, step: int = 1, image: int = 0) -> Sample:
    ids = [np.asarray(bead, dtype=np.uint32) for bead in (i, j)]
    return np.asarray(_core.word_noise(seed, step, *np.broadcast_arrays(*ids), image))


def disjoint(*, seed: int = 1, step: int = 1, first: int = 0, image: int = 0, count: int = SAMPLES) -> Sample:
    """Noise of the pairs (2k, 2k + 1), which share no bead."""
    k = np.arange(first, first + count)
    return noise(2 * k, 2 * k + 1, seed=seed, step=step, image=image)


def errors(sample: Sample, mean: float = 0.0, variance: float = 1.0) -> float:
    """How far the mean of a sample is from what it should be, in standard errors."""
    return abs(float(np.mean(sample)) - mean) * float(np.sqrt(len(sample) / variance))


def centred_square(sample: Sample) -> Sample:
    """z² - 1, with mean 0 and variance 9/5 - 1."""
    return sample**2 - 1.0


def uncorrelated(a: Sample, b: Sample) -> bool:
    """Values and squares of two samples are uncorrelated within the bounds."""
    squares = centred_square(a) * centred_square(b)
    return errors(a * b) < SIGMAS and errors(squares, variance=0.8**2) < SIGMAS


@pytest.mark.parametrize("seed", [0, 1, 42, 2**32, LAST_SEED])
@pytest.mark.parametrize("step", [0, 1, 2**32, 2**48 - 1])
def test_moments_are_those_of_the_uniform_distribution(seed: int, step: int) -> None:
    sample = disjoint(seed=seed, step=step)
    # On (-√3, √3) E z^n = 3^(n/2) / (n + 1) for even n, so that the kurtosis is 9/5.
    moment = {n: 3.0 ** (n / 2) / (n + 1) for n in (2, 4, 6, 8)}
    assert errors(sample) < SIGMAS
    assert errors(sample**2, 1.0, moment[4] - 1.0) < SIGMAS
    assert errors(sample**3, 0.0, moment[6]) < SIGMAS
    assert errors(sample**4, 1.8, moment[8] - 1.8**2) < SIGMAS
    assert np.abs(sample).max() <= np.sqrt(3.0)


def test_every_bin_has_its_share() -> None:
    """χ² of 4096 equal bins over many draws; its spread is √(2 · 4095)."""
    sample = np.concatenate([disjoint(seed=seed) for seed in range(8)])
    counts, _ = np.histogram(sample, 4096, (-np.sqrt(3.0), np.sqrt(3.0)))
    expected = len(sample) / 4096
    square = float(np.sum((counts - expected) ** 2) / expected)
    assert abs(square - 4095) < SIGMAS * np.sqrt(2 * 4095)


def test_every_bit_is_fair_and_alone() -> None:
    words = np.rint(disjoint() / UNIT).astype(np.int64).astype(np.uint32)
    bits = np.array([(words >> np.uint32(k) & np.uint32(1)) * 2.0 - 1.0 for k in range(32)])
    matrix = np.abs(bits @ bits.T) / np.sqrt(SAMPLES)
    assert np.abs(bits.sum(axis=1)).max() < SIGMAS * np.sqrt(SAMPLES)
    assert matrix[~np.eye(32, dtype=bool)].max() < SIGMAS


def test_noise_is_symmetric_and_distinct() -> None:
    rng = np.random.default_rng(5)
    i, j = rng.integers(0, 2**32, size=(2, SAMPLES), dtype=np.uint32)
    sample = noise(i, j, seed=9, step=77)
    assert np.array_equal(sample, noise(j, i, seed=9, step=77))
    # Draws of 32 bits meet by chance: n²/2³³ of them.
    expected = SAMPLES**2 / 2**33
    assert abs(SAMPLES - len(np.unique(sample)) - expected) < SIGMAS * np.sqrt(expected)


@pytest.mark.parametrize("bead", [0, 1, 1234, 2**28 - 2])
def test_pairs_that_share_a_bead_are_independent(bead: int) -> None:
    partner = np.arange(2000, 2000 + SAMPLES)
    sample = noise(bead, partner)
    assert errors(sample) < SIGMAS
    assert errors(sample**2, 1.0, 0.8) < SIGMAS
    for lag in range(1, 7):
        assert uncorrelated(sample[lag:], sample[:-lag]), lag
    assert uncorrelated(sample, noise(bead + 1, partner))


def clusters(size: int) -> NDArray[np.int64]:
    """(size, samples) different beads, near each other in half of the samples and anywhere in the others."""
    rng = np.random.default_rng(size)
    near = 8 * np.arange(SAMPLES // 2) + np.argsort(rng.random((8, SAMPLES // 2)), axis=0)[:size]
    far = rng.integers(0, 2**20, (size, SAMPLES // 2)) * size + np.arange(size)[:, None]
    return np.concatenate([near, far], axis=1)


@pytest.mark.parametrize("step", [1, 2, 1000])
def test_triangles_are_independent(step: int) -> None:
    a, b, c = clusters(3)
    z = [noise(a, b, step=step), noise(b, c, step=step), noise(c, a, step=step)]
    assert errors(z[0] * z[1] * z[2]) < SIGMAS
    squares = [centred_square(x) for x in z]
    assert errors(squares[0] * squares[1] * squares[2], variance=0.8**3) < SIGMAS
    assert errors(z[0] * z[1] * squares[2], variance=0.8) < SIGMAS
    for x, y in combinations(z, 2):
        assert uncorrelated(x, y)


@pytest.mark.parametrize("step", [1, 2, 1000])
def test_closed_walks_over_four_beads_are_independent(step: int) -> None:
    """(ij)(kl)(ik)(jl): the words of the first two pairs have the same sum as those of the last two."""
    i, j, k, m = clusters(4)
    z = [noise(a, b, step=step) for a, b in ((i, j), (k, m), (i, k), (j, m))]
    assert errors(np.prod(z, axis=0)) < SIGMAS
    assert errors(np.prod([centred_square(x) for x in z], axis=0), variance=0.8**4) < SIGMAS
    assert errors(np.prod(np.sign(z), axis=0)) < SIGMAS
    # Sums of two noises have a fourth moment of 12/5.
    for sign in (1.0, -1.0):
        u, v = (z[0] + sign * z[1]) / np.sqrt(2.0), (z[2] + sign * z[3]) / np.sqrt(2.0)
        assert errors(u * v) < SIGMAS
        assert errors(centred_square(u) * centred_square(v), variance=1.4**2) < SIGMAS
    for x, y in combinations(z, 2):
        assert uncorrelated(x, y)


def test_all_pairs_of_a_cluster_are_uncorrelated_over_the_steps() -> None:
    """The force on a bead is a sum over pairs: every two of them, among 8 beads, in one step and the next."""
    pairs = np.array(list(combinations(range(8), 2)))
    steps = 20_000
    rows = np.array([noise(pairs[:, 0], pairs[:, 1], seed=3, step=step) for step in range(steps)])
    matrix = rows.T @ rows / steps
    assert np.abs(matrix[~np.eye(len(pairs), dtype=bool)]).max() * np.sqrt(steps) < SIGMAS
    assert np.abs(np.diag(matrix) - 1.0).max() * np.sqrt(steps / 0.8) < SIGMAS
    later = rows[1:].T @ rows[:-1] / (steps - 1)
    assert np.abs(later).max() * np.sqrt(steps - 1) < SIGMAS


@pytest.mark.parametrize("lag", range(1, 7))
@pytest.mark.parametrize("step", [0, 1000, 2**32 - 3])
def test_steps_are_independent(step: int, lag: int) -> None:
    assert uncorrelated(disjoint(step=step), disjoint(step=step + lag))


@pytest.mark.parametrize(("seed", "other"), [(0, 1), (1, 2), (2**32 - 1, 2**32), (0, LAST_SEED), (5, 5 + 2**32)])
def test_neighbouring_seeds_are_independent(seed: int, other: int) -> None:
    a, b = disjoint(seed=seed), disjoint(seed=other)
    assert uncorrelated(a, b)
    assert uncorrelated(a[1:], b[:-1])
    # A seed must not be a shift of another one in the steps, nor in the beads.
    assert uncorrelated(a, disjoint(seed=other, step=2))
    assert uncorrelated(a, disjoint(seed=other, first=1))
    assert np.count_nonzero(np.isin(a, b)) < 2 * SAMPLES**2 / 2**32


def test_images_of_a_pair_are_independent() -> None:
    samples = [disjoint(image=image, count=200_000) for image in (0, 1, 2, 5, 43, 215, 255)]
    for a, b in combinations(samples, 2):
        assert uncorrelated(a, b)


@pytest.mark.parametrize("shift", [1, 2, 3, 16, 256, 4096, 65536])
def test_ids_near_each_other_are_independent(shift: int) -> None:
    """All (k, k + shift) share beads with their neighbours, as chains and rows of a lattice do."""
    k = np.arange(SAMPLES)
    sample = noise(k, k + shift)
    for lag in sorted({1, 2, shift, 2 * shift}):
        assert uncorrelated(sample[lag:], sample[:-lag]), lag


def test_start_velocities_are_unlike_the_noise() -> None:
    beads = 100_000
    velocities = Simulation(make_scene({"A": beads}, cell=200.0), seed=7, threads=1).state.velocities
    k = np.arange(beads)
    for step in (0, 1):
        for partner in (0, 1):
            assert errors(velocities[:, 0] * noise(k, partner, seed=7, step=step)) < SIGMAS
